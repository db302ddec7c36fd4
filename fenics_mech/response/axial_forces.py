"""Axial forces of the response, which the geometric stiffness is updated with until they settle."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._constants import TINY
from fenics_mech.effects import AxialForces, Terms
from fenics_mech.effects.geometric_stiffness import EFFECT as GEOMETRIC_STIFFNESS
from fenics_mech.effects.geometric_stiffness import of_forces
from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import axial_forces
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
        forces, before = axial_forces(system, respond(system)), system.terms.stiffening
        assert before is not None
        change = np.abs(forces.mean - before.force).max() / max(float(np.abs(forces.mean).max()), TINY)
        system = with_axial_forces(system, forces)
        if change < TENSION.settled:
            return system
    raise SolverError(
        f"the axial forces do not settle: after {TENSION.most_updates} updates they still change by {change:.1e} of "
        f"the largest. Take the effect {LARGE_ROTATIONS.name!r} instead of {GEOMETRIC_STIFFNESS.name!r} with "
        "tension = 'settled'"
    )


def with_axial_forces(system: System, forces: AxialForces) -> System:
    """Give a system whose geometric stiffness comes from other axial forces.

    Parameters
    ----------
    system
        The mechanism with the effect 'geometric-stiffness'.
    forces
        The axial forces.
    """
    given = of_forces(system.beams, forces)
    return replace(system, terms=replace(system.terms, stiffening=given.stiffening, uneven=given.uneven))
