"""Reads a drawing: a script for a process of its own, as its file may take any time and memory, or crash its reader.

``python reader.py DRAWING MEMORY FILE_SIZE`` writes the nodes and named groups into ``groups.npz`` beside the drawing.
It imports no room of the package, so that it starts fast. What goes wrong is its last line on stderr.
"""

from __future__ import annotations

import io
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech._sketches import groups_of_sketch
from fenics_mech._system import limit_process

Found = tuple[Array, dict[str, Index], dict[str, Index], list[str]]  # nodes, lines, points, other groups
SCRIPT, MESH, ABAQUS = ".geo", ".msh", ".inp"
SKETCHES = ".svg", ".dxf"
NOT_GMSH = "it does not begin with $MeshFormat"
INCLUDES = "it includes another file (*INCLUDE); a drawing is one file"


def main() -> None:
    """Read the drawing that the command names."""
    path = Path(sys.argv[1])
    limit_process(int(sys.argv[2]), int(sys.argv[3]))
    try:
        nodes, lines, points, others = _found(path)
    except MemoryError:
        sys.exit("it takes too much memory")
    except Exception as error:  # gmsh raises nothing more special, and meshio whatever it stumbles over
        sys.exit(" ".join(str(error).split())[:200] or "no reason is known, or it takes too much memory")
    names = np.array(json.dumps([list(lines), list(points), others]))
    groups: dict[str, Any] = {f"lines{i}": cells for i, cells in enumerate(lines.values())}
    groups |= {f"points{i}": cells for i, cells in enumerate(points.values())}
    np.savez(path.with_name("groups.npz"), names=names, nodes=nodes, **groups)


def _found(path: Path) -> Found:
    """Read a file with the program that knows its format."""
    if path.suffix in SKETCHES:
        return groups_of_sketch(path)
    if path.suffix == ABAQUS:
        return _from_meshio(path)
    with path.open("rb") as file:
        first = file.read(64)
    if path.suffix == MESH and not first.startswith(b"$MeshFormat\n"):
        raise ValueError(NOT_GMSH)
    if path.suffix == MESH and not first.split(b"\n")[1].startswith(b"4"):
        return _from_meshio(path)
    return _from_gmsh(path)


def _from_gmsh(path: Path) -> Found:
    """Let gmsh read a script, which it then meshes, or a mesh."""
    import gmsh  # noqa: PLC0415  (only one of the two readers is needed)

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Verbosity", 0)
    try:
        gmsh.merge(str(path))
        if path.suffix == SCRIPT:
            gmsh.model.mesh.generate(1)
    except Exception as error:
        raise ValueError(str(error).replace(f"'{path}', ", "").replace(str(path), "the drawing")) from error
    return _gmsh_groups(gmsh.model)


def _gmsh_groups(model: Any) -> Found:
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
    return nodes, found[1], {name: cells[:, 0] for name, cells in found[0].items()}, others


def _from_meshio(path: Path) -> Found:
    """Let meshio read a mesh; it complains by printing and leaving."""
    import meshio  # noqa: PLC0415

    with redirect_stdout(io.StringIO()) as said, redirect_stderr(said):
        try:
            mesh = meshio.gmsh.read(path) if path.suffix == MESH else meshio.abaqus.read(_without_includes(path))
            plane = np.asarray(mesh.points, dtype=float).reshape(len(mesh.points), -1)[:, :3]
            nodes = np.pad(plane, ((0, 0), (0, 3 - plane.shape[1])))
        except SystemExit as error:
            raise ValueError(said.getvalue()) from error
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
    return nodes, _joined(lines), _joined(points), others


def _without_includes(path: Path) -> Path:
    """Give the path of an Abaqus file that names no other; its keywords are found as meshio finds them."""
    for line in path.read_text("utf-8").splitlines():
        if line.partition(",")[0].replace("*", "").strip().upper() == "INCLUDE":
            raise ValueError(INCLUDES)
    return path


def _joined(groups: dict[str, list[Index]]) -> dict[str, Index]:
    return {name: np.concatenate(parts) for name, parts in groups.items()}


def _named_cells(mesh: Any) -> list[tuple[str, str, Index]]:
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


if __name__ == "__main__":
    main()
