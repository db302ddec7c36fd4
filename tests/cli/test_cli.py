"""The command as a user meets it: files, summaries, and one-message errors."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from fenics_mech import Result, analyse, cli
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS

DEMO = str(DEMOS / "four_bar.toml")


def command(*arguments, folder=None, **environment):
    """Run `fenics-mech` in a process of its own."""
    return subprocess.run(
        [sys.executable, "-m", "fenics_mech", *map(str, arguments)],
        capture_output=True,
        text=True,
        cwd=folder,
        env=os.environ | {"COLUMNS": "100"} | environment,
        timeout=120,
        check=False,
    )


@pytest.fixture
def call(monkeypatch, capsys):
    """Run `fenics-mech` in this process; gives exit code, stdout and stderr."""

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["fenics-mech", *map(str, arguments)])
        try:
            cli.main()
            code = 0
        except SystemExit as end:
            code = end.code
        printed = capsys.readouterr()
        return code or 0, printed.out, printed.err

    return run


@pytest.mark.slow
def test_run_writes_result_plots_and_summary(call, tmp_path):
    code, out, _ = call("run", DEMO, "-o", tmp_path / "out", "--csv")
    assert code == 0
    files = {path.name for path in (tmp_path / "out").iterdir()}
    assert {"result.nc", "report.html", "strain.png", "strain_map.png", "frequencies.png"} <= files
    assert {"strain.csv", "joint_force.csv"} <= files
    assert not [name for name in files if name.startswith(".")]
    result = Result.load(tmp_path / "out" / "result.nc")
    peak = float(np.abs(result.data["strain"].sel(member="coupler")).max()) * 1e6
    assert peak == pytest.approx(271.8, rel=0.01)  # 268.3 of exact beams, with other damping
    told = re.search(
        r"^coupler +19\.3 +(\d+) ", out, re.MULTILINE
    )  # where the stress is largest, to which damping adds
    assert told is not None
    assert float(told[1]) == pytest.approx(peak, abs=1)
    assert len(out.splitlines()) <= 32
    assert re.search(r"Wrote result\.nc, warnings\.txt, report\.html, \d+ tables and 9 plots to ", out)
    page = (tmp_path / "out" / "report.html").read_text()
    accurate = next(line for line in out.splitlines() if line.startswith("The computation is accurate"))
    assert accurate in page


def test_a_saved_result_is_drawn_and_reported(call, tmp_path):
    result = analyse(seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24}))
    file, page = result.save(tmp_path / "result.nc"), tmp_path / "new" / "page.html"
    code, out, _ = call("report", file, "-o", page)
    assert (code, out) == (0, f"Wrote {page}\n")
    assert page.read_text().startswith("<!doctype html>")
    code, out, _ = call(
        "plot", file, "-o", tmp_path / "plots", "--only", "strain", "--only", "deflection", "--as", "svg"
    )
    assert code == 0
    assert {path.name for path in (tmp_path / "plots").iterdir()} == {"strain.svg", "deflection.svg"}
    for arguments, said in (
        (("plot", file, "--only", "strains"), "there is no plot 'strains'"),
        (("plot", file, "--as", "bmp"), r"must end in one of .png, .pdf, .svg"),
        (("report", file, "-o", tmp_path / "page.pdf"), "must end in .html"),
        (("report", tmp_path / "none.nc"), "No such file"),
    ):
        code, _, err = call(*arguments)
        assert code == 1
        assert said in " ".join(err.split())


def test_details_and_no_report(call, tmp_path):
    scene = tmp_path / "scene.toml"
    text = Path(DEMO).read_text().replace('effects = "auto"', "effects = []")
    scene.write_text(
        text.replace('"periodic"', '"quasi-static"').replace(
            "sub_intervals = 360", "sub_intervals = 12\nallow_coarse = true"
        )
    )
    code, out, _ = call("run", scene, "-o", tmp_path, "--details", "--no-plots", "--no-report")
    assert code == 0
    assert "Peaks of the joint forces" in out
    assert {path.name for path in tmp_path.iterdir()} == {"scene.toml", "result.nc", "warnings.txt"}


def test_modes_prints_and_writes_frequencies(call, tmp_path):
    code, out, _ = call("modes", DEMO, "-o", tmp_path, "--draw", tmp_path / "shapes.png", "--angle", 90)
    assert (tmp_path / "shapes.png").stat().st_size > 10_000
    assert code == 0
    assert "47.56" in out  # the coupler as a simply supported beam (7.6)
    table = np.genfromtxt(tmp_path / "frequencies.csv", delimiter=",", names=True)
    assert min(table[table.dtype.names[-5]]) == pytest.approx(42.03, abs=0.01)


def test_check_of_a_scene_does_not_solve_it(call, tmp_path):
    code, out, _ = call("check", DEMO)
    assert code == 0
    assert "follower" in out


def test_mesh_writes_three_files(call, tmp_path):
    code, out, _ = call("mesh", DEMO, "-o", tmp_path)
    assert code == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mesh.msh", "mesh.vtu", "mesh.xdmf"]
    assert "9 elements" in out


def test_schema_is_json(call):
    code, out, _ = call("schema")
    assert code == 0
    assert "links" in json.loads(out)["properties"]


def test_bad_scene_is_one_line_and_no_traceback(call, tmp_path, demo_text):
    (tmp_path / "bad.toml").write_text(demo_text.replace('"71 GPa"', '"71 kg"'))
    code, out, err = call("run", tmp_path / "bad.toml", "-o", tmp_path / "out")
    assert code == 1
    assert out == ""
    assert err.startswith("error: bad.toml: materials.aluminium.modulus (line 6)")
    assert err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_folder_that_cannot_be_made_is_named(call, tmp_path):
    (tmp_path / "file").write_text("")
    code, _, err = call("run", DEMO, "-o", tmp_path / "file" / "out")
    assert code == 1
    assert "cannot make the folder" in err


def test_unknown_ending_is_refused_before_any_work(call, tmp_path):
    code, _, err = call("animate", DEMO, "-o", tmp_path / "motion.avi")
    assert code == 1
    assert ".mp4" in err


@pytest.mark.slow
def test_animate_takes_a_saved_result(call, tmp_path):
    saved = seed_four_bar(analysis={"sub_intervals": 24, "method": "quasi-static"})
    analyse(saved).save(tmp_path / "result.nc")
    code, _, _ = call("animate", tmp_path / "result.nc", "-o", tmp_path / "peak.png")
    assert code == 0
    assert (tmp_path / "peak.png").stat().st_size > 10_000


def test_check_draws_the_model_and_refuses_other_endings(call, tmp_path):
    file = tmp_path / "new" / "model.png"
    code, out, _ = call("check", DEMO, "--draw", file)
    assert code == 0
    assert file.stat().st_size > 10_000
    assert "model.png" in out
    code, _, said = call("check", DEMO, "--draw", tmp_path / "model.bmp")
    assert code
    assert ".png, .pdf, .svg" in said


@pytest.mark.parametrize("name", ["run", "modes", "check", "animate", "mesh", "schema"])
def test_every_command_has_help(call, name):
    code, out, _ = call(name, "--help")
    assert code == 0
    assert "Usage" in out


def test_module_runs_and_help_is_quick_to_import():
    done = command("--help")
    assert done.returncode == 0
    imported = subprocess.run(
        [sys.executable, "-c", "import fenics_mech.cli, sys; print('dolfinx' in sys.modules)"],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert imported.stdout.strip() == "False"


def test_error_exit_code_in_a_real_process(tmp_path):
    done = command("run", tmp_path / "missing.toml")
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert "missing.toml" in done.stderr


def test_refine_cuts_every_element(call, tmp_path):
    code, out, _ = call("mesh", DEMO, "-o", tmp_path, "--refine", 2)
    assert code == 0
    assert "36 elements" in out


def test_a_result_cannot_be_refined(call, tmp_path):
    code, _, err = call("animate", tmp_path / "result.nc", "-o", tmp_path / "peak.png", "--refine", 1)
    assert code == 1
    assert "cannot be refined" in err


def test_a_drawn_scene_is_run_from_another_folder(tmp_path):
    drawn = DEMOS.parent / "meshes" / "four_bar.toml"
    done = command("modes", drawn, "-o", tmp_path, folder=tmp_path)
    assert done.returncode == 0, done.stderr
    table = np.genfromtxt(tmp_path / "frequencies.csv", delimiter=",", names=True)
    assert min(table[table.dtype.names[-5]]) == pytest.approx(42.03, abs=0.01)


def test_refine_beside_a_tolerance_is_refused(call, tmp_path):
    code, _, err = call("run", DEMO, "--tol", "1e-2", "--refine", "1", "-o", tmp_path)
    assert code == 1
    assert "--refine states the mesh, which the tolerance of 0.01 selects" in err


@pytest.fixture
def slow(tmp_path):
    """A demo without vibration, whose effects are chosen by their estimates."""
    text = (DEMOS / "manipulator.toml").read_text(encoding="utf-8")
    path = tmp_path / "slow.toml"
    path.write_text(text.replace('method = "periodic"', 'method = "quasi-static"'), encoding="utf-8")
    return path


def test_effects_of_a_tolerance(call, slow):
    for text in ("1e-4", "0.01%"):
        code, out, _ = call("effects", slow, "--tol", text)
        assert code == 0
        assert "effects = 'auto' selects effects" in out
    code, _, err = call("effects", DEMO, "--tol", "tight")
    assert code == 1
    assert "tolerance: cannot read 'tight'" in err


def test_effects_leaves_nothing_to_the_run(call):
    _, out, _ = call("effects", DEMO)  # which has exact strains, and states "auto"
    assert 'selects effects = ["coupling", "large-rotations"' in out


@pytest.mark.parametrize("words", ["", "Unable to allocate 313. MiB"])
def test_no_memory_is_told_with_what_to_do(call, monkeypatch, words):
    def full():
        raise MemoryError(words)

    monkeypatch.setattr(cli, "app", full)
    code, _, message = call("run", DEMO)
    assert code == 1
    assert message.startswith("error: not enough memory: take fewer sub_intervals")
    assert message.rstrip().endswith(words)


def test_a_sweep_without_an_answer_fails_and_tells_why(call, tmp_path):
    code, out, err = call("sweep", DEMO, "--over", "links.coupler.points.B.0=0.01:0.02:2", "-o", tmp_path / "out")
    assert code == 1
    assert "2 of 2 points failed" in out
    assert err == "error: every point of the sweep failed; the lines above and sweep.nc say why\n"
    assert (tmp_path / "out" / "sweep.nc").exists()


def test_warnings_are_told_and_strict_makes_them_errors(call, tmp_path):
    text = (DEMOS / "four_bar.toml").read_text()
    wrong, weak = tmp_path / "wrong.toml", tmp_path / "weak.toml"
    wrong.write_text(text.replace('"2714 kg/m^3"', "2.714"))
    code, out, said = call("check", wrong)
    assert code == 0
    assert "The drive turns through the whole cycle" in out
    assert "warning: materials.aluminium.density: 2.714 kg/m^3" in said
    for name in ("check", "run"):
        code, out, said = call(name, wrong, "--strict", *(() if name == "check" else ("-o", tmp_path / "out")))
        assert (code, out) == (1, "")
        assert "error: warnings are errors with --strict" in said
    assert not (tmp_path / "out").exists()
    code, out, said = call("check", DEMO, "--strict")
    assert (code, said) == (0, "")
    text = text.replace('method = "periodic"', 'method = "quasi-static"')
    weak.write_text(text.replace('"2714 kg/m^3"', '"2714 kg/m^3"\nstrength = "15 MPa"'))
    code, out, said = call("run", weak, "--strict", "--no-plots", "-o", tmp_path / "weak")
    assert "error: warnings are errors with --strict" in said
    assert code == 1
    result = Result.load(tmp_path / "weak" / "result.nc")
    stress = result.data["stress"]
    members = [str(m) for m in stress["member"].to_numpy() if abs(stress.sel(member=m)).max() > 15e6]
    assert [warning.split(" reaches ")[0].split()[-1] for warning in result.warnings] == members
    assert "follower" in members
    largest = float(abs(stress.sel(member="follower")).max()) / 1e6
    assert f"{largest:.4g} MPa at s = " in result.warnings[-1]
    assert "Warning: materials.aluminium.strength" in out


def test_a_reader_that_has_enough_ends_no_process():
    """PETSc takes the signal of a broken pipe for a fault, and tells it with a trace."""
    script = "from fenics_mech._console import start_libraries as start; import os, signal; start(); "
    script += "os.kill(os.getpid(), signal.SIGPIPE); print('goes on')"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "goes on\n", "")
