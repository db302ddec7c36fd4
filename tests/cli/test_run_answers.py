"""What `fenics-mech run` prints: units that are asked for, JSON, and nothing at all."""

import contextlib
import json
import re
import sys

import numpy as np
import pytest

from fenics_mech import Result, SceneError, cli, load
from fenics_mech._console import _Bar
from fenics_mech.recovery.peaks import peak_of
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views.summary import summary
from tests.common import DEMOS, analysed

PSI, POUND, INCH = 6894.757293168361, 4.4482216152605, 0.0254
DIGITS = 2e-3  # of three or four digits that are printed


@pytest.fixture
def call(monkeypatch, capsys, tmp_path):
    """Run a scene of few positions and give exit code, stdout and stderr."""
    scene = tmp_path / "scene.toml"
    text = (DEMOS / "four_bar.toml").read_text().replace('"periodic"', '"quasi-static"')
    scene.write_text(
        text.replace("sub_intervals = 360", "sub_intervals = 24").replace('effects = "auto" ', "effects = [] ")
    )

    def run(*arguments):
        words = ["fenics-mech", "run", str(scene), "--no-plots", "-o", str(tmp_path / "out"), *arguments]
        monkeypatch.setattr(sys, "argv", words)
        try:
            cli.main()
            code = 0
        except SystemExit as end:
            code = end.code
        return code or 0, *capsys.readouterr()

    return run


def largest_of(result, name):
    """Largest value of a variable on each of its owners, between the positions too."""
    return np.abs(peak_of(result, name)[2])


def row(text, name):
    return next(line.split() for line in text.splitlines() if line.split()[:1] == [name])


def test_units_that_are_asked_for_are_those_of_all_numbers(call, tmp_path):
    code, usual, _ = call("--details")
    assert code == 0
    code, found, _ = call("--details", "--units", "in, psi, lbf, lbf in, rpm")
    assert code == 0
    for column, factor in ((2, 1e6 / PSI), (6, 1e-3 / INCH)):
        one, other = (float(row(text, "coupler")[column]) for text in (usual, found))
        assert other == pytest.approx(factor * one, rel=DIGITS)
    assert float(row(found, "A")[1]) == pytest.approx(float(row(usual, "A")[1]) / POUND, rel=DIGITS)
    assert row(found, "A")[2] == "lbf"
    assert "at 308.4 rpm;" in found
    short = call("--units", "in, psi, lbf, lbf in, rpm")[1]
    assert "drive O at 308 rpm, one turn" in short
    assert "force, lbf" in short
    peak = float(re.search(r"Peak stress (\S+) psi", short)[1])
    shaking = next(line for line in found.splitlines() if "shaking moment" in line)
    result = Result.load(tmp_path / "out" / "result.nc")
    assert "lbf in" in shaking
    assert peak == pytest.approx(largest_of(result, "stress").max() / PSI, rel=DIGITS)
    assert re.search(r"shaking force \S+ lbf at \S+, \S+ lbf in at", " ".join(short.split()))
    largest = largest_of(result, "shaking_moment").max() / (POUND * INCH)
    assert abs(float(shaking.split()[2])) == pytest.approx(largest, rel=DIGITS)


def test_units_of_the_scene_hold_unless_others_are_asked_for():
    result = analysed(seed_four_bar(units=("in", "%"), analysis={"method": "quasi-static", "sub_intervals": 24}))
    text = str(summary(result))
    assert re.search(r"MPa +% .* in ", text)
    assert re.search(r"MPa +\N{MICRO SIGN}m/m .* mm ", str(summary(result, units=AnswerUnits())))


@pytest.mark.parametrize("name", ["kg", "5 mm", "", "x" * 500, "parsec*"])
def test_what_is_no_unit_of_an_answer_is_named(name):
    with pytest.raises(SceneError, match=r"units: .* is not the unit of a printed answer"):
        seed_four_bar(units=(name,))
    with pytest.raises(SceneError, match="too many"):
        seed_four_bar(units=("mm",) * 21)


def test_json_is_what_the_result_holds(call, tmp_path):
    code, text, _ = call("--json")
    assert code == 0
    found, result = json.loads(text), Result.load(tmp_path / "out" / "result.nc")
    data = result.data
    assert found["files"] == [str(tmp_path / "out" / name) for name in ("result.nc", "warnings.txt", "report.html")]
    swing = found["members"]["coupler"]["stress_range"]
    assert swing["value"] == pytest.approx(float(data["stress_range"].sel(member="coupler").max()))
    place = {"s": swing["s"], "fibre": swing["fibre"]}
    assert float(data["stress_range"].sel(member="coupler", **place)) == pytest.approx(swing["value"])
    peak = found["members"]["coupler"]["strain"]
    members, joints = list(data["member"].to_numpy()), list(data["joint"].to_numpy())
    assert abs(peak["value"]) == pytest.approx(largest_of(result, "strain")[members.index("coupler")])
    assert found["joints"]["A"]["value"] == pytest.approx(largest_of(result, "joint_force")[joints.index("A")])
    assert found["mobility"] == 1
    assert found["verdict"]["level"] in ("good", "note", "warn", "bad")


def test_quiet_run_prints_nothing(call, tmp_path, monkeypatch):
    monkeypatch.setattr("fenics_mech._console.PAUSE", 0.0)  # between lines of progress
    assert "writing result.nc" in call()[2]
    assert call("--quiet") == (0, "", "")
    assert load(DEMOS / "four_bar.toml").name == Result.load(tmp_path / "out" / "result.nc").scene.name
    code, out, err = call("--json", "--quiet")
    assert (code, out) == (1, "")
    assert "leave --quiet, --units and --details out" in err


def test_a_motion_in_time_says_how_far_it_has_come(monkeypatch, capsys, tmp_path):
    """Where there is no terminal by lines, and on one by the bar, which moves inside of the step "response"."""
    for name in ("PAUSE", "OFTEN"):
        monkeypatch.setattr(f"fenics_mech._console.{name}", 1e-9)
    places, inside = [], _Bar.inside

    def watched(self, share):
        inside(self, share)
        places.append(self.progress.tasks[0].completed)

    monkeypatch.setattr(_Bar, "inside", watched)
    pendulum = str(DEMOS / "free_motion" / "pendulum.toml")
    monkeypatch.setattr(sys, "argv", ["fenics-mech", "run", pendulum, "--no-plots", "--no-report", "-o", str(tmp_path)])
    with contextlib.suppress(SystemExit):
        cli.main()
    told = [int(line.split()[1]) for line in capsys.readouterr().err.splitlines() if re.match(r"response \d+ %", line)]
    assert told == sorted(told)
    assert len(told) > 20
    response = places[: places.index(2.0) + 1]  # "effects" is one step, "response" the next
    assert response[0] == pytest.approx(1.0, abs=0.05)
    assert (np.diff(response) > 0).all()
