"""Frequencies of beams that turn evenly, in the turning frame: Ritz solutions and a printed table."""

import numpy as np
import pytest
import scipy.sparse as sp

from fenics_mech.geometry import PLANE, SPACE, PoseMotion
from fenics_mech.machine import Machine
from fenics_mech.solve import frequencies
from tests.machine.builders import STEEL, Bar, Members


class Spinning:
    """A chart in which everything turns evenly about an axis through the origin."""

    still = False

    def __init__(self, machine, speed):
        g = machine.geometry
        self.g, self.r, self.R, self.spin = g, np.array(machine.r), np.array(machine.R), np.eye(g.turns)[-1] * speed

    def at(self, t):
        W = self.g.skew(self.spin)
        turn = self.g.about(self.spin, np.linalg.norm(self.spin) * t)[:, None]
        r = np.einsum("tpij,pj->tpi", np.broadcast_to(turn, (len(t), len(self.r), *W.shape)), self.r)
        spin = np.broadcast_to(self.spin, (*r.shape[:2], len(self.spin))).copy()
        return PoseMotion(r, turn @ self.R, r @ W.T, spin, r @ (W @ W).T, 0 * spin)


def turning(machine, speed, count):
    """Give the slowest rates in the frame that turns with the machine, about its equilibrium there."""
    chart = machine.chart = Spinning(machine, speed)
    W, d = machine.geometry.skew(chart.spin), machine.geometry.d
    still = sp.lil_matrix((machine.size, machine.size))  # rates of coordinates that stand still in the turning frame
    for places in machine.places:
        for vector in (places[:d], places[d:]):
            if len(vector) == len(W) and vector[0] >= 0:
                still[np.ix_(vector, vector)] = W
    still, q, zero = still.tocsr(), np.zeros(machine.size), np.zeros(1)
    for _ in range(8):
        found = machine.residual(zero, q[None], (still @ q)[None], (still @ (still @ q))[None])
        M, C, K = (machine.pattern.matrix(x[0]) for x in (found.M, found.C, found.K))
        K = K + C @ still + M @ still @ still
        q -= np.linalg.solve(K.toarray(), found.force[0])
    assert np.abs(found.force).max() < 1e-14 * np.abs(K).max()  # but for rounding
    return frequencies(M, C + 2 * M @ still, K, count)[0].imag


def arm(geometry, count, length, bar, inner=0):
    """Build an arm whose root is at the origin and fixed in the chart; give its tip."""
    machine, (x, y) = Machine(geometry), np.eye(geometry.d)[:2]
    hub, tip = machine.add_pose(0 * x, fixed="place and turn"), machine.add_pose(length * x)
    members = Members(machine)
    members.add(hub, tip, count, bar, y, inner)
    members.done()
    return machine, tip


@pytest.mark.parametrize(
    ("count", "inner", "speed", "exact", "bound"),
    [
        (4, 0, 20.0, [26.371], 5e-5),
        (4, 0, 120.0, [43.985, 815.4], 1.6e-3),
        (1, 1, 20.0, [26.371], 5e-5),
        (1, 3, 120.0, [43.985, 815.4], 3e-4),
    ],
)
def test_a_turning_beam_with_a_tip_body_has_the_frequencies_of_ritz(count, inner, speed, exact, bound):
    """Own Ritz solution about the turning state; with the rigid body's force times arm."""
    machine, tip = arm(PLANE, count, 0.3, Bar(STEEL * 6e-5, [STEEL * 4.5e-11], 7850 * 6e-5), inner)
    machine.masses.add_body(machine.end(tip, np.array([0.45, 0.0])), 0.5, np.zeros((2, 2)))
    np.testing.assert_allclose(turning(machine, speed, len(exact)), exact, rtol=bound)


# First flap frequencies over sqrt(EI/(m L^4)), at speeds in the same unit: Wright, Smith, Thresher and Wang, Vibration
# modes of centrifugally stiffened beams, J. Appl. Mech. 49 (1982). Those of lag are sqrt(flap^2 - speed^2).
FLAP = {6.0: 7.3604, 12.0: 13.1702}


@pytest.mark.parametrize(("speed", "lag", "flap"), [(6.0, 8e-4, 2.7e-4), (12.0, 6.5e-3, 1.1e-3)])
def test_a_turning_cantilever_lags_and_flaps_with_order_4(speed, lag, flap):
    """A slender beam: its axial frequencies are 1e4 times as high. Bounds of 4 elements."""
    exact, errors = np.array([np.sqrt(FLAP[speed] ** 2 - speed**2), FLAP[speed]]), []
    for count in (4, 8):
        machine, _ = arm(SPACE, count, 1.0, Bar(1e8, [1.0, 1.0], 1.0, 1e4, [1e-7, 1e-7]))
        errors.append(np.abs(turning(machine, speed, 2) / exact - 1))
    assert (errors[0] < [lag, flap]).all()
    assert (np.log2(errors[0] / errors[1]) > 3.6).all()  # the table's digits are 1e-5


@pytest.mark.parametrize(
    ("inner", "speed", "bound"), [(2, 6.0, 5e-4), (3, 6.0, 1e-5), (3, 12.0, 1.1e-3), (4, 12.0, 1e-4)]
)
def test_a_turning_cantilever_of_one_element_lags_as_in_the_table(inner, speed, bound):
    """The axial force goes from its largest to 0 within the element."""
    machine, _ = arm(PLANE, 1, 1.0, Bar(1e8, [1.0], 1.0, rotary=[1e-7]), inner)
    assert abs(turning(machine, speed, 1)[0] / np.sqrt(FLAP[speed] ** 2 - speed**2) - 1) < bound
