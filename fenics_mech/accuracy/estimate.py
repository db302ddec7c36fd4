"""Errors of strains, deflections, joint forces and efforts of drives, one by each source.

They come from motions that the solver gives without that error.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech.accuracy.mesh_residual import OF_SLIDERS, moved_by_gaps
from fenics_mech.accuracy.quantities import Quantities, measures, names_of
from fenics_mech.accuracy.slider_kinks import ringing, unloaded
from fenics_mech.beams.variable_sections import misfit
from fenics_mech.effects import NOTHING
from fenics_mech.effects.effect import Choice
from fenics_mech.effects.springs import too_stiff
from fenics_mech.errors import UnresolvedError
from fenics_mech.mechanism import System
from fenics_mech.response import History
from fenics_mech.response.periodic.steps import like_blows
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
LARGEST_ERROR = 0.05  # of the largest strain, by all numerical sources
LARGEST_OF_REST = 0.5  # of the largest deflection and joint force: beyond it not one digit is known
STEPS = ("time", "harmonics")
NUMERICAL = (*STEPS, "modes", "mesh")  # sources that are judged
LIMITS = (
    ("strain", STEPS, 0.02),
    ("strain", NUMERICAL, LARGEST_ERROR),
    ("deflection", NUMERICAL, LARGEST_OF_REST),
    ("joint_force", NUMERICAL, LARGEST_OF_REST),
)
PLACES = {  # of an error, in words, and what it is relative to
    "strain": ("strain of", "its largest value"),
    "deflection": ("deflection of", "its largest value"),
    "joint_force": ("force in joint", "the largest joint force"),
    "torque": ("effort of the drive at", "the largest effort of a drive"),
}
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

    Quantities are "strain", "deflection", "joint_force" and "torque", see `names_of`.

    Parameters
    ----------
    errors
        By quantity, then by source: of each member's strain (1) and deflection (m), of the force in each joint (N) and
        of the effort of each drive (N m or N), ``(members, joints or drives,)``.
    order
        With which power of its number a source falls: of sub-intervals, elements, modes, harmonics, stations; 0 where
        it does not.
    measure
        By quantity, what errors are relative to; see `measures`.
    """

    errors: Mapping[str, Mapping[str, Array]]
    order: Mapping[str, float]
    measure: Mapping[str, Array]

    def relative(self, what: str) -> dict[str, float]:
        """Largest error of a quantity by each source, relative to its measure."""
        size = self.measure[what]
        return {source: float((error / size).max(initial=0.0)) for source, error in self.errors[what].items()}

    def total(self, what: str) -> float:
        """Largest error of a quantity by all sources together, relative to its measure."""
        return float(self.of(list(self.errors[what]), what).max(initial=0.0))

    def judge(self, scene: Scene) -> None:
        """Raise `UnresolvedError` where the numerical errors are too large, unless the scene lets them pass.

        Strains are what a mesh and steps are chosen for, and have the narrower limits. Deflections and joint forces
        are refused only where they have not one right digit. Efforts of drives are not: where a mechanism is balanced
        they are small differences, of which the summary says that they are wrong.
        """
        if scene.analysis.allow_coarse:
            return
        names = names_of(scene)
        for what, sources, limit in LIMITS:
            errors = self.of(sources, what)
            if not errors.max(initial=0.0) <= limit:
                worst = int(errors.argmax())
                shares = {source: float(self.of([source], what)[worst]) for source in sources}
                place, measure = PLACES[what]
                said = f"{place} {names[what][worst]!r} is uncertain by"
                raise _refusal(scene, said, measure, shares, self.order, limit)

    def of(self, sources: Sequence[str], what: str = "strain") -> Array:
        """Error of a quantity by some sources together, relative to its measure, ``(members, joints or drives,)``."""
        found = [self.errors[what][source] for source in sources if source in self.errors[what]]
        return np.sum(found, axis=0) / self.measure[what] if found else np.zeros_like(self.measure[what])

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
    curves: Mapping[str, Array],
    sampling: Array | None = None,
    choices: Sequence[Choice] = (),
) -> Errors:
    """Estimate the errors of a result by all sources that can be told.

    Parameters
    ----------
    scene, system, history
        What was analysed, and its motion with those that are better.
    curves
        At the stations of the result, as magnitudes ``(angles, members, stations, fibres)`` or with their sign:
        "strain" of the outer fibres and "deflection" (m).
    sampling
        Error of the members' strains by the number of positions, ``(members,)``; it counts as "time".
    choices
        What was decided about effects.
    """
    base = Quantities.of(scene, system, history.elastic)
    largest = base.largest | {name: np.abs(curve).max(axis=(0, 2, 3)) for name, curve in curves.items()}
    nothing = {name: np.zeros_like(size) for name, size in largest.items()}
    found: dict[str, dict[str, Array]] = {name: {} for name in largest}
    order: dict[str, float] = {}

    def add(source: str, errors: Mapping[str, Array], times: float, falling: float) -> None:
        for name, by_source in found.items():
            by_source[source] = by_source.get(source, 0.0) + times * errors.get(name, nothing[name])
        order.setdefault(source, falling)

    for source, better in history.better.items():
        add(source, nothing, 1.0, better.order)
    for source, change, times in _changes(scene, system, history, base):
        add(source, change, times, history.better[source].order)
    if scene.analysis.method in ("periodic", "transient") and (blows := _by_blows(scene, system, history.elastic)):
        add("mesh", blows, 1.0, OF_SLIDERS)
    if (missed := misfit(scene, system.beams)).any():
        most = {name: missed.max() * size for name, size in largest.items()}
        add("mesh", most | {"strain": missed * largest["strain"]}, 1.0, 1.0)
    if sampling is not None:
        add("time", {"strain": sampling}, 1.0, 1.0)
    add("stations", {name: between_stations(curve) for name, curve in curves.items()}, 1.0, 2.0)
    if (left := left_out(choices)) is not None:
        add("effects", largest, left, 0.0)
    return Errors(found, order, measures(scene, largest))


def _changes(
    scene: Scene, system: System, history: History, base: Quantities
) -> Iterator[tuple[str, dict[str, Array], float]]:
    """Give by source what the better motions change of each quantity, and how many times as large its error is."""
    for source, better in history.better.items():
        if better.history.displacement is not history.displacement or better.loads is not NOTHING:
            change = Quantities.of(scene, system, better.history.elastic, better.loads) - base
            if source == "mesh" and system.transformation.constraints.contacts:
                change = change.with_nodes(system, moved_by_gaps(system, history.elastic))
            yield source, change.largest, better.safety
        if better.hidden is not None:
            beside, share = better.hidden
            yield source, (Quantities.of(scene, system, beside.elastic) - base).largest, 1 / share


def _by_blows(scene: Scene, system: System, history: History) -> dict[str, Array] | None:
    """Give the errors by the nodes that sliders pass; see `passing`. Modes add up."""
    free, step = unloaded(system), scene.period / scene.analysis.sub_intervals
    parts = [Quantities.of(scene, free, part).sizes for part in ringing(system, history, step)]
    if not parts:
        return None
    return {name: np.sum([part[name] for part in parts], axis=0).max(axis=0, initial=0.0) for name in parts[0]}


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
