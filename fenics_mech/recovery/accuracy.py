"""Errors of strains and joint forces, one by each source, from motions that the solver gives without that error."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech.beams.varying import misfit
from fenics_mech.effects import NOTHING
from fenics_mech.effects.effect import Choice
from fenics_mech.effects.springs import too_stiff
from fenics_mech.errors import UnresolvedError
from fenics_mech.mechanism import System
from fenics_mech.recovery.contacts import point_loads
from fenics_mech.recovery.ends import element_tension
from fenics_mech.recovery.joints import joint_forces, joint_names, nodal_forces, reactions
from fenics_mech.recovery.members import recover_members, section_forces, stiffnesses
from fenics_mech.recovery.mesh_error import OF_SLIDERS
from fenics_mech.recovery.passing import ringing, unloaded
from fenics_mech.response import History
from fenics_mech.response.steps import like_blows
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
STATIONS = 5  # of each member at which strains are compared
LARGEST_ERROR = 0.05  # of the largest strain, by all numerical sources
LEAST = 0.1  # of the mechanism's largest strain that a member's own must have to be the measure of its error
STEPS = ("time", "harmonics")
NUMERICAL = (*STEPS, "modes", "mesh")  # sources that are judged
LIMITS = ("strain", STEPS, 0.02), ("strain", NUMERICAL, LARGEST_ERROR), ("force", NUMERICAL, 0.5)
FAULTS = {
    "time": "the sub-intervals are too long",
    "mesh": "the elements are too long",
    "modes": "the modes kept are too few",
    "harmonics": "the harmonics are too few",
}
OWN_STEPS = ("transient_ts_rtol", "transient_ts_atol", "transient_ts_adapt")  # options beside the tolerance
UNSEEN = 0.1  # of the largest value of a factor
MARGIN = 1.2  # of the numbers that a refusal asks for


@dataclass(frozen=True)
class Errors:
    """Errors by their sources: "time" (steps), "mesh", "modes" (left out), "harmonics", "stations", "effects".

    Parameters
    ----------
    strain, force
        Of the strain of each member, and of the force in each joint (N): by source, ``(members,)`` and ``(joints,)``.
    order
        With which power of its number a source falls: of sub-intervals, elements, modes, harmonics, stations; 0 where
        it does not.
    largest, forces
        The largest strain of each member, ``(members,)``, and the largest force in each joint (N), ``(joints,)``.
    """

    strain: Mapping[str, Array]
    force: Mapping[str, Array]
    order: Mapping[str, float]
    largest: Array
    forces: Array

    @property
    def measure(self) -> Array:
        """Strain of each member that its error is relative to."""
        return np.maximum(np.maximum(self.largest, LEAST * self.largest.max()), np.finfo(float).tiny)

    @property
    def most_force(self) -> Array:
        """Force that the error of each joint's is relative to, the largest of all (N), ``(joints,)``."""
        return np.full_like(self.forces, max(float(self.forces.max(initial=0.0)), np.finfo(float).tiny))

    @property
    def relative(self) -> dict[str, float]:
        """Largest error of a strain by each source, relative to the member's largest strain."""
        return {source: float((error / self.measure).max()) for source, error in self.strain.items()}

    @property
    def total(self) -> float:
        """Largest error of a strain by all sources together, relative to the member's largest strain."""
        return float(self.of(list(self.strain)).max())

    def judge(self, scene: Scene) -> None:
        """Raise `UnresolvedError` where the numerical errors are too large, unless the scene lets them pass."""
        if scene.analysis.allow_coarse:
            return
        names = {"strain": list(scene.members()), "force": joint_names(scene)}
        for what, sources, limit in LIMITS:
            errors = self.of(sources, what)
            if not errors.max(initial=0.0) <= limit:
                worst = int(errors.argmax())
                shares = {source: float(self.of([source], what)[worst]) for source in sources}
                place = f"{'of' if what == 'strain' else 'in joint'} {names[what][worst]!r}"
                measure = "its largest value" if what == "strain" else "the largest joint force"
                raise _refusal(scene, f"{what} {place} is uncertain by", measure, shares, self.order, limit)

    def of(self, sources: Sequence[str], what: str = "strain") -> Array:
        """Error by some sources together, relative to its measure, of members' strains or joints' forces."""
        errors, size = (self.strain, self.measure) if what == "strain" else (self.force, self.most_force)
        found = [errors[source] for source in sources if source in errors]
        return np.sum(found, axis=0) / size if found else np.zeros_like(size)

    @property
    def too_large(self) -> bool:
        """Whether they are larger than `judge` lets pass."""
        return any(not self.of(sources, what).max(initial=0.0) <= limit for what, sources, limit in LIMITS)


