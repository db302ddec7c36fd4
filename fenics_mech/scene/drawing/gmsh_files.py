"""Drawings as they stand in files: nodes, lines, and what the physical groups are called."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech._files import read_bounded, reason_of
from fenics_mech.errors import SceneError
from fenics_mech.scene.drawing.script import check_script

FORMATS = {  # by ending: who reads it
    ".geo": "gmsh",
    ".msh": "gmsh",
    ".inp": "meshio",
    ".svg": "svgelements",
    ".dxf": "ezdxf",
}
READER = Path(__file__).with_name("reader.py")
THREADS = "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"  # each of which takes memory
NAME_GROUPS = (
    'Name the lines of each link, as in Physical Curve("crank") = {1}, and the joints: Physical Point("joint A")'
)


@dataclass(frozen=True)
class ReaderLimits:
    """Limits of what a drawing, which may come from a stranger, may be and take."""

    flat: float = 1e-9  # largest z, of the drawing's size
    largest_file: int = 20_000_000  # bytes; a drawing of 100,000 lines has 10 MB
    most_lines: int = 50_000  # measured: members are traced at 2,500 lines a second
    largest_answer: int = 100_000_000  # bytes, of nodes and groups
    patience: int = 30  # seconds for the reader
    memory: int = 1_500_000_000  # bytes of addresses for the reader
    corner: float = 1e-6  # rad, smallest angle between two lines that are two members
    coincident: float = 1e-9  # largest distance between the points of one pin, of the drawing's size


DRAWING = ReaderLimits()


@dataclass(frozen=True)
class Drawing:
    """A mechanism as it is drawn."""

    file: str  # its name, for errors
    nodes: Array  # places (m), ``(nodes, 2)``
    lines: Index  # nodes of the straight lines that belong to a group, ``(lines, 2)``
    line_group: tuple[str, ...]  # name of each line's group
    line_groups: tuple[str, ...]  # names of all groups of lines in the order of the drawing
    point_groups: dict[str, tuple[int, ...]]  # nodes of the named points by group, in the order of the drawing

    def error(self, message: str, hint: str = "") -> SceneError:
        """Make an error about this drawing."""
        return SceneError(f"{self.file}: {message}", place="drawing", hint=hint)

    def at(self, node: int) -> str:
        """Say where a node lies."""
        x, y = self.nodes[node]
        return f"({x:.6g}, {y:.6g}) m"


# nodes in the drawing's unit, ``(nodes, 3)``, nodes of lines, ``(lines, 2)``, and of points by group, other groups
Groups = tuple[Array, dict[str, Index], dict[str, Index], tuple[str, ...]]


def read_drawing(path: Path, unit: float = 1.0) -> Drawing:
    """Read a drawing (.geo, .msh, .inp, .svg, .dxf), whose unit is of a length (m)."""
    places, lines_of, points_of, others = _read(path)
    if not lines_of and not points_of:
        raise SceneError(f"{path.name} has no named physical groups", place="drawing", hint=NAME_GROUPS)
    if others:
        message = f"{path.name}: the physical group {others[0]!r} holds neither points nor straight lines"
        hint = (
            "Links are drawn as lines (elements of first order, Mesh.ElementOrder = 1); a plate as a triangle of lines"
        )
        raise SceneError(message, place="drawing", hint=hint)
    if not any(len(cells) for cells in lines_of.values()):
        raise SceneError(f"{path.name} has no lines in a named physical group", place="drawing", hint=NAME_GROUPS)
    lines = np.concatenate(list(lines_of.values()))
    if len(lines) > DRAWING.most_lines:
        message = f"{path.name} has {len(lines)} lines in named groups, and at most {DRAWING.most_lines} are taken"
        raise SceneError(message, place="drawing", hint="Mesh the curves with fewer elements")
    names = tuple(name for name, cells in lines_of.items() for _ in cells)
    points = {name: tuple(dict.fromkeys(nodes.tolist())) for name, nodes in points_of.items()}
    drawing = Drawing(path.name, unit * places[:, :2], lines, names, tuple(lines_of), points)
    _check_lines(drawing, unit * places[:, 2])
    return drawing


def _check_lines(drawing: Drawing, z: Array) -> None:
    """Raise where a line is drawn twice, has no length, or leaves the plane."""
    nodes, lines = drawing.nodes, drawing.lines
    named = [np.array(group, dtype=np.int64) for group in drawing.point_groups.values()]
    used = np.unique(np.concatenate([lines.ravel(), *named]))
    if used[0] < 0 or used[-1] >= len(nodes) or not np.isfinite(nodes[used]).all():
        raise drawing.error("a line or point has no place", "The mesh file is damaged")
    size = float(np.ptp(nodes[lines.ravel()], axis=0).max())
    if (away := used[np.abs(z[used]) > DRAWING.flat * size]).size:
        raise drawing.error(
            f"the point {drawing.at(away[0])} has z = {z[away[0]]:.6g} m",
            "A planar linkage is drawn in the plane z = 0",
        )
    short = np.linalg.norm(nodes[lines[:, 1]] - nodes[lines[:, 0]], axis=1) <= 1e-12 * size
    if short.any():
        i = int(np.flatnonzero(short)[0])
        raise drawing.error(
            f"a line of {drawing.line_group[i]!r} at {drawing.at(lines[i, 0])} has length 0", "Remove it"
        )
    seen: dict[tuple[int, int], str] = {}
    for (a, b), name in zip(lines.tolist(), drawing.line_group):
        other = seen.setdefault((min(a, b), max(a, b)), name)
        if other != name:
            where = f"{drawing.at(a)} to {drawing.at(b)}"
            raise drawing.error(f"the line from {where} is in two groups, {other!r} and {name!r}", "Keep it in one")
    if len(seen) < len(lines):
        raise drawing.error("a line is drawn twice", "Remove its double")


def _read(path: Path) -> Groups:
    """Read a file's groups in a process of its own; the file is one of a known format."""
    try:
        content = read_bounded(path, DRAWING.largest_file)
    except (OSError, ValueError) as error:
        hint = "The path is relative to the scene file's folder"
        raise SceneError(f"cannot read {path.name}: {reason_of(error)}", place="drawing", hint=hint) from error
    ending = path.suffix.lower()
    hint = "Draw the mechanism in gmsh (.geo, .msh), as a sketch (.svg, .dxf), or write its sets for Abaqus (.inp)"
    if ending not in FORMATS:
        raise SceneError(f"{path.name} is no drawing: its ending is {ending!r}", place="drawing", hint=hint)
    if ending == ".geo":
        try:
            check_script(content.decode("utf-8"), path.name)
        except UnicodeDecodeError as error:
            raise SceneError(f"{path.name} is not a gmsh script: it is not a UTF-8 text", place="drawing") from error
    try:
        return _read_in_own_process(content, ending)
    except ValueError as error:
        raise SceneError(f"{FORMATS[ending]} cannot read {path.name}: {error}", place="drawing", hint=hint) from error


