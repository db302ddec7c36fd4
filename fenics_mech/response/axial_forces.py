"""Axial forces of the response, which the geometric stiffness is updated with until they settle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects import StressStiffening, Terms
from fenics_mech.effects.geometric_stiffness import EFFECT as GEOMETRIC_STIFFNESS
from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class TensionLimits:
    """When axial forces have settled."""

    most_updates: int = 60  # before they count as not settling
    settled: float = 1e-7  # change of the axial forces, of the largest


TENSION = TensionLimits()


def settles(tension: str, terms: Terms) -> bool:
    """Whether the axial forces of the geometric stiffness are those of the response, and not of the rigid motion.

    Parameters
    ----------
    tension
        The scene's `analysis.tension`.
    terms
        What the effects add.
    """
    return tension == "settled" and terms.stiffening is not None


def settle(system: System, respond: Callable[[System], ElasticResponse]) -> System:
    """Update the tension of the geometric stiffness with the response until it settles.

    Parameters
    ----------
    system
        The mechanism with the effect 'geometric-stiffness'.
    respond
        Gives the response of a mechanism.

    Raises
    ------
    SolverError
        When the axial forces do not settle.
    """
    for _ in range(TENSION.most_updates):
        tension = mean_tension(system, respond(system))
        before = system.terms.stiffening
        assert before is not None
        change = np.abs(tension - before.tension).max() / max(float(np.abs(tension).max()), 1e-300)
        system = with_tension(system, tension)
        if change < TENSION.settled:
            return system
    raise SolverError(
        f"the axial forces do not settle: after {TENSION.most_updates} updates they still change by {change:.1e} of "
        f"the largest. Take the effect {LARGE_ROTATIONS.name!r} instead of {GEOMETRIC_STIFFNESS.name!r} with "
        "tension = 'settled'"
    )


def with_tension(system: System, tension: Array) -> System:
    """Give a system whose geometric stiffness comes from another axial force (N), ``(angles, elements)``.

    Parameters
    ----------
    system
        The mechanism with the effect 'geometric-stiffness'.
    tension
        The axial force.
    """
    return replace(system, terms=replace(system.terms, stiffening=StressStiffening.of(system.beams, tension)))
