"""What the residual gives: forces, tangents, and the stresses of every term."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fenics_mech._arrays import Array
from fenics_mech.machine.groups import Moved
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.pattern import Pattern


@dataclass(frozen=True)
class Evaluation:
    """The residual of a machine at some instants.

    Parameters
    ----------
    force
        Residual of the coordinates (N, N m), then of the rows, ``(instants, size)``.
    M, C, K
        Derivatives by accelerations and multipliers, by rates, and by coordinates, ``(instants, entries)``.
    pattern
        Where their entries lie.
    terms
        Measures and stresses of every term.
    at
        The poses.
    t
        Instants ``(instants,)`` (s).
    """

    force: Array
    M: Array
    C: Array
    K: Array
    pattern: Pattern
    terms: Sequence[Measured]
    at: Moved
    t: Array


def linear_forces(base: Evaluation, ahead: Evaluation, behind: Evaluation, share: float) -> Evaluation:
    """Give the stresses and inertia of a motion that is linear beside another, at the places of that other."""
    terms = []
    for here, one, other in zip(base.terms, ahead.terms, behind.terms):
        stress = here.response.stress + share * (one.response.stress - other.response.stress)
        terms.append(replace(here, response=replace(here.response, stress=stress)))
    rates, inert = (
        getattr(base.at, name) + share * (getattr(ahead.at, name) - getattr(behind.at, name))
        for name in ("rates", "inert")
    )
    return replace(base, terms=terms, at=replace(base.at, rates=rates, inert=inert))
