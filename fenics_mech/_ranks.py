"""The processes of `mpirun`: work over the positions shared among them, and errors that end all of them.

What is not shared every process does by itself, and comes to the same. So each has the whole of every array.
"""

from __future__ import annotations

from collections.abc import Callable
from contextvars import ContextVar
from typing import Any, TypeVar

from fenics_mech._constants import INTERRUPTED
from fenics_mech._petsc import MPI
from fenics_mech.errors import MechanismError

Found = TypeVar("Found")
_sharing: ContextVar[Any] = ContextVar("processes that share positions", default=None)


class _EndedError(Exception):
    """Another process is at its end already. It is no `MechanismError`, after which an analysis might go on."""


def together(comm: Any, work: Callable[[], Found]) -> Found:
    """Let every process work; an error of one is raised by all, so that none waits for one that has ended."""
    try:
        found, error = tried(comm, work)
    except _EndedError as ended:
        raise MechanismError(str(ended)) from None
    reports = comm.allgather((True, error and f"{type(error).__name__}: {error}"))
    if error is not None:
        raise error
    for rank, (_, text) in enumerate(reports):
        if text:
            raise MechanismError(f"process {rank} ended with {text}")
    return found  # type: ignore[return-value]


def shared(work: Callable[[], Found]) -> Found:
    """Let every process of `MPI.COMM_WORLD` do the same work, in which `over_positions` shares what it is given."""
    before = _sharing.set(MPI.COMM_WORLD)
    try:
        return together(MPI.COMM_WORLD, work)
    finally:
        _sharing.reset(before)


def tried(comm: Any, work: Callable[[], Found]) -> tuple[Found | None, Exception | None]:
    """Give what the work finds, or its error; an interrupt ends all processes."""
    try:
        return work(), None
    except _EndedError:
        raise
    except Exception as error:
        return None, error
    except BaseException:
        if comm.size > 1:
            comm.Abort(INTERRUPTED)
        raise
