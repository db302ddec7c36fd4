"""Export of the mesh through meshio: the mechanism in the plane, with its physical groups."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.errors import ResultError
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene

FORMATS = {".msh": "gmsh", ".vtu": "vtu", ".xdmf": "xdmf"}


def plane_mesh(scene: Scene, mesh: BeamMesh, motion: Motion) -> meshio.Mesh:
    """Place the nodes in the fixed frame at the first angle of a motion; a physical group per member and per joint.

    Lines are grouped by member, points by joint, numbered from 1 in the order of the scene.
    """
    angle = motion.angle[0, mesh.node_link]
    c, s, (x, y) = np.cos(angle), np.sin(angle), mesh.node_xy.T
    turned = np.stack([c * x - s * y, s * x + c * y, np.zeros_like(x)], axis=-1)
    turned[:, :2] += motion.position[0, mesh.node_link]
    pins = [
        (number, mesh.node(point))
        for number, joint in enumerate(scene.joints.values(), 1)
        for point in joint.connect
        if not point.startswith("ground.")
    ]
    joint_number, joint_node = (np.array(column, dtype=np.int64) for column in zip(*pins))
    groups = [mesh.cell_member + 1, joint_number]
    return meshio.Mesh(
        turned,
        [("line", mesh.cell_nodes), ("vertex", joint_node[:, None])],
        cell_data={"gmsh:physical": groups, "gmsh:geometrical": groups},
        field_data={name: np.array([number, 1]) for number, name in enumerate(mesh.members, 1)}
        | {f"joint {name}": np.array([number, 0]) for number, name in enumerate(scene.joints, 1)},
    )


def write_mesh(mesh: meshio.Mesh, path: Path) -> None:
    """Write a mesh in the format of the file's ending.

    Raises
    ------
    ResultError
        When the ending is unknown or the file cannot be written.
    """
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
    joint = np.zeros(len(mesh.points), dtype=np.int64)
    joint[mesh.cells[1].data[:, 0]] = mesh.cell_data["gmsh:physical"][1]
    member = {"member": [mesh.cell_data["gmsh:physical"][0]]}
    return meshio.Mesh(mesh.points, mesh.cells[:1], point_data={"joint": joint}, cell_data=member)
