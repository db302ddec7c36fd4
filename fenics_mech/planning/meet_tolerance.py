"""Meeting a tolerance: mesh, modes of the members and steps in time, chosen by the errors that results estimate."""

from __future__ import annotations

import logging
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import xarray as xr

from fenics_mech.answers.by_poses import collected, estimated, planned, solution, stability_of, with_errors
from fenics_mech.errors import SolverError, TooLargeError, UnresolvedError, percent, percent_of_error
from fenics_mech.estimate.accepted_errors import ORIGINS
from fenics_mech.estimate.quantities import ERROR_VARIABLES
from fenics_mech.estimate.remarks import UNKNOWN
from fenics_mech.joints.torsional_springs import refuse_too_stiff
from fenics_mech.machine.corners import positions_for_corners, refuse_unresolved
from fenics_mech.machine.linkage import Linkage
from fenics_mech.planning.answer_remarks import WORDS
from fenics_mech.planning.discretisation import (
    NUMBERS,
    REFINE,
    Discretisation,
    Trial,
    refuse_stated,
    refuse_unknown,
    slow_order,
)
from fenics_mech.planning.sampling_checks import refuse_undersampled
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import BETWEEN, PEAK, PEAKS, doubts
from fenics_mech.recovery.result import stamp
from fenics_mech.scene import Scene
from fenics_mech.scene.base import SCENE

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class SearchLimits:
    """Limits of the search for a discretisation."""

    most_rounds: int = 12  # before a tolerance counts as not met
    enough: float = 0.7  # of the tolerance: estimates are 0.7 to 2 of the true error
    largest_judged: float = 0.1  # error of a motion that may be called unstable
    most_without_answer: int = 200  # sub-intervals, or the scene's own, after which no answer is an answer
    most_stations: float = 4.0  # times as many in a round
    most_steps: float = 5.0  # the same of sub-intervals
    most_elements: float = 6.0  # the same of elements, whose errors fall most evenly
    least_of_peaks: float = 0.02  # of the tolerance: what the other sources leave where each has its share
    order_of_peaks: float = 6.0  # with which doubts of peaks fall in the positions at least
    largest_share: float = 0.2  # of the tolerance, that the error of each source is sent below
    share_of_mesh: float = 0.28  # of the tolerance, that its error is sent below
    doubted_order: float = 2.0  # of the mesh, with which errors along members fall, which may be what is left
    doubted_up_to: float = 3.0  # times as many elements, that are taken for the case that they are
    margin: float = 1.1  # by how much more it grows than it should
    margin_of_peaks: float = 1.25  # the same of positions between which peaks are doubted, of which few tell little
    unseen: float = 2.0  # times as many where peaks are doubtful: half of these positions do not see the curves

    def share(self, source: str) -> float:
        """Share of a tolerance that the error of a source is sent below."""
        return self.share_of_mesh if source == "mesh" else self.largest_share


SEARCH = SearchLimits()


def within(scene: Scene) -> Result:
    """Analyse a scene so that every quantity that its tolerance names is within it of the converged one."""
    refuse_stated(scene)
    chosen = planned(scene)
    refuse_unknown(chosen)
    discretisation, trials, stability = _start(chosen), list[Trial](), None
    for done in range(1, SEARCH.most_rounds + 1):
        trial = discretisation.of(chosen)
        try:
            solved = solution(trial)
            errors = estimated(solved, scene.effects == "auto")
        except UnresolvedError:  # steps that are far too long may have no answer at all
            if discretisation.steps >= max(SEARCH.most_without_answer, scene.analysis.sub_intervals) or not _periodic(
                chosen
            ):
                raise
            discretisation = discretisation.finer("time", 2.0)
            continue
        except (TooLargeError, MemoryError) as error:
            why = f"the next needs more memory than there is, {_numbers(discretisation)}"
            raise _not_met(chosen, trials, why) from error
        result = with_errors(solved, errors)
        this = Trial(discretisation, *_errors(scene, result), int(result.data.attrs["dofs"]))
        missed = _missed(scene, this)
        logger.info("trial %d, %s: errors %s; not met: %s", done, _numbers(discretisation), this.errors, missed)
        near = stability is None and sum(this.errors["strain"].values()) <= SEARCH.largest_judged
        doubted = doubts(result) if _periodic(scene) else dict.fromkeys(PEAKS, 0.0)  # else none are chosen
        met = not missed and _beyond(scene, this, doubted) <= 1
        if scene.analysis.stability and (near or met):  # coarse steps tell it first
            stability = stability_of(solved)
        if met:
            if not scene.analysis.allow_coarse:
                errors.refuse_missed(solved.scene)
            result = collected(solved, errors, xr.Dataset() if stability is None else stability)
            refuse_too_stiff(trial.changed(analysis__allow_coarse=scene.analysis.allow_coarse))
            accounted = stamp(trial) | {"chosen": _account(trial, result, this, done)}
            return Result.with_scene(trial, result.data.assign_attrs(accounted))
        trials.append(this)
        discretisation = _next(chosen, trials) if missed else discretisation
        discretisation = _seeing_peaks(scene, discretisation, this, doubted)
    raise _not_met(chosen, trials, f"{SEARCH.most_rounds} rounds were made")


