"""Work over the processes of `mpirun`, on one or more machines: the first one leads, and the others do what it shares.

The pool of mpi4py hands out tasks as processes become free. MPI ends all of them with the first that is lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextvars import ContextVar
from functools import wraps
from typing import Any, ParamSpec, TypeVar

from fenics_mech._petsc import MPI
from fenics_mech._ranks import together, tried
from fenics_mech.errors import MechanismError

Task = TypeVar("Task")
Given = ParamSpec("Given")
Found = TypeVar("Found")
Done = TypeVar("Done")
_pool: ContextVar[Any] = ContextVar("the other processes of mpirun", default=None)


def led(study: Callable[Given, Found]) -> Callable[Given, Found]:
    """Let the first process do a study, and the others what it shares; all get what it finds, or its error."""

    @wraps(study)
    def alone_or_led(*given: Given.args, **named: Given.kwargs) -> Found:
        comm = MPI.COMM_WORLD
        if comm.size == 1:
            return study(*given, **named)
        if named.get("jobs", 1) != 1:
            raise MechanismError("the processes of mpirun share the trials already: leave --jobs out, or mpirun")
        from mpi4py.futures import MPICommExecutor  # noqa: PLC0415  (under mpirun only)

        found, error = None, None
        with MPICommExecutor(comm) as pool:  # the others work in here until the first one has left
            if pool is not None:
                before = _pool.set(pool)
                found, error = tried(comm, lambda: study(*given, **named))
                _pool.reset(before)

        def outcome() -> Found | None:
            if error is not None:
                raise error
            return found

        return comm.bcast(together(comm, outcome))  # type: ignore[no-any-return]

    return alone_or_led


def leads() -> bool:
    """Whether this process leads others of `mpirun`."""
    return _pool.get() is not None


def over_machines(tasks: Sequence[Task], work: Callable[[Task], Done], done: Callable[[Task, Done], None]) -> None:
    """Work on tasks in the processes that this one leads."""
    from concurrent.futures import as_completed  # noqa: PLC0415

    running = {_pool.get().submit(work, task): task for task in tasks}
    try:
        for future in as_completed(running):
            done(running[future], future.result())
    finally:
        for future in running:
            future.cancel()
