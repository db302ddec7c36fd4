"""Cubics between positions of a cycle, against their closed forms."""

import numpy as np
import pytest

from fenics_mech.recovery.cycle_curves import NEIGHBOURS, CycleCurves, _akima_slopes, akima_over_cycle

EIGHT = 2 * np.pi * np.arange(8) / 8


def test_a_cubic_turns_where_its_slope_is_zero():
    """f(1 - f)(1 - 2f) has slopes 1 and 1 at its ends and turns at (3 -+ sqrt(3))/6, +-sqrt(3)/18 high."""
    curves = CycleCurves(np.zeros((3, 1)), np.ones((3, 1)))
    for (place, value), sign in ((curves.highest(), -1), (curves.lowest(), 1)):
        assert place[0] % 1 == pytest.approx((3 + sign * np.sqrt(3)) / 6, rel=1e-14)
        assert value[0] == pytest.approx(-sign * np.sqrt(3) / 18, rel=1e-14)
    height = np.sqrt(3) / 18
    assert curves.turning()[:, 0] == pytest.approx(3 * [0, height, -height], abs=1e-16)


@pytest.mark.parametrize("seed", range(5))
def test_extremes_are_those_of_the_curve_everywhere(seed):
    random = np.random.default_rng(seed)
    curves = CycleCurves(random.normal(size=(12, 20)), random.normal(scale=4, size=(12, 20)))
    fine = curves.at(np.arange(0, 12, 1 / 512))
    for (place, value), seen in ((curves.highest(), fine.max(axis=0)), (curves.lowest(), fine.min(axis=0))):
        assert value == pytest.approx(seen, abs=1e-4)  # a curvature of 60 between points of 1/512
        assert (np.sign(seen - fine.mean(axis=0)) * (value - seen) >= -1e-12).all()
        assert curves.at(place).diagonal() == pytest.approx(value, abs=1e-12)
    place, value = curves.largest()
    assert np.abs(value) == pytest.approx(np.abs(fine).max(axis=0), abs=1e-4)
    assert curves.at(place).diagonal() == pytest.approx(value, abs=1e-12)
    assert curves.turning().max(axis=0) == pytest.approx(curves.highest()[1], abs=1e-12)
    assert curves.turning().min(axis=0) == pytest.approx(curves.lowest()[1], abs=1e-12)


@pytest.mark.parametrize(
    ("count", "curve"), [(12, lambda x: np.exp(2 * np.cos(x))), (90, lambda x: -abs(np.sin(x / 2)))]
)
def test_a_peak_at_the_start_is_not_at_the_end(count, curve):
    """An even curve has a slope of nothing but rounding at 0, where the step before it ends."""
    curves = CycleCurves.through(curve(2 * np.pi * np.arange(count) / count)[:, None])
    place = curves.highest()[0][0]
    assert place < count
    assert min(place, count - place) == pytest.approx(0, abs=1e-7)  # a maximum is known to the root of rounding


def test_a_smooth_curve_is_its_harmonics_and_a_cornered_one_stays_between_its_positions():
    """The slope of the spline of cos k theta is -k sin k theta times 3 sin x/(x (2 + cos x)) with x = k h.

    It goes through eight points for each of the 48 positions.
    """
    theta = 2 * np.pi * np.arange(48) / 48
    step = np.clip((theta - 1) / 0.13, 0, 1) * np.clip((4.5 - theta) / 0.13, 0, 1)
    curves = CycleCurves.through(np.stack([np.cos(3 * theta), step], axis=1))
    assert curves.corners.tolist() == [False, True]
    fine, x = 2 * np.pi * np.arange(8 * 48) / (8 * 48), 3 * theta[1] / 8
    assert curves.per_position == 8
    assert curves.values[:, 0] == pytest.approx(np.cos(3 * fine), abs=1e-14)
    expected = -np.sin(3 * fine) * 3 * np.sin(x) / (2 + np.cos(x))
    assert curves.slopes[:, 0] == pytest.approx(expected, abs=1e-14)
    assert curves.highest()[1][1] < 1.01
    assert CycleCurves.of_positions(step).highest()[1] == step.max()


