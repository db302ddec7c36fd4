"""The gmsh session: opened where it is needed, and left as it was found."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import gmsh


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
