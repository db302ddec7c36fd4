"""Sweeps in space."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.studies.spatial_sweep import parsed_axis
from tests.common import DEMOS


@pytest.fixture(scope="module")
def coarse() -> fm.SpatialScene:
    scene = fm.load(DEMOS / "space" / "drive_line.toml")
    return scene.changed({"analysis.positions": 12, "mesh.elements": 1, "analysis.error_estimates": False})


def test_points_are_those_of_single_analyses(coarse):
    found = fm.sweep_in_space(coarse, {"drive.speed": ["300 rpm", "600 rpm"]})
    alone = fm.analyse(coarse.changed({"drive.speed": "600 rpm"})).data
    assert found["von_mises"].dims == ("drive.speed", "member")
    assert found["von_mises"].values[1] == pytest.approx(alone["von_mises"].max(["theta", "s"]).values, rel=1e-12)
    assert found["drive.speed"].values == pytest.approx([10 * np.pi, 20 * np.pi])
    assert found["von_mises"].attrs["units"] == "Pa"


@pytest.mark.slow
def test_several_processes_give_the_same(coarse):
    values = {"drive.speed": ["300 rpm", "600 rpm", "900 rpm"]}
    one, two = (fm.sweep_in_space(coarse, values, jobs=jobs) for jobs in (1, 2))
    assert one.identical(two)


def test_a_point_that_fails_is_told_and_ends_nothing(coarse):
    found = fm.sweep_in_space(coarse, {"materials.steel.modulus": [1.0, 210e9]})
    assert found["error"].values[0] != ""
    assert found["error"].values[1] == ""
    assert np.isnan(found["von_mises"].values[0]).all()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("drive.speed", "cannot read"),
        ("drive.speed=1:2:1", "cannot read"),
        ("name=a:b:3", "only a number can vary"),
        ("drive.nothing=1:2:3", "nothing"),
    ],
)
def test_ranges_that_cannot_be_read_are_refused(coarse, text, said):
    with pytest.raises(fm.SceneError, match=said):
        parsed_axis(coarse, text)


def test_a_range_is_read_with_its_unit(coarse):
    path, values = parsed_axis(coarse, "drive.speed=300 rpm:900 rpm:3")
    assert path == "drive.speed"
    assert values == pytest.approx([10 * np.pi, 20 * np.pi, 30 * np.pi])
