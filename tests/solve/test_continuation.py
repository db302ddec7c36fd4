"""Continuation of periodic motions: Duffing's oscillator by its Fourier series, Mathieu's by an integration."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_mech.errors import SolverError
from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine, Row
from fenics_mech.solve import Family, continued, periodic
from fenics_mech.terms import Look, Measure, Response, Term
from tests.response.forced import folds

DAMPING, CUBIC, FORCE = 0.04, 0.25, 0.1
STEPS = 40


class Oscillating(Term):
    """``q'' + c q' + (1 + e cos(w t)) q + b q^3 = F cos(w t)`` of a mass of 1 kg."""

    measures = (Measure(Look.PLACE, 0),)

    def __init__(self, pair, rate, force=FORCE, damping=DAMPING, parametric=0.0):
        super().__init__([pair])
        self.numbers = rate, force, damping, parametric

    def respond(self, t, x, v):
        """Give the force on the mass, turned round."""
        rate, force, damping, parametric = self.numbers
        wave, one = np.cos(rate * t)[:, None, None], np.ones((*x.shape, 1))
        stiffness = 1 + parametric * wave
        stress = damping * v + stiffness * x + CUBIC * x**3 - force * wave
        return Response(stress, one * (stiffness + 3 * CUBIC * x**2)[..., None], damping * one)


class Repeating(NamedTuple):
    """A machine and its period (s)."""

    machine: Machine
    period: float


def oscillator(rate, **numbers):
    """A mass on a line."""
    machine = Machine(PLANE)
    mass = machine.add_pose(np.zeros(2), fixed="turn")
    machine.masses.add_body(machine.end(mass), 1.0, np.zeros((2, 2)))
    pair = machine.at_ground(), machine.end(mass)
    machine.rows.append(Row(pair, Measure(Look.PLACE, 1), name="line"))
    machine.terms.append(Oscillating(pair, rate, **numbers))
    return Repeating(machine, 2 * np.pi / rate)


def followed(at, ends, points):
    """Follow the branch from the motion at the first end."""
    first = at(ends[0])
    return list(continued(Family(at, ends), periodic(first.machine, first.period, STEPS), points))


def numbers(found, kind):
    return np.array([point.value for point in found if point.kind == kind])


@pytest.fixture(scope="module")
def upwards():
    return followed(oscillator, (0.7, 1.5), 30)


def test_folds_are_those_of_the_fourier_series(upwards):
    # steps of order 5; the number at a fold is good to the square of the slope that counts as none
    expected = folds(DAMPING, CUBIC, FORCE)
    assert numbers(upwards, "fold") == pytest.approx(expected[:, 0], rel=1e-6)
    waves = [
        2 * np.abs(np.mean(p.cycle.path.q0[:, 0] * np.exp(-2j * np.pi * np.arange(STEPS) / STEPS)))
        for p in upwards
        if p.kind
    ]
    assert waves == pytest.approx(expected[:, 1], rel=1e-3)  # where the number hardly changes, the amplitude does


def test_motions_between_folds_grow_by_a_real_multiplier(upwards):
    first, second = (k for k, point in enumerate(upwards) if point.kind)
    assert all(point.stable for point in (*upwards[:first], *upwards[second + 1 :]))
    between = [point.leading for point in upwards[first + 1 : second]]
    assert all(value.real > 1 and abs(value.imag) < 1e-9 for value in between)
    assert [upwards[k].leading for k in (first, second)] == pytest.approx([1.0, 1.0], abs=1e-3)


def test_a_branch_is_the_same_in_both_directions(upwards):
    back = followed(oscillator, (1.5, 0.7), 17)
    assert [back[0].value, back[-1].value] == [1.5, 0.7]
    assert numbers(back, "fold")[::-1] == pytest.approx(numbers(upwards, "fold"), rel=1e-7)
    assert back[-1].cycle.path.q0 == pytest.approx(upwards[0].cycle.path.q0, rel=1e-6, abs=1e-8)


def test_the_points_are_motions(upwards):
    for point in upwards[::7]:
        assert np.abs(point.cycle.evaluation.force).max() < 1e-8 * FORCE


def test_a_branch_over_the_force_folds_at_the_same_motions():
    # the branch over the force at a given rate is S-shaped: at its folds, that over the rate of such a force folds too
    rate = 1.2
    found = numbers(followed(lambda force: oscillator(rate, force=force), (0.05, 0.35), 20), "fold")
    assert len(found) == 2
    for fold in found:
        assert np.abs(folds(DAMPING, CUBIC, fold)[:, 0] - rate).min() < 1e-6


def monodromy(rate, parametric):
    """State of Mathieu's oscillator after a cycle, by an integration of another kind, from both unit states."""
    times, states = (0, 2 * np.pi / rate), np.eye(2)

    def change(t, x):
        return [x[1], -DAMPING * x[1] - (1 + parametric * np.cos(rate * t)) * x[0]]

    return np.array([solve_ivp(change, times, x, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1] for x in states])


def test_period_doublings_of_rest_under_a_pulsating_stiffness():
    """Mathieu's oscillator at rest: Nayfeh and Mook, Nonlinear Oscillations (1979), section 5.3."""
    parametric = 0.2
    grows = lambda rate: np.linalg.eigvals(monodromy(rate, parametric)).real.min() + 1 + 5e-5  # noqa: E731
    expected = [brentq(grows, 1.85, 1.95), brentq(grows, 2.05, 2.15)]
    found = followed(lambda rate: oscillator(rate, force=0.0, parametric=parametric), (1.8, 2.2), 12)
    assert numbers(found, "period doubling") == pytest.approx(expected, abs=2e-5)  # 5e-5 of a multiplier
    assert len(found) > 12


def test_a_vibration_of_another_frequency_grows_where_damping_ends():
    """Multipliers have the magnitude exp(-c T/2), which steps keep to 1e-6."""
    found = followed(lambda damping: oscillator(0.7, damping=damping), (0.1, -0.1), 5)
    assert numbers(found, "Neimark-Sacker") == pytest.approx(0.0, abs=1e-4 * 0.7 / np.pi)
    assert [point.stable for point in found] == sorted((point.stable for point in found), reverse=True)


def test_a_branch_that_is_lost_is_named():
    def at(rate):
        if rate > 1.0:
            raise SolverError("no machine here")
        return oscillator(rate)

    with pytest.raises(SolverError, match=r"lost beyond 1|lost beyond 0\.9.*no machine here"):
        followed(at, (0.8, 1.5), 20)


def test_a_step_that_lands_beyond_the_range_ends_there(upwards):
    """Behind the lower fold the rate grows faster than along the tangent: aimed inside, a step lands outside."""
    last = upwards[-2].value + 0.7 * (upwards[-1].value - upwards[-2].value)
    found = followed(oscillator, (0.7, last), 4)
    assert found[-1].value == last
