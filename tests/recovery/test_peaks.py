"""Curves between the positions of a cycle, against curves that are known everywhere."""

import numpy as np
import pytest
import xarray as xr

from fenics_mech import Impulse, Result
from fenics_mech.analysis import analyse
from fenics_mech.recovery.cycle_curves import CycleCurves
from fenics_mech.recovery.peaks import PEAK, between_positions, curves_of, curves_over_cycle, doubts, peak_of, smoothed
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
    assert peak(found) == pytest.approx(1.0, abs=4e-4)  # 27^2 h^4/384 with h = 2 pi/48 is 5.6e-4
    assert abs(peak(found) - 1) <= doubts(found)["strain"] + 1e-12
    assert doubts(found)["strain"] < 0.02


def test_the_error_falls_with_the_fourth_power_of_the_points():
    """A cubic spline of cos(k theta) errs by (k h)^4/384 between points: 8 for each of 48 positions, 4 of 100."""
    for count, points in ((48, 384), (100, 400)):
        analysis = {"sub_intervals": count, "modes": 2, "stations": 3, "error_estimates": False, "stability": False}
        result = analyse(seed_four_bar(effects=(), analysis=analysis))
        theta = result.data["theta"].to_numpy()
        at = np.arange(0, count, count / 1440)
        values = curves_over_cycle(result.scene, np.cos(10 * theta)).at(at)
        bound = (10 * 2 * np.pi / points) ** 4 / 384
        assert 0.5 * bound < np.abs(values - np.cos(10 * (theta[0] + at * (theta[1] - theta[0])))).max() < 1.2 * bound


def test_a_quasi_static_cycle_has_its_peaks_between_positions_too():
    analysis = {"method": "quasi-static", "stations": 3, "error_estimates": False, "allow_coarse": True}
    few, many = (analyse(seed_four_bar(analysis=analysis | {"sub_intervals": count})) for count in (48, 1440))
    for name in ("strain", "joint_force", "input_torque"):
        ends = [np.abs(peak_of(result, name)[2]) for result in (few, many)]
        at_positions = np.abs(few.data[name].to_numpy()).max()
        assert ends[0] == pytest.approx(ends[1], rel=1e-4), name
        if name == "strain":
            assert at_positions < ends[1].max() * (1 - 2e-4)
    assert max(doubts(few).values()) < 0.01


@pytest.mark.parametrize(
    ("count", "strain", "force"), [(7, 0.4, 0.5), (12, 0.4, 0.1), (13, 0.4, 0.05), (25, 1e-2, 2e-3)]
)
def test_few_or_odd_positions_doubt_their_peaks_by_more_than_these_are_off(count, strain, force):
    """Akima's curves alone, as odd numbers of positions once had, miss forces by 0.026 of the largest at 25."""
    analysis = {"method": "quasi-static", "stations": 3, "error_estimates": False, "allow_coarse": True}
    some, many = (analyse(seed_four_bar(analysis=analysis | {"sub_intervals": n})) for n in (count, 1440))
    for (name, doubt), largest in zip(doubts(some).items(), (strain, force)):
        found, right = (np.abs(peak_of(result, name)[2]) for result in (some, many))
        off = np.abs(found - right).max() / right.max()
        assert off < largest, name
        assert off <= doubt <= 1, name


def test_positions_keep_their_values_and_peaks_have_positions_of_their_own(result):
    expected = result.data["strain"].transpose("theta", ...).to_numpy()
    theta, values = smoothed(result, expected)
    distance = np.abs(theta[:, None] - result.data["theta"].to_numpy())
    assert distance.min(axis=0).max() < 1e-12
    assert values[distance.argmin(axis=0)] == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    closer = between_positions(result).data
    assert theta.tolist() == closer["theta"].to_numpy().tolist()
    for name in ("strain", "stress", "input_torque"):
        largest = np.abs(peak_of(result, name)[2]).max()
        assert np.abs(closer[name]).max() == pytest.approx(largest, rel=1e-9)
    force = np.linalg.norm(closer["joint_force"].transpose("theta", "joint", "component"), axis=-1).max(axis=0)
    # a place beside the one at which the cubic of the length is largest may have a length that is larger by h^4
    assert force == pytest.approx(peak_of(result, "joint_force")[2], rel=1e-5)


