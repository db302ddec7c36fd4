"""Work shared by processes of this machine, in which the loss of one costs what it was at, and nothing else.

Each process is a `ProcessPoolExecutor` of its own, as a pool ends with the first process that it loses.
"""

from __future__ import annotations

import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Iterable
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context, parent_process
from typing import TypeVar

from fenics_mech.errors import SolverError
from fenics_mech.studies.worker_logs import Channel, heard, send_log

MAX_FAILED_STARTS = 10
STARTER = "fenics_mech.studies.process_starter"  # what the process that starts the others imports before MPI
Task = TypeVar("Task")


def over_processes(
    count: int,
    tasks: Iterable[Task],
    work: Callable[[Task], object],
    lost: Callable[[Task], None],
    started: Callable[[Task], None] = lambda task: None,
) -> None:
    """Work on tasks in so many processes.

    Parameters
    ----------
    count
        Number of processes.
    tasks
        What to work on, in this order; it is pickled.
    work
        A function of a module, that each process imports. Its first error ends all.
    lost
        Called with the task of a process that was ended from outside; another process takes its place.
    started
        Called with each task as it begins.

    Raises
    ------
    SolverError
        If `MAX_FAILED_STARTS` processes in a row are lost before they work.
    """
    context = get_context("forkserver")
    context.set_forkserver_preload([STARTER, __name__, work.__module__])  # imported once for all
    waiting, idle, failures = deque(tasks), list[ProcessPoolExecutor](), 0
    running: dict[Future[object], tuple[ProcessPoolExecutor, Task]] = {}
    with heard() as logs:
        try:
            while waiting or running:
                while waiting and len(running) < count:
                    task = waiting.popleft()
                    pool = idle.pop() if idle else ProcessPoolExecutor(1, context, _begin, (logs.channel(context),))
                    try:
                        running[pool.submit(work, task)] = pool, task
                    except (BrokenProcessPool, EOFError, OSError) as error:  # lost before the task reached it
                        waiting.appendleft(task)
                        failures += 1
                        if failures == MAX_FAILED_STARTS:
                            raise SolverError(f"{failures} processes in a row could not be started: {error}") from error
                    else:
                        failures = 0
                        started(task)
                for future in wait(running, return_when=FIRST_COMPLETED).done:
                    pool, task = running.pop(future)
                    try:
                        future.result()
                        idle.append(pool)
                    except BrokenProcessPool:
                        lost(task)
        finally:
            for pool in (*idle, *(pool for pool, _ in running.values())):
                pool.shutdown(wait=False, cancel_futures=True)


def _begin(channel: Channel) -> None:
    """Let the process end with the one that it works for, and at once where both are interrupted; it logs there."""
    send_log(channel)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    assert parent is not None
    parent.join()
    os._exit(1)
