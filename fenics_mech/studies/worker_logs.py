"""What processes that share work log, told by the one that they work for.

Each process has a pipe of its own: one that is killed in the middle of a record spoils no other's.
"""

from __future__ import annotations

import contextlib
import logging
import threading
from collections.abc import Iterator
from logging.handlers import QueueHandler
from multiprocessing.connection import Connection, wait
from multiprocessing.context import BaseContext

NAME = "fenics_mech"  # of the logger above all of the program
PAUSE = 0.2  # s, after which pipes of new processes are heard too

Channel = tuple[Connection, int]  # where a process sends its records, and from which level on


class _Pipe:
    """A pipe as the queue of a `QueueHandler`."""

    def __init__(self, connection: Connection) -> None:
        self.put_nowait = connection.send


class WorkerLogs:
    """The pipes of all processes, whose records are handled here as if they were logged here."""

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
        while ready := wait(list(self.ends), patience):
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
