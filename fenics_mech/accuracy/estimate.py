"""Errors of strains, deflections, joint forces and efforts of drives, one by each source.

They come from motions that the solver gives without that error.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.at_stations import AtStations
from fenics_mech.accuracy.base_response import Compared
from fenics_mech.accuracy.corrected_response import ESTIMATES, CorrectedResponse
from fenics_mech.accuracy.linearised_drag import left_out_of_drag
from fenics_mech.accuracy.mesh_errors import error_of_mesh
from fenics_mech.accuracy.mesh_residual import OF_SLIDERS
from fenics_mech.accuracy.missed_peaks import BETWEEN, MissedPeaks
from fenics_mech.accuracy.periodic_errors import collocation_errors, harmonic_errors
from fenics_mech.accuracy.quantities import Quantities, measures, measures_of_members, places_of
from fenics_mech.accuracy.remarks import not_estimated
from fenics_mech.accuracy.rounding import lost_by_rounding
from fenics_mech.accuracy.slider_kinks import ringing, unloaded
from fenics_mech.accuracy.static_errors import static_errors
from fenics_mech.accuracy.sub_interval_errors import sub_interval_errors
from fenics_mech.accuracy.superposition_errors import superposition_errors
from fenics_mech.accuracy.theory_errors import theory_errors
from fenics_mech.accuracy.theory_ladder import UNKNOWN, judged
from fenics_mech.accuracy.transient_errors import transient_errors, trial_of_steps
from fenics_mech.accuracy.undamped_modes import TOO_MANY, left_undamped
from fenics_mech.beams.variable_sections import misfit
from fenics_mech.effects import EFFECTS
from fenics_mech.effects.effect import Choice
from fenics_mech.errors import ANSWERED, UnresolvedError, percent
from fenics_mech.mechanism import System
from fenics_mech.response.solution import (
    CollocationSolution,
    FreeSolution,
    HarmonicSolution,
    Solution,
    StaticSolution,
    SubIntervalSolution,
    SuperposedSolution,
    TransientSolution,
)
from fenics_mech.response.transient.free_motion import course_of, solution_from
from fenics_mech.scene import Damping, Scene


@dataclass(frozen=True)
class AcceptedErrors:
    """Largest errors of a result that is not refused, relative to the largest value of a quantity."""

    by_steps: float = 0.02  # of a strain: steps are cheap
    by_positions: float = 0.05  # of a strain or joint force: so are positions
    of_strain: float = 0.05  # by all numerical sources
    of_rest: float = 0.5  # of deflections and joint forces: beyond it not one digit is known
    margin: float = 1.2  # factor on the numbers that a refusal asks for


ACCEPTED = AcceptedErrors()
STEPS = ("time", "harmonics")
BY_POSITIONS = 2.0  # with which power of their number errors by peaks between positions fall
NUMERICAL = (*STEPS, "modes", "mesh")  # sources that are judged
JUDGED = (
    ("strain", STEPS, ACCEPTED.by_steps),
    ("strain", NUMERICAL, ACCEPTED.of_strain),
    ("deflection", NUMERICAL, ACCEPTED.of_rest),
    ("joint_force", NUMERICAL, ACCEPTED.of_rest),
)
PLACES = {  # of an error, in words, and what it is relative to
    "strain": ("strain of", "its largest value"),
    "deflection": ("deflection of", "its largest value"),
    "joint_force": ("force in joint", "the largest joint force"),
    "torque": ("effort of the drive at", "the largest effort of a drive"),
}
ORIGINS = {"time": "time steps", "mesh": "mesh", "modes": "modes left out", "harmonics": "harmonics left out"}
ORIGINS |= {BETWEEN: "peaks between positions"}
FAULTS = {
    "time": "the sub-intervals are too long",
    "mesh": "the elements are too long",
    "modes": "the modes kept are too few",
    "harmonics": "the harmonics are too few",
}


@dataclass(frozen=True)
class Errors:
    """Errors by their sources.

    These are "time" (steps), "mesh", "modes" (left out), "harmonics", "stations", "theory", "effects" and "joints".
    Quantities are "strain", "deflection", "joint_force" and "torque", see `places_of`.

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
    remarks
        What is wrong by more than the estimates say.
    largest
        By quantity, the largest values.
    missed
        What lies between the positions of a cycle.
    """

    errors: Mapping[str, dict[str, Array]]
    order: dict[str, float]
    measure: Mapping[str, Array]
    remarks: tuple[str, ...] = ()
    largest: Mapping[str, Array] = field(default_factory=dict)
    missed: MissedPeaks | None = None

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
        if not scene.analysis.allow_coarse and (refusal := self.refusal(scene)) is not None:
            raise refusal

    def refusal(self, scene: Scene) -> UnresolvedError | None:
        """Give the error that says where numerical errors are too large, and by what; None where they are not.

        Parameters
        ----------
        scene
            The scene.
        """
        enough = self._enough(scene)
        if enough is None:  # then no steps cure it
            return self.missing(scene)
        names = places_of(scene.members(), scene.joints, scene.moved_joints)
        for what, sources, limit in JUDGED:
            errors = self.of(sources, what)
            if not errors.max(initial=0.0) <= limit:
                worst = int(errors.argmax())
                shares = {source: float(self.of([source], what)[worst]) for source in sources}
                place, measure = PLACES[what]
                said = f"{place} {names[what][worst]!r} is uncertain by"
                return _refusal(scene, said, measure, shares, self.order, limit, enough or 0)
        return self.missing(scene)

    def refuse_missed(self, scene: Scene) -> None:
        """Raise `UnresolvedError` where the positions surely miss peaks of joint forces or strains by too much."""
        if (refusal := self.missing(scene)) is not None:
            raise refusal

    def missing(self, scene: Scene) -> UnresolvedError | None:
        """Give the error that says which peaks the positions surely miss by too much; None where they miss none.

        Parameters
        ----------
        scene
            The scene.
        """
        names = places_of(scene.members(), scene.joints, scene.moved_joints)
        for what, missed in self._missed().items():
            if self.missed is not None and missed.max(initial=0.0) > ACCEPTED.by_positions:
                worst = int(missed.argmax())
                where = f"{PLACES[what][0]} {names[what][worst]!r}"
                return self.missed.refusal((what, worst), where, self._enough(scene))
        return None

    def _missed(self) -> dict[str, Array]:
        """Share of their measure by which positions surely miss peaks, of joint forces first, which have them too."""
        if self.missed is None:
            return {}
        known = self.missed.known
        return {what: known[what] / self.measure[what] for what in ("joint_force", "strain") if what in known}

    def _enough(self, scene: Scene) -> int | None:
        """Number of positions that surely miss no peak by too much: 0 where these do not, None where too many."""
        missed = self._missed()
        if self.missed is None or not any(
            shares.max(initial=0.0) > ACCEPTED.by_positions for shares in missed.values()
        ):
            return 0
        most = ACCEPTED.by_positions / ACCEPTED.margin
        measure = measures(scene, {**self.largest, **self.missed.peaks})  # as it is where the peaks are shown
        return self.missed.enough({what: most * measure[what] for what in missed})

    def of(self, sources: Sequence[str], what: str = "strain") -> Array:
        """Error of a quantity by some sources together, relative to its measure, ``(members, joints or drives,)``."""
        found = [self.errors[what][source] for source in sources if source in self.errors[what]]
        return np.sum(found, axis=0) / self.measure[what] if found else np.zeros_like(self.measure[what])

    def at_stations(self, there: AtStations) -> Errors:
        """Give the errors of the same motion at other stations.

        Parameters
        ----------
        there
            What was recovered there.
        """
        here, largest = there.between, there.largest
        errors = {
            name: by_source | {"stations": here[name]} if name in here else by_source
            for name, by_source in self.errors.items()
        }
        measure = {**self.measure, **measures_of_members(largest)}
        return replace(self, errors=errors, measure=measure, largest={**self.largest, **largest})

    def with_theory(self, solution: Solution, choices: Sequence[Choice] = ()) -> Errors:
        """Add what the theory of a response and the effects that are off leave out.

        Parameters
        ----------
        solution
            The response.
        choices
            What was decided about effects.
        """
        theory, remarks, added = theory_errors(solution.on_few_nodes), self.remarks, dict[str, dict[str, Array]]()
        if theory is None:
            remarks = (*remarks, UNKNOWN)
        elif theory:
            added["theory"] = {name: np.minimum(theory[name], size) for name, size in self.measure.items()}
        known = () if theory is None else judged(solution.scene.analysis.method)
        if (left := left_out(choices, known)) is not None:
            added["effects"] = {name: left * size for name, size in self.largest.items()}
        errors = {
            name: by_source | {source: parts[name] for source, parts in added.items()}
            for name, by_source in self.errors.items()
        }
        return replace(self, errors=errors, order=self.order | dict.fromkeys(added, 0.0), remarks=remarks)

    @property
    def too_large(self) -> bool:
        """Whether they are larger than `judge` lets pass."""
        if any(shares.max(initial=0.0) > ACCEPTED.by_positions for shares in self._missed().values()):
            return True
        judged_here = [one for one in JUDGED if one[0] in self.errors]
        return any(not self.of(sources, what).max(initial=0.0) <= limit for what, sources, limit in judged_here)


def _refusal(
    scene: Scene,
    what: str,
    measure: str,
    shares: Mapping[str, float],
    order: Mapping[str, float],
    limit: float,
    least: int,
) -> UnresolvedError:
    """Say which source has the largest part in the error of a strain or force, and what to do about it.

    `least` are sub-intervals without which the positions would be refused next.
    """
    total, source = sum(shares.values()), max(shares, key=shares.__getitem__)
    room = max(limit - (total - shares[source]), limit / 2)
    in_time = source == "time" and scene.analysis.method == "transient"
    fault = "the time steps or sub-intervals are too long" if in_time else FAULTS[source]
    times = (shares[source] / room) ** (1 / order[source])
    advice = _advice(scene, source, times, least)
    finer = _finer(scene, source, times)
    if least:
        finer["sub_intervals"] = max(least, finer.get("sub_intervals", 0))
        advice += "" if "sub_intervals" in advice else f", and at least {least} sub_intervals"
    return UnresolvedError(
        f"{fault}: the {what} an estimated {percent(total)} of {measure}, "
        f"{percent(shares[source])} of it from the {ORIGINS[source]}. "
        f"{advice}; analysis.allow_coarse lets it pass"
    ).finer_by(ANSWERED, **finer)


def _finer(scene: Scene, source: str, times: float) -> dict[str, float]:
    """Give the numbers with which the error of a source is small enough, which is to fall so many times."""
    analysis, more = scene.analysis, ACCEPTED.margin * times
    if source == "time" and analysis.method == "transient":
        return {"time_tolerance": analysis.time_tolerance / more}
    if source in ("mesh", "modes") and analysis.reduction != "none":
        return {}  # the cutoff is stated in hertz, or that of the members
    if source == "mesh":
        return {"elements": more}
    if source == "harmonics":  # which need more than four times as many sub-intervals
        harmonics = math.ceil(more * analysis.harmonics)
        return {"harmonics": harmonics, "sub_intervals": max(analysis.sub_intervals, 4 * harmonics + 2)}
    name = {"time": "sub_intervals", "modes": "modes"}[source]
    return {name: math.ceil(more * getattr(analysis, name))}


def estimate(
    solution: Solution,
    system: System,
    found: AtStations,
    choices: Sequence[Choice] = (),
    theory: bool = True,
) -> Errors:
    """Estimate the errors of a result by all sources that are known.

    Parameters
    ----------
    solution
        The response.
    system
        Its mechanism, as forces act on it.
    found
        What was recovered at the stations of the result.
    choices
        What was decided about effects.
    theory
        Whether they are told of what is left out of the equation, too; else `Errors.with_theory` adds it.

    Raises
    ------
    UnresolvedError
        When a linearisation leaves out so much, or the mesh is so coarse, that estimates do not hold. When numerical
        errors are larger than `Errors.judge` lets pass.
    """
    errors = _numerical(solution, system, found)
    errors.judge(solution.scene)  # before the theory, which takes longest
    return errors.with_theory(solution, choices) if theory else errors


def _numerical(solution: Solution, system: System, at: AtStations) -> Errors:
    """Estimate the errors by steps, mesh, modes and stations; parameters are those of `estimate`."""
    remarks = left_out_of_drag(solution)
    scene, whole = solution.scene, Compared.of(solution, system)
    largest = whole.base.largest | at.largest
    nothing = {name: np.zeros_like(size) for name, size in largest.items()}
    found: dict[str, dict[str, Array]] = {name: {} for name in largest}
    order: dict[str, float] = {}

    def add(source: str, errors: Mapping[str, Array], times: float, falling: float) -> None:
        for name, by_source in found.items():
            by_source[source] = by_source.get(source, 0.0) + times * errors.get(name, nothing[name])
        order.setdefault(source, falling)

    corrected, few = corrected_responses(solution), whole.on_few_nodes
    for source, without in corrected.items():
        if source != "mesh":
            add(source, (few if source == "time" else whole).change(source, without), without.safety, without.order)
    if "mesh" in corrected:
        by_mesh, remark = error_of_mesh(whole, corrected["mesh"])
        add("mesh", by_mesh, 1.0, corrected["mesh"].order)
        remarks += [remark] if remark else []
    rounded = lost_by_rounding(solution)
    add("mesh", {name: rounded * size for name, size in largest.items()}, 1.0, 1.0)
    if (undamped := left_undamped(solution)) is None:
        remarks.append(TOO_MANY)
    elif undamped:
        add("modes" if "modes" in corrected else "time", undamped, ESTIMATES.of_steps, 1.0)
    if isinstance(solution, FreeSolution) and (trial := trial_of_steps(scene.analysis, solution.course.parted)):
        add("time", _by_other_steps(solution, whole.base, trial[0]), trial[1], 1.0)
    if "time" in whole.missed:
        add("time", whole.missed["time"], 1.0, corrected["time"].order)
    if not isinstance(solution, StaticSolution) and (kinks := _by_slider_kinks(solution, system)):
        add("mesh", kinks, 1.0, OF_SLIDERS)
    if (unlike := misfit(scene.rigidity, system.beams)).any():
        most = {name: unlike.max() * size for name, size in largest.items()}
        add("mesh", most | {"strain": unlike * largest["strain"]}, 1.0, 1.0)
    if at.sampling is not None:
        add("time", {"strain": at.sampling}, 1.0, 1.0)
    if at.missed is not None:
        add(BETWEEN, at.missed.errors, 1.0, BY_POSITIONS)
    add("stations", at.between, 1.0, 2.0)
    told = [without.remark for without in corrected.values() if without.remark]
    return Errors(
        found, order, measures(scene, largest), (*told, *not_estimated(solution), *remarks), largest, at.missed
    )


def corrected_responses(solution: Solution) -> dict[str, CorrectedResponse]:
    """Give a response without each of its numerical sources of error, by the source."""
    match solution:
        case SubIntervalSolution():
            return sub_interval_errors(solution)
        case CollocationSolution():
            return collocation_errors(solution)
        case HarmonicSolution():
            return harmonic_errors(solution)
        case TransientSolution():
            return transient_errors(solution)
        case SuperposedSolution():
            return superposition_errors(solution)
        case FreeSolution():
            return {}
        case StaticSolution():
            return static_errors(solution)
    raise TypeError(f"no errors are estimated of a {type(solution).__name__}")


def _by_other_steps(solution: FreeSolution, base: Quantities, tolerance: float) -> dict[str, Array]:
    """Give the difference of a motion with freedoms from one with another tolerance of its time steps, over its own."""
    state, start = solution.state, solution.start
    other = solution_from(state, start, course_of(state, start, tolerance))
    return (Quantities.of(solution.scene, other.system, other.response.undamped) - base).largest


def _by_slider_kinks(solution: Solution, system: System) -> dict[str, Array] | None:
    """Give the errors by the nodes that sliders pass; see `slider_kinks`. Modes add up."""
    scene = solution.scene
    free, step = unloaded(system), scene.period / scene.analysis.sub_intervals
    parts = [Quantities.of(scene, free, part).sizes for part in ringing(system, solution.response.undamped, step)]
    if not parts:
        return None
    return {name: np.sum([part[name] for part in parts], axis=0).max(axis=0, initial=0.0) for name in parts[0]}


def left_out(choices: Sequence[Choice], known: Collection[str] = ()) -> float | None:
    """Sum of the sizes of effects that are off, relative to the strains; None where they were not estimated.

    Those that are known by the theory's own error are not among them.
    """
    if all(choice.size is None for choice in choices):
        return None
    inside = {choice.effect.replaces for choice in choices if choice.acts} | set(known)
    return sum(c.size for c in choices if c.size is not None and not c.acts and c.effect.name not in inside)


def _advice(scene: Scene, source: str, times: float, least: int) -> str:
    """Say how many more it takes, of sub-intervals as many as `least`."""
    analysis = scene.analysis
    if source == "time" and analysis.method == "transient":
        tolerance = analysis.time_tolerance / (ACCEPTED.margin * times)
        return f"Take analysis.time_tolerance = {tolerance:.1g}, and where the material damps more sub_intervals"
    if source == "modes" and analysis.reduction != "none":
        return f"Take a cutoff {math.ceil(ACCEPTED.margin * times * 10) / 10:g} times as high"
    if source == "mesh" and analysis.reduction != "none":
        if not any(EFFECTS[name].couples for name in scene.named_effects):
            return "Take effects = ['coupling'], or reduction = 'none': (5.1) depends on the coordinates"
        return f"Take a cutoff {math.ceil(ACCEPTED.margin * times**2 * 10) / 10:g} times as high, and finer elements"
    if source == "mesh":
        return f"Take {math.ceil(ACCEPTED.margin * times * 100) / 100:.3g} times as many elements, rounded up"
    name, now = {
        "time": ("sub_intervals", analysis.sub_intervals),
        "modes": ("modes", analysis.modes),
        "harmonics": ("harmonics", analysis.harmonics),
    }[source]
    assert not isinstance(now, str)  # all modes leave none out
    free = scene.damping == Damping() and not scene.dampers
    first = "State the damping, as nothing damps the vibration, or take" if source == "time" and free else "Take"
    enough = math.ceil(ACCEPTED.margin * now * times)
    return f"{first} at least {max(enough, least) if source == 'time' else enough} {name}"
