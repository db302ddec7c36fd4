"""Drawings as they stand in files: nodes, lines, and what the physical groups are called."""

from __future__ import annotations

import io
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import meshio
import numpy as np
from numpy.typing import NDArray

from fenics_mech import _gmsh
from fenics_mech._files import read_bounded, reason_of
from fenics_mech.errors import SceneError
from fenics_mech.scene.drawing.script import check_script

Array = NDArray[np.float64]
Index = NDArray[np.int64]
FLAT = 1e-9  # largest z, of the drawing's size
LARGEST_FILE = 100_000_000  # bytes
NAME_GROUPS = (
    'Name the lines of each link, as in Physical Curve("crank") = {1}, and the joints: Physical Point("joint A")'
)


@dataclass(frozen=True)
class Drawing:
    """A mechanism as it is drawn.

    Parameters
    ----------
    file
        Name of the file, for errors.
    nodes
        Places (m), ``(nodes, 2)``.
    lines
        Nodes of the straight lines that belong to a group, ``(lines, 2)``.
    line_group
        Name of each line's group.
    line_groups
        Names of all groups of lines in the order of the drawing.
    point_groups
        Nodes of the named points by group, in the order of the drawing.
    """

    file: str
    nodes: Array
    lines: Index
    line_group: tuple[str, ...]
    line_groups: tuple[str, ...]
    point_groups: dict[str, tuple[int, ...]]

    def error(self, message: str, hint: str = "") -> SceneError:
        """Make an error about this drawing."""
        return SceneError(f"{self.file}: {message}", place="drawing", hint=hint)

    def at(self, node: int) -> str:
        """Say where a node lies."""
        x, y = self.nodes[node]
        return f"({x:.6g}, {y:.6g}) m"


@dataclass(frozen=True)
class Groups:
    """The contents of a file.

    Parameters
    ----------
    nodes
        Places in the drawing's unit, ``(nodes, 3)``.
    lines, points
        Nodes of the lines, ``(lines, 2)``, and points, ``(points,)``, of each group by name.
    others
        Names of groups of something else than points and straight lines.
    """

    nodes: Array
    lines: dict[str, Index]
    points: dict[str, Index]
    others: tuple[str, ...] = ()


def read_drawing(path: Path, unit: float = 1.0) -> Drawing:
    """Read a drawing.

    Parameters
    ----------
    path
        A gmsh script (.geo), a gmsh mesh (.msh), or a file that meshio reads.
    unit
        Length of the drawing's unit (m).

    Raises
    ------
    SceneError
        When the file cannot be read, or holds no lines in named groups.
    """
    groups = _read(path)
    if not groups.lines and not groups.points:
        raise SceneError(f"{path.name} has no named physical groups", place="drawing", hint=NAME_GROUPS)
    if groups.others:
        message = f"{path.name}: the physical group {groups.others[0]!r} holds neither points nor straight lines"
        hint = (
            "Links are drawn as lines (elements of first order, Mesh.ElementOrder = 1); a plate as a triangle of lines"
        )
        raise SceneError(message, place="drawing", hint=hint)
    if not any(len(cells) for cells in groups.lines.values()):
        raise SceneError(f"{path.name} has no lines in a named physical group", place="drawing", hint=NAME_GROUPS)
    lines = np.concatenate(list(groups.lines.values()))
    names = tuple(name for name, cells in groups.lines.items() for _ in cells)
    points = {name: tuple(dict.fromkeys(nodes.tolist())) for name, nodes in groups.points.items()}
    drawing = Drawing(path.name, unit * groups.nodes[:, :2], lines, names, tuple(groups.lines), points)
    _check_lines(drawing, unit * groups.nodes[:, 2])
    return drawing


def _check_lines(drawing: Drawing, z: Array) -> None:
    """Raise where a line is drawn twice, has no length, or leaves the plane."""
    nodes, lines = drawing.nodes, drawing.lines
    named = [np.array(group, dtype=np.int64) for group in drawing.point_groups.values()]
    used = np.unique(np.concatenate([lines.ravel(), *named]))
    if used[0] < 0 or used[-1] >= len(nodes) or not np.isfinite(nodes[used]).all():
        raise drawing.error("a line or point has no place", "The mesh file is damaged")
    size = float(np.ptp(nodes[lines.ravel()], axis=0).max())
    if (away := used[np.abs(z[used]) > FLAT * size]).size:
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
    """Read a file's groups with the program that knows its format."""
    try:
        content = read_bounded(path, LARGEST_FILE)
    except (OSError, ValueError) as error:
        hint = "The path is relative to the scene file's folder"
        raise SceneError(f"cannot read {path.name}: {reason_of(error)}", place="drawing", hint=hint) from error
    if path.suffix.lower() == ".geo":
        try:
            text = content.decode("utf-8")
        except UnicodeDecodeError as error:
            raise SceneError(f"{path.name} is not a gmsh script: it is not a UTF-8 text", place="drawing") from error
        check_script(text, path.name)
        return _from_gmsh(text.encode(), path.name, ".geo")
    if path.suffix.lower() == ".msh":
        version = content[:64].split(b"\n")[1:2] if content.startswith(b"$MeshFormat") else []
        if not version:
            raise SceneError(f"{path.name} is not a gmsh mesh: it does not begin with $MeshFormat", place="drawing")
        if version[0].startswith(b"4"):
            return _from_gmsh(content, path.name, ".msh")
    return _from_meshio(path)


