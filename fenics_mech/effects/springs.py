"""Springs between points, and torsional springs at joints."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.separations import SEPARATION, Separation, across
from fenics_mech.effects.terms import NOTHING, AddedMatrices, Loads, Situation, Terms
from fenics_mech.errors import SceneError, UnresolvedError
from fenics_mech.kinematics import Motion, solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import member_nodes
from fenics_mech.scene.springs_dampers import HingeSpring, LineSpring

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh


def terms(situation: Situation) -> Terms:
    """Give the springs' forces at the elongation of the rigid motion, and how these change with v.

    With d from the first point to the second and its length l the force is ``k (1 - l0/l) d``. Its tangent is
    ``k (1 - (l0/l) (1 - n n^T))``: the spring's stiffness along n, and across it the tension over the length.
    """
    scene, mesh, motion = situation.scene, situation.beams.mesh, situation.motion
    size = 3 * len(mesh.node_name)
    if scene.analysis.method == "periodic" and scene.drives:
        for name, spring in scene.springs.items():
            if isinstance(spring, HingeSpring):
                _refuse_winding(motion.theta, scene.cycle_rate, name, Separation.of(scene, mesh, motion, spring))
    found = (
        Terms(
            loads=Loads(force=separation.force(pull, size)),
            matrices=AddedMatrices(stiffness=(separation.entries(tangent),)),
            rotation_forces=separation.couples(pull, tangent),
        )
        for separation, pull, tangent, _ in _pulls(scene, mesh, motion)
    )
    return sum(found, NOTHING)


def spring_forces(scene: Scene, mesh: BeamMesh, motion: Motion, v: Array) -> dict[str, Array]:
    """Tension of each spring (N), or the moment with which it turns its second body back (N m), ``(angles,)``.

    Parameters
    ----------
    scene, mesh, motion
        The scene, its mesh and its rigid motion.
    v
        Elastic displacement in link axes, ``(angles, nodal dofs)``.
    """
    forces = {}
    for name, spring in scene.springs.items():
        separation = Separation.of(scene, mesh, motion, spring)
        if isinstance(spring, HingeSpring):
            longer = separation.value[:, 0] - _free_angle(scene, mesh, spring) + separation.elastic(v)[:, 0]
        else:
            along = separation.value / np.maximum(separation.length, np.finfo(float).tiny)[:, None]
            longer = (
                separation.length - _free_length(scene, mesh, spring) + np.sum(along * separation.elastic(v), axis=1)
            )
        forces[name] = spring.stiffness * longer
    return forces


def spring_power(scene: Scene, mesh: BeamMesh, rates: Motion, v: Array, deformation: Array) -> Array:
    """Power of all springs on the bent mechanism (W), ``(angles,)``: minus the rate of their energy to second order.

    With the elastic part e of the separation d, the energy is ``V(d) + V' e + e V'' e/2`` about the rigid motion.

    Parameters
    ----------
    scene, mesh
        The scene and its mesh.
    rates
        Rates of the links, true or virtual.
    v, deformation
        Elastic displacement in link axes, and its rate, ``(angles, nodal dofs)``.
    """
    power = np.zeros(len(v))
    for separation, pull, tangent, bending in _pulls(scene, mesh, rates):
        e, rate = separation.elastic(v), separation.rate
        force = pull + (tangent @ e[..., None])[..., 0]
        power -= np.sum(force * (rate + separation.elastic_rate(v, deformation)), axis=1)
        if bending:
            n, length = separation.value / separation.length[:, None], separation.length
            along, turned = np.sum(n * rate, axis=1), separation.turned(n, rate)
            aside = np.sum(e * (across(n) @ e[..., None])[..., 0], axis=1)
            cross = np.sum(turned * e, axis=1) * np.sum(n * e, axis=1)
            power -= bending / length * (along / length * aside / 2 + cross)
    return power


def spring_energy(scene: Scene, mesh: BeamMesh, motion: Motion, v: Array) -> Array:
    """Energy of all springs to second order in v (J), ``(angles,)``, but for a constant; see `spring_power`.

    Parameters
    ----------
    scene
        The scene.
    mesh
        The mesh of its members.
    motion
        Its rigid motion.
    v
        Elastic displacement in link axes, ``(angles, nodal dofs)``.
    """
    energy = np.zeros(len(v))
    stiffness = [spring.stiffness for spring in scene.springs.values()]
    for k, (separation, pull, tangent, _) in zip(stiffness, _pulls(scene, mesh, motion)):
        e = separation.elastic(v)
        energy += np.sum(pull * (e + pull / (2 * k)) + (tangent @ e[..., None])[..., 0] * e / 2, axis=1)
    return energy


def shortening_power(scene: Scene, mesh: BeamMesh, rates: Motion, v: Array, deformation: Array) -> Array:
    """Of `spring_power`, the part that is linear in a displacement (W), ``(angles,)``.

    Parameters are those of `spring_power`.
    """
    power = np.zeros(len(v))
    for separation, pull, tangent, _ in _pulls(scene, mesh, rates):
        change = (tangent @ separation.elastic(v)[..., None])[..., 0]
        power -= np.sum(pull * separation.elastic_rate(v, deformation) + change * separation.rate, axis=1)
    return power


def _pulls(scene: Scene, mesh: BeamMesh, motion: Motion) -> Iterator[tuple[Separation, Array, Array, float]]:
    """Give what lies between the ends of each spring, its pull and tangent, and stiffness times free length (N)."""
    for name, spring in scene.springs.items():
        separation, k, bending = Separation.of(scene, mesh, motion, spring), spring.stiffness, 0.0
        if isinstance(spring, HingeSpring):
            pull, tangent = separation.value - _free_angle(scene, mesh, spring), np.ones((len(separation.value), 1, 1))
        else:
            free = _free_length(scene, mesh, spring)
            pull, tangent = _of_line(motion, name, separation, free)
            bending = k * free
        yield separation, k * pull, k * tangent, bending


def _of_line(motion: Motion, name: str, separation: Separation, free: float) -> tuple[Array, Array]:
    """Force of a spring of stiffness 1, ``(angles, 2)``, and its tangent, ``(angles, 2, 2)``."""
    one = np.broadcast_to(np.eye(2), (len(separation.value), 2, 2))
    if free == 0:
        return separation.value, one
    direction = separation.direction(motion, f"springs.{name}")
    return separation.value - free * direction, one - (free / separation.length)[:, None, None] * across(direction)


def _at_start(scene: Scene, mesh: BeamMesh, spring: LineSpring | HingeSpring) -> Separation:
    return Separation.of(scene, mesh, solve_motion(scene, np.zeros(1)), spring)


def _free_length(scene: Scene, mesh: BeamMesh, spring: LineSpring) -> float:
    return float(_at_start(scene, mesh, spring).length[0]) if spring.length is None else spring.length


def _free_angle(scene: Scene, mesh: BeamMesh, spring: HingeSpring) -> float:
    """Rotation at which the spring is free: as stated, whole turns and all, or that at the start."""
    return float(_at_start(scene, mesh, spring).value[0, 0]) if spring.angle is None else spring.angle


def too_stiff(scene: Scene) -> dict[str, float]:
    """Give torsional springs whose own vibration is one of the mesh, and damped by a ratio, with what they may have.

    Its frequency is about the root of stiffness over the inertia of an element's end, and the drag of modal damping on
    the rotation goes with it, whatever the slow motion is. The bound (N m/rad) is as good as rigid beside the elements.

    Parameters
    ----------
    scene
        The scene.

    Returns
    -------
    dict
        By name of the spring, the largest stiffness that it may have (N m/rad).
    """
    if not np.any(scene.damping.ratio) or scene.analysis.method not in ("periodic", "transient"):
        return {}
    bounds = {name: _bound(scene, spring) for name, spring in scene.springs.items() if isinstance(spring, HingeSpring)}
    return {name: bound for name, bound in bounds.items() if scene.springs[name].stiffness > bound}


def _bound(scene: Scene, spring: HingeSpring) -> float:
    """Give the largest stiffness of a torsional spring beside the elements that end at its joint (N m/rad)."""
    points = [point.split(".") for point in scene.joints[spring.joint].connect]
    ends, held = [], {(body, scene.links[body].end_at(point)) for body, point in points if body != "ground"}
    for label, (link, member) in scene.members().items():
        for end in (0, 1):
            if (link, member.ends[end]) in held:
                share = np.diff(member_nodes(scene, label, True))[-end]
                h = share * math.dist(*scene.member_ends(label))
                ends.append(4 * float(scene.rigidity(label, np.array([float(end)])).bending[0]) / h)
    return SEPARATION.stiffest * min(ends, default=math.inf)


def refuse_too_stiff(scene: Scene) -> None:
    """Raise `UnresolvedError` for a torsional spring that is `too_stiff`, unless the scene lets it pass.

    Parameters
    ----------
    scene
        The scene.
    """
    for name, bound in ({} if scene.analysis.allow_coarse else too_stiff(scene)).items():
        raise UnresolvedError(
            f"springs.{name}: with damping.ratio the drag on a torsional spring so much stiffer than the elements "
            f"beside it depends on the mesh. Take up to {bound:.2g} N m/rad, which is as good as rigid there, or "
            "damping.material instead of the ratio; analysis.allow_coarse lets it pass"
        ).finer_by(elements=1.01 * scene.springs[name].stiffness / bound)  # which goes with one over their lengths


def wound_at_start(stated: Scene, scene: Scene) -> tuple[str, ...]:
    """Tell of torsional springs that begin more than half a turn away from a free angle within one turn.

    An angle read off a sketch may be a whole turn away from that of the joint. Where the scene states the joint's start
    or a free angle of a turn and more, turns are meant.

    Parameters
    ----------
    stated
        The scene as it is stated.
    scene
        The same, with a freedom for all that can move and no drive leads.
    """
    chosen = {name for name, freedom in stated.freedoms.items() if freedom.start is not None}
    chosen |= {drive.joint for drive in stated.drives}
    found = []
    for name, spring in stated.springs.items():
        if not isinstance(spring, HingeSpring) or spring.angle is None or spring.joint in chosen:
            continue
        here = _angle_between(scene, spring)
        turns = round((here - spring.angle) / TURN)
        if turns and abs(spring.angle) < TURN:
            angles = here, spring.angle, spring.angle + turns * TURN
            begins, free, nearer = (f"{math.degrees(angle):.6g} deg" for angle in angles)
            found.append(
                f"springs.{name}.angle: the joint begins at {begins} and the spring is free at {free}, so that it is "
                f'wound up at the start. Whole turns count: "{nearer}" is less'
            )
    return tuple(found)


def _angle_between(scene: Scene, hinge: HingeSpring) -> float:
    """Angle of a hinge's second body against its first at drive angle 0 (rad)."""
    bodies = hinge.bodies or tuple(point.split(".")[0] for point in scene.joints[hinge.joint].connect)
    angles = dict(zip(scene.links, solve_motion(scene, np.zeros(1)).angle[0].tolist())) | {"ground": 0.0}
    return angles[bodies[1]] - angles[bodies[0]]


def _refuse_winding(theta: Array, cycle_rate: float, name: str, separation: Separation) -> None:
    """Raise `SceneError` when a spring is wound up by a turn in every cycle; a part of a cycle alone tells nothing."""
    steps = np.diff(theta, append=theta[0] + TURN)
    if steps.max() > TURN / 4:
        return
    rate = separation.rate.reshape(len(theta), -1)[:, 0] / cycle_rate
    if round(float(np.sum(steps * (rate + np.roll(rate, -1))) / (2 * TURN))):
        raise SceneError(
            "the bodies turn against each other without end, which winds the spring up in every cycle",
            place=f"springs.{name}",
            hint="Put it at a joint that swings, or write analysis.method = 'quasi-static' for one cycle",
        )


EFFECT = Effect(
    name="springs",
    meaning="springs between points, and torsional springs at joints",
    source="Przemieniecki (1968), ch. 15, for the tangent",
    work="own",
    terms=terms,
    stated=lambda scene: bool(scene.springs),
    stated_by="[springs]",
)
