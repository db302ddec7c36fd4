"""The cache of compiled forms: shared by all runs of a user, and never spoilt by one that was killed.

ffcx marks a form that is being compiled by its C file, and waits 10 s for one that a killed process has left. So each
compilation holds a lock, which the system takes away from a process that ends, and first removes what has no end mark.
What is compiled is run: a cache that someone else could have written to is not used.
"""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager
from functools import cache
from multiprocessing import parent_process
from pathlib import Path
from typing import TypeVar

from fenics_mech._system import folder_of_ones_own, locked
from fenics_mech.errors import MechanismError, SolverError

logger = logging.getLogger(__name__)
Made = TypeVar("Made")
_cleaned: dict[Path, int] = {}  # when each folder was last changed, as it was found clean


def compile_safely(make: Callable[[Path], Made]) -> Made:
    """Let `make` compile into the user's cache; where that fails, into a folder of this process."""
    # It runs in that folder: dolfinx and ffcx take options of the C compiler from files in the current one.
    try:
        with _locked(folder_of_ones_own(_user_folder())) as folder, chdir(folder):
            return make(folder)
    except Exception as error:  # ffcx, cffi, setuptools and the loader raise many types, for a disk as for a C compiler
        made = _made_for_now(make)
        _say_why(" ".join(str(error).split()) or type(error).__name__)
        return made


def _made_for_now(make: Callable[[Path], Made]) -> Made:
    try:
        with chdir(_own_folder()):
            return make(_own_folder())
    except Exception as error:
        what = " ".join(str(error).split()) or type(error).__name__
        raise SolverError(
            f"the forms cannot be compiled: {what}. A C compiler (cc) and some room in the folder for temporary "
            f"files ({tempfile.gettempdir()}) are needed"
        ) from error


@cache
def _say_why(reason: str) -> None:
    """Say once why the user's cache is not used; processes that others have started leave that to them."""
    if parent_process() is None:
        logger.warning(
            "Forms are compiled for this run only: %s. A folder of your own, to which nobody else can write, is "
            "expected at $XDG_CACHE_HOME/fenics_mech or ~/.cache/fenics_mech",
            MechanismError(reason),
        )


def _user_folder() -> Path:
    """Give the user's cache; a relative path counts from a folder that may be a stranger's, and is passed over."""
    for base in (os.environ.get("XDG_CACHE_HOME", ""), os.path.expanduser("~/.cache")):
        if os.path.isabs(base):
            return Path(base) / "fenics_mech"
    raise FileNotFoundError("there is no home folder")


@cache
def _own_folder() -> Path:
    folder = tempfile.mkdtemp(prefix="fenics-mech-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return Path(folder)


@contextmanager
def _locked(folder: Path) -> Iterator[Path]:
    """Hold the lock of a cache, freed of what was not finished."""
    with locked(folder / "lock"):
        if folder.stat().st_mtime_ns != _cleaned.get(folder):
            _clean(folder)
            _cleaned[folder] = folder.stat().st_mtime_ns
        try:
            yield folder
        except Exception:  # of a full disk, or of a library that a full disk has cut: the next run makes them anew
            for left in folder.glob("libffcx_*"):
                left.unlink(missing_ok=True)
            raise


def _clean(folder: Path) -> None:
    """Remove what was begun and not finished."""
    for source in folder.glob("*.c"):
        if not source.with_suffix(".c.cached").exists():
            source.unlink()
    for mark in folder.glob("*.c.cached"):
        if not mark.with_suffix("").exists():
            mark.unlink()
