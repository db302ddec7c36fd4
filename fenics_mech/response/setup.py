"""From a scene to its mechanism at the drive angles, with the effects that act in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._guard import guarded, require_memory
from fenics_mech.beams import Beams, assemble_beams, mesh_scene
from fenics_mech.beams.reduction import Reduction
from fenics_mech.effects import EFFECTS, NOTHING, Situation, StressStiffening, active, build_terms, shaped
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.kinematics import Motion, refuse_unresolved, solve_motion
from fenics_mech.kinematics.freedom import describe
from fenics_mech.mechanism import RigidModes, System, build_system
from fenics_mech.mechanism.rigid import LARGEST_TURN
from fenics_mech.modes import Modes, solve_modes
from fenics_mech.response.periodic.steps import Steps, hides
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.meshing import member_nodes, thinned
from fenics_mech.scene.sampling import SAMPLES

MOST_SEEN = 10  # elements of a reduced member on which strains are recovered: 5e-6 of them off those on 64
MOST_PRESSED = 32  # the same, where axial forces act on the bent axis: those are as good as these elements
MOST_UPDATES = 60  # of the axial forces by the response
CUT = "Write analysis.method = 'periodic' and solver = 'collocation', whose steps are cut at corners. Or "
SETTLED = 1e-7  # change of the axial forces, of the largest


@guarded()
def mechanism(scene: Scene, progress: Callable[[str], None] = lambda step: None) -> System:
    """Build the mechanism at equal steps over a cycle, or at its one position when nothing drives it.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at some drive angle.
    SceneError
        When the cycle and its results need more memory than there is, or its positions miss a corner of the motion.
    """
    require_positions(scene, scene.analysis.sub_intervals if scene.drives and scene.analysis.method != "static" else 1)
    progress("kinematics")
    if scene.analysis.method == "static":
        motion = solve_motion(scene, np.array([scene.analysis.position])).held()
    else:
        motion = solve_motion(scene, scene.drive_angles(scene.analysis.sub_intervals) if scene.drives else np.zeros(1))
        if scene.drives and scene.analysis.method != "transient" and not scene.analysis.allow_coarse:
            refuse_unresolved(scene, motion)
    progress("beams")
    return system_at(scene, links(scene), motion)


def refuse_unseen(scene: Scene, points: int, by_collocation: bool = False) -> None:
    """Raise `SceneError` where points of a cycle miss what a load or a drive does between them.

    Parameters
    ----------
    scene
        The scene.
    points
        Number of points of the cycle.
    by_collocation
        Whether they are collocation points of steps that are cut at hidden corners of the loads' factors.
    """
    if scene.analysis.allow_coarse or not scene.drives or scene.analysis.method == "static":
        return
    several, count = isinstance(scene.drive, tuple), scene.analysis.sub_intervals
    found = {
        f"drive.{i}.law" if several else "drive.law": (
            "the law of the drive",
            drive.enough_angles(points, scene.cycle_rate),
        )
        for i, drive in enumerate(scene.drives)
    }
    for name, load in scene.loads.items():
        enough = points if by_collocation and load.cut_where_needed else load.enough_angles(points)
        found[f"loads.{name}.factor"] = "the factor of the load", enough
    for place, (what, enough) in found.items():
        if enough > points:
            slower = "state what changes more slowly, such as a wider pulse; analysis.allow_coarse lets it pass"
            wanted = f"Take at least {math.ceil(count * enough / points)} sub_intervals, or {slower}"
            raise SceneError(
                f"{count} positions miss what {what} does between them",
                place=place,
                hint=wanted
                if enough < SAMPLES
                else (CUT if place.startswith("loads.") and not by_collocation else "") + slower,
            )
    if by_collocation:
        refuse_hidden(scene)


def refuse_hidden(scene: Scene) -> None:
    """Raise `SceneError` where a load's factor has a peak that no collocation point of the scene's steps shows."""
    steps, tableau = Steps.of(scene), Tableau.of(scene.analysis.scheme, scene.analysis.stages)
    for name, load in scene.loads.items():
        if not scene.analysis.allow_coarse and hides(load, steps, tableau, scene.cycle_rate):
            raise SceneError(
                f"the factor has a peak between the points of {scene.analysis.sub_intervals} steps of a cycle",
                place=f"loads.{name}.factor",
                hint="State the peak by a table or a pulse, at whose corners steps are cut, or make it wider; "
                "analysis.allow_coarse lets it pass",
            )


def links(scene: Scene) -> Beams:
    """Mesh and assemble the links, with fewer coordinates if the scene wants that."""
    fine = shaped(scene, assemble_beams(scene, mesh_scene(scene)))
    if scene.analysis.reduction == "none":
        return fine
    members = _reducible(scene, fine)
    varies = fine.inertia.density.varies  # then strains are recovered on all elements
    coarse = scene if varies else thinned(scene, [fine.mesh.members[i] for i in members], _most_seen(scene))
    seen = fine if coarse is scene else shaped(coarse, assemble_beams(coarse, mesh_scene(coarse)))
    cutoff = scene.analysis.cutoff
    reduction = Reduction.of(fine, seen, members, None if cutoff == "auto" else 2 * math.pi * cutoff)
    return replace(seen, reduction=reduction)


def stress_stiffened(scene: Scene) -> bool:
    """Whether axial forces act on the bent axis."""
    return any(effect.stress_stiffening for effect in active(scene))


def _most_seen(scene: Scene) -> int:
    """Elements of a reduced member on which it is recovered, at most."""
    return MOST_PRESSED if stress_stiffened(scene) else MOST_SEEN


def _reducible(scene: Scene, beams: Beams) -> list[int]:
    """Members that have inner nodes, and no need of them: no pin travels along them, and they can stretch."""
    guides = {
        id(scene.links[joint.connect[0].split(".")[0]].members[joint.member])
        for joint in scene.joints.values()
        if isinstance(joint, Slot | Prismatic) and joint.member is not None
    }
    owners = beams.mesh.cell_member
    needed = np.append(owners[np.isinf(beams.rigidity.axial.mean)], np.flatnonzero(np.bincount(owners) == 1))
    return [i for i, (_, member) in enumerate(scene.members().values()) if id(member) not in guides and i not in needed]


def require_positions(scene: Scene, positions: int) -> None:
    """Raise `TooLargeError` where loops, nodes and results at so many positions do not fit into memory."""
    most = math.inf if scene.analysis.reduction == "none" else _most_seen(scene)
    nodes = sum(min(len(member_nodes(scene, label)), most) for label in scene.members())
    each = 4 * (3 * len(scene.links)) ** 2 + 200 * nodes + 48 * len(scene.members()) * scene.analysis.stations
    hint = "Take fewer sub_intervals, cycles of a motion in time, stations or elements"
    require_memory(float(positions) * each, f"{positions} positions of {len(scene.links)} links", hint)


def system_at(scene: Scene, beams: Beams, motion: Motion) -> System:
    """Build the mechanism at the angles of a motion, with its effects."""
    return _with_effects(scene, build_system(scene, beams, motion))


def moved(scene: Scene, system: System, motion: Motion) -> System:
    """Take a mechanism to another motion with the same coordinates, which `system_at` may choose anew."""
    return _with_effects(scene, replace(system, motion=motion, terms=NOTHING))


def _with_effects(scene: Scene, bare: System) -> System:
    situation = Situation(scene, bare.beams, bare.motion, tension=lambda: rigid_tension(scene, bare))
    return replace(bare, terms=build_terms(situation))


def rigid_tension(scene: Scene, bare: System) -> Array:
    """Axial force of each element from loads and rigid motion (N), ``(angles, elements)``."""
    linear = tuple(name for name in scene.named_effects if not EFFECTS[name].stress_stiffening)
    system = _with_effects(scene.changed(effects=linear), bare)
    return mean_tension(system, static_response(scene, system))


def rough_tension(scene: Scene, system: System) -> Array | None:
    """Axial force from loads and rigid motion (N), in the strings of the links' nonlinear law, if they have one."""
    law = system.terms.law
    return None if law is None else law.on_elements.mean(rigid_tension(scene, system))


