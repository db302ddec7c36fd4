"""PETSc options of one solver: the program's defaults, then what the scene asks for, under a prefix of its own."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from traceback import clear_frames
from typing import Any

import scipy.sparse as sp
from petsc4py import PETSc

from fenics_mech.errors import SolverError

SMALLEST_PIVOT = 1e-290  # PETSc's own, 2e-14, is not free of units: the stiffness of a machine in micrometres is less
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
    """Give a solver its options and destroy it at the end, unless it is kept.

    Parameters
    ----------
    solver
        A new KSP or EPS.
    prefix
        The prefix of its options, such as "periodic_".
    defaults
        Options without prefix.
    asked
        Options with prefix, which win over the defaults; those of other prefixes are passed over. Options on the PETSc
        command line or in the environment variable PETSC_OPTIONS win over both.
    keep
        Whether it is needed later on: whoever keeps it destroys it, as Python by itself does not.
    """
    solver.setOptionsPrefix(prefix)
    base = PETSc.Options()
    options = {prefix + key: value for key, value in defaults.items()}
    options |= {key: value for key, value in asked.items() if key.startswith(prefix)}
    ours = {key: value for key, value in options.items() if not base.hasName(key)}
    for key, value in ours.items():
        base.setValue(key, value)
    try:
        solver.setFromOptions()
        yield solver
    except PETSc.Error as error:
        raise SolverError(f"the solver with the options {prefix}* stopped: {reason(error)}") from error
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


def reason(error: PETSc.Error) -> str:
    """Give the line of a PETSc error that says what went wrong."""
    lines = [line.split("] ", 1)[-1].strip() for line in str(error).splitlines() if line.strip()]
    return lines[-1] if lines else "unknown reason"


def name_of(enumeration: Any, code: int) -> str:
    """Give the name of a converged reason, as KSP and EPS report it."""
    names = [name for name, value in vars(enumeration).items() if value == code and not name.startswith("_")]
    return names[0] if names else str(code)
