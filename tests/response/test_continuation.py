"""Continuation through folds: Duffing's oscillator against its Fourier series, and branches that are lost."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fenics_mech.errors import SolverError
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.continuation import arc_length as continuation
from fenics_mech.response.continuation.arc_length import Family, Point, continued, paced
from fenics_mech.response.periodic.collocation import solve_collocation
from fenics_mech.response.periodic.tableau import Tableau
from tests.response.forced import folds

DAMPING, CUBIC, FORCE = 0.04, 0.25, 0.1
COUNT, TABLEAU = 40, Tableau.of("gauss", 3)
STEP = 2 * np.pi / COUNT
ANGLES = (STEP * (np.arange(COUNT)[:, None] + TABLEAU.points)).ravel()


class Forced:
    """``q'' + c q' + q + b q^3 = F cos(angle)``, at any rate of the angle."""

    def __init__(self, force=FORCE):
        ones = np.ones((len(ANGLES), 1, 1))
        self.linear = Matrices.of_full(ones, DAMPING * ones, ones, force * np.cos(ANGLES)[:, None])
        self.links_stiffness = self.linear.stiffness
        self.system = SimpleNamespace(terms=SimpleNamespace(law=self), motion=SimpleNamespace(theta=ANGLES, omega=1))

    def linearised(self, q, rate, tension, share=1.0, second=None):
        """The tangent at q, under a share of the load."""
        stiffness = self.linear.stiffness.full + 3 * CUBIC * q[..., None] ** 2
        return Matrices.of_full(
            self.linear.mass.full, self.linear.damping.full, stiffness, share * self.linear.load + 2 * CUBIC * q**3
        )

    def predicted_tension(self, tangents, q, rate):
        """There is none."""
        return np.zeros((len(q), 1))

    def residual_near(self, tangents, state, tension, share):
        """What is left of the equation under a share of the load, and the tangents as they are."""
        return self.residual(*state) + (1 - share) * self.linear.load, tangents

    def in_links(self, q, rate):
        """There are no links."""
        return q, rate

    def about(self, q, rate, tension):
        """There is no tension."""
        return None, self

    def at(self, q, rate):
        """It is 0."""
        return np.zeros((len(q), 1))

    def residual(self, q, rate, second):
        """What is left of the equation."""
        return second + DAMPING * rate + q + CUBIC * q**3 - self.linear.load


def family(ends, at=lambda value: Forced(), rate=lambda value: value):
    return Family(at, rate, ends, TABLEAU, STEP, {})


def first(of):
    value = of.ends[0]
    orbit = solve_collocation(of.at(value), TABLEAU, STEP / of.rate(value), {}, np.zeros((len(ANGLES), 1)))
    return Point(value, paced(orbit, 1 / of.rate(value)), np.zeros((len(ANGLES), 1)))


def rates_at(found):
    return np.array([point.value for point in found if point.fold])


@pytest.fixture(scope="module")
def upwards():
    speeds = family((0.7, 1.5))
    return list(continued(speeds, first(speeds), 30))


def test_folds_are_those_of_the_fourier_series(upwards):
    # steps of order 6; the number at a fold is good to (1e-4)^2/2 of the range
    expected = folds(DAMPING, CUBIC, FORCE)
    assert rates_at(upwards) == pytest.approx(expected[:, 0], rel=1e-6)
    waves = [
        2 * np.abs(np.mean(p.orbit.start[:, 0] * np.exp(-1j * STEP * np.arange(COUNT)))) for p in upwards if p.fold
    ]
    assert waves == pytest.approx(expected[:, 1], rel=1e-3)  # where the number hardly changes, the amplitude does


def test_a_branch_is_the_same_in_both_directions(upwards):
    speeds = family((1.5, 0.7))
    back = list(continued(speeds, first(speeds), 17))
    assert [back[0].value, back[-1].value] == [1.5, 0.7]
    assert rates_at(back)[::-1] == pytest.approx(rates_at(upwards), rel=1e-7)
    assert back[-1].orbit.start == pytest.approx(upwards[0].orbit.start, rel=1e-7, abs=1e-9)


def test_the_points_are_motions(upwards):
    for point in upwards[::7]:
        orbit = paced(point.orbit, point.value)
        lack = Forced().residual(orbit.displacement, orbit.velocity, orbit.acceleration)
        assert np.abs(lack).max() < 1e-8 * FORCE


def test_a_branch_over_the_force_folds_at_the_same_motions(upwards):
    # the branch over the force at a given rate is S-shaped: at its folds, that over the rate of such a force folds too
    rate = 1.2
    forces = family((0.05, 0.35), Forced, lambda value: rate)
    found = list(continued(forces, first(forces), 20))
    assert len(rates_at(found)) == 2
    for fold in rates_at(found):
        off = np.abs(folds(DAMPING, CUBIC, fold)[:, 0] - rate)
        assert off.min() < 1e-6


def test_a_step_that_lands_beyond_the_range_ends_there(upwards):
    # behind the lower fold the rate grows faster than along the tangent: aimed inside, the step lands outside
    second = max(k for k, point in enumerate(upwards) if point.fold)
    point, speeds = upwards[second + 2], family((0.7, 1.5))
    metric = continuation._metric(speeds, np.ones((COUNT, 1)), point)
    _, tangent = continuation._corrected(
        speeds, metric, point, continuation._Direction(continuation._combined(0.0, point.orbit), 1.0)
    )
    tangent, arc = tangent.times(1 / metric.length(tangent)), 0.3
    free, _, ended = continuation._advanced(speeds, metric, point, tangent, arc)
    aimed = point.value + arc * tangent.value
    assert not ended
    assert free.value > aimed + 1e-3
    end = (aimed + free.value) / 2
    last, _, ended = continuation._advanced(family((0.7, end)), metric, point, tangent, arc)
    assert ended
    assert last.value == end


def test_a_branch_that_is_lost_is_named():
    def at(value):
        if value > 1.0:
            raise SolverError("no equation here")
        return Forced()

    speeds = family((0.8, 1.5), at)
    found = continued(speeds, first(speeds), 20)
    with pytest.raises(SolverError, match=r"lost beyond 1|lost beyond 0\.9.*no equation here"):
        list(found)


def test_a_start_that_is_no_motion_is_refused(monkeypatch):
    speeds = family((0.8, 1.5))
    straight = first(speeds)
    monkeypatch.setattr(continuation, "BRANCH", replace(continuation.BRANCH, most_iterations=1))
    with pytest.raises(SolverError, match="Newton's method stopped after 1 iterations, changing by"):
        next(continued(speeds, Point(0.8, paced(straight.orbit, 2.0), straight.tension), 20))
