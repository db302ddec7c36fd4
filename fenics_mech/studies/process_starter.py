"""Imported first, and only, by the process that starts those that share work: its open files stay its own.

MPI may start a daemon there. Had that the socket at which processes are asked for, it would keep the socket open after
the loss of the process, and who asks then would wait for ever.
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from fenics_mech._libraries import alone

STREAMS = 3  # input, output and errors, which programs share

for _file in Path("/dev/fd").iterdir():
    if int(_file.name) >= STREAMS:
        with contextlib.suppress(OSError):  # the folder that is read here is closed already
            os.set_inheritable(int(_file.name), False)

with alone():
    from mpi4py import MPI  # noqa: F401
