"""Motions of the points of a sweep, kept until the points at peaks are analysed again with estimates."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from fenics_mech._files import write_whole
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.response.periodic.known_motion import KnownMotion

MOST = 1_000_000  # numbers of a motion that is kept: a larger one is found again as fast as it is written and read
PARTS = ("turned", "displacement", "velocity", "tension")


def write_motion(path: Path, motion: KnownMotion) -> None:
    """Write a motion, if it is not large.

    Parameters
    ----------
    path
        The file.
    motion
        The motion.

    Raises
    ------
    ResultError
        When the file cannot be written.
    """
    parts = {name: getattr(motion, name) for name in PARTS}
    if sum(part.size for part in parts.values()) > MOST:
        return

    def write(temporary: Path) -> None:
        with temporary.open("wb") as file:
            np.savez(file, **parts)

    write_whole(path, write)


def read_motion(path: Path, mesh: BeamMesh) -> KnownMotion | None:
    """Read a motion of links with a mesh; None where there is none.

    Parameters
    ----------
    path
        The file.
    mesh
        The mesh of the links.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            turned, *others = (np.asarray(file[name], dtype=float) for name in PARTS)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
    widths = (3 * len(mesh.node_link),) * 2 + (len(mesh.cell),)
    fits = turned.ndim == 1 and all(part.shape == (len(turned), n) for part, n in zip(others, widths))
    return KnownMotion(mesh, turned, *others) if fits else None