def _errors(scene: Scene, result: Result) -> tuple[dict[str, dict[str, float]], dict[str, float]]:
    """Relative errors of strains and of what the tolerance names, by quantity and source, and the sources' orders."""
    stated = scene.effects != "auto"  # the tolerance is then that of the equation
    apart = ["effects", "joints", *(["theory"] if stated else [])]
    if not _periodic(scene):  # its positions are not chosen, and `unmet` tells what they miss
        apart.append(BETWEEN)
    data = result.data.drop_sel(source=apart, errors="ignore")
    sources = [str(source) for source in data["source"].to_numpy()]
    names = {what: f"{ERROR_VARIABLES[what][1]}relative_error" for what in ("strain", *scene.tolerances)}
    errors = {what: dict(zip(sources, data[name].to_numpy().tolist())) for what, name in names.items()}
    return errors, dict(zip(sources, data["error_order"].to_numpy().tolist()))


def _missed(scene: Scene, trial: Trial) -> list[str]:
    """Quantities whose tolerance a trial does not meet."""
    return [
        what for what, most in scene.tolerances.items() if not sum(trial.errors[what].values()) <= SEARCH.enough * most
    ]


def _beyond(scene: Scene, trial: Trial, doubted: Mapping[str, float]) -> float:
    """Give the uncertainty of peaks between the positions, over what the tolerance and other errors leave to it."""
    limits = dict.fromkeys(doubted, PEAK.doubtful)
    for what in set(limits) & set(scene.tolerances):
        errors, most = trial.errors[what], scene.tolerances[what]
        rest = SEARCH.enough * most - sum(errors.values()) + errors.get(BETWEEN, 0.0)
        limits[what] = min(PEAK.doubtful, max(rest, SEARCH.least_of_peaks * most))
    return max(found / limits[name] for name, found in doubted.items())


def _periodic(scene: Scene) -> bool:
    return scene.analysis.method == "periodic"


def _next(scene: Scene, trials: Sequence[Trial]) -> Discretisation:
    """Give the choices of the next trial."""
    # An error falls with its power. Where it fell far more slowly, it has to fall on as it did: that power, once it
    # has been seen twice, or once where loads jump, shows what the tolerance would take.
    last = trials[-1]
    more: dict[str, tuple[float, float]] = {}
    for what in _missed(scene, last):
        for source, error in last.errors[what].items():
            if source != BETWEEN and error > SEARCH.share(source) * scene.tolerances[what]:  # see `_seeing_peaks`
                (by, least_by), (before, least_before) = _times(scene, trials, what, source), more.get(source, (1, 1))
                more[source] = max(by, before), max(least_by, least_before)
    if _stations_suffice(scene, last):  # which leave the motion as it is
        more = {"stations": more["stations"]}
    finer = least = last.discretisation
    for source, (by, least_by) in more.items():
        finer, least = finer.finer(source, by), least.finer(source, least_by)
    if what := last.too_large(least, scene):
        too_many = f"so many {what} take too much memory or time"
        raise _not_met(scene, trials, f"it would take about {_numbers(least)}: {too_many}")
    return least if last.too_large(finer, scene) else finer


def _seeing_peaks(scene: Scene, chosen: Discretisation, last: Trial, doubted: Mapping[str, float]) -> Discretisation:
    """Give choices whose positions leave no doubt of peaks between them, by what they leave in the last trial."""
    if (beyond := _beyond(scene, last, doubted)) <= 1:
        return chosen
    more = SEARCH.margin_of_peaks * beyond ** (1 / SEARCH.order_of_peaks)
    if max(doubted.values()) > PEAK.doubtful:
        more = max(more, SEARCH.unseen)
    return replace(chosen, sub_intervals=max(chosen.sub_intervals, more * last.discretisation.steps))


