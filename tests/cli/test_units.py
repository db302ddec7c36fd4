"""`--units` of the commands that tell numbers: each tells them in the units that are named."""

import json

import pytest
from typer.testing import CliRunner

from fenics_mech.cli import app
from fenics_mech.scene import load
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.writing import write_scene
from fenics_mech.studies.sweep import Sweep

NAMED = ("--units", "in, psi, lbf, %")


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    path = tmp_path_factory.mktemp("units") / "scene.toml"
    wearing = {"materials.material.fatigue": {"range": "40 MPa", "slope": 5}}
    few = {"method": "quasi-static", "sub_intervals": 24}
    return write_scene(seed_four_bar(analysis=few, effects=[]).changed(wearing), path)


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["sweep", "--over", "drive.speed=100 rpm:200 rpm:2"], ["strain (%)"]),
        (["refine"], ["strain crank (%)", "stress crank (psi)"]),
        (["fatigue"], ["(psi) (psi)"]),
        (["compare"], ["strain (%) crank", "deflection (in) crank", "joint force (lbf) O"]),
    ],
)
def test_commands_tell_numbers_in_the_units_that_are_asked_for(scene, tmp_path, words, told):
    found = CliRunner().invoke(app, [words[0], str(scene), *words[1:], *NAMED, "-o", str(tmp_path / "out")])
    assert found.exit_code == 0, found.output
    text = " ".join(found.output.split())
    for label in told:
        assert label in text
    refused = CliRunner().invoke(
        app, [words[0], str(scene), *words[1:], "--units", "apples", "-o", str(tmp_path / "no")]
    )
    assert "--units: 'apples' is not the unit of a printed answer" in str(refused.exception)
    assert not (tmp_path / "no").exists()


def test_the_units_of_a_command_do_not_make_another_sweep(scene, tmp_path):
    """The folder keeps the sweep in the units of its scene: it goes on whatever the units."""
    words = ["sweep", str(scene), "--over", "drive.speed=100 rpm:200 rpm:2", "-o", str(tmp_path)]
    for more in ((), NAMED, ("--units", "mm")):
        assert CliRunner().invoke(app, [*words, *more]).exit_code == 0
    assert json.loads(Sweep.load(tmp_path / "sweep.nc").data.attrs["scene"])["units"] == list(load(scene).units)
