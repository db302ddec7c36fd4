"""What is wrong with a result by more than its estimates of errors say."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.rotary_inertia import EFFECT as ROTARY
from fenics_mech.effects.shear import EFFECT as SHEAR
from fenics_mech.effects.springs import too_stiff
from fenics_mech.response.periodic.steps import loads_act_like_impulses
from fenics_mech.response.solution import (
    CollocationSolution,
    FreeSolution,
    HarmonicSolution,
    Solution,
    StaticSolution,
)
from fenics_mech.scene import Analysis, Scene
from fenics_mech.scene.sampling import SAMPLING

LITTLE = 1e-3  # of an inertia or a displacement, below which what slopes change of it is not told
NO_ESTIMATE = "all errors, as none is estimated there"  # of a point of a sweep without error estimates
UNKNOWN_AFTER_CONTACT = "the error of the time steps, which contacts may make as large as the motion itself"
FINER_AFTER_CONTACT = (
    "how far contacts let nearly the same motions part: the error of the time steps is the difference from {} their "
    "tolerance"
)


def after_contacts(analysis: Analysis, share: str = "half") -> str:
    """Say what is not known of the time steps of a motion whose contacts opened.

    Parameters
    ----------
    analysis
        What the scene asks for.
    share
        Of their tolerance, that of the steps which tell of the error.
    """
    return FINER_AFTER_CONTACT.format(share) if analysis.error_estimates == "contacts" else UNKNOWN_AFTER_CONTACT


def not_estimated(solution: Solution) -> list[str]:
    """Say what is wrong by more than any of the estimates says.

    Parameters
    ----------
    solution
        A solution of any method.

    Returns
    -------
    list of str
        Phrases; empty where there is nothing to say.
    """
    found = _of_loads(solution) + _of_sections(solution) + _of_bodies(solution) + _of_rigid_links(solution)
    found += _of_shear(solution)
    if isinstance(solution, FreeSolution):
        found.append("what the mesh does to a motion with freedoms")
        found += [after_contacts(solution.scene.analysis)] if solution.course.parted else []
    springs = too_stiff(solution.scene)
    found += [f"what damping.ratio makes of the torsional spring {name!r}, by the mesh" for name in springs]
    cut = isinstance(solution, CollocationSolution)  # steps are cut at corners of the loads' factors
    return found + between_points(solution.scene, _points_of(solution), cut)


def _of_loads(solution: Solution) -> list[str]:
    """Vibration that loads excite beyond what mesh and modes resolve."""
    found, beyond = [], "put into vibration that mesh and modes are too coarse for"
    if solution.scene.impulses and not isinstance(solution, StaticSolution):
        found.append(f"what impulses {beyond}")
    if solution.scene.loads and isinstance(solution, CollocationSolution) and loads_act_like_impulses(solution.scene):
        found.append(f"what pulses much shorter than a step {beyond}")
    return found


def _slopes(solution: Solution) -> Array:
    """Give the largest slope of every node over all positions, ``(nodes,)``."""
    nodal = solution.system.to_links(solution.response.displacement)
    return np.asarray(np.abs(nodal[:, 2::3]).max(axis=0))


def _of_sections(solution: Solution) -> list[str]:
    """What the sections' inertia misses where axes turn far: it is that of rotations w', and not of their arc sines.

    Its share of the mass is ``(pi r/L)^2``, of which large slopes change ``w'^2/2``.
    """
    scene, system = solution.scene, solution.system
    if ROTARY.name not in scene.named_effects or isinstance(solution, StaticSolution) or system.spin is not None:
        return []
    middle = np.array([0.5])
    sections = [(scene.rigidity(label, middle), math.dist(*scene.member_ends(label))) for label in scene.members()]
    heaviest = max(float(part.rotary_inertia[0] / part.line_density[0]) / length**2 for part, length in sections)
    slope = float(_slopes(solution).max())
    if math.pi**2 * heaviest * slope**2 / 2 < LITTLE:
        return []
    return [f"what slopes of {slope:.2g} change of the inertia of the sections, which is that of small rotations"]


def _of_bodies(solution: Solution) -> list[str]:
    """What moments of inertia of point masses miss where the axis below them turns far, as `_of_sections`."""
    scene, system, found = solution.scene, solution.system, list[str]()
    if isinstance(solution, StaticSolution):
        return found
    slopes, middle = _slopes(solution), np.array([0.5])
    for node, body in system.beams.inertia.bodies:
        place = system.beams.mesh.node_name[node]
        members = [label for label, (link, _) in scene.members().items() if link == place.split(".")[0]]
        if not body.inertia or not members:
            continue
        lengths = [math.dist(*scene.member_ends(label)) for label in members]
        densities = [scene.rigidity(label, middle).line_density[0] for label in members]
        share = body.inertia / (body.mass + np.dot(densities, lengths)) / max(lengths) ** 2
        slope = float(slopes[node])
        if math.pi**2 * share * slope**2 / 2 >= LITTLE:
            found.append(
                f"what a slope of {slope:.2g} changes of the inertia at {place}, which is that of small rotations"
            )
    return found


def _of_shear(solution: Solution) -> list[str]:
    """What shear misses where axes turn far: its angles are added to slopes, and not to rotations.

    Its share of the deflection is ``(pi/L)^2 EI/(G A_s)``, of which large slopes change ``w'^2/2``.
    """
    scene, system = solution.scene, solution.system
    if system.terms.law is None or SHEAR.name not in scene.named_effects:
        return []
    middle = np.array([0.5])
    softest = max(
        float((scene.rigidity(label, middle).bending / scene.shear_stiffness(label, middle))[0])
        / math.dist(*scene.member_ends(label)) ** 2
        for label in scene.members()
    )
    slope = float(_slopes(solution).max())
    if math.pi**2 * softest * slope**2 / 2 < LITTLE:
        return []
    return [f"what slopes of {slope:.2g} change of the angles of shear, which are those of small rotations"]


def _of_rigid_links(solution: Solution) -> list[str]:
    """What places of points on rigid links miss where strains are exact and the links turn far with elastic ones."""
    scene, system, found = solution.scene, solution.system, list[str]()
    if system.terms.law is None:
        return found
    turned = _slopes(solution)
    for name, link in scene.links.items():
        if link.rigid is None or all(place == tuple(link.rigid.centre) for place in link.points.values()):
            continue
        turn = float(turned[system.beams.mesh.node(f"{name}.centre")])
        if turn**2 / 2 >= LITTLE:
            found.append(
                f"what an elastic rotation by {turn:.2g} rad changes of the places of points on the rigid link "
                f"{name!r}, which are those of small rotations (a stiff member of one element has none of this error)"
            )
    return found


def between_points(scene: Scene, count: int, cut: bool = False) -> list[str]:
    """Say what loads and drives do between the points of a cycle.

    Parameters
    ----------
    scene
        The scene.
    count
        Number of the points; 0 where steps are as short as they need be.
    cut
        Whether steps are cut at corners of the loads' factors.
    """
    if not count:
        return []
    loads = [
        f"what the factor of the load {name!r} does between positions, which do not see it"
        for name, load in scene.loads.items()
        if not (cut and load.cut_where_needed)
        if load.share_missed(count) > SAMPLING.unresolved or load.enough_angles(count) > count
    ]
    drives = [drive for drive in scene.drives if drive.enough_angles(count, scene.cycle_rate) > count]
    return loads + [f"what the law of the drive at {drive.joint!r} does between positions" for drive in drives]


def _points_of(solution: Solution) -> int:
    """Number of points of a cycle that see what a load or a drive does; 0 where steps are as short as they need be."""
    analysis = solution.scene.analysis
    if analysis.method == "static":
        return 0
    by_points = isinstance(solution, CollocationSolution | HarmonicSolution)
    return analysis.sub_intervals * (analysis.stages if by_points else 1)
