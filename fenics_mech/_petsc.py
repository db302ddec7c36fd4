"""PETSc options of one solver: the program's defaults, then what the scene asks for, under a prefix of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from traceback import clear_frames
from typing import Any

import scipy.sparse as sp

from fenics_mech.errors import MechanismError, SolverError


def not_there(error: ImportError) -> MechanismError:
    """Say what to install where PETSc, SLEPc or dolfinx cannot be imported."""
    return MechanismError(
        f"PETSc, SLEPc and dolfinx cannot be loaded: {error}. Install them from Debian (python3-dolfinx, "
        "python3-slepc4py), from conda-forge (fenics-dolfinx, slepc4py), or as wheels (pip install "
        "'fenics_mech[solver]', for Python 3.12 and later on Linux)"
    )


class Absent:
    """Stands for a library that is not there: results are read and drawn without it, and its use is an error."""

    def __init__(self, error: ImportError) -> None:
        self.error = error

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):  # what Python itself asks of every object
            raise AttributeError(name)
        raise not_there(self.error)


try:
    with suppress(ModuleNotFoundError):
        import dolfinx_solver  # noqa: F401  (wheels of PETSc and dolfinx: it refuses what cannot work beside them)
    from mpi4py import MPI  # first: PETSc's wheels take the MPI that is loaded
    from petsc4py import PETSc
    from slepc4py import SLEPc
except ImportError as error:
    MPI = PETSc = SLEPc = Absent(error)  # type: ignore[assignment,misc]
if not isinstance(PETSc, Absent) and PETSc.ScalarType is not PETSc.RealType:
    raise MechanismError("the PETSc that is installed computes with complex numbers: install the one with real numbers")

SMALLEST_PIVOT = 1e-290  # PETSc's own, 2e-14, is not free of units: the stiffness of a machine in micrometres is less
LATER = {"ts_dt": "ts_time_step"}  # names of options that PETSc has given new ones: each release reads the one it knows
MEANINGS = {  # of PETSc's error codes, which stay when releases change: include/petscerror.h
    55: "out of memory",
    56: "the method does not support this matrix or problem",
    60: "sizes do not match",
    62: "an argument or option has a wrong value",
    63: "a number is out of its range",
    71: "a pivot is zero: the matrix is singular",
    72: "numbers overflow, or are not numbers",
    73: "a step is missing or too early",
    76: "a library that PETSc calls failed",
    81: "a pivot is zero: the matrix is singular",
    82: "no convergence",
    86: "this PETSc or SLEPc knows no method of that name",
    91: "no convergence",
    92: "no factorisation of that kind",
}
WHOLE_SPECTRUM = {"eps_type": "lapack", "eps_smallest_real": ""}
SLOWEST_MODES = {
    "eps_type": "krylovschur",
    "eps_target": 0.0,
    "eps_target_magnitude": "",
    "st_type": "sinvert",
    "st_ksp_type": "preonly",
    "st_pc_type": "cholesky",
    "st_pc_factor_zeropivot": SMALLEST_PIVOT,
}
DIRECT = {"ksp_type": "preonly", "pc_type": "lu", "pc_factor_zeropivot": SMALLEST_PIVOT}


def to_petsc(matrix: sp.csr_matrix) -> PETSc.Mat:
    """Copy a SciPy matrix into a PETSc one."""
    csr = (matrix.indptr.astype(PETSc.IntType), matrix.indices.astype(PETSc.IntType), matrix.data)
    return PETSc.Mat().createAIJ(matrix.shape, csr=csr, comm=PETSc.COMM_SELF)


def to_scipy(matrix: PETSc.Mat) -> sp.csr_matrix:
    """Copy a PETSc matrix into a SciPy one."""
    return sp.csr_matrix(matrix.getValuesCSR()[::-1], shape=matrix.size)


@contextmanager
def configured(
    solver: Any, prefix: str, defaults: Mapping[str, Any], asked: Mapping[str, Any], keep: bool = False
) -> Iterator[Any]:
    """Give a solver its options and destroy it at the end, unless it is kept."""
    solver.setOptionsPrefix(prefix)
    base = PETSc.Options()
    options = {prefix + key: value for key, value in defaults.items()}
    options |= {key: value for key, value in asked.items() if key.startswith(prefix)}
    options |= {prefix + new: options[prefix + old] for old, new in LATER.items() if prefix + old in options}
    ours = {key: value for key, value in options.items() if not base.hasName(key)}
    for key, value in ours.items():
        base.setValue(key, value)
    try:
        solver.setFromOptions()
        yield solver
    except (PETSc.Error, SystemError) as error:
        if (own := _raised_by_ours(error)) is not None:
            clear_frames(own.__traceback__)
            raise own from None
        code = code_of(error)
        asked_for = ", ".join(f"{key} = {value}" for key, value in ours.items() if key in asked)
        raise SolverError(
            f"the solver with the options {prefix}* stopped: {MEANINGS.get(code, 'an error')} (PETSc's code {code}"
            f"{_reason(solver)})" + (f". The scene has {asked_for}" if asked_for else "")
        ) from error
    except BaseException as error:
        # Frames of a callback that raised hold the solver. PETSc would destroy it at its own end, after that of Python,
        # and call Python code of the solver then: a segmentation fault.
        clear_frames(error.__traceback__)
        raise
    finally:
        for key in ours:
            base.delValue(key)
        if not keep:
            solver.destroy()


def code_of(error: BaseException) -> int:
    """Give the code of an error of PETSc or SLEPc."""
    # SLEPc for Python 3.25 raises a `SystemError` that has PETSc's as its cause; any other one is raised again.
    found = error if isinstance(error, PETSc.Error) else error.__cause__
    if not isinstance(found, PETSc.Error):
        raise error
    return int(found.ierr)


def _raised_by_ours(error: BaseException) -> BaseException | None:
    """Give what our code raised when PETSc called it, which petsc4py 3.22 and later make the cause of its own error."""
    cause = error.__cause__
    while isinstance(cause, PETSc.Error | SystemError):
        cause = cause.__cause__
    return cause


def _reason(solver: Any) -> str:
    """Name the reason for which a KSP, EPS or TS says that it did not converge, if it says so."""
    code = solver.getConvergedReason()
    return f", {name_of(type(solver).ConvergedReason, code)}" if code < 0 else ""


def name_of(enumeration: Any, code: int) -> str:
    """Give the name of a converged reason, as KSP and EPS report it."""
    names = [name for name, value in vars(enumeration).items() if value == code and not name.startswith("_")]
    return names[0] if names else str(code)
