"""The walk: scene, rigid motion, P(theta), modes, sub-intervals, strains."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech._petsc import DIRECT, PETSc, configured
from fenics_mech.classical.joining import (
    closed_cycle,
    flat,
    forced,
    free,
    joins,
    marched,
    refuse_ringing,
    steady,
    whole,
)
from fenics_mech.classical.linkage import assembly, rigid_motion
from fenics_mech.classical.links import Links, Transformation
from fenics_mech.classical.modes import Modes, followed, slowest
from fenics_mech.classical.strains import recovered
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.formulas.expression import Jet


@dataclass(frozen=True)
class Response:
    """The elastic motion of a linkage by the dissertation's method, at the middles of the sub-intervals.

    Parameters
    ----------
    theta, time
        Drive angles (rad) and times (s), ``(positions,)``.
    coordinates
        Names of the coordinates q: "link.node.x" in link axes, "joint.X" in the fixed frame, "joint.slide".
    q
        Coordinates (m, rad), ``(positions, coordinates)``.
    members, s
        Names of the members, and the stations 0..1 along each.
    strain
        Of both outer fibres, + first, ``(positions, members, stations, 2)``.
    deflection
        Of the members' axes in the fixed frame (m), ``(positions, members, stations, 2)``.
    modes
        The natural modes kept.
    """

    theta: Array
    time: Array
    coordinates: tuple[str, ...]
    q: Array
    members: tuple[str, ...]
    s: Array
    strain: Array
    deflection: Array
    modes: Modes

    @property
    def frequency(self) -> Array:
        """Natural frequencies (Hz), ``(positions, modes)``."""
        return self.modes.omega / (2 * np.pi)


def sub_intervals(scene: Scene) -> Response:
    """Solve the truncated equation (5.1) for its periodic motion by sub-intervals with constant coefficients.

    Parameters
    ----------
    scene
        The scene. Its analysis states `sub_intervals`, `modes`, `join`, `load`, `static_correction` and `stations`.

    Raises
    ------
    AssemblyError
        When the links cannot be put together.
    SceneError
        When the scene has something that the method does not know.
    SolverError
        When PETSc or SLEPc does not find an answer.

    Examples
    --------
    >>> from fenics_mech.classical import sub_intervals
    >>> scene = fm.load("demos/four_bar.toml").changed(effects=(), analysis={"sub_intervals": 60, "modes": 3})
    >>> answer = sub_intervals(scene)
    >>> answer.members, answer.frequency[0].round(2).tolist()
    (('crank', 'coupler', 'follower'), [43.3, 48.74, 62.16])
    """
    _refuse_beyond(scene)
    count, step = scene.analysis.sub_intervals, scene.period / scene.analysis.sub_intervals
    time = step * np.arange(count + 1)
    return _walked(scene, time[:-1], time - step / 2, periodic=True)


def transient(scene: Scene) -> Response:
    """Superpose modes in time (E.13), from rest with straight links, over the run-up and `cycles` of the drive.

    Parameters
    ----------
    scene
        As of `sub_intervals`; `cycles` is another of its options. `settled` is not looked at.

    Raises
    ------
    AssemblyError
        As of `sub_intervals`.
    SceneError
        As of `sub_intervals`.
    SolverError
        As of `sub_intervals`.

    Examples
    --------
    >>> from fenics_mech.classical import transient
    >>> analysis = {"method": "transient", "sub_intervals": 90, "cycles": 1, "modes": 3}
    >>> answer = transient(fm.load("demos/four_bar.toml").changed(effects=(), analysis=analysis))
    >>> answer.strain.shape, bool(abs(answer.strain[0]).max() < 1e-3)
    ((91, 3, 21, 2), True)
    """
    _refuse_beyond(scene)
    step = scene.period / scene.analysis.sub_intervals
    run_up = max((drive.run_up or 0.0) for drive in scene.drives)
    count = math.ceil(run_up / step - 1e-6) + scene.analysis.cycles * scene.analysis.sub_intervals + 1
    time = step * np.arange(count)
    edges = np.append(time, time[-1] + step) - step / 2
    edges[0] = 0.0  # it begins in the middle of the first
    return _walked(scene, time, edges, periodic=False)


def _walked(scene: Scene, time: Array, edges: Array, *, periodic: bool) -> Response:
    """Give the motion at the middles of sub-intervals (s), whose edges are one more."""
    coordinate, at_edges = (_steady(scene, t) if periodic else scene.coordinate(t) for t in (time, edges))
    links, branch, step = Links.of(scene), assembly(scene), float(time[1] - time[0])
    motion, beside = (rigid_motion(scene, branch, at) for at in (coordinate, at_edges))
    P, rigid = Transformation.of(links, motion, beside), links.rigid_acceleration(motion)
    force = P.load(rigid)
    rise = np.diff(P.at(beside).load(links.rigid_acceleration(beside)), axis=0) / np.diff(edges)[:, None]
    if scene.analysis.load == "constant":
        rise = np.zeros_like(force)
    modes, straining, static = _modes(scene, P, force)
    omega, zeta = modes.omega, _ratios(scene, modes)
    load, slope = (np.einsum("kmi,ki->km", modes.shapes, part) for part in (force, rise))  # (5.2)
    join, half = joins(scene.analysis.join, modes, zeta, straining, step), whole(free(omega, zeta, step / 2))
    start = load - slope * step / 2
    to_middle = flat(forced(omega, zeta, start, slope, step / 2))
    if periodic:
        transition = whole(free(omega, zeta, step))
        starts = closed_cycle(join, transition, flat(forced(omega, zeta, start, slope, step)), scene.petsc)  # (5.16)
        states = np.einsum("kij,kj->ki", half, starts) + to_middle
    else:
        states = marched(join, half, flat(forced(omega, zeta, load, slope, step / 2)), to_middle)
    y, ringing = states[:, : omega.shape[1]], np.ones(omega.shape[1])
    if periodic:
        swinging = (states - flat(steady(omega, zeta, load, slope))).reshape(len(y), 2, -1)
        energy = (omega**2)[:, None] * swinging**2
        ringing = np.sqrt(energy.sum(axis=1).max(axis=0) / max((omega**2 * y**2).sum(axis=1).max(), TINY))
    if not scene.analysis.allow_ringing:
        refuse_ringing(omega, step, ringing)
    answering = load if scene.analysis.static_correction else np.zeros_like(load)
    q = static + np.einsum("kmi,km->ki", modes.shapes, y - answering / omega**2)  # (5.3)
    elastic = np.einsum("kmi,km->ki", modes.shapes, answering - omega**2 * y)  # drag is balanced by its own stress
    inertia = P.to_nodes(elastic) + (rigid if scene.analysis.static_correction else 0.0)
    s = np.linspace(0, 1, scene.analysis.stations)
    strain, deflection = recovered(links, motion, P.to_nodes(q), inertia, s)
    return Response(coordinate.value, time, P.names, q, links.mesh.members, s, strain, deflection, modes)


def _steady(scene: Scene, time: Array) -> Jet:
    """Drive coordinate at its constant rate."""
    rate = np.full_like(time, scene.cycle_rate)
    return Jet(rate * time, rate, np.zeros_like(time))


def _modes(scene: Scene, P: Transformation, force: Array) -> tuple[Modes, Array, Array]:
    """Modes at all positions, how the turning of the links strains them, and the static answer to the load.

    Turning strains mode j at the rate ``phi_i^T P^T k P' phi_j / omega_i^2``, per coordinate of mode i.
    """
    size = force.shape[1]
    count = size if scene.analysis.modes == "all" else min(scene.analysis.modes, size)
    omega, shapes, momenta = np.empty((len(force), count)), *np.empty((2, len(force), count, size))
    static, turning = np.zeros_like(force), []
    for k, (mass, stiffness, turned) in enumerate(P.matrices()):
        omega[k], shapes[k], momenta[k] = slowest(mass, stiffness, count, scene.petsc)
        turning.append(turned)
        if scene.analysis.static_correction:
            static[k] = _solved(stiffness, force[k])
    modes = followed(omega, shapes, momenta)
    strained = modes.shapes / modes.omega[..., None] ** 2
    straining = np.array([a @ turned @ b.T for a, turned, b in zip(strained, turning, modes.shapes)])
    return modes, straining, static


def _solved(matrix: PETSc.Mat, right: Array) -> Array:
    """Solve one system by PETSc."""
    vector, answer = matrix.createVecs()
    vector.array[:] = right
    ksp = PETSc.KSP().create(comm=PETSc.COMM_SELF)
    ksp.setOperators(matrix)
    with configured(ksp, "static_", DIRECT, {}):
        ksp.solve(vector, answer)
    found = np.array(answer.array_r)
    for thing in (vector, answer):
        thing.destroy()
    return found


def _ratios(scene: Scene, modes: Modes) -> Array:
    """Damping ratio of every mode (E.12): the last one stated holds for the modes after it."""
    stated = np.atleast_1d(scene.damping.ratio)
    return np.broadcast_to(stated[np.minimum(np.arange(modes.omega.shape[1]), len(stated) - 1)], modes.omega.shape)


def _refuse_beyond(scene: Scene) -> None:
    """Raise `SceneError` where a scene states what (5.1) with modal damping does not know."""
    damping, analysis = scene.damping, scene.analysis
    sections = [scene.sections[member.section] for _, member in scene.members().values()]
    there = {
        "effects": scene.effects,
        "loads": scene.loads,
        "impulses": scene.impulses,
        "springs": scene.springs,
        "dampers": scene.dampers,
        "joint_laws": scene.joint_laws,
        "freedoms": scene.freedoms,
        "plugins": scene.plugins,
        "tolerance": scene.tolerance,
        "drive": not scene.drives or [drive.motor for drive in scene.drives if drive.motor],
        "damping": damping.material or damping.external or damping.relative or damping.air,
        "sections": [section for section in sections if not section.constant],
        "analysis.reduction": analysis.reduction != "none",
        "analysis.start": analysis.start != "rigid",
        "joints": [name for name, joint in scene.joints.items() if joint.member is not None],
        "links": [r for r in scene.rigidities(np.zeros(1)) if r.neutral.any() or r.mass_centre.any()],
    }
    if place := next((name for name, value in there.items() if value), None):
        raise SceneError(
            "the dissertation's method knows driven links of uniform symmetric sections on pins, welds and guides, "
            "their inertia and weight, and damping ratios of modes",
            place=place,
            hint="Leave it out, or take fm.analyse, which knows it",
        )
