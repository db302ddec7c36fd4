"""What is judged of several load cases: of each reason that of the worst case, which is named."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from fenics_mech.safety.load_cases import most_stressed
from fenics_mech.views.judgement import Judgement
from fenics_mech.views.reading import ForceReading, reading_of


def worst_of_cases(each: Mapping[str, Sequence[Judgement]], governing: str, levels: Sequence[str]) -> list[Judgement]:
    """Give of all that is judged what the worst load case has; of equal ones the governing case."""
    each, found = {governing: each[governing], **each}, list["Judgement"]()
    for about in dict.fromkeys(judged.about for every in each.values() for judged in every):
        of_case = {name: [one for one in judged if one.about == about] for name, judged in each.items()}
        rank = {name: min(levels.index(one.level) for one in judged) for name, judged in of_case.items() if judged}
        worst = min(rank, key=rank.__getitem__)
        alike = len({tuple(judged) for judged in of_case.values()}) == 1
        told = "" if alike else f"In case {worst}: "
        found += [replace(one, text=f"{told}{one.text}") for one in of_case[worst]]
    return sorted(found, key=lambda judged: levels.index(judged.level))


def of_most_stressed(reading: ForceReading, headline: Callable[[ForceReading], tuple[str, str]]) -> tuple[str, str]:
    """Give the headline of the most stressed load case, with its name."""
    case = most_stressed(reading.result)
    value, rest = headline(reading_of(reading.result.cases[case], reading.units))
    return value, f"in case {case}, {rest}"