def _read_in_own_process(content: bytes, ending: str) -> Groups:
    """Let `fenics_mech.scene.drawing.reader` read a copy: gmsh runs a script NAME.opt that lies beside a file NAME."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / f"drawing{ending}"
        copy.write_bytes(content)
        command = [sys.executable, "-P", str(READER), str(copy), str(DRAWING.memory), str(DRAWING.largest_answer)]
        alone = os.environ | {name: "1" for name in THREADS}
        try:
            done = subprocess.run(
                command,
                capture_output=True,
                cwd=folder,
                env=alone,
                timeout=DRAWING.patience,
                check=False,
                stdin=subprocess.DEVNULL,
            )
        except subprocess.TimeoutExpired as error:
            raise ValueError(f"it takes longer than {DRAWING.patience} s") from error
        if done.returncode:
            said = done.stderr.decode(errors="replace").strip().splitlines()
            raise ValueError(
                said[-1] if said and done.returncode == 1 else "the reader ended, out of memory or by a fault"
            )
        with np.load(copy.with_name("groups.npz"), allow_pickle=False) as found:
            lines, points, others = json.loads(str(found["names"]))
            lines_of = {name: found[f"lines{i}"] for i, name in enumerate(lines)}
            return found["nodes"], lines_of, {name: found[f"points{i}"] for i, name in enumerate(points)}, tuple(others)
