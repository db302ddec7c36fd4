"""Forces drawn as paths of their tips, paths of points, and plots in the units of the scene."""

import numpy as np
import pytest

from fenics_mech.errors import ResultError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.views.plots import plot_force_path, plot_joint_forces, plot_point_path, plot_strain

POUND = 4.4482216152605


def in_units(result, *units):
    """Give the result with units stated in its scene."""
    scene = result.scene.changed(units=list(units))
    return Result(result.data.assign_attrs(scene=scene.model_dump_json()))


def longest(axes):
    """Points of the longest line of some axes."""
    return max((np.asarray(line.get_xydata(), float) for line in axes.get_lines()), key=len)


def test_path_of_a_force_is_closed_and_its_ring_is_the_largest_force(result):
    axes = plot_force_path(result, "A")
    path = longest(axes)
    assert path[0] == pytest.approx(path[-1])
    force = between_positions(result).data["joint_force"].sel(joint="A").transpose("theta", "component").to_numpy()
    assert path[:-1] == pytest.approx(force)
    ring = next(line for line in axes.get_lines() if line.get_markersize() == 9)
    assert np.linalg.norm(ring.get_xydata()) == pytest.approx(np.linalg.norm(force, axis=1).max())


def test_path_of_the_crank_pin_is_a_circle(result):
    radius = np.linalg.norm(longest(plot_point_path(result, ["crank.A"])), axis=1)
    length = 1e3 * np.hypot(*result.scene.links["crank"].points["A"])
    assert radius == pytest.approx(length, rel=0.02)


def test_units_of_the_scene_are_those_of_the_plots(result):
    """Also of the reference: a plot without units stated is in N and micrometres per metre."""
    other = in_units(result, "lbf", "%")
    one, two = (longest(plot_joint_forces(found)) for found in (result, other))
    assert two[:, 1] == pytest.approx(one[:, 1] / POUND)
    assert plot_joint_forces(other).get_ylabel() == "force (lbf)"
    one, two = (longest(plot_strain(found, "coupler")) for found in (result, other))
    assert two[:, 1] == pytest.approx(one[:, 1] / 1e4)


def test_result_plots_by_name_and_names_what_there_is(result):
    assert result.plot("force_path", "B").get_title("left").startswith("Force of joint B")
    with pytest.raises(ResultError, match="there is no plot 'all'; there are strain"):
        result.plot("all")
    with pytest.raises(ViewError, match="no joint 'X'"):
        result.plot("force_path", "X")
