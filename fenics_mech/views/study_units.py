"""Units in which studies tell numbers: those that are asked for or that the study is written in, else the usual."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from fenics_mech.recovery.exports import KIND_OF
from fenics_mech.recovery.variables import STRAINS
from fenics_mech.scene import Scene
from fenics_mech.scene.answer_units import AnswerUnits, named_units
from fenics_mech.scene.units import unit_written
from fenics_mech.studies.design.design_variables import Design, DesignVariable
from fenics_mech.studies.design.result_numbers import Quantity
from fenics_mech.views.prefixes import fitted

if TYPE_CHECKING:
    from fenics_mech.studies.design.trial import Trial


@dataclass(frozen=True)
class Told:
    """The unit in which a number is told."""

    unit: str = "1"  # its name; "1" for pure numbers
    size: float = 1.0  # how much of SI it is

    def text(self, value: float, digits: int = 5) -> str:
        """Write a value in SI as a number in this unit; "-" where there is none."""
        return "-" if math.isnan(value) else f"{value / self.size:.{digits}g}"

    def whole(self, value: float, digits: int = 5) -> str:
        """Write a value in SI with the unit behind it."""
        return f"{self.text(value, digits)}{self.behind}"

    def label(self, name: str) -> str:
        """Name an axis that shows the number."""
        return name if self.unit == "1" else f"{name} ({self.unit})"

    @property
    def behind(self) -> str:
        """What stands behind a number."""
        return "" if self.unit == "1" else f" {self.unit}"


def failures_of(trials: Iterable[Trial]) -> str:
    """Say how many trials failed with which kind of error; nothing where none did."""
    failures = Counter(trial.error for trial in trials if trial.failed)
    return ", ".join(f"{count} with {kind}" for kind, count in failures.items())


def cost_of(trials: Sequence[Trial], seconds: float, digits: int = 1) -> str:
    """Say how many trials there are, and how long they took in all and in this run."""
    run = sum(trial.seconds for trial in trials)
    return f"{len(trials)} trials of {run:.{digits}f} s in all; {seconds:.0f} s in this run."


def number_unit(of: Quantity, design: Design, shown: ArrayLike) -> Told:
    """Give the unit of a number: that of the scene's answers, that of its limit, or the usual one."""
    # The usual one has the prefix that fits the numbers which are shown.
    kind = "strain" if of.name in STRAINS else KIND_OF.get(of.unit, "")
    if kind in (named := named_units(design.scene.units)):
        return Told(*named[kind])
    for limit in design.study.limits:
        values = [value for value in (limit.most, limit.least) if value is not None]
        if not isinstance(of, Quantity) or limit.of != of.text:
            continue
        if found := unit_written([str(v) for v in values], [of.in_si(v) for v in values]):
            return Told(*found)
    if not kind:
        return Told(of.unit)
    sizes = np.abs(np.asarray(shown, dtype=float))
    return Told(*fitted({kind: sizes.max(initial=0.0, where=np.isfinite(sizes))}, AnswerUnits()).known[kind])


def variable_unit(variable: DesignVariable, scene: Scene) -> Told:
    """Give the unit of a variable: one that the scene names for answers, that in which it is written, or SI."""
    kind, named = KIND_OF.get(variable.unit, ""), named_units(scene.units)
    return Told(*(named.get(kind) or variable.written or (variable.unit, 1.0)))
