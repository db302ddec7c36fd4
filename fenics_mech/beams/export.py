"""Export of the mesh through meshio: the mechanism in the plane, with its physical groups."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np

from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.errors import ResultError
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Link
from fenics_mech.scene.joints import Joint

FORMATS = {".msh": "gmsh", ".vtu": "vtu", ".xdmf": "xdmf"}


def plane_mesh(links: Mapping[str, Link], joints: Mapping[str, Joint], mesh: BeamMesh, motion: Motion) -> meshio.Mesh:
    """Place the nodes in the fixed frame at the first angle of a motion, with the physical groups of a drawing."""
    # Lines are grouped by member, numbered from 1. Points are grouped by joint, numbered from 1 in the order of the
    # scene, and then by name where they are in no joint. `fenics_mech.scene.drawing` says what the groups' names mean
    # and reads the mesh back. Rigid links are not drawn.
    angle = motion.angle[0, mesh.node_link]
    c, s, (x, y) = np.cos(angle), np.sin(angle), mesh.node_xy.T
    turned = np.stack([c * x - s * y, s * x + c * y, np.zeros_like(x)], axis=-1)
    turned[:, :2] += motion.position[0, mesh.node_link]
    points = _point_groups(links, joints)
    joined = [(number, mesh.node(point)) for number, of_group in enumerate(points.values(), 1) for point in of_group]
    point_number, point_node = (np.array(column, dtype=np.int64) for column in zip(*joined))
    groups = [mesh.cell_member + 1, point_number]
    return meshio.Mesh(
        turned,
        [("line", mesh.cell_nodes), ("vertex", point_node[:, None])],
        cell_data={"gmsh:physical": groups, "gmsh:geometrical": groups},
        field_data={name: np.array([number, 1]) for number, name in enumerate(mesh.members, 1)}
        | {name: np.array([number, 0]) for number, (name, at) in enumerate(points.items(), 1) if at},
    )


def _point_groups(links: Mapping[str, Link], joints: Mapping[str, Joint]) -> dict[str, list[str]]:
    """Points of the links that bend, as "link.point", by the name of their group; the joints come first."""
    bends = [name for name, link in links.items() if link.members]
    groups: dict[str, list[str]] = {}
    jointed = set()
    for name, joint in joints.items():
        bodies = {point.split(".")[0] for point in joint.connect}
        here = [point for point in joint.connect if point.split(".")[0] in bends]
        kind = "ground" if "ground" in bodies else "joint"
        groups[f"{kind if joint.kind == 'revolute' and bodies <= {*bends, 'ground'} else 'point'} {name}"] = here
        jointed.update(here)
    for name in bends:
        for point in links[name].points:
            if f"{name}.{point}" not in jointed:
                groups.setdefault(f"point {point}", []).append(f"{name}.{point}")
    return groups


def write_mesh(mesh: meshio.Mesh, path: Path) -> None:
    """Write a mesh in the format of the file's ending."""
    if path.suffix not in FORMATS:
        raise ResultError(f"{path}: unknown mesh format {path.suffix!r}; known are {', '.join(FORMATS)}")
    try:
        if path.suffix == ".msh":
            meshio.gmsh.write(path, mesh, fmt_version="2.2", binary=False)
        else:
            options = {"data_format": "XML"} if path.suffix == ".xdmf" else {}
            _lines_only(mesh).write(path, file_format=FORMATS[path.suffix], **options)
    except OSError as error:
        raise ResultError(f"{path}: cannot be written: {error.strerror}") from error


def _lines_only(mesh: meshio.Mesh) -> meshio.Mesh:
    """Turn the points' groups into point data, for formats and viewers that take one kind of cell."""
    point = np.zeros(len(mesh.points), dtype=np.int64)
    point[mesh.cells[1].data[:, 0]] = mesh.cell_data["gmsh:physical"][1]
    member = {"member": [mesh.cell_data["gmsh:physical"][0]]}
    return meshio.Mesh(mesh.points, mesh.cells[:1], point_data={"point": point}, cell_data=member)
