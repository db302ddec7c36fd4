"""The mesh: one gmsh model in which every member is an interval of its own, in arc length.

Nodes are numbered link by link, so that the matrices in link axes are banded.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import gmsh
import numpy as np
from numpy.typing import NDArray

from fenics_mech import _fenicsx
from fenics_mech.scene import Member, Scene

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class BeamMesh:
    """The members of a scene cut into elements.

    Parameters
    ----------
    mesh
        The dolfinx mesh (gdim 1): the members lie one after the other on the x axis.
    members
        Labels of the members.
    member_link
        Link of each member, as index into the scene's links.
    member_angle, member_length
        Angle of each member's axis in its link's frame (rad) and its length (m).
    cell
        dolfinx index of each element; elements are ordered by member and along it.
    cell_flipped
        Whether the dolfinx cell runs from the element's second node to its first.
    cell_member, cell_nodes, cell_start, cell_length
        Member, nodes ``(elements, 2)``, and the arc length from the member's first point (m) of each element.
    node_link, node_xy
        Link of each node and its place in the link's frame (m).
    node_name
        "link.point", or "label@s" for nodes inside a member.
    """

    mesh: Any
    members: tuple[str, ...]
    member_link: Index
    member_angle: Array
    member_length: Array
    cell: Index
    cell_flipped: NDArray[np.bool_]
    cell_member: Index
    cell_nodes: Index
    cell_start: Array
    cell_length: Array
    node_link: Index
    node_xy: Array
    node_name: tuple[str, ...]

    def node(self, name: str) -> int:
        """Index of the node of that name."""
        return self.node_name.index(name)


def mesh_scene(scene: Scene) -> BeamMesh:
    """Mesh all members of a scene with gmsh and read them into dolfinx."""
    members = scene.members()
    axes = [np.subtract(*scene.member_ends(label)[::-1]) for label in members]
    angles, lengths = [np.arctan2(y, x) for x, y in axes], [float(np.hypot(x, y)) for x, y in axes]
    with _gmsh_model() as model:
        places = _draw(model, scene, lengths)
        model.mesh.generate(1)
        mesh, ends, groups = _fenicsx.line_mesh(model, places)
    order = np.argsort(ends.min(axis=1))
    ends, member_of = ends[order], groups[order] - 1
    offset = np.array([ends[member_of == i].min() for i in range(len(members))])
    nodes = _number_nodes(scene, member_of, (ends.max(axis=1) - offset[member_of]) / np.array(lengths)[member_of])
    return BeamMesh(
        mesh=mesh,
        members=tuple(members),
        member_link=np.array([list(scene.links).index(link) for link, _ in members.values()]),
        member_angle=np.array(angles),
        member_length=np.array(lengths),
        cell=order,
        cell_flipped=ends[:, 0] > ends[:, 1],
        cell_member=member_of,
        cell_start=ends.min(axis=1) - offset[member_of],
        cell_length=np.abs(ends[:, 1] - ends[:, 0]),
        **nodes,
    )


def _number_nodes(scene: Scene, cell_member: Index, cell_end: Array) -> dict[str, Any]:
    """Number the nodes along the members of each link; nodes at a link's points are shared by its members."""
    links: list[int] = []
    names: list[str] = []
    places: list[Array] = []
    known: dict[str, int] = {}
    cell_nodes = np.empty((len(cell_member), 2), dtype=np.int64)

    def node(name: str, link: str, place: Array) -> int:
        if name not in known:
            known[name] = len(names)
            names.append(name)
            links.append(list(scene.links).index(link))
            places.append(place)
        return known[name]

    for i, (label, (link, member)) in enumerate(scene.members().items()):
        first, second = (np.array(scene.links[link].points[end]) for end in member.ends)
        chain = [node(f"{link}.{member.ends[0]}", link, first)]
        cells = np.flatnonzero(cell_member == i)
        for s in cell_end[cells[:-1]]:
            chain.append(node(f"{label}@{s:.12g}", link, first + s * (second - first)))
        chain.append(node(f"{link}.{member.ends[1]}", link, second))
        cell_nodes[cells, 0], cell_nodes[cells, 1] = chain[:-1], chain[1:]
    return {
        "cell_nodes": cell_nodes,
        "node_link": np.array(links),
        "node_xy": np.array(places),
        "node_name": tuple(names),
    }


def stations(scene: Scene, member: Member) -> Array:
    """Nodes along a member, 0 to 1."""
    mesh = member.mesh or scene.mesh
    if mesh.stations is not None:
        return np.array(mesh.stations)
    lengths = mesh.grading ** np.arange(mesh.elements)
    return np.concatenate([[0.0], np.cumsum(lengths)[:-1] / lengths.sum(), [1.0]])


@contextmanager
def _gmsh_model() -> Iterator[Any]:
    """Open a gmsh model of our own and leave gmsh as it was found."""
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


def _draw(model: Any, scene: Scene, lengths: list[float]) -> Array:
    """Draw the members one after the other on the x axis; a physical group per member and per joint.

    Gives the x of all nodes that the mesh will have.
    """
    geometry, x, groups, nodes = model.geo, 0.0, [], []
    ends: dict[str, list[int]] = {}
    for length, (link, member) in zip(lengths, scene.members().values()):
        mesh = member.mesh or scene.mesh
        graded = mesh.stations is None
        places = np.array([0.0, 1.0]) if graded else stations(scene, member)
        points = [geometry.addPoint(x + length * s, 0, 0) for s in places]
        curves = [geometry.addLine(a, b) for a, b in pairwise(points)]
        for curve in curves:
            geometry.mesh.setTransfiniteCurve(curve, (mesh.elements if graded else 1) + 1, "Progression", mesh.grading)
        groups.append(curves)
        nodes.append(x + length * stations(scene, member))
        for end, point in zip(member.ends, (points[0], points[-1])):
            ends.setdefault(f"{link}.{end}", []).append(point)
        x += 2 * length  # the gap keeps the members apart
    geometry.synchronize()
    for tag, (label, curves) in enumerate(zip(scene.members(), groups), 1):
        model.addPhysicalGroup(1, curves, tag, name=label)
    for name, joint in scene.joints.items():
        points = [point for end in joint.connect for point in ends.get(end, [])]
        model.addPhysicalGroup(0, points, name=name)
    return np.concatenate(nodes)
