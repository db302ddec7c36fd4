"""How far a piece of long work has come: what does the work says it, and a command shows it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

Listener = Callable[[float], None]

_listener: ContextVar[Listener | None] = ContextVar("listener", default=None)


@contextmanager
def heard(listener: Listener) -> Iterator[None]:
    """Call a listener with the share of the work that is done, from 0 to 1, wherever `reached` says it."""
    token = _listener.set(listener)
    try:
        yield
    finally:
        _listener.reset(token)


def reached(time: float, start: float, end: float) -> None:
    """Say how far a motion in time has come."""
    if (listener := _listener.get()) is not None and end > start:
        listener(min(max((time - start) / (end - start), 0.0), 1.0))
