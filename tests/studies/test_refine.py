"""Refinement: orders and extrapolated answers of known sequences, of a beam, and of the seed."""

import numpy as np
import pytest
from typer.testing import CliRunner

from fenics_mech import SceneError
from fenics_mech.cli import app
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.studies.refine import Refinement, refine, richardson
from tests.common import DEMOS
from tests.recovery.test_momentum import arm


@pytest.mark.parametrize("order", [1, 2, 4, 6.5])
def test_order_and_limit_of_a_power_come_out(order):
    limit, steps = np.array([3.0, -2.0]), 0.5 ** np.arange(4)
    values = limit + np.outer(steps**order, [0.3, -0.2])
    found, extrapolated = richardson(values)
    assert found == pytest.approx(order)
    assert extrapolated == pytest.approx(limit)


def test_what_does_not_converge_has_no_order():
    found, extrapolated = richardson(np.array([[1.0, 1.0, 2.0], [2.0, 1.5, 2.0], [4.0, 1.0, 2.0]]))
    assert np.isnan(found).all()
    assert np.isnan(extrapolated[:2]).all()
    assert extrapolated[2] == 2.0


def test_frequencies_of_a_cantilever_converge_to_euler_bernoulli_with_order_4():
    joints = {"O": {"kind": "weld", "connect": ("ground.O", "arm.O")}}
    scene = arm(joints=joints, drive=(), masses={}, gravity=(0, -9.81), analysis={"method": "static"})
    data = refine(scene.changed(mesh__elements=4)).data
    omega = np.array([1.8751040687, 4.6940911330]) ** 2 * np.sqrt(206e9 * 0.005**2 / 12 / 7850) / 0.5**2
    assert list(data["refinement"].to_numpy()) == ["elements"]
    assert list(data["count"].to_numpy()[0]) == [4, 8, 16]
    for i in (1, 2):
        row = data.sel(refinement="elements", quantity=f"frequency mode {i}")
        assert float(row["order"]) == pytest.approx(4, abs=0.3)
        exact = omega[i - 1] / (2 * np.pi)
        found = float(row["extrapolated"])
        finest = float(row["value"][-1])
        assert abs(found - exact) < 0.3 * abs(finest - exact)
        assert float(row["error"]) == pytest.approx(abs(float(row["value"][0]) / exact - 1), rel=0.1)
    strain = data.sel(refinement="elements", quantity="strain arm")  # of statics it is exact on any mesh
    assert np.ptp(strain["value"].to_numpy()) < 1e-9 * float(strain["value"][0])


@pytest.mark.long
@pytest.mark.slow
def test_steps_of_the_linear_equation_converge():
    analysis = {"sub_intervals": 96, "solver": "collocation", "stability": False, "modes": "all"}
    data = refine(seed_four_bar(drive__speed=15.0, effects=("coupling",), analysis=analysis)).data
    by_steps = data.sel(refinement="sub_intervals")
    assert list(by_steps["count"].to_numpy()) == [48, 96, 192]
    order = by_steps["order"].sel(quantity=["strain crank", "strain follower"]).to_numpy()
    assert (order > 4).all()  # of three Radau points it is 5
    by_mesh = data.sel(refinement="elements")["order"].sel(quantity=["strain crank", "strain coupler"]).to_numpy()
    assert by_mesh == pytest.approx(4, abs=0.7)


@pytest.mark.parametrize(
    ("changes", "levels", "message"),
    [({}, 2, "3 or more are needed"), ({"analysis__sub_intervals": 25}, 3, "25 sub-intervals cannot be halved")],
)
def test_refinements_that_show_nothing_are_refused(changes, levels, message):
    scene = seed_four_bar(effects=(), **{"analysis__sub_intervals": 24, "analysis__allow_coarse": True} | changes)
    with pytest.raises(SceneError, match=message):
        refine(scene, levels)


def test_command_writes_and_prints(tmp_path):
    text = (DEMOS / "four_bar.toml").read_text().replace('"periodic"', '"quasi-static"')
    file = tmp_path / "scene.toml"
    file.write_text(text.replace("sub_intervals = 360", "sub_intervals = 24").replace('"auto" ', "[] "))
    done = CliRunner().invoke(app, ["refine", str(file), "-o", str(tmp_path / "out")], env={"COLUMNS": "80"})
    assert done.exit_code == 0, done.output
    assert "frequency mode 1 (Hz)" in done.output
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"refine.nc", "refine.csv", "refine_elements.png"}
    found = Refinement.load(tmp_path / "out" / "refine.nc").data
    assert found["unit"].sel(quantity="stress crank").item() == "Pa"
    lines = (tmp_path / "out" / "refine.csv").read_text().splitlines()
    assert lines[0].startswith("refinement,quantity,level 1,level 2,level 3,order")
