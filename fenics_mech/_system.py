"""What only some systems have, in one place: limits of a process, locks of files, and opening without waiting.

On Windows there is neither `resource` nor `fcntl`: psutil tells the memory there, and filelock locks.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import ModuleType

resource: ModuleType | None
fcntl: ModuleType | None
try:
    import fcntl
    import resource
except ImportError:
    resource = fcntl = None

# Flags to open a file for reading: a pipe that nobody writes to would block, and Windows would change ends of lines.
READ = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)


def memory_of_machine() -> int:
    """Give the memory of the machine (bytes)."""
    if hasattr(os, "sysconf"):
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    import psutil  # noqa: PLC0415

    return int(psutil.virtual_memory().total)


def memory_limit() -> int | None:
    """Give the memory that this process may have (bytes), or None where nothing limits it."""
    if resource is None:
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if limit == resource.RLIM_INFINITY else int(limit)


def limit_process(memory: int, largest_file: int) -> None:
    """Limit what this process may take, where the system can."""
    if resource is not None:
        for limit, most in ((resource.RLIMIT_AS, memory), (resource.RLIMIT_FSIZE, largest_file)):
            resource.setrlimit(limit, (most, most))


def folder_of_ones_own(folder: Path) -> Path:
    """Make a folder of code that is run, and give its real path, in which nobody else can change anything."""
    # As by StrictModes of ssh: it is the user's, those that it is in are his or the system's, and no group or other
    # user may write to one of them. In one with the sticky bit, such as /tmp, others can change their own files only.
    for missing in [one for one in (*reversed(folder.parents), folder) if not one.exists()]:
        missing.mkdir(mode=0o700, exist_ok=True)
    real = folder.resolve(strict=True)
    if fcntl is None:  # Windows gives each user a folder of his own
        return real
    for one in (real, *real.parents):
        found = one.stat()
        others = found.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
        if found.st_uid != os.geteuid() and (found.st_uid or one == real):
            raise PermissionError(f"{one} belongs to another user")
        if others and (one == real or not found.st_mode & stat.S_ISVTX):
            raise PermissionError(f"others may write to {one}")
    return real


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock that a file stands for; the system takes it away from a process that ends."""
    if fcntl is None:
        import filelock  # noqa: PLC0415

        with filelock.FileLock(path):
            yield
    else:
        lock = os.open(path, READ | os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)  # which empties nothing
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
            yield
        finally:
            os.close(lock)


@contextmanager
def alone_in(folder: Path) -> Iterator[bool]:
    """Hold a folder against others that ask so until the process ends; tell whether nobody else holds it."""
    # Systems and file systems without such locks hold nothing.
    if fcntl is None:
        yield True
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        yield _lock(handle)
    finally:
        os.close(handle)


def _lock(handle: int) -> bool:
    assert fcntl is not None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    except OSError:  # a file system without locks
        pass
    return True
