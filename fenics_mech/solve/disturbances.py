"""Small disturbances beside a motion in time, carried through its steps: multipliers and Lyapunov exponents.

The equation linearised about the motion is solved by the collocation of the steps themselves. So the disturbance is
that of the motion as it is computed. Disturbances that are followed for long are made orthogonal again and again, and
what they have grown by is summed up. In the plane coordinates of poses add up, so that they are the same beside every
chart at rest.

Source: Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980), p. 21; Parker and Chua, Practical Numerical
Algorithms for Chaotic Systems (1989), chapters 3 and 4.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.joints.rubbing import Rubbing
from fenics_mech.machine import Machine
from fenics_mech.solve.sparse import Factors, blocks_of
from fenics_mech.solve.stages import stage_matrix
from fenics_mech.solve.step import Step

APART = 1e-5  # of the extent, or rad, by which gradients of rows are differentiated along a motion
SMALLEST = 1e-9  # of the largest singular value of rows without units: those below it hold nothing


@dataclass
class Transition:
    """Carries disturbances of the state from a start on."""

    states: Array  # disturbances of coordinates and rates, one a column, (2 n, disturbances)
    rough: bool = False  # whether dry friction turned round between the stages of a step, which do not show how

    def take(self, step: Step) -> None:
        """Carry the disturbances through a step that is solved."""
        shares = np.append(0.0, step.tableau.c)
        for k, term in enumerate(step.machine.terms):
            if isinstance(term, Rubbing) and not self.rough:
                self.rough = term.turned_unseen(step.measured(k, shares).rate[:, 0, 0])
        self.states = inside(step, self.states, _seconds(step, self.states), np.ones(1))[0]


@dataclass
class Growth:
    """Follows how fast disturbances grow, however far a motion goes."""

    states: Array  # as of `Transition`
    # gives, by a step, shares of it, and disturbances there (shares, 2 n, disturbances), by what their size is told:
    # as many numbers as there are disturbances (shares, disturbances, disturbances)
    seen: Callable[[Step, Array, Array], Array]
    # instants at which the growth is wanted too: it is no straight line between the ends of steps (times,) (s)
    times: Array
    # time (s), and logarithm of what each disturbance has grown by since the start, there and at the ends of steps
    of_each: list[tuple[float, Array]] = field(default_factory=list)

    def take(self, step: Step) -> None:
        """Carry the disturbances through a step that is solved, and make what is seen of them orthogonal."""
        if not self.of_each:
            self._begin(np.linalg.qr(self.seen(step, np.zeros(1), self.states[None])[0])[1])
        second, end = _seconds(step, self.states), step.t + step.h
        before = self.of_each[-1][1] if self.of_each else 0.0
        due = self.times[(self.times > step.t) & (self.times < end)]
        shares = np.append((due - step.t) / step.h, 1.0)
        at = inside(step, self.states, second, shares)
        triangles = np.linalg.qr(self.seen(step, shares, at))[1]
        grown = np.log(np.maximum(np.abs(np.diagonal(triangles, axis1=1, axis2=2)), TINY))
        self.of_each += [(float(t), before + growth) for t, growth in zip([*due, end], grown)]
        self.states = at[-1]
        self._begin(triangles[-1])

    def _begin(self, triangle: Array) -> None:
        """Make disturbances those that are orthogonal and of size 1 where they are seen."""
        self.states = np.linalg.solve(triangle.T, self.states.T).T


def _seconds(step: Step, states: Array) -> Array:
    """Give the accelerations of disturbances at the stages of a step ``(stages, size, disturbances)``."""
    machine, tableau, h, (M, C, K) = step.machine, step.tableau, step.h, step.tangents_there()
    zero, right = np.zeros((machine.size - machine.n, states.shape[1])), []
    place, rate = (np.concatenate([x, zero]) for x in np.split(states, 2))
    for share, damping, stiffness in zip(tableau.c, C, K):
        right.append(
            machine.pattern.matrix(damping) @ rate + machine.pattern.matrix(stiffness) @ (place + h * share * rate)
        )
    blocks = blocks_of(machine.pattern, len(tableau.c))
    factors = Factors(blocks, stage_matrix(tableau, h, M, C, K), f"step at {step.t:.6g} s")
    found = factors.solve(-np.stack(right, axis=1).reshape(blocks.size, -1))
    return np.moveaxis(found.reshape(machine.size, len(tableau.c), -1), 0, 1)


def inside(step: Step, states: Array, second: Array, shares: Array) -> Array:
    """Give disturbances at shares of a step ``(shares, 2 n, disturbances)``, by their accelerations at its stages."""
    (place, rate), n, h = np.split(states, 2), step.machine.n, step.h
    integrals = step.tableau.at(shares)[1]
    once = h * np.tensordot(integrals, second[:, :n], 1)
    twice = h * h * np.tensordot(integrals @ step.tableau.A, second[:, :n], 1)
    return np.concatenate([place + h * shares[:, None, None] * rate + twice, rate + once], axis=1)


def allowed(machine: Machine, t: float, v: Array) -> tuple[Array, Array]:
    """Give the disturbances of a state that the rows of joints allow, where the chart of a machine rests."""
    # v (n,)
    n, end, units = machine.n, machine.n + machine.held, machine.units[: machine.n]
    spacing = APART / max(float(np.abs(v / units).max(initial=0.0)), TINY)
    q = np.zeros((3, machine.size))
    q[1, :n], q[2, :n] = spacing * v, -spacing * v
    found = machine.residual(np.full(3, t), q, 0 * q, 0 * q, loads=0.0, moving=False)
    here, ahead, behind = machine.pattern.dense(found.K)[:, n:end, :n] * units
    _, sizes, ways = np.linalg.svd(here)
    rank = int((sizes > SMALLEST * sizes.max(initial=0.0)).sum())
    free, back = ways[rank:].T, np.linalg.pinv(here, SMALLEST)
    turned = -back @ ((ahead - behind) / (2 * spacing)) @ free
    states = np.block([[free, np.zeros_like(free)], [turned, free]])
    return np.tile(units, 2)[:, None] * states, units[:, None] * back


def quarters_of(times: Array) -> Array:
    """Give where the last two quarters of a motion begin and end (s), whose growth makes the exponents."""
    # times (times,) (s)
    return np.linspace(times[0], times[-1], 5)[2:]