def test_a_largest_value_has_no_kink_where_its_place_moves(result):
    """The peak of a curve that is moved by a position: its slope jumps by 9 h, or 1.2, where another is the largest."""
    shifts = np.radians(7.5) * np.linspace(0, 1, 41)
    found = [peak(with_strain(result, lambda theta, at=at: np.exp(np.cos(3 * (theta - at))) / np.e)) for at in shifts]
    # it is lower by up to 3.3e-4 half way, about as a sine squared: its slope changes by 2 pi^2 3.3e-4/h^2 d
    assert np.abs(np.diff(found, 2)).max() / np.diff(shifts)[0] < 2e-3


def test_a_spline_does_not_swing_beyond_a_corner(result):
    """A step with flanks of two positions: a spline rises 7 % above it."""
    step = with_strain(result, lambda theta: np.clip((theta - 1) / 0.26, 0, 1) * np.clip((4.5 - theta) / 0.26, 0, 1))
    assert peak(step) < 1.01


@pytest.mark.parametrize("harmonics", [2, 8, 20])  # 20 at 48 positions are beyond these by 70 %
def test_peaks_are_those_of_all_curves(result, harmonics):
    """They are sought among the few curves of each member or joint that may have them."""
    random, shape = np.random.default_rng(harmonics), {}
    for name in ("strain", "joint_force"):
        data = result.data[name].transpose("theta", ...)
        amplitude = random.standard_normal((harmonics, *data.shape[1:]))
        waves = np.cos(np.outer(data["theta"], 1 + np.arange(harmonics)))
        sizes = random.uniform(0.2, 1, data.shape[1:])  # of which some curves are far below others
        shape[name] = data.copy(data=np.tensordot(waves, amplitude, 1) * sizes)
    found = Result(result.data.assign(shape))
    for name, seen in (("strain", CycleCurves.largest), ("joint_force", CycleCurves.longest)):
        places, values = (part.reshape(len(part), -1) for part in seen(curves_of(found, name)))
        highest = np.arange(len(values)), np.abs(values).argmax(axis=1)
        which, place, value = peak_of(found, name)
        assert (which == highest[1]).all()
        assert (place == places[highest]).all()
        assert (value == values[highest]).all()


def test_a_peak_between_positions_is_found_on_a_curve_that_is_lower_at_them(result):
    """One of 1 half way between two positions, where it is cos 30 deg, and others of 0.9 at a position."""
    theta = result.data["theta"] - result.data["theta"][0]
    lower, higher = np.cos(8 * (theta - np.pi / 48)), 0.9 * np.cos(8 * theta)
    strain = xr.where((result.data["s"] == 0.5) & (result.data["fibre"] == "-"), lower, higher)
    strain = strain.broadcast_like(result.data["strain"]).transpose(*result.data["strain"].dims)
    which, place, value = peak_of(Result(result.data.assign(strain=strain)), "strain")
    assert which.tolist() == [3, 3, 3]  # the second fibre of the second station
    assert place % 3 == pytest.approx([0.5] * 3, abs=1e-6)
    assert np.abs(value) == pytest.approx([1.0] * 3, rel=0.01)


def test_jumps_and_many_positions_are_left_as_they_are(result):
    push = {"push": Impulse(at="coupler.B", impulse=(0.0, 0.1), angle=1.0)}
    jumping = Result(result.data.assign_attrs(scene=result.scene.changed(impulses=push).model_dump_json()))
    assert between_positions(jumping) is jumping
    assert np.abs(peak_of(jumping, "strain")[2]).max() == np.abs(jumping.data["strain"]).max()
    many = result.data.reindex(theta=np.linspace(0, 2 * np.pi, PEAK.certain, endpoint=False), method="nearest")
    assert doubts(Result(many)) == {"strain": 0.0, "joint_force": 0.0}


def test_what_is_made_of_a_result_is_kept_with_it_and_with_no_other(result):
    found = between_positions(result)
    assert between_positions(result) is found
    assert between_positions(Result(result.data)) is not found
