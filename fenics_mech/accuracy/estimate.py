"""Errors of strains, deflections, joint forces and efforts of drives, one by each source.

They come from motions that the solver gives without that error.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.accepted_errors import ACCEPTED, refusal_by
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
from fenics_mech.accuracy.theory_errors import theory_errors
from fenics_mech.accuracy.theory_ladder import UNKNOWN, judged
from fenics_mech.accuracy.undamped_modes import TOO_MANY, left_undamped
from fenics_mech.beams.variable_sections import misfit
from fenics_mech.effects.effect import Choice
from fenics_mech.errors import UnresolvedError
from fenics_mech.mechanism import System
from fenics_mech.response.solution import (
    CollocationSolution,
    FreeSolution,
    HarmonicSolution,
    Solution,
    StaticSolution,
)
from fenics_mech.response.transient.free_motion import course_of, solution_from
from fenics_mech.scene import Analysis, Scene

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
                return refusal_by(scene, said, measure, shares, self.order, limit, enough or 0)
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
        add("time", undamped, ESTIMATES.of_steps, 1.0)
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
        case CollocationSolution():
            return collocation_errors(solution)
        case HarmonicSolution():
            return harmonic_errors(solution)
        case FreeSolution():
            return {}
        case StaticSolution():
            return static_errors(solution)
    raise TypeError(f"no errors are estimated of a {type(solution).__name__}")


def trial_of_steps(analysis: Analysis, parted: bool) -> tuple[float, float] | None:
    """Tolerance of the steps that tell the error of those of a free motion, and the factor on the difference.

    Parameters
    ----------
    analysis
        What the scene asks for.
    parted
        Whether contacts opened.

    Returns
    -------
    tuple or None
        The tolerance over that of the motion, and the factor. None where contacts opened and their estimate is not
        asked for.
    """
    if not parted:
        return ESTIMATES.rougher, ESTIMATES.rough_share
    return (ESTIMATES.finer, ESTIMATES.finer_share) if analysis.error_estimates == "contacts" else None


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
