"""What numbers may do to a computation: overflow, make a matrix singular, or ask for more memory than there is."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import numpy as np

from fenics_mech._system import memory_limit, memory_of_machine
from fenics_mech.errors import SolverError, TooLargeError

ADVICE = (
    "Look for numbers of very different size in the scene: a very stiff spring or damper, a tiny mass, a wrong unit. "
    "What is to be rigid is better a weld or a rigid link"
)
OF_CONTAINER = (Path("/sys/fs/cgroup/memory.max"), Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"))


@contextmanager
def guarded() -> Iterator[None]:
    """Turn what NumPy raises about matrices and numbers into a `SolverError`; numbers that overflow raise too."""
    # As a decorator it guards a function.
    try:
        with np.errstate(over="raise", divide="raise", invalid="raise"):
            yield
    except (np.linalg.LinAlgError, RuntimeError) as error:
        if isinstance(error, RuntimeError) and "factor" not in str(error).lower():  # SuperLU has no type of its own
            raise
        raise SolverError(f"a matrix of the equations cannot be solved with ({error}). {ADVICE}") from error
    except (FloatingPointError, OverflowError) as error:
        raise SolverError(f"the numbers are too large or too small to be computed with ({error}). {ADVICE}") from error


def memory() -> int:
    """Give the memory that there is for this process (bytes): the machine's, or what its limits or container allow."""
    found = [memory_of_machine()]
    if (limit := memory_limit()) is not None:
        found.append(limit)
    for path in OF_CONTAINER:
        with suppress(OSError, ValueError):  # there is none, or it says "max"
            found.append(int(path.read_text()))
    return min(found)


def require_memory(numbers: float, what: str, hint: str) -> None:
    """Refuse what needs more memory than the machine has."""
    there = memory()
    if 8 * numbers > there:
        raise TooLargeError(
            f"{what} need about {8 * numbers / 1e9:.3g} GB of memory, and there is {there / 1e9:.3g} GB for it",
            hint=hint,
        )
