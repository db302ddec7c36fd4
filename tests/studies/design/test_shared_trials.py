"""Trials that processes share: the same numbers with any number of them, and one that is lost costs its trial."""

import csv
import os
import signal
import subprocess
import time

import pytest

import fenics_mech as fm
from fenics_mech.scene.writing import write_scene
from tests.studies.processes import ENVIRONMENT, MPIRUN, command, finished
from tests.studies.test_worker_processes import workers_of

QUICK = {"analysis.method": "quasi-static", "analysis.sub_intervals": 36, "effects": ()}
with_mpirun = pytest.mark.skipif(MPIRUN is None, reason="no mpirun")


def scene_file(folder, changes=QUICK, **study):
    """Write the four-bar with two variables, of which one may leave it without an assembly, and some scatter."""
    ground = {"numbers": ["ground.points.C.0"], "between": ["9 in", "20 in"]}  # 17.4 in is the longest that turns
    speed = {"numbers": ["drive.speed"], "between": ["100 rpm", "500 rpm"]}
    study = {"variables": {"ground": ground, "speed": speed}, "scatter": {"ground": ground}} | study
    return write_scene(fm.load("demos/four_bar.toml").changed(changes).changed(study=study), folder / "scene.toml")


def table(path):
    """Rows of a table without what depends on the machine."""
    return [{k: v for k, v in row.items() if k != "seconds"} for row in csv.DictReader(path.read_text().splitlines())]


@pytest.mark.long
@pytest.mark.slow
@with_mpirun
@pytest.mark.parametrize(
    ("words", "name", "ranks"),
    [
        (("optimise", "--method", "differential-evolution", "--steps", "2", "--population", "6"), "history.csv", 3),
        (("optimise", "--method", "trust-constr", "--steps", "3"), "history.csv", 2),  # differences
        (("spread", "--samples", "8"), "samples.csv", 3),
    ],
)
def test_processes_of_mpirun_find_what_one_finds(words, name, ranks, tmp_path):
    file = scene_file(tmp_path, minimise=["strain.max"], limits=[{"of": "torque.rms", "least": 0.2}])
    run = ["-m", "fenics_mech", words[0], file, *words[1:], "-o"]
    for count in (0, ranks):
        ended = finished(*run, tmp_path / str(count), ranks=count)
        assert ended.returncode == 0, ended.stderr
        assert ended.stdout.count("Wrote") == 1
    alone, shared = (table(tmp_path / str(count) / name) for count in (0, ranks))
    assert len(alone) >= 8
    assert shared == alone


@pytest.mark.long
@pytest.mark.slow
@with_mpirun
def test_all_processes_get_the_result_and_the_first_one_writes(tmp_path):
    file = scene_file(tmp_path, minimise=["strain.max"])
    script = f"""
from pathlib import Path
import fenics_mech as fm
from fenics_mech._petsc import MPI
few = fm.Search(generations=1, population=4)
found = fm.optimise(fm.load({str(file)!r}), method="differential-evolution", search=few)
ran = sum(trial.seconds for trial in found.history)
said = found.best.values, len(found.history), len(set(MPI.COMM_WORLD.allgather(ran)))
Path({str(tmp_path)!r}, f"said{{MPI.COMM_WORLD.rank}}").write_text(str(said))
"""
    (tmp_path / "script.py").write_text(script)
    ended = finished(tmp_path / "script.py", ranks=3)
    assert ended.returncode == 0, ended.stderr
    said = [path.read_text() for path in tmp_path.glob("said*")]
    assert len(said) == 3
    assert len(set(said)) == 1
    assert said[0].endswith(", 1)")  # no trial was run twice


@pytest.mark.slow
@with_mpirun
@pytest.mark.parametrize(
    ("changes", "options", "said"),
    [
        ({"ground.points.C.0": "19 in"}, (), "the scene that the study starts from fails"),
        ({}, ("--jobs", "2"), "leave --jobs out, or mpirun"),
        ({"study.minimise": ["strian.max"]}, (), "Did you mean strain"),
    ],
)
def test_an_error_ends_all_processes_with_one_message(changes, options, said, tmp_path):
    file = scene_file(tmp_path, QUICK | {k: v for k, v in changes.items() if "study" not in k}, minimise=["strain.max"])
    if "study.minimise" in changes:
        file.write_text(file.read_text().replace("strain.max", "strian.max"))
    ended = finished("-m", "fenics_mech", "optimise", file, *options, "-o", tmp_path / "out", ranks=2)
    assert ended.returncode == 1
    assert ended.stderr.count("error:") == 1
    assert said in " ".join(ended.stderr.split())
    assert "Traceback" not in ended.stderr


@pytest.mark.long
@pytest.mark.slow
def test_a_killed_worker_costs_its_sample_and_the_next_run_computes_it(tmp_path):
    slow = {"effects": ("coupling", "large-rotations"), "analysis.sub_intervals": 90}
    speed = {"numbers": ["drive.speed"], "tolerance": "2 %"}
    file = scene_file(tmp_path, slow, scatter={"speed": speed}, results=["strain.max"])
    run = ("-m", "fenics_mech", "spread", file, "--samples", "8", "-o", tmp_path / "out", "--jobs", "2")
    with subprocess.Popen(command(*run), env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as process:
        limit, workers = time.monotonic() + 60, []
        while not workers and time.monotonic() < limit:
            workers = workers_of(process.pid)
        os.kill(workers[0], signal.SIGKILL)
        said, _ = process.communicate(timeout=120)
    assert process.returncode == 0
    errors = [row["error"] for row in table(tmp_path / "out" / "samples.csv")]
    assert sorted(errors) == [""] * 7 + ["LostProcess"]
    assert "LostProcess" in said
    assert finished(*run).returncode == 0
    again = table(tmp_path / "out" / "samples.csv")
    assert not [row["error"] for row in again if row["error"]]
    assert finished(*run[:-4], "-o", tmp_path / "alone").returncode == 0
    assert table(tmp_path / "alone" / "samples.csv") == again