def _refusal(
    scene: Scene, what: str, measure: str, shares: Mapping[str, float], order: Mapping[str, float], limit: float
) -> UnresolvedError:
    """Say which source has the largest part in the error of a strain or force, and what to do about it."""
    total, source = sum(shares.values()), max(shares, key=shares.__getitem__)
    room = max(limit - (total - shares[source]), limit / 2)
    in_time = source == "time" and scene.analysis.method == "transient"
    fault = "the time steps or sub-intervals are too long" if in_time else FAULTS[source]
    return UnresolvedError(
        f"{fault}: the {what} {total:.2g} of {measure}, by estimate, "
        f"{shares[source]:.2g} of it by the {source}. "
        f"{_advice(scene, source, (shares[source] / room) ** (1 / order[source]))}; "
        "analysis.allow_coarse lets it pass"
    )


def estimated(
    scene: Scene,
    system: System,
    history: History,
    strain: Array,
    sampling: Array | None = None,
    choices: Sequence[Choice] = (),
) -> Errors:
    """Estimate the errors of a result by all sources that can be told.

    Parameters
    ----------
    scene, system, history
        What was analysed, and its motion with those that are better.
    strain
        Strains of the outer fibres, ``(angles, members, stations, fibres)``.
    sampling
        Error of the members' strains by the number of positions, ``(members,)``; it counts as "time".
    choices
        What was decided about effects.
    """
    base = _recovered(scene, system, history.elastic)
    largest, forces = np.abs(strain).max(axis=(0, 2, 3)), np.linalg.norm(base[2], axis=-1).max(axis=1, initial=0.0)
    nothing = np.zeros_like(largest), np.zeros_like(forces)
    strains: dict[str, Array] = {}
    by_joint: dict[str, Array] = {}
    order: dict[str, float] = {}

    def add(source: str, strain: Array, force: Array, falling: float) -> None:
        strains[source] = strains.get(source, 0.0) + strain
        by_joint[source] = by_joint.get(source, 0.0) + force
        order.setdefault(source, falling)

    for source, better in history.better.items():
        add(source, *nothing, better.order)
        if better.history.displacement is not history.displacement or better.loads is not NOTHING:
            there = system if better.loads is NOTHING else system.with_terms(system.terms + better.loads)
            strain_change, force_change = _change(_recovered(scene, there, better.history.elastic), base)
            add(source, better.safety * strain_change, better.safety * force_change, better.order)
        if better.hidden is not None:
            beside, share = better.hidden
            strain_change, force_change = _change(_recovered(scene, system, beside.elastic), base)
            add(source, strain_change / share, force_change / share, better.order)
    if scene.analysis.method in ("periodic", "transient") and (blows := _by_blows(scene, system, history.elastic)):
        add("mesh", *blows, OF_SLIDERS)
    if (missed := misfit(scene, system.beams)).any():
        add("mesh", missed * largest, missed.max() * forces, 1.0)
    if sampling is not None:
        add("time", sampling, nothing[1], 1.0)
    add("stations", between_stations(strain), nothing[1], 2.0)
    if (left := left_out(choices)) is not None:
        add("effects", left * largest, left * forces, 0.0)
    return Errors(strains, by_joint, order, largest, forces)