def _from_gmsh(content: bytes, name: str, ending: str) -> Groups:
    """Let gmsh read a script, which it then meshes, or a mesh of version 4."""
    with tempfile.TemporaryDirectory() as folder, _gmsh.model() as model:
        # a copy under a name of our own, since gmsh also runs a script NAME.opt that lies beside the file
        copy = Path(folder) / f"drawing{ending}"
        copy.write_bytes(content)
        try:
            _gmsh.merge(_gmsh.meshed(copy) if ending == ".geo" else copy)
        except Exception as error:  # gmsh raises nothing more special
            message = str(error).replace(f"'{copy}', ", "").replace(str(copy), name)
            raise SceneError(f"gmsh cannot read {name}: {message}", place="drawing") from error
        return _gmsh_groups(model)


def _gmsh_groups(model: Any) -> Groups:
    """Take nodes and groups out of a meshed gmsh model."""
    tags, xyz, _ = model.mesh.getNodes()
    order = np.argsort(tags)
    tags, nodes = tags[order], xyz.reshape(-1, 3)[order]
    found: dict[int, dict[str, Index]] = {0: {}, 1: {}}
    others = []
    for dim, number in model.getPhysicalGroups():
        name = model.getPhysicalName(dim, number) or f"{number} (without a name)"
        cells = [np.empty((0, dim + 1), dtype=np.int64)]
        for entity in model.getEntitiesForPhysicalGroup(dim, number):
            for kind, _, ends in zip(*model.mesh.getElements(dim, entity)):
                if kind in (1, 15):  # line and point of first order
                    at = np.searchsorted(tags, ends)
                    known = np.append(tags, 0)[at] == ends
                    cells.append(np.where(known, at, -1).reshape(-1, dim + 1))
                else:
                    others.append(name)
        if dim < 2:
            found[dim][name] = np.concatenate(cells)
        else:
            others.append(name)
    return Groups(nodes, found[1], {name: cells[:, 0] for name, cells in found[0].items()}, tuple(others))


def _from_meshio(path: Path) -> Groups:
    """Let meshio read a mesh; it complains by printing and leaving."""
    with redirect_stdout(io.StringIO()) as said, redirect_stderr(said):
        try:
            mesh = meshio.gmsh.read(path) if path.suffix.lower() == ".msh" else meshio.read(path)
            plane = np.asarray(mesh.points, dtype=float).reshape(len(mesh.points), -1)[:, :3]
            nodes = np.pad(plane, ((0, 0), (0, 3 - plane.shape[1])))
        except (Exception, SystemExit) as error:  # whatever its many readers stumble over
            reason = " ".join((said.getvalue() or ("" if isinstance(error, SystemExit) else str(error))).split())
            hint = "Draw the mechanism in gmsh (.geo, .msh), or in a format that meshio reads"
            message = f"{path.name} is not a mesh that can be read" + (f": {reason[:200]}" if reason else "")
            raise SceneError(message, place="drawing", hint=hint) from error
    lines: dict[str, list[Index]] = {}
    points: dict[str, list[Index]] = {name: [np.asarray(at, dtype=np.int64)] for name, at in mesh.point_sets.items()}
    others = []
    for name, kind, cells in _named_cells(mesh):
        if kind == "line":
            lines.setdefault(name, []).append(cells.astype(np.int64))
        elif kind == "vertex":
            points.setdefault(name, []).append(cells[:, 0].astype(np.int64))
        else:
            others.append(name)
    return Groups(nodes, _joined(lines), _joined(points), tuple(others))


def _joined(groups: dict[str, list[Index]]) -> dict[str, Index]:
    return {name: np.concatenate(parts) for name, parts in groups.items()}


def _named_cells(mesh: meshio.Mesh) -> list[tuple[str, str, Index]]:
    """Name, kind and nodes of all cells in groups of a mesh, group by group."""
    named = []
    if "gmsh:physical" in mesh.cell_data:
        dims = {(int(dim), int(number)): name for name, (number, dim) in mesh.field_data.items()}
        for block, numbers in zip(mesh.cells, mesh.cell_data["gmsh:physical"]):
            for number in sorted(set(numbers.tolist()) - {0}):
                name = dims.get((block.dim, number), f"{number} (without a name)")
                named.append((number, name, block.type, block.data[numbers == number]))
        return [entry[1:] for entry in sorted(named, key=lambda entry: entry[0])]
    for name, parts in mesh.cell_sets.items():
        for block, part in zip(mesh.cells, parts):
            if part is not None and len(part):
                named.append((0, name, block.type, block.data[np.asarray(part, dtype=np.int64)]))
    return [entry[1:] for entry in named]
