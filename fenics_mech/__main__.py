"""``python -m fenics_mech``, and the `fenics-mech` command: it may be interrupted at any time, also as it starts."""

from __future__ import annotations

import _thread
import gc
import os
import signal
import sys
import time
from types import FrameType
from typing import Any

from fenics_mech._constants import INTERRUPTED

SOON = 0.001  # seconds
# What an interrupt arrives as: the alarm is one that is sent again, and Windows has none.
SIGNALS = [getattr(signal, name) for name in ("SIGALRM", "SIGINT") if hasattr(signal, name)]


def send_again() -> None:
    """Interrupt this process soon."""
    if hasattr(signal, "setitimer"):
        signal.setitimer(signal.ITIMER_REAL, SOON)
    else:
        _thread.start_new_thread(_interrupt_soon, ())


def _interrupt_soon() -> None:
    time.sleep(SOON)
    _thread.interrupt_main()


class _Interrupt:
    """Ctrl-C, which ends the command with one line wherever it comes."""

    # Libraries in C turn an interrupt into another error or drop it. The one is known by `seen`, the other is sent
    # again.

    def __init__(self) -> None:
        self.seen = self.dropping = False
        for number in SIGNALS:
            signal.signal(number, self.raised)
        self.before, sys.unraisablehook = sys.unraisablehook, self.dropped

    def raised(self, number: int, frame: FrameType | None) -> None:
        self.seen = True
        if not self.dropping:
            raise KeyboardInterrupt
        send_again()

    def dropped(self, unraisable: Any) -> None:
        if issubclass(unraisable.exc_type, KeyboardInterrupt):
            self.dropping = True  # what is raised in here is dropped too
            send_again()
            self.dropping = False
        elif not self.seen:
            self.before(unraisable)

    def end(self) -> None:
        """Say so and leave, without what the libraries do as they are shut down."""
        for number in SIGNALS:  # the interrupt that was sent again may come only now
            signal.signal(number, signal.SIG_IGN)
        sys.stderr.write("interrupted\n")
        sys.stderr.flush()
        os._exit(INTERRUPTED)


def main() -> None:
    """Run the command."""
    interrupt = _Interrupt()
    sys.stdout, sys.stderr = (stream or open(os.devnull, "w") for stream in (sys.stdout, sys.stderr))  # noqa: SIM115
    try:
        from fenics_mech.cli import main as command  # noqa: PLC0415

        command()
    except BaseException as error:
        if interrupt.seen or isinstance(error, KeyboardInterrupt):
            interrupt.end()
        raise
    finally:
        gc.freeze()  # as it ends, Python would search all objects for garbage several times


if __name__ == "__main__":
    main()
