"""What runs without `resource`, `fcntl` and `O_NONBLOCK`, as on Windows, which is simulated."""

import json
import subprocess
import sys

import pytest

from fenics_mech import analyse, load
from tests.common import DEMOS, ROOT

WITHOUT = """
import os, sys, types
for name in ("fcntl", "resource", *sys.argv.pop(1).split()):
    sys.modules[name] = None
for name in ("O_NONBLOCK", "sysconf"):
    delattr(os, name)
total = types.SimpleNamespace(total=8_000_000_000)
sys.modules["psutil"] = types.SimpleNamespace(virtual_memory=lambda: total)
import fenics_mech._guard
from fenics_mech._system import fcntl, resource
assert fcntl is resource is None and fenics_mech._guard.memory() <= total.total
from fenics_mech.__main__ import main
main()
"""


@pytest.fixture
def run(tmp_path):
    def command(*arguments, lacks="mpi4py petsc4py slepc4py dolfinx"):
        done = subprocess.run(
            [sys.executable, "-c", WITHOUT, lacks, *map(str, arguments)],
            capture_output=True, text=True, timeout=120, cwd=ROOT, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stderr
        return done.stdout

    return command


def test_schema_and_check_need_no_posix_nor_solver(run):
    assert json.loads(run("schema"))["title"] == "Scene"
    assert "coupler" in run("check", DEMOS / "four_bar.toml")


def test_the_report_of_a_result_needs_no_posix(run, tmp_path):
    scene = load(DEMOS / "four_bar.toml").changed({"effects": (), "analysis.method": "quasi-static"})
    analyse(scene).save(tmp_path / "result.nc")
    run("report", tmp_path / "result.nc", "-o", tmp_path / "report.html", lacks="")
    assert "four-bar" in (tmp_path / "report.html").read_text()
