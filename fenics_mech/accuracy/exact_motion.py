"""The exact motion beside a known one, and the difference of the two.

The forces of the exact equation that the known motion's own lacks act as a load. The exact equation, linearised about
the motion, answers to it.

A state here is q, q' and q'', ``(3, angles, coordinates)``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.accuracy.quantities import Quantities, stations_of
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices, not_positive
from fenics_mech.response.periodic.newton import Orbit, settled
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class TheoryLimits:
    """How the theory's error is estimated: two digits are enough."""

    stages: int = 3  # Radau points of a step
    tail: float = 0.003  # of the motion's amplitude, in harmonics that are left to shorter steps
    positions: int = 8  # for the fastest of the other harmonics: with fewer the series has wrong axial forces,
    end: float = 1e-5  # unless what is beyond 3/8 of the positions has no more than this share of the amplitude
    steps: int = 4  # for the same; each has three Radau points
    turn: float = 0.8  # rad of the slowest vibration in a step in time; measured: 0.94 to 1.0 of the truth, 0.3 with 5
    steps_between: int = 8  # of these, between two positions
    fewest: int = 48  # steps
    between: int = 4  # times as many angles, at which the largest change by such a series is looked for
    most_iterations: int = 8  # of Newton's method: it converges quadratically where the exact motion is near
    accepted: float = 0.1  # change by the last iteration, up to which its answer is an estimate
    converged: float = 1e-4  # change that the next iteration would make: axial stiffness makes forces of it
    most_growth: float = 3.0  # powers of 10 in a cycle, of a disturbance beside the motion: no stable one is near then
    damped_up_to: float = 1.0  # as of `Cycle`, of a motion by its harmonics; measured: more modes change 3e-4 of it


THEORY = TheoryLimits()
POINTS = Tableau.of("radau", THEORY.stages)


Theory = tuple[Scene, System, ElasticResponse]  # a response of one


def at_rest(system: System, there: System, response: ElasticResponse) -> Array:
    """Give the change of a displacement without inertia, ``(angles, coordinates)``.

    Parameters
    ----------
    system, there
        The mechanism in its own theory, and in the exact one.
    response
        The displacement.

    Raises
    ------
    SolverError
        Where the exact theory has no stable equilibrium near.
    """
    rung, top = (Equation(replace(one, terms=replace(one.terms, coupled=False))) for one in (system, there))
    still = np.zeros_like(response.displacement)

    def answer(tangents: Matrices, load: Array) -> Array:
        if len(not_positive(tangents.stiffness)):
            raise SolverError("the exact equilibrium is not stable")
        return np.stack([tangents.stiffness.solve(load), still, still])

    state = np.stack([response.displacement, still, still])
    return answered(rung.residual(*state), lambda _: top, state, mean_tension(system, response), answer)[0]


def state_of(orbit: Orbit) -> Array:
    """Give q, q' and q'' of a motion at the points of a solver."""
    return np.stack([orbit.displacement, orbit.velocity, orbit.acceleration])


def answered(
    known: Array,
    exact: Callable[[Array], Equation],
    state: Array,
    tension: Array,
    answer: Callable[[Matrices, Array], Array],
) -> Array:
    """Give the change of a state to one that leaves of the exact equation what it leaves of its own.

    These are two steps of Newton's method or more: axial forces are right to the first order of a change only.

    Parameters
    ----------
    known
        What the state leaves of its own equation, ``(angles, coordinates)``.
    exact
        Gives the exact equation about a state.
    state
        The state.
    tension
        Axial forces of the elements that go with it (N), ``(angles, elements)``.
    answer
        Gives the change of a state by a load, of an equation with these tangents.

    Raises
    ------
    SolverError
        Where they do not converge.
    """
    found, changes = state, list[float]()
    while len(changes) < THEORY.most_iterations:
        top = exact(found)
        tangents = top.linearised(found[0], found[1], tension, second=found[2])
        change = answer(tangents, known + tangents.load - tangents.left(*found))
        tension = top.predicted_tension(tangents, *(found + change)[:2])
        found = found + change
        changes.append(float(np.linalg.norm(change[0])) / max(float(np.linalg.norm(found[0])), TINY))
        if len(changes) > 1 and settled(changes, THEORY.converged):
            break
    if not changes[-1] < THEORY.accepted:
        raise SolverError(f"the exact motion is not near: the last iteration changes it by {changes[-1]:.1g}")
    return found - state


def change_between(rung: Theory, top: Theory) -> Quantities:
    """Give the difference of two motions of a mechanism, the first of which is in another theory."""
    s = stations_of(top[1])
    found, base = (Quantities.of(scene, system, response.undamped, s=s) for scene, system, response in (top, rung))
    return found - base
