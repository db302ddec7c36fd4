"""The commands take scenes in space, and say in one line what they do not take of them."""

import json
import shutil
import sys

import pytest
import xarray as xr

import fenics_mech as fm
from fenics_mech import cli
from tests.common import DEMOS


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a coarse scene, and with what `run` writes of it."""
    folder = tmp_path_factory.mktemp("space")
    text = (DEMOS / "space" / "rssr.toml").read_text()
    (folder / "rssr.toml").write_text(f"{text}\n[analysis]\npositions = 12\n[mesh]\nelements = 1\n")
    return folder


@pytest.fixture
def call(monkeypatch, capsys, place):
    """Run a command in the folder and give exit code, stdout and stderr."""

    def run(*words):
        monkeypatch.chdir(place)
        monkeypatch.setattr(sys, "argv", ["fenics-mech", *words])
        code = 0
        try:
            cli.main()
        except SystemExit as end:
            code = end.code or 0
        return code, *capsys.readouterr()

    return run


def test_run_writes_what_it_writes_of_plane_scenes(call, place):
    code, said, _ = call("run", "rssr.toml", "-o", "out", "--csv")
    assert code == 0
    assert "Largest von Mises stress" in said
    names = {path.name for path in (place / "out").iterdir()}
    assert {"result.nc", "warnings.txt", "report.html", "views.png", "stress.png", "von_mises.csv"} <= names
    assert fm.SpatialResult.load(place / "out" / "result.nc").scene.analysis.positions == 12
    for words in (("report", "-o", "r.html"), ("plot", "--only", "views", "-o", "p", "--as", "pdf")):
        assert call(words[0], "out/result.nc", *words[1:], "--units", "in, psi")[0] == 0
    assert "psi" in (place / "r.html").read_text()
    assert [path.name for path in (place / "p").iterdir()] == ["views.pdf"]
    assert call("animate", "out/result.nc", "-o", "m.png")[0] == 0
    for words in (
        ("fatigue", "out/result.nc"),
        ("compare", "out/result.nc", "b.nc"),
    ):
        shutil.copy(place / "out" / "result.nc", place / "b.nc")
        code, _, error = call(*words)
        assert code == 1
        assert "result in space" in error
        assert len(error.splitlines()) == 1


def test_results_are_exported(call, place):
    call("run", "rssr.toml", "-o", "e", "--no-plots", "--no-report", "-q")
    code, said, _ = call("export", "e/result.nc", "e/m.pvd", "e/m.mat", "e/von_mises.csv")
    assert code == 0
    assert said.count("Wrote") == 3
    assert call("export", "e/result.nc", "e/psi/von_mises.csv", "--units", "psi")[0] == 0
    tables = [(place / name / "von_mises.csv").read_text().splitlines() for name in ("e", "e/psi")]
    plain, psi = (float(lines[1].split(",")[-1]) for lines in tables)
    assert plain == pytest.approx(6894.757 * psi, rel=1e-6)
    for words in (("e/m.xlsx",), ("e/m.dxf",), ("--matrices", "e/k.mat"), ("e/no_such.csv",)):
        code, _, error = call("export", "e/result.nc", *words)
        assert code == 1
        assert len(error.splitlines()) == 1


def test_run_prints_json_or_nothing(call):
    code, said, _ = call("run", "rssr.toml", "-o", "json", "--json", "--no-plots", "--no-report")
    assert code == 0
    found = json.loads(said)
    assert set(found["members"]) == {"crank", "coupler", "rocker"}
    assert len(found["files"]) == 2
    code, said, _ = call("run", "rssr.toml", "-o", "quiet", "-q", "--no-plots", "--no-report", "--strict")
    assert (code, said) == (1, "") if found["warnings"] else (0, "")
    assert "Mobility" in call("check", "rssr.toml")[1]


@pytest.mark.parametrize(
    "words",
    [
        ("run", "--refine", "1"),
        ("run", "--tol", "1e-3"),
        ("run", "--jobs", "2"),
        ("check", "--update"),
        ("modes", "--draw", "shapes.png"),
        ("animate", "--true-width", "-o", "m.png"),
    ],
)
def test_options_that_do_not_apply_are_refused_in_one_line(call, words):
    code, said, error = call(words[0], "rssr.toml", *words[1:])
    assert (code, said) == (1, "")
    assert error.startswith(f"error: {words[1]} cannot be used here, as the scene is in space")
    assert len(error.splitlines()) == 1


@pytest.mark.parametrize(
    "words",
    [
        ("follow", "--over", "drive.speed=1:2"),
        ("identify", "record.csv"),
        ("export", "motion.dxf"),
        ("run@idle",),
        *((name,) for name in ("optimise", "spread", "balance", "compare", "refine", "fatigue", "mesh", "effects")),
    ],
)
def test_commands_for_the_plane_say_so_in_one_line(call, words, place):
    (place / "record.csv").write_text("angle_deg,strain\n0,0\n")
    name, _, case = words[0].partition("@")
    code, said, error = call(name, f"rssr{'@' + case if case else ''}.toml", *words[1:])
    assert (code, said) == (1, "")
    assert "in space" in error
    assert len(error.splitlines()) == 1


def test_check_tells_members_joints_and_draws(call, place):
    code, said, _ = call("check", "rssr.toml", "--draw", "model.svg")
    assert code == 0
    assert "0.385122" in said
    assert "universal" in said
    assert "Mobility 1, without drives" in said
    assert (place / "model.svg").exists()


def test_modes_tell_frequencies_by_position(call, place):
    code, said, _ = call("modes", "rssr.toml", "-o", "modes")
    assert code == 0
    assert {path.name for path in (place / "modes").iterdir()} == {"frequencies.csv", "frequencies.png"}
    assert len((place / "modes" / "frequencies.csv").read_text().splitlines()) == 13
    assert "lowest" in said


def test_schema_has_the_keys_of_space(call):
    space = json.loads(call("schema", "--space")[1])
    assert "SpatialJoint" in space["$defs"]
    assert space["properties"]["gravity"]["description"] == "Acceleration along X, Y and Z (m/s^2)."
    assert "SpatialJoint" not in json.loads(call("schema")[1])["$defs"]


def test_a_sweep_tells_largest_sizes_and_the_lowest_frequency(call, place):
    code, said, _ = call("sweep", "rssr.toml", "--over", "drive.speed=40:60:2", "-o", "sweep")
    assert code == 0
    assert {path.name for path in (place / "sweep").iterdir()} == {"sweep.nc", "sweep.png"}
    found = xr.load_dataset(place / "sweep" / "sweep.nc", engine="h5netcdf")
    rows = [line.split() for line in said.splitlines() if line.startswith(("40", "60"))]
    assert [float(row[1]) for row in rows] == pytest.approx(1e-6 * found["von_mises"].max("member").values, rel=5e-3)
    assert [float(row[5]) for row in rows] == pytest.approx(found["lowest_frequency"].min("mode").values, rel=5e-3)
