"""Reading files that others have made: ordinary ones only, and none that is larger than it can be."""

from __future__ import annotations

import os
import stat
from pathlib import Path


def read_bounded(path: Path, largest: int) -> bytes:
    """Read an ordinary file of at most so many bytes; pipes and devices may never end.

    Raises
    ------
    OSError
        When it cannot be read.
    ValueError
        When it is not an ordinary file, is too large, or has a name that no file can have.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NONBLOCK)  # a pipe that nobody writes to would block
    with open(handle, "rb") as file:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise ValueError("it is not an ordinary file")
        if found.st_size > largest:
            raise ValueError(f"it has {found.st_size} bytes, and at most {largest} are expected")
        return file.read()


def reason_of(error: OSError | ValueError) -> str:
    """Say why a file cannot be read or written."""
    return (isinstance(error, OSError) and error.strerror) or str(error)