@pytest.mark.parametrize("count", [48, 60])
def test_harmonics_give_values_that_splines_miss(count):
    """The eighth harmonic: splines through 48 positions miss its peak by up to (8 h)^4/384 = 3e-3.

    Those through eight times as many points miss it by 4096 times less.
    """
    theta = 2 * np.pi * np.arange(count) / count
    curves = CycleCurves.through(np.cos(8 * (theta - 0.01))[:, None])
    assert curves.highest()[1] == pytest.approx(1.0, abs=2e-6)


@pytest.mark.parametrize("share", [0.25, 0.4])
def test_a_curve_that_half_of_the_positions_miss_has_no_corners(share):
    """A bell whose harmonics fade between the highest that half of 80 positions show and the highest that all do."""
    width = share * 80
    theta = 2 * np.pi * np.arange(80) / 80
    curves = CycleCurves.through(np.exp(width * (np.cos(theta - 0.03) - 1))[:, None])
    assert not curves.corners.any()
    assert curves.highest()[1] == pytest.approx(1.0, abs=1e-4)


def test_there_may_be_no_curves():
    for count in (24, 25, 400):
        for of_harmonics in (True, False):
            curves = CycleCurves.through(np.zeros((count, 0)), of_harmonics)
            assert curves.at(np.arange(3.0)).shape == (3, 0)


def test_lengths_of_vectors_turn_with_them():
    """A vector that turns keeps its length; one along a line has its size as length, with a corner at zero."""
    curves = CycleCurves.through(np.stack([np.cos(EIGHT), np.sin(EIGHT)], axis=1)).lengths()
    assert curves.values == pytest.approx(np.ones(360))
    assert curves.slopes == pytest.approx(np.zeros(360), abs=1e-14)
    line = CycleCurves.through(np.outer(0.2 + np.cos(EIGHT - 0.1), [3.0, 4.0]))
    along = CycleCurves.through(5 * (0.2 + np.cos(EIGHT - 0.1))).largest()
    for found in (line.lengths().largest(), line.longest()):
        assert np.array(found) == pytest.approx(np.array(along), rel=1e-12)
    swinging = CycleCurves.through(np.stack([np.cos(EIGHT - 0.1), 0.5 * np.sin(2 * EIGHT)], axis=1))
    place, length = swinging.longest()
    assert length == pytest.approx(np.linalg.norm(swinging.at(place.reshape(1))), rel=1e-14)
    assert length == pytest.approx(np.linalg.norm(swinging.at(np.arange(0, 8, 1 / 512)), axis=1).max(), rel=1e-3)


def test_halves_are_curves_through_every_second_position():
    curves = CycleCurves.through(np.cos(EIGHT - 0.3)[:, None])
    halves = curves.others()
    alone = [CycleCurves.through(half) for half in (curves.values[::90], curves.values[45::90])]
    for k, half in enumerate(alone):
        assert halves.values[:: halves.per_position, k].tolist() == np.cos(EIGHT - 0.3)[k::2, None].tolist()
        assert not half.corners.any()
        assert np.array_equal(halves.values[:, k], half.values)
        assert np.array_equal(halves.slopes[:, k], half.slopes)
    assert halves.corners.tolist() == [curves.corners.tolist()] * 2
    of_positions = CycleCurves.of_positions(np.arange(7.0)).others()
    assert of_positions.values.T.tolist() == [[0, 2, 4, 6], [1, 3, 5, 5]]
    assert not of_positions.slopes.any()
    other = CycleCurves.through(np.cos(EIGHT[:7] * 8 / 7)[:, None]).others()  # an odd number
    assert other.corners.tolist() == [[False]] * 2
    assert other.values.shape == (360, 2, 1)  # halves of eight values


@pytest.mark.parametrize("count", [3, 4, 5, 8, 90])
def test_slopes_of_akima_are_those_of_scipy(count):
    """Also where curves are straight on both sides of a position, or turn by rounding only."""
    random, at = np.random.default_rng(count), np.arange(float(count))
    values = np.concatenate([random.normal(size=(count, 20)), random.integers(0, 2, (count, 20))], axis=1)
    values[:, 0] = 1e-12 * values[:, 0]
    expected = akima_over_cycle(at, values, count, NEIGHBOURS)(at, 1)
    assert np.array_equal(_akima_slopes(values), expected)
    assert _akima_slopes(np.empty((count, 0))).shape == (count, 0)
