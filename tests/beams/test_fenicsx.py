"""What differs between versions of dolfinx, PETSc and SLEPc, and what a user is told of one that does not work."""

import subprocess
import sys

import numpy as np
import pytest

from fenics_mech import _fenicsx
from fenics_mech._petsc import PETSc, SLEPc, code_of, configured
from fenics_mech.errors import MechanismError, SolverError
from tests.common import ROOT

WITHOUT = """
import sys
sys.modules["petsc4py"] = None
from fenics_mech.__main__ import main
sys.argv = ["fenics-mech", "run", "demos/four_bar.toml"]
main()
"""


@pytest.mark.parametrize("version", ["0.4.9", "0.8.0", "0.12.0.dev0", "1.0.0"])
def test_a_version_that_is_not_known_to_work_is_named_in_an_error(monkeypatch, version):
    monkeypatch.setattr(_fenicsx.dolfinx, "__version__", version)
    said = f"dolfinx {version} is installed, and only 0.5, 0.9, 0.10 and 0.11 are known to work"
    with pytest.raises(MechanismError, match=said):
        _fenicsx.line_mesh("no model of gmsh")


def test_the_version_is_not_blamed_where_it_is_known_to_work():
    with pytest.raises(AttributeError, match="no attribute"):
        _fenicsx.line_mesh("no model of gmsh")


def test_installed_dolfinx_is_one_that_is_known_to_work():
    assert _fenicsx.found() in _fenicsx.KNOWN


@pytest.mark.parametrize(("option", "said"), [("eps_type", "no method of that name"), ("eps_tol", "out of its range")])
def test_options_that_slepc_refuses_are_told_by_its_code(option, said):
    eps = SLEPc.EPS().create(comm=PETSc.COMM_SELF)
    said = f"test_.* stopped: .*{said}.*test_{option} = nonsense"
    options = {f"test_{option}": "nonsense"}
    with pytest.raises(SolverError, match=said), configured(eps, "test_", {}, options):
        pass


def test_a_singular_matrix_is_told_by_petscs_code():
    matrix = PETSc.Mat().createDense((2, 2), array=np.zeros((2, 2)), comm=PETSc.COMM_SELF)
    matrix.assemble()
    ksp, options = PETSc.KSP().create(comm=PETSc.COMM_SELF), {"ksp_error_if_not_converged": True, "pc_type": "lu"}
    ksp.setOperators(matrix)
    said = r"a pivot is zero: the matrix is singular \(PETSc's code 71\)$"
    with pytest.raises(SolverError, match=said), configured(ksp, "test_", options, {}):
        ksp.setUp()


def test_errors_that_are_not_petscs_stay_as_they_are():
    other = SystemError("of Python")
    with pytest.raises(SystemError, match="of Python"):
        code_of(other)


def test_without_petsc_the_command_says_what_to_install():
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT], cwd=ROOT, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.returncode == 1
    assert done.stderr.startswith("error: PETSc, SLEPc and dolfinx cannot be loaded")
    assert "fenics_mech[solver]" in done.stderr
    assert "Traceback" not in done.stderr