def _change(recovered: Sequence[Array], base: Sequence[Array]) -> tuple[Array, Array]:
    """Largest change of each member's strain and of the force in each joint; see `_recovered`."""
    axial, bending, forces = (after - before for after, before in zip(recovered, base))
    strain = (np.abs(axial) + np.abs(bending)).max(axis=(0, 2))
    return strain, np.linalg.norm(forces, axis=-1).max(axis=1, initial=0.0)


def _by_blows(scene: Scene, system: System, history: History) -> tuple[Array, Array] | None:
    """Strain of each member and force in each joint by the nodes that sliders pass; see `passing`. Modes add up."""
    free, step = unloaded(system), scene.period / scene.analysis.sub_intervals
    parts = [_recovered(scene, free, part) for part in ringing(system, history, step)]
    if not parts:
        return None
    strain = sum((np.abs(axial) + np.abs(bending)).max(axis=2) for axial, bending, _ in parts)
    force = sum(np.linalg.norm(forces, axis=-1) for *_, forces in parts)
    return strain.max(axis=0), force.max(axis=1, initial=0.0)


def left_out(choices: Sequence[Choice]) -> float | None:
    """Sum of the sizes of effects that are off, relative to the strains; None where they were not estimated."""
    if all(choice.size is None for choice in choices):
        return None
    inside = {choice.effect.replaces for choice in choices if choice.acts}
    return sum(c.size for c in choices if c.size is not None and not c.acts and c.effect.name not in inside)


def own_steps(scene: Scene) -> bool:
    """Whether the scene's options of PETSc choose the steps in time, whatever the tolerance."""
    return any(name.startswith(OWN_STEPS) for name in scene.petsc)


def not_estimated(scene: Scene, history: History) -> list[str]:
    """Say what is wrong by more than any of the estimates tells."""
    analysis, found = scene.analysis, []
    in_time = analysis.method == "transient"
    reduced, started = in_time and analysis.reduction != "none", in_time and analysis.start != "rigid"
    if history.course is not None and history.course.too_fast is not None:
        found.append(
            f"what the mesh does to vibration from {history.course.too_fast:.3g} Hz on, which {analysis.sub_intervals} "
            "sub_intervals are too few for"
        )
    found += [
        f"what the {source} does next to a resonance that hardly anything damps, which it may move there or away"
        for source, better in history.better.items()
        if better.unheld
    ]
    if scene.impulses and analysis.method in ("periodic", "transient"):
        found.append("what impulses put into vibration that mesh and modes are too coarse for")
    if scene.loads and analysis.method == "periodic" and _by_collocation(scene, history) and like_blows(scene):
        found.append("what pulses much shorter than a step put into vibration that mesh and modes are too coarse for")
    if in_time and own_steps(scene):
        found.append("the time steps, which PETSc's options state")
    if reduced and started:
        found.append("what the start puts into the modes left out of members")
    if reduced and any(load.jumps for load in scene.loads.values()):
        found.append("what loads that jump put into the modes left out of members")
    if started and scene.damping.material:
        found.append("strains in the first instants, where the start lets the material's viscous stress jump")
    if started and np.any(scene.damping.ratio):
        found.append("joint forces in the first instants, where the start lets the forces of damping jump")
    if analysis.method == "periodic" and history.velocity is None and analysis.join == "modal":
        found.append("what join = 'modal' loses where the modes' shapes change, whatever the number of sub_intervals")
    found += [f"what damping.ratio makes of the torsional spring {name!r}, by the mesh" for name in too_stiff(scene)]
    count = _seen_points(scene, history)
    found += [
        f"what the factor of the load {name!r} does between positions, which do not see it"
        for name, load in scene.loads.items()
        if count and not (_by_collocation(scene, history) and load.cut_where_needed)
        if load.unseen(count) > UNSEEN or load.enough_angles(count) > count
    ]
    found += [
        f"what the law of the drive at {drive.joint!r} does between positions"
        for drive in scene.drives
        if count and drive.enough_angles(count, scene.cycle_rate) > count
    ]
    return found