def _times(scene: Scene, trials: Sequence[Trial], what: str, source: str) -> tuple[float, float]:
    """Give how many times as many steps or elements an error asks for, and how many it needs at least."""
    last, tolerance = trials[-1], scene.tolerances[what]
    error = last.errors[what][source]
    power = slow_order(trials, what, source) if error > tolerance else None
    if power is None or not (_jumping(scene) or slow_order(trials[:-1], what, source)):
        power = max(last.orders[source], 1.0)
    over = error / (SEARCH.share(source) * tolerance)
    by = SEARCH.margin * over ** (1 / max(power, 1.0))
    if source == "mesh" and power > SEARCH.doubted_order:
        by = max(by, min(SEARCH.margin * over ** (1 / SEARCH.doubted_order), SEARCH.doubted_up_to))
    if source == "time" and power > REFINE.order_of_steps:
        by = max(by, over ** (1 / REFINE.order_of_steps))
    least = min(over, sum(last.errors[what].values()) / SEARCH.enough / tolerance)
    most = {"time": SEARCH.most_steps, "mesh": SEARCH.most_elements}.get(source, SEARCH.most_stations)
    return min(by, most), SEARCH.margin * least ** (1 / power)


def _stations_suffice(scene: Scene, trial: Trial) -> bool:
    """Whether every tolerance that a trial does not meet is met with more stations, and nothing else."""
    rest = {what: sum(errors.values()) - errors.get("stations", 0.0) for what, errors in trial.errors.items()}
    return all(
        rest[what] <= (SEARCH.enough - SEARCH.largest_share) * scene.tolerances[what] for what in _missed(scene, trial)
    )


def _not_met(scene: Scene, trials: Sequence[Trial], why: str) -> SolverError:
    """Say that the tolerance is not met, what error is left, by what, and what to do."""
    if not trials:
        return SolverError(f"the tolerance of {_stated(scene)} cannot be met: {why}. Leave it out")
    last = trials[-1]
    missed = _missed(scene, last) or list(scene.tolerances)
    left = " and ".join(_left(trials, what) for what in missed)
    stated, numbers = _stated(scene, missed), _numbers(last.discretisation)
    advice = "Give a larger tolerance"
    if _jumping(scene):
        advice += (
            ", or loads with longer flanks (ramp), or material damping. Jumps of loads excite vibrations that only "
            "short steps and many modes follow"
        )
    return SolverError(f"the tolerance of {stated} is not met: with {numbers} {left}; {why}. {advice}")


def _stated(scene: Scene, quantities: Sequence[str] | None = None) -> str:
    """Name the tolerances of some quantities, or of all, and what they are of where that is not strains alone."""
    names = list(scene.tolerances) if quantities is None else quantities
    alone = list(scene.tolerances) == ["strain"]
    return " and ".join(f"{scene.tolerances[what]:g}{'' if alone else ' of ' + WORDS[what]}" for what in names)


def _left(trials: Sequence[Trial], what: str) -> str:
    """Say what error of a quantity is left, and by what."""
    errors = trials[-1].errors[what]
    worst = max(errors, key=errors.__getitem__)
    order = slow_order(trials, what, worst)
    falls = f", with an observed convergence order of {order:.1f} in the {NUMBERS[worst]}" if order is not None else ""
    total = sum(errors.values())
    share = f"{percent(errors[worst])} of it from the {ORIGINS.get(worst, worst)}"
    return f"the {WORDS[what]} are uncertain by an estimated {percent(total)}, {share}{falls}"


def _numbers(discretisation: Discretisation) -> str:
    elements, stations = math.ceil(discretisation.elements), math.ceil(discretisation.stations)
    return f"{discretisation.steps} sub_intervals, {elements} elements a member and {stations} stations"


def _start(scene: Scene) -> Discretisation:
    """Give the choices to begin with: coarse ones, from which the errors are estimated."""
    elements = REFINE.fewest_elements
    if _periodic(scene):  # whose trials take long; errors fall with the fourth power
        elements = math.ceil(elements * max(1.0, REFINE.from_fewest / min(scene.tolerances.values())) ** 0.25)
    return Discretisation(elements, _fewest_steps(scene), _fewest_stations(scene))


