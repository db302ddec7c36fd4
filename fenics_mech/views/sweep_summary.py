"""Summary of a sweep: the largest stresses and strains, points outside the theory, points that failed and why."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech.errors import percent
from fenics_mech.estimate.remarks import NO_ESTIMATE
from fenics_mech.planning.answer_remarks import in_words
from fenics_mech.recovery.peaks import PEAK
from fenics_mech.studies.sweep_peaks import RESOLVED
from fenics_mech.views.prefixes import labelled
from fenics_mech.views.sweep_data import (
    RESONANCE,
    beyond_theory,
    named,
    peak_of_speed,
    range_of,
    resonances_of,
    rising_at_ends,
    theory_levels,
    units_of,
    unresolved_at,
    whole_points,
    without_unstable,
    written,
    written_unit,
)
from fenics_mech.views.tables import number, table_of
from fenics_mech.views.words import share

if TYPE_CHECKING:
    from fenics_mech.studies.sweep import Sweep

MOST_RANGES = 6  # of values that failed, that are listed
NONE = "NO errors are estimated at {}: the theory is judged there by fixed limits, and mesh and steps are not judged."
EVERYWHERE = "`--estimates all` estimates and judges them at all points."
KINDS = {  # of errors, in words
    "SceneError": "the scene is not valid there",
    "TooLargeError": "too large for memory or a solver",
    "AssemblyError": "the links cannot be put together",
    "SolverError": "no accurate answer, or no stable motion, is found",
    "UnresolvedError": "steps, modes or elements are too coarse",
    "NoStableMotion": "no stable motion is found, also by continuation from the points beside them",
    "LostProcess": "the process was lost; a sweep into the same folder tries them again",
}


def sweep_summary(sweep: Sweep) -> Group:
    """Tell the largest stresses and strains of a sweep with the values at which they occur, and which points failed."""
    paths = sweep.paths
    data = sweep.data.transpose(*paths, ...)
    parts: list[RenderableType] = [Text(data.attrs["title"], style="bold")]
    if "peak_strain" in data:
        parts.append(_peaks(sweep))
    parts += [
        *_between(data, paths),
        *_safety(data, paths),
        *_resonances(without_unstable(data), paths),
        *_unresolved(data, paths),
    ]
    beyond = beyond_theory(data).to_numpy()
    if beyond.any():
        text = (
            f"{beyond.sum()} of {beyond.size} points are OUTSIDE THE THEORY that acts: {_where(data, paths, beyond)}. "
            "`fenics-mech run` at one of them says by how much its strains are wrong."
        )
        parts.append(Text(text, style="bold red"))
    parts += [*_with_care(data, paths), *_too_coarse(data, paths), *_unstable(data, paths), *_finer(data, paths)]
    parts += _changing_effects(data, paths)
    names = "error", "message", "not_estimated", "warnings"
    errors, messages, missing, warned = (data[name].to_numpy().astype(str) for name in names)
    doubts = data["peak_doubt"].to_numpy() if "peak_doubt" in data else np.zeros(1)
    if (doubtful := doubts > PEAK.doubtful).any():
        text = f"Peaks between the positions are uncertain by up to {np.nanmax(doubts):.1%} at"
        parts.append(Text(f"{text} {_where(data, paths, doubtful)}: take more sub_intervals"))
    for source in np.unique(missing[missing != ""]):
        at = _where(data, paths, missing == source)
        told = NONE.format(at) if source == NO_ESTIMATE else f"NOT included in the error estimates at {at}: {source}"
        some = source == NO_ESTIMATE and not (missing == source).all()
        parts.append(Text(f"{told} {EVERYWHERE}" if some else told))
    if (warned != "").any():
        first = warned[warned != ""][0].splitlines()[0]
        at = _where(data, paths, warned != "")
        parts.append(Text(f"Warnings at {at}. The first is: {first}", style="bold yellow"))
    if (errors != "").any():
        parts.append(Text(f"{(errors != '').sum()} of {errors.size} points failed:"))
    for kind in np.unique(errors[errors != ""]):
        places = errors == kind
        why = KINDS.get(kind, f"unexpected error {kind}; a sweep into the same folder tries them again")
        at, message = _where(data, paths, places), messages[places][0]
        parts.append(Text(f"  {places.sum()} at {at}: {why}. The first message is: {message}"))
    return Group(*parts)


def _with_care(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Say by how much linear theory is off where its numbers are to be used with care."""
    careful = (theory_levels(data) == "warn").to_numpy()
    if not careful.any() or "theory_share" not in data:
        return []
    shares = [data[name].to_numpy() for name in ("theory_share", "deflection_theory_share")]
    known, much = np.where(careful, np.fmax(*shares), np.nan), "may leave too much out"
    if not np.isnan(known).all():
        much = f"leaves out up to {share(float(np.nanmax(known)))} of the strain or deflection"
    text = f"Linear theory {much} at {_where(data, paths, careful)}: use these with care."
    return [Text(text, style="yellow")]


