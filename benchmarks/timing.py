"""Timing: the median of repeats after a warm-up, and what of it is not Python."""

from __future__ import annotations

import cProfile
import os
import platform
import pstats
import re
import resource
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from fenics_mech._version import __version__

Found = TypeVar("Found")
Clock = Callable[[], float]
MOST_REPEATS, ENOUGH = 5, 1.5  # repeats, and seconds after which there are no more
BARE = re.compile(r"petsc4py|slepc4py|_sparsetools|superlu|lapack|numpy.linalg")
LINEAR_ALGEBRA = re.compile(r"numpy/linalg|scipy/linalg|_solvers|scipy/sparse/linalg")
TIMES = {  # in tables of runs: unit, meaning
    "seconds": ("s", "processor time, median of the repeats"),
    "wall_seconds": ("s", "time on the wall, median of the repeats"),
    "repeats": ("1", "repeats after the warm-up"),
}
PACKAGES = ("numpy", "scipy", "petsc4py", "slepc4py", "fenics-dolfinx", "exudyn")


@dataclass(frozen=True)
class Timing:
    """How long a piece of work took.

    Parameters
    ----------
    seconds
        Median of the processor time of its repeats (s).
    wall
        Median of the time on the wall (s): longer where other programs use the machine too.
    first
        Processor time of the first run, which compiles or reads what is compiled (s).
    repeats
        Number of repeats.
    """

    seconds: float
    wall: float
    first: float
    repeats: int

    @property
    def numbers(self) -> dict[str, float]:
        """What a table of runs has of it: `TIMES`."""
        return {"seconds": self.seconds, "wall_seconds": self.wall, "repeats": float(self.repeats)}


def timed(
    work: Callable[[], Found], clock: Clock = time.process_time, wall: Clock = time.perf_counter
) -> tuple[Found, Timing]:
    """Do a piece of work once to warm up, then again until there are enough repeats; a long one is its own repeat.

    Parameters
    ----------
    work
        The piece of work.
    clock, wall
        Give processor time and time on the wall (s).

    Returns
    -------
    tuple
        What the first run gave, and the median times of the repeats.
    """
    begin, start = wall(), clock()
    found = work()
    first = clock() - start
    times = [(first, wall() - begin)] if first > ENOUGH else []
    while len(times) < MOST_REPEATS and (not times or sum(each for each, _ in times) < ENOUGH):
        begin, start = wall(), clock()
        work()
        times.append((clock() - start, wall() - begin))
    seconds, walls = np.median(times, axis=0)
    return found, Timing(float(seconds), float(walls), first, len(times))


def machine() -> dict[str, str]:
    """Say what runs: processor, threads, versions."""
    named = re.search(r"^model name\s*:\s*(.*)$", _read("/proc/cpuinfo"), re.MULTILINE)
    found = {"fenics_mech": __version__, "python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            number = getattr(sys.modules.get(package.removeprefix("fenics-")), "__version__", None)
            found |= {package: number} if number else {}
    return {
        "machine": f"{named[1] if named else platform.processor() or platform.machine()}, {os.cpu_count()} processors",
        "threads": os.environ["OMP_NUM_THREADS"],
        "versions": ", ".join(f"{name} {number}" for name, number in found.items()),
    }


def _read(path: str) -> str:
    try:
        return Path(path).read_text()
    except OSError:
        return ""


def bare_seconds(work: Callable[[], Any]) -> float:
    """Processor time that a piece of work spends inside PETSc, SLEPc, LAPACK and sparse products (s).

    That is what the same calls with the same matrices would take without anything around them. Products of dense
    matrices are not in it, as no profile tells them from other work on arrays.

    Parameters
    ----------
    work
        The piece of work.
    """
    profile = cProfile.Profile(time.process_time)
    profile.runcall(work)
    bare = 0.0
    for (file, _, name), (_, _, inside, _, _) in pstats.Stats(profile).stats.items():  # type: ignore[attr-defined]
        if LINEAR_ALGEBRA.search(file) or (file == "~" and BARE.search(name)):
            bare += inside
    return bare


def peak_memory() -> float:
    """Give the largest memory of this process so far (bytes)."""
    # Linux keeps it by program: what `getrusage` gives there is also that of the one that started it.
    try:
        status = Path("/proc/self/status").read_text()
    except OSError:  # macOS, in bytes
        return float(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
    return next(float(line.split()[1]) * 1024 for line in status.splitlines() if line.startswith("VmHWM"))
