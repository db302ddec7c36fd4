"""Work shared by processes of this machine, in which the loss of one costs what it was at, and nothing else.

Each process is a `ProcessPoolExecutor` of its own, as a pool ends with the first process that it loses.
"""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, chdir
from itertools import chain
from logging.handlers import QueueHandler
from multiprocessing import forkserver, get_context, parent_process
from multiprocessing.connection import Connection
from multiprocessing.connection import wait as wait_for
from multiprocessing.context import BaseContext
from typing import Any, Self, TypeVar

from fenics_mech._libraries import launched, leave_pint_out
from fenics_mech.errors import SolverError

NAME = "fenics_mech"  # of the logger above all of the program
PAUSE = 0.2  # s, after which pipes of new processes are heard too

Channel = tuple[Connection, int]  # where a process sends its records, and from which level on


class _Pipe:
    """A pipe as the queue of a `QueueHandler`."""

    def __init__(self, connection: Connection) -> None:
        self.put_nowait = connection.send


class WorkerLogs:
    """The pipes of all processes, whose records are handled here as if they were logged here."""

    # Each process has a pipe of its own: one that is killed in the middle of a record spoils no other's.

    def __init__(self) -> None:
        self.level = logging.getLogger(NAME).getEffectiveLevel()
        self.ends: list[Connection] = []
        self.others: list[Connection] = []
        self.over = threading.Event()
        self.thread = threading.Thread(target=self._listen, daemon=True)

    def channel(self, context: BaseContext) -> Channel:
        """Give a new process what it sends its records by."""
        here, there = context.Pipe(duplex=False)
        self.ends.append(here)
        self.others.append(there)
        return there, self.level

    def _listen(self) -> None:
        while not self.over.is_set():
            if not self.ends:
                self.over.wait(PAUSE)
            self._hear(PAUSE)
        self._hear(0.0)

    def _hear(self, patience: float) -> None:
        """Handle what has come, until nothing comes."""
        while ready := wait_for(list(self.ends), patience):
            for end in ready:
                assert isinstance(end, Connection)
                try:
                    record = end.recv()
                except (EOFError, OSError):
                    self.ends.remove(end)
                else:
                    logging.getLogger(record.name).handle(record)


@contextlib.contextmanager
def heard() -> Iterator[WorkerLogs]:
    """Handle the records of processes as long as they work."""
    logs = WorkerLogs()
    logs.thread.start()
    try:
        yield logs
    finally:
        logs.over.set()
        logs.thread.join()
        for end in (*logs.ends, *logs.others):
            end.close()


def send_log(channel: Channel) -> None:
    """Let a process send what it logs to the one that it works for."""
    connection, level = channel
    logger = logging.getLogger(NAME)
    logger.handlers, logger.propagate = [QueueHandler(_Pipe(connection))], False  # type: ignore[arg-type]
    logger.setLevel(level)


MAX_FAILED_STARTS = 10
AFTER_FAILURE = 0.05  # s that a start waits after one that failed, and after each further one as much more
STARTER = "fenics_mech.studies.process_starter"  # what the process that starts the others imports first
LATER = ("scipy.ndimage",)  # what all analyses import as they go on, and each process would for itself
DONE: Any = object()  # in place of a task, at the end of a run
Task = TypeVar("Task")


def prepare(module: str) -> None:
    """Let what starts processes import what they need, while this one imports what it needs itself."""
    # Python and PETSc would look for modules and options in the current folder, which may be a stranger's. So that
    # process begins in another one; those that it starts are in the current folder.
    forkserver.set_forkserver_preload([STARTER, __name__, module, *LATER])  # imported once for all
    with chdir(os.sep):
        forkserver.ensure_running()


class Workers:
    """Processes that start as there is work, and end with the block of a study: ``with Workers(2) as workers``."""

    # What they keep from one task to the next, they keep from one call of `share` to the next too.

    def __init__(self, count: int) -> None:
        self.count = count
        self._context = get_context("forkserver")
        self._idle: list[ProcessPoolExecutor] = []
        self._open = ExitStack()
        self._logs: WorkerLogs | None = None

    def __enter__(self) -> Self:
        """Give itself, to end the processes with the block."""
        return self

    def __exit__(self, *_: object) -> None:
        """End the processes, and tell the last that they logged."""
        _end(self._idle)
        self._open.close()
        self.count = 0

    def share(
        self,
        runs: Iterable[Iterable[Task]],
        work: Callable[[Task], object],
        lost: Callable[[Task], None],
        started: Callable[[Task], None] = lambda task: None,
    ) -> None:
        """Let the processes work on tasks."""
        if launched():
            raise SolverError("`--jobs` starts processes itself, which `mpirun` does not let it: leave one of them out")
        prepare(work.__module__)
        failures = 0
        waiting: deque[tuple[Iterator[Task], ProcessPoolExecutor | None]] = deque((iter(run), None) for run in runs)
        running: dict[Future[object], tuple[ProcessPoolExecutor, Task, Iterator[Task]]] = {}
        try:
            while waiting or running:
                while waiting and len(running) < self.count:
                    run, pool = waiting.popleft()
                    if (task := next(run, DONE)) is DONE:
                        self._idle += [] if pool is None else [pool]
                        continue
                    pool = pool or self._pool()
                    try:
                        running[pool.submit(work, task)] = pool, task, run
                    except (BrokenProcessPool, EOFError, OSError) as error:  # lost before the task reached it
                        waiting.appendleft((chain([task], run), None))
                        failures += 1
                        if failures == MAX_FAILED_STARTS:
                            raise SolverError(f"{failures} processes in a row could not be started: {error}") from error
                        time.sleep(failures * AFTER_FAILURE)  # the process that starts others may be dying still
                    else:
                        failures = 0
                        started(task)
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    pool, task, run = running.pop(future)
                    kept: ProcessPoolExecutor | None = None
                    try:
                        future.result()
                        kept = pool
                    except BrokenProcessPool:
                        lost(task)
                    waiting.appendleft((run, kept))
        finally:
            _end([*(pool for pool, *_ in running.values()), *(pool for _, pool in waiting if pool)])

    def _pool(self) -> ProcessPoolExecutor:
        """Give a process that has nothing to do, or a new one."""
        if self._idle:
            return self._idle.pop()
        if self._logs is None:
            self._logs = self._open.enter_context(heard())
        return ProcessPoolExecutor(1, self._context, _begin, (self._logs.channel(self._context),))


def _end(pools: Iterable[ProcessPoolExecutor]) -> None:
    for pool in pools:
        pool.shutdown(wait=False, cancel_futures=True)


def _begin(channel: Channel) -> None:
    """Let the process end with the one that it works for, and at once where both are interrupted; it logs there."""
    leave_pint_out()
    send_log(channel)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