def static_response(scene: Scene, system: System) -> ElasticResponse:
    """Solve for the static or quasi-static response, as far as something holds the mechanism.

    Raises
    ------
    SceneError
        When nothing is driven, and loads move a rigid-body mode that is to stay at rest, or moderate rotations are
        asked for where there is one.
    SolverError
        When there is no answer, or springs let a whole link turn too far for small motions.
    """
    if not len(system.motion.free):
        return solve_static(system, scene.petsc)
    rigid = RigidModes.of(system)
    if loose := rigid.moved_by(system.load[0]) if scene.analysis.method == "static" else []:
        free = "; ".join(names_of(scene, system, rigid, loose))
        raise SceneError(
            f"nothing holds the mechanism against its loads: {free}",
            place="analysis.method",
            hint="Add a drive, a spring or a support, or write method = 'quasi-static' for links that give way to the "
            "loads and carry their own inertia",
        )
    if len(rigid) and system.terms.law is not None:
        free = "; ".join(names_of(scene, system, rigid))
        raise SceneError(
            f"the effect 'moderate-rotations' needs a mechanism that is held: {free}",
            place="effects",
            hint="Add a drive, a spring or a support, or leave the effect out",
        )
    at_rest = scene.analysis.method == "static"
    response = solve_static(system, scene.petsc, RigidModes.of(system, symmetric=False) if at_rest else None)
    turned = np.abs(system.to_links(response.displacement)[:, 2::3])
    whole = np.array([turned[:, system.beams.mesh.node_link == i].min() for i in range(len(scene.links))])
    if whole.max() > LARGEST_TURN:
        farthest = list(scene.links)[int(whole.argmax())]
        raise SolverError(
            f"what holds the mechanism lets link {farthest} turn by {whole.max():.3g} rad from its rough angle, "
            f"and small motions end at {LARGEST_TURN} rad. Give angles near to the equilibrium, or stiffer springs"
        )
    return response


