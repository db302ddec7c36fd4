"""`--units` of the commands that tell numbers: each tells them in the units that are named."""

import csv
import json
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from fenics_mech.cli import app
from fenics_mech.cli.common import unit_names
from fenics_mech.errors import SceneError
from fenics_mech.recovery import Result
from fenics_mech.scene import load
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.writing import write_scene
from fenics_mech.studies.sweep import Sweep
from tests.common import DEMOS

NAMED = ("--units", "in, psi, lbf, %, rpm")


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
        (["refine"], ["strain crank", "(%)", "stress crank", "(psi)"]),  # a unit may stand below
        (["fatigue"], ["(psi) (psi)"]),
        (["modes"], ["lowest highest lowest highest", "(Hz) (Hz) (rpm) (rpm)"]),
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


MASSES = """
[sections.flat]
shape = "rectangle"
width = "25.4 mm"  # to be found
height = "1.6 mm"
[study]
minimise = ["mass[coupler]"]
limits = [{ of = "mass[coupler]", least = "20 g" }]
[study.variables]
width = { numbers = ["sections.flat.width"], between = ["12 mm", "30 mm"] }
[study.scatter]
width = { numbers = ["sections.flat.width"], tolerance = "0.5 mm" }
"""  # looks at masses alone, so that no trial is analysed


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    path = tmp_path_factory.mktemp("study") / "scene.toml"
    seed = (
        (DEMOS / "four_bar.toml")
        .read_text()
        .replace(
            'section = "strip", material = "aluminium" }\nangle = "70',
            ('section = "flat", material = "aluminium" }\nangle = "70'),
        )
    )
    path.write_text(seed.replace('"periodic"', '"quasi-static"').replace("360", "24") + MASSES)
    (path.parent / "mass.csv").write_text("number,value,deviation\nmass[coupler],0.025,0.0005\n")
    return path


@pytest.mark.parametrize(
    ("words", "told", "in_inches"),
    [
        (["optimise"], ["width 25.4 16.484 12 to 30 mm", "30.817 20 least 20 g"], ["1 0.64899 0.47244 to 1.1811 in"]),
        (["identify", "mass.csv"], ["width 25.4 20.606 0.41", "0.5 g", "mm"], ["1 0.81124 0.016", "in"]),
        (["spread", "-n", "8"], ["keep all limits", "30.82", " g "], ["keep all limits", "30.82", " g "]),
    ],
)
def test_studies_tell_numbers_in_the_units_in_which_they_are_written(
    study, tmp_path, monkeypatch, words, told, in_inches
):
    monkeypatch.chdir(study.parent)
    for more, expected in (((), told), (("--units", "in, psi"), in_inches)):
        call = [words[0], str(study), *words[1:], "-o", str(tmp_path / "out"), *more]
        found = CliRunner().invoke(app, call)
        assert found.exit_code == 0, found.output
        text = " ".join(found.output.split())
        for label in expected:
            assert label in text
    for name in {"optimise": ["best.toml"], "identify": ["identified.toml"]}.get(words[0], []):
        lines = (tmp_path / "out" / name).read_text()
        assert ' mm"  # to be found' in lines
        assert load(tmp_path / "out" / name).sections["flat"].width != load(study).sections["flat"].width


def test_spread_tells_numbers_limits_and_curves_in_the_units_that_are_asked_for(study, tmp_path):
    looked_at = """
limits = [{ of = "stress[coupler].max", most = "20 MPa" }, { of = "mass", least = "20 g" }]
results = ["shaking_force.rms", "deflection.max", "mass"]
curves = ["deflection[coupler][@0.5][y]"]
[study.scatter]
speed = { numbers = ["drive.speed"], tolerance = "2 %" }
"""
    text = study.read_text()
    path = tmp_path / "spread.toml"
    path.write_text(text[: text.index('minimise = ["mass')] + looked_at)
    call = ["spread", str(path), "-n", "4", "--indices", "-o", str(tmp_path / "out")]
    found = CliRunner().invoke(app, [*call, "--units", "in, psi, lbf, rpm"])
    assert found.exit_code == 0, found.output
    told = [line.split() for line in found.output.splitlines() if line.strip()]
    with open(tmp_path / "out" / "spread.csv") as file:  # in SI, whatever the units
        nominal = {row["number"]: float(row["nominal"]) for row in csv.DictReader(file)}
    expected = {"stress[coupler].max": (6894.757, "psi"), "shaking_force.rms": (4.4482216, "lbf")}
    expected |= {"deflection.max": (0.0254, "in"), "mass": (1e-3, "g")}  # as in its limit
    for name, (one, unit) in expected.items():
        row = next(line for line in told if line[0] == name)
        assert row[-1] == unit
        assert float(row[1]) == pytest.approx(nominal[name] / one, rel=1e-3)
    said = " ".join(found.output.split())
    assert "keep stress[coupler].max at most 2900.8 psi" in said
    assert "nan" not in said  # a mass that does not scatter has no shares


