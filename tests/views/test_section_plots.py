"""Section forces along members: those of the result, and in balance with each other."""

import numpy as np
import pytest

from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.views.page.curves import member_mass
from fenics_mech.views.plots import plot_section_forces, section_force_figure
from fenics_mech.views.reading import SECTION_FORCES, reading_of_members
from tests.views.test_page import free_result


def drawn(axes):
    """The curve of some axes, and the least and the largest of its shaded band at each station."""
    line, (band,) = axes.get_lines()[0], axes.collections
    corners = band.get_paths()[0].vertices
    x, y = line.get_data()
    at = [corners[np.isclose(corners[:, 0], place), 1] for place in x]
    return x, y, np.array([one.min() for one in at]), np.array([one.max() for one in at])


@pytest.mark.parametrize("force", SECTION_FORCES)
def test_the_curve_is_that_of_the_result_inside_its_band(result, force):
    k = 5
    x, y, low, high = drawn(plot_section_forces(result, "follower", force=force, at=float(result.data["theta"][k])))
    known = result.data[force].sel(member="follower")
    assert y == pytest.approx(known.isel(theta=k).to_numpy(), abs=1e-9)
    assert x[-1] == pytest.approx(1e3 * result.scene.links["follower"].points["B"][0])
    room = 1e-9 + 1e-9 * float(abs(known).max())  # of interpolation at the positions themselves
    assert (low <= known.min("theta").to_numpy() + room).all()
    assert (high >= known.max("theta").to_numpy() - room).all()


def test_shear_is_the_slope_of_the_moment(result):
    """V = dM/ds along a beam: differences over 21 stations, of which the ends are of first order."""
    at = float(result.data["theta"][3])
    x, moment, *_ = drawn(plot_section_forces(result, "crank", at=at))
    _, shear, *_ = drawn(plot_section_forces(result, "crank", force="shear_force", at=at))
    slope = np.gradient(moment, x / 1e3)
    assert slope[1:-1] == pytest.approx(shear[1:-1], rel=1e-2)


@pytest.mark.slow
def test_a_bar_let_fall_from_the_level_has_its_textbook_shear():
    """V = m g (1 - 4 s + 3 s^2)/4 of a uniform bar on a pin, released at rest (Beer and Johnston, plane motion)."""
    result = free_result()
    scene, (mass, _) = result.scene, member_mass(result.scene, "bar")
    _, shear, *_ = drawn(plot_section_forces(result, "bar", force="shear_force", at=0.0))
    weight, s = mass * abs(scene.gravity[1]), result.data["s"].to_numpy()
    assert shear == pytest.approx(weight * (1 - 4 * s + 3 * s**2) / 4, abs=2e-3 * weight)


def test_it_is_drawn_at_the_peak_of_the_member_unless_told_otherwise(result):
    reading = reading_of_members(result)
    peak = reading.peaks[reading.members.index("coupler")]
    axes = result.plot("section_forces", "coupler")
    assert axes.get_title("left") == f"Bending moment of coupler at {reading.at(peak.k)}"
    assert drawn(axes)[1] == pytest.approx(reading.section_force("moment")[peak.k, peak.i])
    assert reading.section_force("moment").shape[0] == between_positions(result).data.sizes["theta"]


def test_the_figure_has_a_column_for_each_member_with_its_own_scale(result):
    figure = section_force_figure(result)
    panels = np.array(figure.axes).reshape(3, 3)
    assert [axes.get_title("left").partition(" at ")[0] for axes in panels[0]] == ["crank", "coupler", "follower"]
    assert panels[2, 0].get_ylabel() == "bending moment (N m)"
    assert panels[2, 0].get_ylim()[1] > 5 * panels[2, 1].get_ylim()[1]  # the crank's moment is 20 times the coupler's


def test_a_motion_in_time_is_asked_for_by_its_time(result):
    scene = result.scene.changed(analysis={**result.scene.analysis.model_dump(), "method": "transient"})
    timed = Result(result.data.assign_attrs(scene=scene.model_dump_json()))
    time = result.data["time"].to_numpy()
    middle = (time[4] + time[5]) / 2
    _, y, *_ = drawn(plot_section_forces(timed, "crank", at=middle))
    known = result.data["moment"].sel(member="crank")
    assert y == pytest.approx((known[4] + known[5]).to_numpy() / 2)
    with pytest.raises(ViewError, match=r"lasts from 0 s to .* is asked for at 9 s"):
        plot_section_forces(timed, "crank", at=9.0)


def test_forces_that_are_not_there_are_refused(result):
    with pytest.raises(ViewError, match="no section force 'torque'; there are axial_force, shear_force, moment"):
        plot_section_forces(result, "crank", force="torque")
    with pytest.raises(ViewError, match="no member 'rocker'"):
        plot_section_forces(result, "rocker")
