"""Files for other programs, read back."""

import numpy as np
import pytest
import pyvista
from scipy.io import loadmat
from typer.testing import CliRunner

from fenics_mech import Result, ResultError
from fenics_mech.cli import app
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.recovery.variables import ATTRIBUTES, STRAINS
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of


@pytest.fixture(scope="module")
def result():
    return response_of(seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 12, "stations": 5}))


def test_time_series_holds_places_displacements_and_fields(result, tmp_path):
    path = result.to_vtk(tmp_path / "motion.pvd", every=3)
    reader, data = pyvista.get_reader(path), result.data
    assert reader.time_values == pytest.approx(data["time"].to_numpy()[::3])
    motion = solve_motion(result.scene, data["theta"].to_numpy())
    for k in (0, 2):
        reader.set_active_time_value(reader.time_values[k])
        grid = reader.read()[0]
        assert grid.n_points == 3 * 5
        assert grid.n_cells == 3 * 4
        ends = [motion.of_point("follower", result.scene.links["follower"].points[name])[0][3 * k] for name in "CB"]
        assert grid.points[10, :2] == pytest.approx(ends[0], abs=1e-12)
        assert grid.points[14, :2] == pytest.approx(ends[1], abs=1e-12)
        here = data.isel(theta=3 * k).sel(member="follower")
        moved = grid.point_data["displacement (m)"][10:]
        assert moved[:, :2] == pytest.approx(here["deflection"].transpose("s", "component").to_numpy())
        assert not moved[:, 2].any()
        for name, expected in {
            "stress minus (Pa)": here["stress"].sel(fibre="-"),
            "strain plus": here["strain"].sel(fibre="+"),
            "moment (N m)": here["moment"],
            "axial force (N)": here["axial_force"],
            "shear force (N)": here["shear_force"],
        }.items():
            assert grid.point_data[name][10:] == pytest.approx(expected.to_numpy()), name
        assert list(grid.cell_data["member"][[0, 4, 8]]) == [0, 1, 2]
        assert list(grid.field_data["member names"]) == ["crank", "coupler", "follower"]
        assert grid.field_data["drive angle (rad)"][0] == pytest.approx(float(data["theta"][3 * k]))


def test_mat_holds_every_variable_with_its_dimensions_and_units(result, tmp_path):
    found, data = loadmat(result.to_mat(tmp_path / "result.mat"), squeeze_me=True), result.data
    for name in data.variables:
        if data[name].dtype.kind in "fi":
            assert np.shape(found[name]) == np.shape(np.squeeze(data[name])), name
            np.testing.assert_array_equal(found[name], np.squeeze(data[name].to_numpy()))
    assert list(found["member"]) == ["crank", "coupler", "follower"]
    assert found["dimensions"]["strain"].item() == "theta, member, s, fibre"
    assert found["units"]["stress"].item() == "Pa"
    assert found["attributes"]["title"].item() == result.scene.name


def test_what_cannot_be_exported_is_said(result, tmp_path):
    with pytest.raises(ResultError, match=r"must end in \.pvd"):
        result.to_vtk(tmp_path / "motion.vtk")
    with pytest.raises(ResultError, match=r"must end in \.mat"):
        result.to_mat(tmp_path / "result.m")
    with pytest.raises(ResultError, match="1 or more"):
        result.to_vtk(tmp_path / "motion.pvd", every=0)
    with pytest.raises(ResultError, match="analyse its scene again"):
        Result(result.data.drop_vars("position")).to_vtk(tmp_path / "motion.pvd")
    (tmp_path / "file").write_text("")
    with pytest.raises(ResultError, match="cannot make the folder"):
        result.to_vtk(tmp_path / "file" / "motion.pvd")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_command_writes_both(result, tmp_path):
    result.save(tmp_path / "result.nc")
    words = [str(tmp_path / name) for name in ("result.nc", "out/m.pvd", "out/r.mat")]
    done = CliRunner().invoke(app, ["export", *words, "--every", "6"])
    assert done.exit_code == 0, done.output
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["m", "m.pvd", "r.mat"]
    assert len(list((tmp_path / "out" / "m").iterdir())) == 2
    assert "exported are .pvd" in str(CliRunner().invoke(app, ["export", words[0], "x.xyz"]).exception)


@pytest.mark.parametrize("name", ["strain", "largest_strain"])
def test_tables_tell_strains_in_the_unit_that_is_asked_for(result, tmp_path, name):
    lines = result.to_table(name, tmp_path / "table.csv", ["%"]).read_text().splitlines()
    assert lines[0].endswith(f",{name} (%)")
    values = [float(line.split(",")[-1]) for line in lines[1:]]
    assert max(values) == pytest.approx(100 * float(result.data[name].max()), rel=1e-12)


def test_every_variable_that_is_a_strain_is_known_as_one():
    """Described as strains, and neither shares of them nor places, phases and numbers of harmonics."""
    other = {"relative_error", "utilisation", "vibration_harmonic", "critical_share"}
    assert (
        set(STRAINS)
        == {name for name, (unit, meaning) in ATTRIBUTES.items() if unit == "1" and "strain" in meaning} - other
    )