@pytest.mark.parametrize(
    ("command", "wrong"),
    [("optimise", '{ of = "mass[coupler]", least = "20 g"'), ("spread", '"20 g"'), ("identify", 'between = ["12 mm"')],
)
def test_what_is_wrong_in_a_study_is_found_in_its_line_before_any_trial(study, tmp_path, command, wrong):
    text = study.read_text()
    assert text.count(wrong) == 1
    (path := tmp_path / "wrong.toml").write_text(text.replace(wrong, re.sub(r"mm|g\b(?=\")", "A", wrong)))
    data = [str(study.parent / "mass.csv")] * (command == "identify")
    found = CliRunner().invoke(app, [command, str(path), *data, "-o", str(tmp_path / "out")])
    assert isinstance(found.exception, SceneError)
    line = text[: text.index(wrong)].count("\n") + 1
    assert re.match(rf"wrong\.toml: study\.\S+.* \(line {line}\): .*wrong unit", str(found.exception))
    assert not (tmp_path / "out").exists()


def test_the_units_of_a_command_do_not_make_another_sweep(scene, tmp_path):
    """The folder keeps the sweep in the units of its scene: it goes on whatever the units."""
    words = ["sweep", str(scene), "--over", "drive.speed=100 rpm:200 rpm:2", "-o", str(tmp_path)]
    for more in ((), NAMED, ("--units", "mm")):
        assert CliRunner().invoke(app, [*words, *more]).exit_code == 0
    assert json.loads(Sweep.load(tmp_path / "sweep.nc").data.attrs["scene"])["units"] == list(load(scene).units)


def test_tables_are_exported_in_the_units_that_are_asked_for(scene, tmp_path):
    """The rest is in SI: angles, times, and shares whose unit is the 1 of strains."""
    assert CliRunner().invoke(app, ["run", str(scene), "--no-plots", "-o", str(tmp_path)]).exit_code == 0
    result = Result.load(tmp_path / "result.nc")
    names = {"stress_range": "psi", "joint_force": "lbf", "deflection": "in", "strain": "%", "moment": "N m"}
    files = [tmp_path / f"{name}.csv" for name in names]
    call = ["export", str(tmp_path / "result.nc"), *map(str, files), *NAMED]
    assert CliRunner().invoke(app, call).exit_code == 0
    sizes = {"psi": 6894.757, "lbf": 4.4482216, "in": 0.0254, "%": 0.01, "N m": 1.0}
    for (name, unit), file in zip(names.items(), files):
        head, *rows = file.read_text().splitlines()
        assert head.split(",")[-1] == f"{name} ({unit})"
        known = result.data[name].to_dataframe().reset_index()[name].to_numpy()
        found = np.array([float(row.split(",")[-1]) for row in rows])
        assert sizes[unit] * found == pytest.approx(known, rel=1e-6)
        assert ("theta (rad)" in head) == ("theta" in result.data[name].dims)
    refused = CliRunner().invoke(app, [*call[:2], str(tmp_path / "all.mat"), *NAMED])
    assert "all.mat: --units is for tables (.csv, .xlsx)" in str(refused.exception)


@pytest.mark.parametrize(
    ("units", "hint"),
    [("in psi", "Write commas between units: 'in, psi'"), ("lb", "lb is a mass. Write 'lbf' for forces")],
)
def test_units_that_are_meant_otherwise_get_a_hint(units, hint):
    with pytest.raises(SceneError, match="is not the unit of a printed answer") as caught:
        unit_names(units)
    assert hint in str(caught.value)


@pytest.mark.parametrize("command", ["report", "plot", "sound"])
def test_a_scene_in_place_of_a_result_is_said(scene, command):
    refused = CliRunner().invoke(app, [command, str(scene)])
    assert f"{scene} is a scene, and a result is expected: `fenics-mech run {scene}" in str(refused.exception)