def _too_coarse(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Say which points have an answer whose numerical errors are too large."""
    if "too_coarse" not in data:  # of version 0.2
        return []
    said = data["too_coarse"].to_numpy().astype(str)
    if not (coarse := said != "").any():
        return []
    text = (
        f"{coarse.sum()} of {said.size} points are TOO COARSE: {_where(data, paths, coarse)}. Their answers are kept, "
        f"with their errors. Of the first: {said[coarse][0]}"
    )
    return [Text(text, style="bold red")]


def _unstable(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Say where the motion that is found is unstable, and what continuation says of stable ones."""
    if "unstable" not in data:  # of version 0.3
        return []
    said = data["unstable"].to_numpy().astype(str)
    if not (unstable := said != "").any():
        return []
    where = _where(data, paths, unstable)
    text = f"{unstable.sum()} of {said.size} points are UNSTABLE, and not among the largest: {where}."
    begin = "By continuation "
    followed = list(dict.fromkeys(f"{begin}{one.partition(begin)[2]}." for one in said[unstable] if begin in one))
    return [Text(f"{text} Of the first: {said[unstable][0]}.", style="bold red"), *map(Text, followed[1:])]


def _finer(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Say which mesh and steps the program took, and where, in place of its usual ones."""
    if "numbers" not in data:
        return []
    chosen = data["numbers"].to_numpy().astype(str)
    answered = data["error"].to_numpy() == ""
    said = []
    for numbers in np.unique(chosen[(chosen != "") & answered]):
        places = (chosen == numbers) & answered
        where = "all points" if places.sum() == answered.sum() else _where(data, paths, places)
        said.append(f"{in_words(numbers)} at {where}")
    steps = "" if len(said) < 2 and all("all points" in one for one in said) else ": curves may have steps there"
    return [Text(f"Chosen by the program as the scene states none: {'; '.join(said)}{steps}.")] if said else []


def _between(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Tell the largest strain and stress that were found between the points."""
    if not (said := str(data.attrs.get("between", ""))):
        return []
    found, units = json.loads(said), units_of(data)
    value = float(found["value"]) / data[paths[0]].attrs["written_factor"]
    strain, stress = (f"{number(units.number(found[kind], kind))} {units.label(kind)}" for kind in ("strain", "stress"))
    at = f"{value:.5g} {written_unit(data, paths[0])}".rstrip()
    return [Text(f"Between the points {found['member']} has more: {strain} and {stress} at {paths[0]} = {at}.")]


def _safety(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Tell the least factor of safety over the wanted one, where it is, and where it is below 1."""
    stable = without_unstable(data)
    if "safety_min" not in stable or not np.isfinite(stable["safety_min"]).any():
        return []
    least = stable["safety_min"].to_numpy()
    there = np.unravel_index(int(np.argmin(np.where(np.isfinite(least), least, np.inf))), least.shape)
    member, mode = (str(data[f"safety_{name}"].to_numpy()[there]) for name in ("member", "mode"))
    at = _where(data, paths, np.array([there]))
    text = f"Least factor of safety over the wanted one: {number(least[there])}, {member}, {mode}, at {at}."
    if (least < 1).any():
        text += f" It is below 1 at {_where(data, paths, least < 1)}."
    return [Text(text, style="bold red" if least[there] < 1 else "bold green")]


def _resonances(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Name the largest resonances of a sweep over one field, as the Campbell diagram does."""
    if len(paths) > 1 or not len(whole_points(data)):
        return []
    said = [
        f"{range_of(data, paths[0], one.point)} ({one.order} times the drive meets mode {one.mode + 1})"
        for one in resonances_of(data)[: RESONANCE.most]
    ]
    none = "No resonance stands out: no harmonic near a mode rises above its growth with the speed squared."
    if len(whole_points(data)) < data["drive_rate"].size:
        none = "No resonance stands out among the points that have an answer. One may be at those that have none."
    if (peak := peak_of_speed(data)) is not None:
        at, times = range_of(data, paths[0], peak[0]), number(peak[1])
        none = (
            f"The strain peaks at {at}, where it is {times} times that beside "
            "it. No multiple of the drive that was looked at meets a known mode there."
        )
    rising = [
        f"Strains still rise at {range_of(data, paths[0], one.point)}, where {one.order} times the drive nears "
        f"mode {one.mode + 1}: the resonance may lie beyond."
        for one in rising_at_ends(data)
    ]
    first = f"Resonances, the largest first: {', '.join(said)}." if said else none
    return [Text(line) for line in ([first] if said or not rising else []) + rising]


def _unresolved(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Say between which points the curves of the peak strains are not resolved."""
    if not len(places := unresolved_at(data, paths)):
        return []
    shown = ", ".join(number(place) for place in places[:MOST_RANGES])
    more = f" and {len(places) - MOST_RANGES} more" if len(places) > MOST_RANGES else ""
    unit = f" {written_unit(data, paths[0])}".rstrip()
    text = f"Between the points near {shown}{more}{unit} lines may miss more than {percent(RESOLVED)} of a peak strain"
    return [Text(f"{text}: --refine-peaks 40 adds points there.")]


def _changing_effects(data: xr.Dataset, paths: list[str]) -> list[Text]:
    """Say which effects act at some points of a sweep only, as "auto" chooses anew at each: curves have steps there."""
    if json.loads(data.attrs.get("scene", "{}")).get("effects") != "auto":
        return []
    chosen, errors = (data[name].to_numpy().astype(str) for name in ("effects", "error"))
    acting = {place: set(names.split(", ")) - {""} for place, names in np.ndenumerate(chosen) if not errors[place]}
    if not acting or not (some := sorted(set.union(*acting.values()) - set.intersection(*acting.values()))):
        return []
    places = {name: np.array([place for place, names in acting.items() if name in names]) for name in some}
    where = "; ".join(f"{name} at {_where(data, paths, at)}" for name, at in places.items())
    text = f"Some effects act at some points only: {where}. List the effects in the scene to use one equation"
    return [Text(f"{text} throughout.")]


def _where(data: xr.Dataset, paths: list[str], places: NDArray[Any]) -> str:
    """Say where some points of a sweep are: ``(points, fields)`` in the order of the grid, or a mask of the grid."""
    places = np.argwhere(places) if places.dtype == bool else places
    if len(paths) > 1:
        return " and ".join(
            f"{path} = {range_of(data, path, along.min(), along.max())}" for path, along in zip(paths, places.T)
        )
    along = places[:, 0]
    runs = np.split(along, np.flatnonzero(np.diff(along) > 1) + 1)
    shown = ", ".join(range_of(data, paths[0], run[0], run[-1]) for run in runs[:MOST_RANGES])
    more = sum(map(len, runs[MOST_RANGES:]))
    return f"{paths[0]} = {shown}" + (f" and {more} more" if more else "")


def _peaks(sweep: Sweep) -> Table:
    """Tabulate the largest peaks of every member: of its stress, and its strain with the values and the place."""
    data, paths = without_unstable(sweep.data), sweep.paths
    columns, units = [named(data, path) for path in paths], units_of(data)
    heads = [labelled(units, "stress"), labelled(units, "strain"), *columns, "place"]
    table = table_of("Largest stress and strain over the sweep", "member", *heads)
    ends = {label: member.ends for label, (_, member) in sweep.scene.members().items()}
    for member in data["member"].to_numpy():
        one = data.sel(member=member)
        peak = one["peak_strain"].fillna(-1)
        best = {str(name): int(index) for name, index in peak.argmax(dim=paths).items()}
        there = one.isel(best)
        values = [number(written(data, path)[best[path]]) for path in paths]
        stress = number(units.number(float(one["peak_stress"].max()), "stress")) if "peak_stress" in one else "-"
        strain, place = (float(there[name]) for name in ("peak_strain", "peak_strain_s"))
        first, last = ends[str(member)]  # places are shares of the length, which may be what is swept
        where = f"at {last if place else first}" if place in (0, 1) else f"{percent(place)} of {first} to {last}"
        table.add_row(escape(str(member)), stress, number(units.number(strain, "strain")), *values, escape(where))
    if without := int((data["not_estimated"] == NO_ESTIMATE).sum()):
        table.caption = f"{without} of {data['not_estimated'].size} points have no error estimate"
    return table
