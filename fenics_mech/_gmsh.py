"""The gmsh session: opened where it is needed, and left as it was found."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import gmsh

PATIENCE = 60  # seconds for a script
MEMORY = 4_000_000_000  # bytes for a script
MESHED = """
import resource, sys
resource.setrlimit(resource.RLIMIT_AS, (int(sys.argv[3]),) * 2)
import gmsh
gmsh.initialize(readConfigFiles=False, interruptible=False)
gmsh.option.setNumber("General.Verbosity", 0)
try:
    gmsh.merge(sys.argv[1])
    gmsh.model.mesh.generate(1)
    gmsh.option.setNumber("Mesh.SaveAll", 1)
    gmsh.option.setNumber("Mesh.Binary", 1)
    gmsh.write(sys.argv[2])
except Exception as error:
    sys.exit(str(error))
"""


@contextmanager
def model() -> Iterator[Any]:
    """Open an empty gmsh model of our own and leave gmsh as it was found."""
    ours = not gmsh.isInitialized()
    if ours:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
        gmsh.option.setNumber("General.Verbosity", 1)
    before = None if ours else gmsh.model.getCurrent()
    try:
        gmsh.model.add("fenics_mech")
        yield gmsh.model
    finally:
        if ours:
            gmsh.finalize()
        else:
            gmsh.model.remove()
            gmsh.model.setCurrent(before)


def merge(path: Path) -> None:
    """Read a file into the current model; gmsh raises `Exception` where it cannot."""
    gmsh.parser.clear()
    gmsh.merge(str(path))


def meshed(script: Path) -> Path:
    """Let gmsh run a script and mesh its curves in a process of its own: a script may loop for ever, or crash gmsh.

    Returns
    -------
    Path
        The mesh, beside the script.

    Raises
    ------
    ValueError
        When it fails, or takes too much time or memory.
    """
    mesh = script.with_suffix(".msh")
    command = [sys.executable, "-c", MESHED, str(script), str(mesh), str(MEMORY)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    except subprocess.TimeoutExpired as error:
        raise ValueError(f"it takes longer than {PATIENCE} s") from error
    if done.returncode:
        said = done.stderr.strip().splitlines()
        raise ValueError(said[-1] if said and done.returncode == 1 else "gmsh ended, out of memory or by a fault of it")
    return mesh
