"""What the program loads as it starts, and with how many threads; each in a process of its own."""

import os
import subprocess
import sys

import pytest

from fenics_mech._libraries import alone
from fenics_mech.cli import app
from tests.common import DEMOS

HEAVY = "dolfinx gmsh h5py imageio matplotlib meshio mpi4py pandas petsc4py pint pyvista scipy slepc4py ufl vtk xarray"
COMMANDS = [command.name or command.callback.__name__ for command in app.registered_commands]
CALLED = """
import sys
from fenics_mech.cli import app
for arguments in {calls}:
    try:
        app(arguments)
    except SystemExit as end:
        assert not end.code
print(*sys.modules)
"""
THREADS = "import fenics_mech, os; print(os.environ['OMP_NUM_THREADS'])"


def printed(code, **environment):
    """What a new Python prints."""
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout.strip()


def loaded(*calls):
    """Which libraries, with their first names, the command has loaded after calls with these arguments."""
    names = printed(CALLED.format(calls=calls), **os.environ).splitlines()[-1]
    return {name.partition(".")[0] for name in names.split()}


def test_help_loads_no_numerical_library():
    found = loaded(["--help"], *([name, "--help"] for name in COMMANDS))
    assert "typer" in found
    assert not found & {*HEAVY.split(), "numpy", "vtkmodules"}


def test_check_and_schema_load_only_what_they_need():
    found = loaded(*(["check", str(scene)] for scene in DEMOS.glob("*.toml")), ["schema"])
    assert "numpy" in found
    assert not found & {*HEAVY.split(), "vtkmodules"}


@pytest.mark.parametrize(("stated", "threads"), [({}, "1"), ({"OMP_NUM_THREADS": "3"}, "3")])
def test_libraries_use_one_thread_unless_the_user_says_otherwise(stated, threads):
    environment = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"}
    assert printed(THREADS, **environment, **stated) == threads


def test_numerical_libraries_start_no_thread():
    environment = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"}
    work = "import fenics_mech, numpy as np, os; np.ones((400, 400)) @ np.ones((400, 400)); "
    assert printed(work + "print(len(os.listdir('/proc/self/task')))", **environment) == "1"


def test_xarray_loads_no_pint_which_reads_units_all_the_same():
    work = """
import sys, xarray
from fenics_mech._libraries import leave_pint_out
leave_pint_out()
xarray.DataArray([1.0], {"x": ["a"]}, "x").to_numpy()
print("pint" in sys.modules)
from fenics_mech.scene.units import registry
print(registry()("2 furlong/fortnight").dimensionality)
"""
    assert printed(work, **os.environ).split("\n") == ["False", "[length] / [time]"]


def test_dolfinx_loads_no_pkg_resources_which_can_be_loaded_later():
    work = """
import sys
from fenics_mech._fenicsx import dolfinx, ufl
print("pkg_resources" in sys.modules, bool(ufl.__version__))
from importlib.util import find_spec
print(find_spec("pkg_resources") is None or bool(__import__("pkg_resources").working_set))
"""
    assert printed(work, **os.environ).split("\n") == ["False True", "True"]


@pytest.mark.parametrize(
    ("stated", "expected"),
    [
        ({}, {"pml": "ob1", "btl": "self", "ess_singleton_isolated": "1"}),
        ({"OMPI_MCA_btl": "tcp,self"}, {"pml": "ob1", "btl": "tcp,self", "ess_singleton_isolated": "1"}),
        ({"OMPI_COMM_WORLD_SIZE": "2"}, {}),  # by mpirun
    ],
)
def test_mpi_of_one_process_looks_for_no_others(stated, expected, monkeypatch):
    for name in [name for name in os.environ if name.startswith(("OMPI_", "PMI"))]:
        monkeypatch.delenv(name)
    for name, value in stated.items():
        monkeypatch.setenv(name, value)
    before = dict(os.environ)
    with alone():
        found = {name.removeprefix("OMPI_MCA_"): value for name, value in os.environ.items() if "OMPI_MCA_" in name}
        assert found == expected
    assert os.environ == before
