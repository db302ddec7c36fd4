"""Rows: conditions of joints on the measures of two ends. Their multipliers are the forces of the joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End
from fenics_mech.terms import Measure


@dataclass(frozen=True)
class Row:
    """A condition of a joint: a measure of two ends has a value.

    Parameters
    ----------
    pair
        The ends.
    measure
        What they are held by.
    value
        Its value: a number, or by time ``(instants,)`` (s), as a drive gives it.
    slack
        Change of the measure per multiplier (m/N, 1/(N m)): of joints that others hold already.
    name
        Of the joint.
    """

    pair: tuple[End, End]
    measure: Measure
    value: float | Callable[[Array], Array] = 0.0
    slack: float = 0.0
    name: str = ""

    @property
    def leads(self) -> bool:
        """Whether it is a drive."""
        return callable(self.value)

    def at(self, t: Array) -> Array:
        """Give its value at some instants ``(instants,)``."""
        return np.asarray(self.value(t)) if callable(self.value) else np.full(len(t), self.value)


class Riding(IntEnum):
    """What a pin on a member looks at, numbered as in the kernels."""

    ACROSS = 0  # its distance from the axis
    TURNED = 1  # sine of the angle from the axis to its first axis
    STROKE = 2  # its place along the straight member


@dataclass(frozen=True)
class Ride:
    """A pin that rides along the bent axis of a member: a row that looks at the element where it is.

    In space it is held along the second axis of the elements alone.

    Parameters
    ----------
    pin
        The pin.
    elements
        Ends of the member's elements, one after the other; their first axes lie along it.
    slack, name
        As of a row.
    look
        What the row looks at. It is 0, or of a stroke what a scale shows.
    marks
        Strokes at the ends of all elements (m), one more than elements.
    bends
        Length of each element (m), and its length over its bending stiffness (1/(N m)), by which it gives way beside
        the cubic under the pin. None where it does not.
    scale
        The pose of this scale, see `Machine.add_scale`; by default the ground.
    """

    pin: End
    elements: tuple[tuple[End, End], ...]
    slack: float = 0.0
    name: str = ""
    look: Riding = Riding.ACROSS
    marks: tuple[float, ...] = ()
    scale: int = 0
    bends: tuple[tuple[float, float], ...] = ()
