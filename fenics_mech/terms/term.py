"""The one interface of everything that exerts forces: measures of two ends, and stresses by them and their rates."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End


class Look(IntEnum):
    """What a measure looks at; the kernels have the same numbers."""

    PLACE = 0
    ALONG = 1
    ALIGNED = 2
    DISTANCE = 3
    ANGLE = 4


class Measure(NamedTuple):
    """A number that two ends have: way along an axis, cosine between axes, distance, or angle.

    Parameters
    ----------
    look
        What it looks at.
    axis, other
        The axis of the first end or of the fixed frame, and for cosines that of the second.
    """

    look: Look
    axis: int = 0
    other: int = 0


@dataclass(frozen=True)
class Response:
    """Stresses at some instants, and their derivatives.

    Parameters
    ----------
    stress
        ``(instants, elements, measures)``; stress times rate of its measure is the power that the term takes (W).
    by_measure, by_rate
        Derivatives ``(instants, elements, measures, measures)``; None where there is none. Where elements respond
        together, both are by all measures of a set ``(instants, sets, stresses of a set, measures of a set)``.
    by_pulls
        Derivatives by the multipliers that the term looks at ``(instants, elements, measures, rows)``.
    off, limit
        How far what Newton's method predicted is from the term's law, and the size by which that is judged (N, N m).
    """

    stress: Array
    by_measure: Array | None = None
    by_rate: Array | None = None
    by_pulls: Array | None = None
    off: float = 0.0
    limit: float = 0.0

    def times(self, share: float) -> Response:
        """Give a share of the stresses."""
        parts = {name: getattr(self, name) for name in ("by_measure", "by_rate", "by_pulls")}
        return replace(self, stress=share * self.stress, **{k: share * x for k, x in parts.items() if x is not None})


class Term(ABC):
    """Elements of one kind between pairs of ends.

    A term states what it looks at (`measures`), and `respond` gives the stresses. The machine makes forces, tangents
    and powers from that. A term that stores energy states it, for the energy balance.

    Parameters
    ----------
    pairs
        Both ends of each element.
    """

    measures: tuple[Measure, ...] = ()  # of each element; beams have their strains
    modes = 0  # patterns of stress over all elements, each an unknown of the machine
    external = False  # whether it is a load from outside, and no part of the machine
    contacts = 0  # places at which bodies may touch: steps in time end where one closes or opens
    rows: Sequence[int] = ()  # whose multipliers it looks at: `respond` takes them, and the stress that was predicted
    together = 1  # so many elements, one after the other, answer with stresses the measures of all of them

    def __init__(self, pairs: Sequence[tuple[End, End]]) -> None:
        self.pairs = list(pairs)

    @property
    def looks(self) -> Sequence[Sequence[Measure]]:
        """Measures of every element, as many of each."""
        return [self.measures] * len(self.pairs)

    @abstractmethod
    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give the stresses at some instants by measures and their rates ``(instants, elements, measures)``."""

    def patterns(self, t: Array) -> Array | None:
        """Give patterns E of stress over all elements ``(instants, elements, measures, modes)``; None for none.

        They are as large as their product with the rates of the measures: the stress E (E . rates) is added.
        """
        return None

    def stiffening(self, present: Array, static: Array | None) -> Array:
        """Give what counts in the geometric stiffness of a linear theory, of present stresses and a static answer's."""
        # Without a static answer no axial forces act.
        return present

    def near(self, t: Array) -> Array | None:
        """Give angles within half a turn of those that are measured ``(instants, elements, measures)``; None for 0."""
        return None

    def energy(self, t: Array, x: Array) -> Array:
        """Give the energy that the elements store ``(instants, elements)`` (J): none, unless a term says so."""
        return np.zeros(x.shape[:2])


def diagonal(values: Array) -> Array:
    """Derivatives of stresses that depend on their own measure alone: ``(..., measures)`` as matrices."""
    return values[..., None] * np.eye(values.shape[-1])


def rubs(terms: Sequence[Term]) -> bool:
    """Say whether forces of joints press bodies that rub.

    Parameters
    ----------
    terms
        Those of a machine.
    """
    return any(len(term.rows) for term in terms)
