"""What runs without `resource`, `fcntl`, `O_NONBLOCK`, alarms and `/proc`: Windows and macOS, simulated."""

import json
import subprocess
import sys

import pytest

from fenics_mech import analyse, load
from fenics_mech._constants import INTERRUPTED
from tests.common import DEMOS, ROOT

WITHOUT = """
import asyncio, os, signal, sys, types  # Python itself may ask a POSIX system for what is taken away
for name in ("fcntl", "resource", *sys.argv.pop(1).split()):
    sys.modules[name] = None
for name in ("O_NONBLOCK", "sysconf"):
    delattr(os, name)
for name in ("SIGALRM", "SIGPIPE", "ITIMER_REAL", "alarm", "setitimer"):
    delattr(signal, name)
total = types.SimpleNamespace(total=8_000_000_000)
sys.modules["psutil"] = types.SimpleNamespace(virtual_memory=lambda: total)
import fenics_mech._guard
from fenics_mech._system import fcntl, resource
assert fcntl is resource is None and fenics_mech._guard.memory() <= total.total
from fenics_mech.__main__ import main
main()
"""


DROPPED = """
import signal, sys, time
del signal.SIGALRM, signal.setitimer
from fenics_mech.__main__ import _Interrupt
interrupt = _Interrupt()
class Library:
    def __del__(self):
        raise KeyboardInterrupt
try:
    Library()
    for _ in range(1000):  # what is not a true signal ends no sleep
        time.sleep(0.01)
except KeyboardInterrupt:
    interrupt.end()
"""


@pytest.fixture
def run(tmp_path):
    def command(*arguments, lacks="mpi4py petsc4py slepc4py dolfinx ufl", code=0):
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT, lacks, *map(str, arguments)],
            capture_output=True, text=True, timeout=120, cwd=ROOT, check=False,
        )  # fmt: skip
        assert done.returncode == code, done.stderr
        return done.stderr if code else done.stdout

    return command


def test_schema_and_check_need_no_posix_nor_solver(run):
    assert json.loads(run("schema"))["title"] == "Scene"
    assert "coupler" in run("check", DEMOS / "four_bar.toml")


@pytest.mark.slow
def test_results_are_reported_drawn_and_compared_without_a_solver(run, tmp_path):
    scene = load(DEMOS / "four_bar.toml").changed({"effects": (), "analysis.method": "quasi-static"})
    file = analyse(scene).save(tmp_path / "result.nc")
    run("report", file, "-o", tmp_path / "report.html")
    assert "four-bar" in (tmp_path / "report.html").read_text()
    run("plot", file, "-o", tmp_path / "plots")
    run("animate", file, "-o", tmp_path / "peak.png")
    run("export", file, tmp_path / "stress.csv")
    assert "strain (µm/m)" in run("compare", file, file, "-o", tmp_path)
    assert {"plots", "peak.png", "stress.csv", "compare.csv"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.parametrize("lacks", ["dolfinx", "ufl", "petsc4py", "mpi4py"])
def test_one_library_that_is_not_there_is_told_with_what_to_install(run, tmp_path, lacks):
    said = run("run", DEMOS / "four_bar.toml", "-o", tmp_path / "out", lacks=lacks, code=1)
    assert said.splitlines()[-1].startswith("error: PETSc, SLEPc and dolfinx cannot be loaded: ")
    assert "Traceback" not in said
    assert not (tmp_path / "out").exists()


def test_an_interrupt_that_a_library_drops_ends_the_command_without_alarms_too():
    done = subprocess.run(
        [sys.executable, "-c", DROPPED], capture_output=True, text=True, timeout=15, check=False, cwd=ROOT
    )
    assert done.returncode == INTERRUPTED
    assert done.stderr.splitlines()[-1] == "interrupted"