def names_of(scene: Scene, system: System, rigid: RigidModes, which: Sequence[int] | None = None) -> list[str]:
    """Say of freedoms that nothing holds what moves in them."""
    motion = system.motion
    motions = np.einsum("mf,fli->mli", rigid.freedoms, motion.free)
    q = np.concatenate([motion.position[0], motion.angle[0][:, None]], axis=1)
    return describe(scene, q, motions if which is None else motions[list(which)])


def boundary_load(scene: Scene, system: System) -> Array | None:
    """Load at the starts of the sub-intervals, ``(angles, coordinates)``, where the scene asks for a linear load."""
    if scene.analysis.load == "constant":
        return None
    half = math.copysign(math.pi / len(system.motion.theta), scene.cycle_rate)
    motion = solve_motion(scene, system.motion.theta - half, near=system.motion)
    return moved(scene.changed(effects=()), system, motion).load  # axial forces load nothing by themselves


def modes_kept(scene: Scene, system: System) -> int:
    """Give the number of modes that the scene keeps."""
    return system.size if scene.analysis.modes == "all" else min(scene.analysis.modes, system.size)


@guarded()
def scene_modes(scene: Scene, system: System) -> Modes:
    """Solve for the modes that the scene keeps."""
    return solve_modes(system, modes_kept(scene, system), scene.petsc)


def settle(system: System, respond: Callable[[System], ElasticResponse]) -> System:
    """Update the tension of the geometric stiffness with the response until it settles.

    Parameters
    ----------
    system
        The mechanism with the effect 'geometric-stiffness'.
    respond
        Gives the response of a mechanism.

    Raises
    ------
    SolverError
        When the axial forces do not settle.
    """
    for _ in range(MOST_UPDATES):
        tension = mean_tension(system, respond(system))
        before = system.terms.stiffening
        assert before is not None
        change = np.abs(tension - before.tension).max() / max(float(np.abs(tension).max()), 1e-300)
        system = with_tension(system, tension)
        if change < SETTLED:
            return system
    raise SolverError(
        f"the axial forces do not settle: after {MOST_UPDATES} updates they still change by {change:.1e} of the "
        "largest. Take the effect 'moderate-rotations' instead of 'geometric-stiffness' with tension = 'settled'"
    )


def with_tension(system: System, tension: Array) -> System:
    """Give a system whose geometric stiffness comes from another axial force (N), ``(angles, elements)``."""
    return replace(system, terms=replace(system.terms, stiffening=StressStiffening.of(system.beams, tension)))
