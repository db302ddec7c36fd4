"""Rows: conditions of joints on the measures of two ends. Their multipliers are the forces of the joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

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


@dataclass(frozen=True)
class Ride:
    """A pin that rides along the bent axis of a member: a row that holds it on the element where it is.

    In space it is held along the second axis of the elements alone.

    Parameters
    ----------
    pin
        The pin.
    elements
        Ends of the member's elements, one after the other; their first axes lie along it.
    slack, name
        As of a row.
    """

    pin: End
    elements: tuple[tuple[End, End], ...]
    slack: float = 0.0
    name: str = ""