def _by_collocation(scene: Scene, history: History) -> bool:
    """Whether a motion was found by steps that are cut at corners of the loads' factors."""
    return scene.analysis.method == "periodic" and history.velocity is not None and "harmonics" not in history.better


def _seen_points(scene: Scene, history: History) -> int:
    """Number of points of a cycle that see what a load or a drive does; 0 where steps are as short as they need be."""
    analysis = scene.analysis
    if analysis.method == "transient":  # the viscous stress is judged by every second position
        return analysis.sub_intervals // 2 if scene.damping.material else 0
    if analysis.method == "static":
        return 0
    by_points = analysis.method == "periodic" and history.velocity is not None  # all but chapter 5
    return analysis.sub_intervals * (analysis.stages if by_points else 1)


def between_stations(strain: Array) -> Array:
    """By how much parabolas through three stations surpass the largest strain at the stations, ``(members,)``."""
    size = np.abs(strain)
    highest = size.max(axis=(0, 2, 3))
    if strain.shape[2] < 3:
        return np.zeros_like(highest)
    before, middle, after = strain[:, :, :-2], strain[:, :, 1:-1], strain[:, :, 2:]
    bend, slope = after - 2 * middle + before, (after - before) / 2
    inside = (np.abs(slope) < np.abs(bend)) & (bend != 0)
    vertex = middle - np.where(inside, slope**2 / (2 * np.where(inside, bend, 1.0)), 0.0)
    return np.maximum(np.abs(vertex).max(axis=(0, 2, 3)) - highest, 0.0)


def _advice(scene: Scene, source: str, times: float) -> str:
    """Say how many more it takes."""
    analysis = scene.analysis
    if source == "time" and analysis.method == "transient":
        tolerance = analysis.time_tolerance / (MARGIN * times)
        return f"Take analysis.time_tolerance = {tolerance:.1g}, and where the material damps more sub_intervals"
    if source == "modes" and analysis.reduction != "none":
        return f"Take a cutoff {math.ceil(MARGIN * times * 10) / 10:g} times as high"
    if source == "mesh" and analysis.reduction != "none":
        if "coupling" not in scene.named_effects:
            return "Take effects = ['coupling'], or reduction = 'none': (5.1) depends on the coordinates"
        return f"Take a cutoff {math.ceil(MARGIN * times**2 * 10) / 10:g} times as high, and finer elements"
    if source == "mesh":
        return f"Take {math.ceil(MARGIN * times * 100) / 100:.3g} times as many elements, rounded up"
    name, now = {
        "time": ("sub_intervals", analysis.sub_intervals),
        "modes": ("modes", analysis.modes),
        "harmonics": ("harmonics", analysis.harmonics),
    }[source]
    assert not isinstance(now, str)  # all modes leave none out
    return f"Take at least {math.ceil(MARGIN * now * times)} {name}"


def _stations(system: System) -> Array:
    """Places at which strains are compared; moments by lumps of mass, or a mean axial force, are right at nodes."""
    mesh, terms = system.beams.mesh, system.terms
    if system.beams.spread is None and terms.tension is None and terms.law is None:
        return np.linspace(0, 1, STATIONS)
    return np.linspace(0, 1, max(STATIONS, 2 * int(np.bincount(mesh.cell_member).max()) + 1))


def _recovered(scene: Scene, system: System, history: History) -> tuple[Array, Array, Array]:
    """Axial and bending strain at few stations, ``(angles, members, stations)``, forces ``(joints, angles, 2)``."""
    found = reactions(system, nodal_forces(system, history))
    s, loads = _stations(system), point_loads(system, found)
    ea, ei, _, fibre = stiffnesses(scene, s)
    if element_tension(system, history) is None:
        axial, _, moment = section_forces(system, history, s, loads)
        axial, moment = (part.reshape(len(part), *ea.shape) for part in (axial, moment))
    else:
        members = recover_members(system, history, s, loads)
        axial, moment = members.axial_force, members.moment
    forces = np.array(list(joint_forces(scene, found).values())).reshape(-1, len(axial), 2)
    return axial / ea, moment * np.abs(fibre).max(axis=-1) / ei, forces
