"""The processes of `mpirun`: work over the positions shared among them, and errors that end all of them.

What is not shared every process does by itself, and comes to the same. So each has the whole of every array.
"""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable, Sequence
from contextvars import ContextVar
from typing import Any, TypeVar

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import INTERRUPTED
from fenics_mech._petsc import MPI
from fenics_mech.errors import MechanismError

Found = TypeVar("Found")
_sharing: ContextVar[Any] = ContextVar("processes that share positions", default=None)


class _EndedError(Exception):
    """Another process is at its end already. It is no `MechanismError`, after which an analysis might go on."""


def together(comm: Any, work: Callable[[], Found]) -> Found:
    """Let every process work; an error of one is raised by all, so that none waits for one that has ended.

    Raises
    ------
    MechanismError
        When another process, and not this one, ended with an error; else the error of this one.
    """
    try:
        found, error = tried(comm, work)
    except _EndedError as ended:
        raise MechanismError(str(ended)) from None
    reports = comm.allgather((True, error and _said(error)))
    if error is not None:
        raise error
    for rank, (_, text) in enumerate(reports):
        if text:
            raise MechanismError(f"process {rank} ended with {text}")
    return found  # type: ignore[return-value]


def shared(work: Callable[[], Found]) -> Found:
    """Let every process of `MPI.COMM_WORLD` do the same work, in which `over_positions` shares what it is given.

    Raises
    ------
    MechanismError
        When another process, and not this one, ended with an error; else the error of this one.
    """
    before = _sharing.set(MPI.COMM_WORLD)
    try:
        return together(MPI.COMM_WORLD, work)
    finally:
        _sharing.reset(before)


def over_positions(count: int, work: Callable[[slice], Sequence[Array]]) -> Sequence[Array]:
    """Work at all positions: each process that shares at some of them, and all get the whole.

    Parameters
    ----------
    count
        Number of positions.
    work
        Gives arrays with the positions of a slice along their first axis. What it gives for a position must not depend
        on the others. Its error is raised by all processes; of several, that at the first positions.
    """
    comm = _sharing.get() or MPI.COMM_SELF
    if comm.size == 1 or count < comm.size:
        return work(slice(0, count))
    ends = [count * rank // comm.size for rank in range(comm.size + 1)]
    found, error = tried(comm, lambda: work(slice(*ends[comm.rank : comm.rank + 2])))
    reports = comm.allgather((False, error and _sendable(error)))
    for rank, (ended, other) in enumerate(reports):
        if ended:
            raise _EndedError(f"process {rank} ended with {other}")
    for _, other in reports:
        if other is not None:
            raise other
    assert found is not None
    return [_gathered(comm, part, ends) for part in found]


def tried(comm: Any, work: Callable[[], Found]) -> tuple[Found | None, Exception | None]:
    """Give what the work finds, or its error; an interrupt ends all processes.

    Parameters
    ----------
    comm
        The processes.
    work
        The work.
    """
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


def _gathered(comm: Any, part: Array, ends: Sequence[int]) -> Array:
    """Join the parts of all processes along the first axis."""
    whole = np.empty((ends[-1], *part.shape[1:]))
    row = MPI.DOUBLE.Create_contiguous(math.prod(part.shape[1:])).Commit()  # counts of numbers may be too large
    counts = [int(count) for count in np.diff(ends)]
    comm.Allgatherv(
        [np.ascontiguousarray(part, dtype=np.float64), len(part), row], [whole, (counts, list(ends[:-1])), row]
    )
    row.Free()
    return whole


def _sendable(error: Exception) -> Exception:
    """Give the error, or one that says the same if it cannot be sent."""
    try:
        pickle.loads(pickle.dumps(error))
    except Exception:  # what an error holds is not known
        return MechanismError(_said(error))
    return error


def _said(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"