def _fewest_stations(scene: Scene) -> int:
    """Give the stations to begin with, as they cost little: those between which a half-wave hides its share."""
    # At d of its length beside its top a half-wave of a sine is lower by ``(pi d)^2/2``, and d is half a distance.
    hidden = SEARCH.largest_share * min(scene.tolerances.values())
    return max(REFINE.fewest_stations, min(SCENE.most_stations, math.ceil(math.pi / math.sqrt(8 * hidden)) + 1))


def _jumping(scene: Scene) -> bool:
    """Whether loads jump."""
    return any(load.jumps for load in scene.loads.values())


def _fewest_steps(scene: Scene) -> int:
    """Give the steps to begin with, which miss no corner of the motion, and nothing that a load or a law does."""
    # Loads that change may do so between few positions: there the scene's own are the fewest.
    analysis = scene.analysis
    if not _periodic(scene):
        quasi_static = scene.drives and analysis.method == "quasi-static"
        if quasi_static and not analysis.allow_coarse:  # trials let pass what its own positions miss
            refuse_unresolved(scene)
            refuse_undersampled(scene, analysis.sub_intervals)
        return analysis.sub_intervals
    varying = [load for load in scene.loads.values() if load.factor is not None]
    steps = analysis.sub_intervals if varying else REFINE.fewest_steps
    points = [load.enough_angles(REFINE.stages * steps) for load in varying if not load.cut_where_needed]
    points += [drive.enough_angles(REFINE.stages * steps, scene.cycle_rate) for drive in scene.drives]
    steps = max([steps, *(math.ceil(count / REFINE.stages) for count in points)])
    taken = {"sub_intervals": steps, "stages": REFINE.stages}
    coarse = scene.changed(analysis=scene.analysis.model_copy(update=taken))
    refuse_undersampled(coarse, REFINE.stages * steps, by_collocation=True)
    if analysis.allow_coarse:
        return steps
    return positions_for_corners(Linkage(scene), scene.drive_angles, True, steps)


def _account(scene: Scene, result: Result, trial: Trial, rounds: int) -> str:
    """Say what was chosen, and why."""
    analysis, alone = scene.analysis, list(scene.tolerances) == ["strain"]
    parts = [f"{result.data.attrs['elements']} elements"]
    if analysis.method == "periodic":
        parts.insert(0, f"{analysis.solver} in {analysis.sub_intervals} sub_intervals")
    parts.append(f"{analysis.stations} stations")
    met = " and ".join(f"{WORDS[what]} to {percent(most)}" for what, most in scene.tolerances.items())
    least = "; ".join(
        ("" if alone else f"{WORDS[what]}: ")
        + ", ".join(f"{source} {percent(error, 1)}" for source, error in trial.errors[what].items())
        for what in scene.tolerances
    )
    trials = "first trial" if rounds == 1 else f"{rounds} trials"
    left = _left_out(scene, result)
    whether = "NOT met, as only steps and mesh are within it, with" if left else "met by"
    said = f"{met}, {whether} {', '.join(parts)} (errors: {least}; {trials})"
    return "; ".join([said, *_others(scene, result), *left])


def _others(scene: Scene, result: Result) -> list[str]:
    """Say what errors the quantities have that the tolerance does not name, by all sources but effects left out."""
    data = result.data.drop_sel(source="effects", errors="ignore")
    rest = {name: f"{prefix}relative_error" for name, (_, prefix, _) in ERROR_VARIABLES.items()}
    told = [
        f"{WORDS[name]} {percent_of_error(data[error].sum().item())}"
        for name, error in rest.items()
        if error in data and name not in scene.tolerances
    ]
    return [f"errors of the rest: {', '.join(told)}"] if told else []


def _left_out(scene: Scene, result: Result) -> list[str]:
    """Say what the effects leave out that act, where it is more than the tolerance or not known."""
    names = {
        "theory": "the effects that the scene lists leave out",
        "effects": "effects left out by estimate come to",
        "joints": "rigid arms and guides leave out",
    }
    shares = result.data["relative_error"]
    beyond = [
        f"{name} {percent_of_error(float(shares.sel(source=source)))}"
        for source, name in names.items()
        if source in shares["source"] and shares.sel(source=source) > scene.neglected
    ]
    if UNKNOWN in result.data.attrs.get("not_estimated", ""):
        beyond.append(f"{UNKNOWN}, which is not estimated")
    return [f"NOT in it: {', '.join(beyond)}"] if beyond else []
