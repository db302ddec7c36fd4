"""Curves of a result over the cycle, by the names of numbers without a reduction: "strain[coupler][@0.5][+]"."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.recovery import Result
from fenics_mech.recovery.signal import last_cycle
from fenics_mech.scene.study import Target
from fenics_mech.studies.design.result_numbers import OWN, Quantity
from fenics_mech.studies.design.targets import at_angles


@dataclass(frozen=True)
class Curve:
    """A quantity of a result at drive angles."""

    of: Quantity  # the quantity, without a reduction
    angles: tuple[float, ...]  # drive angles (rad)
    names: tuple[str, ...] = field(init=False, compare=False)

    def __post_init__(self) -> None:
        names = tuple(f"{self.of.text} at {math.degrees(angle):.9g} deg" for angle in self.angles)
        object.__setattr__(self, "names", names)

    @classmethod
    def read(cls, text: str, angles: Array | list[float]) -> Curve:
        """Read the name of a curve."""
        of = Quantity.read(text)
        if of.reduction or of.name in OWN:
            hint = "Write a variable of the result and its labels, such as strain[coupler][@0.5][+] or torque"
            raise SceneError(f"{text!r} is one number, and no curve over the drive angle", place="study", hint=hint)
        return cls(of, tuple(float(angle) for angle in angles))

    @property
    def text(self) -> str:
        """Its name."""
        return self.of.text

    @property
    def name(self) -> str:
        """Variable of the result."""
        return self.of.name

    @property
    def labels(self) -> tuple[str, ...]:
        """Member, joint, mode or the like."""
        return self.of.labels

    @property
    def unit(self) -> str:
        """SI unit."""
        return self.of.unit

    @property
    def variables(self) -> tuple[str, ...]:
        """Variables of the result that it is made from."""
        return self.of.variables

    @property
    def needs_stability(self) -> bool:
        """Whether the analysis must judge stability."""
        return self.of.needs_stability

    def numbers(self, result: Result, targets: Mapping[str, Target]) -> dict[str, float]:
        """Give its values in a result, by their names."""
        if result.cases:
            if not (case := self.of.case_of(result)):
                hint = f"Name one in brackets: {', '.join(result.cases)}"
                raise SceneError(f"{self.text!r} is a curve of each load case", place="study", hint=hint)
            labels = tuple(label for label in self.labels if label != case)
            told = replace(self, of=replace(self.of, labels=labels)).numbers(result.cases[case], targets)
            return dict(zip(self.names, told.values()))
        found = self.of.variable(result)
        part = last_cycle(result.scene.analysis, result.scene.drives, result.data)
        if found.dims != ("theta",) or part is None:
            more = " and ".join(str(dim) for dim in found.dims if dim != "theta")
            hint = f"Name its {more} in brackets, such as [@0.5] for a place" if more else "It needs a drive that turns"
            raise SceneError(f"{self.text!r} is no single curve over a cycle", place="study", hint=hint)
        theta, values = found["theta"].to_numpy()[part], found.to_numpy()[part]
        return dict(zip(self.names, at_angles(theta, values, np.array(self.angles)).tolist()))

    def values(self, numbers: Mapping[str, float]) -> Array:
        """Give its values of the numbers of a trial, ``(angles,)``."""
        return np.array([numbers[name] for name in self.names])


ResultNumbers = Quantity | Curve
