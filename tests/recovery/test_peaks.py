"""Curves between the positions of a cycle, against curves that are known everywhere."""

import numpy as np
import pytest
import xarray as xr

from fenics_mech import Result
from fenics_mech.analysis import analyse
from fenics_mech.recovery.peaks import PEAK, between_positions, doubts, smoothed
from fenics_mech.scene.factories import seed_four_bar


@pytest.fixture(scope="module")
def result():
    analysis = {"sub_intervals": 48, "modes": 2, "stations": 3, "error_estimates": False, "stability": False}
    return analyse(seed_four_bar(effects=(), analysis=analysis))


def with_strain(result, curve):
    """Give the result with a curve of the drive angle as the strain of its first member, and nothing elsewhere."""
    theta = result.data["theta"]
    first = result.data["member"] == result.data["member"][0]
    found = {"strain": curve(theta - theta[0]) * first * xr.ones_like(result.data["strain"])}
    return Result(result.data.assign(found | {"joint_force": xr.zeros_like(result.data["joint_force"])}))


def peak(result):
    return float(np.abs(between_positions(result).data["strain"]).max())


@pytest.mark.parametrize("shift", np.linspace(0, np.radians(7.5), 5))
def test_a_smooth_peak_between_positions_is_right_and_no_more_doubted_than_it_is(result, shift):
    """Eight harmonics at 48 positions; the doubt is above the error, and the error of the largest position."""
    found = with_strain(result, lambda theta: np.exp(np.cos(3 * (theta - shift))) / np.e)
    assert peak(found) == pytest.approx(1.0, abs=2e-3)  # (9 pi/720)^2/2 = 8e-4 is between the closer positions
    assert abs(peak(found) - 1) < doubts(found)["strain"] + 8e-4
    assert doubts(found)["strain"] < 0.02


def test_the_error_falls_with_the_fourth_power_of_the_positions():
    """A cubic spline of cos(k theta) errs by (k h)^4/384 between positions, at the largest."""
    for count in (48, 96):
        analysis = {"sub_intervals": count, "modes": 2, "stations": 3, "error_estimates": False, "stability": False}
        result = analyse(seed_four_bar(effects=(), analysis=analysis))
        theta = result.data["theta"].to_numpy()
        closer, values = smoothed(result, np.cos(4 * theta))
        bound = (4 * 2 * np.pi / count) ** 4 / 384
        assert 0.5 * bound < np.abs(values - np.cos(4 * closer)).max() < 1.2 * bound


def test_positions_keep_their_values(result):
    theta, values = smoothed(result, result.data["strain"].transpose("theta", ...).to_numpy())
    times = len(theta) // 48
    assert theta[::times] == pytest.approx(result.data["theta"].to_numpy(), abs=1e-12)
    expected = result.data["strain"].transpose("theta", ...).to_numpy()
    assert values[::times] == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())


def test_a_spline_does_not_swing_beyond_a_corner(result):
    """A step with flanks of two positions: a spline rises 7 % above it."""
    step = with_strain(result, lambda theta: np.clip((theta - 1) / 0.26, 0, 1) * np.clip((4.5 - theta) / 0.26, 0, 1))
    assert peak(step) < 1.01


def test_jumps_and_many_positions_are_left_as_they_are(result):
    many = result.data.reindex(theta=np.linspace(0, 2 * np.pi, PEAK.close, endpoint=False), method="nearest")
    assert between_positions(Result(many)).data["strain"].sizes["theta"] == PEAK.close
    assert doubts(Result(many)) == {"strain": 0.0, "joint_force": 0.0}
