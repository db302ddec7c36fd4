"""The mesh: one gmsh model in which every member is an interval of its own, in arc length.

Nodes are numbered link by link, so that the matrices in link axes are banded.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech import _fenicsx, _gmsh
from fenics_mech._arrays import Array, Index
from fenics_mech.beams.made_once import MadeOnce
from fenics_mech.errors import SceneError
from fenics_mech.scene import Link, Member, Scene
from fenics_mech.scene.meshing import member_nodes


@dataclass(frozen=True)
class BeamMesh(MadeOnce):
    """The members of a scene cut into elements."""

    mesh: Any  # the dolfinx mesh (gdim 1): the members lie one after the other on the x axis
    members: tuple[str, ...]  # labels of the members
    member_link: Index  # link of each member, as index into the scene's links
    member_angle: Array  # angle of each member's axis in its link's frame (rad) and its length (m)
    member_length: Array
    cell: Index  # dolfinx index of each element; elements are ordered by member and along it
    cell_flipped: NDArray[np.bool_]  # whether the dolfinx cell runs from the element's second node to its first
    # member, nodes (elements, 2), and the arc length from the member's first point (m) of each element
    cell_member: Index
    cell_nodes: Index
    cell_start: Array
    cell_length: Array
    node_link: Index  # link of each node and its place in the link's frame (m)
    node_xy: Array
    # "link.point", "label@s" for nodes inside a member, and "link.centre" for a rigid link, which has one node
    node_name: tuple[str, ...]
    other_names: Mapping[str, str]  # by "link.point" of a point that is no member's end: that of the end at its place

    def node(self, name: str) -> int:
        """Index of the node of that name."""
        return self._index[name]

    @cached_property
    def space(self) -> Any:
        """The broken space of Euler and Bernoulli's beams: linear along the axis, cubic across it."""
        return _fenicsx.broken_space(self.mesh, (1, 3))

    @cached_property
    def constants(self) -> Any:
        """The space of one number for each cell."""
        return _fenicsx.broken_line(self.mesh, 0)

    @cached_property
    def _index(self) -> dict[str, int]:
        index = {name: i for i, name in enumerate(self.node_name)}
        return index | {other: index[name] for other, name in self.other_names.items()}


def mesh_scene(scene: Scene, loads_at_nodes: bool = False) -> BeamMesh:
    """Mesh all members of a scene with gmsh and read them into dolfinx."""
    members = scene.members()
    if not members:
        raise SceneError(
            "no link has a member: there is nothing that bends",
            place="links",
            hint="Rigid links move by method = 'transient', or with a drive by 'quasi-static' or 'periodic'",
        )
    points = {link: {name: np.array(at) for name, at in body.points.items()} for link, body in scene.links.items()}
    axes = [points[link][member.ends[1]] - points[link][member.ends[0]] for link, member in members.values()]
    angles, lengths = [np.arctan2(y, x) for x, y in axes], np.array([np.hypot(x, y) for x, y in axes])
    stations = [member_nodes(scene, label, loads_at_nodes) for label in members]
    start = 2 * (np.cumsum(lengths) - lengths)  # of each member on the x axis; the gaps separate the members
    with _gmsh.model() as model:
        _draw(model, [x + length * s for x, length, s in zip(start, lengths, stations)])
        mesh, ends, groups = _fenicsx.line_mesh(model)
    order = np.argsort(ends.min(axis=1))
    ends, member_of = ends[order], groups[order] - 1
    links = {name: i for i, name in enumerate(scene.links)}
    return BeamMesh(
        mesh=mesh,
        members=tuple(members),
        member_link=np.array([links[link] for link, _ in members.values()]),
        member_angle=np.array(angles),
        member_length=lengths,
        cell=order,
        cell_flipped=ends[:, 0] > ends[:, 1],
        cell_member=member_of,
        cell_start=ends.min(axis=1) - start[member_of],
        cell_length=np.abs(ends[:, 1] - ends[:, 0]),
        other_names={
            f"{name}.{point}": f"{name}.{end}"
            for name, link in scene.links.items()
            for point in (link.points if link.members else ())
            if (end := link.end_at(point)) != point
        },
        **_number_nodes(scene.links, members, stations),
    )


def _draw(model: Any, places: list[Array]) -> None:
    """Give gmsh the members as curves on the x axis with the nodes they shall have; a physical group per member."""
    before = 0
    for tag, x in enumerate(places, 1):
        nodes = np.arange(before + 1, before + len(x) + 1)
        before += len(x)
        model.addDiscreteEntity(1, tag)
        model.mesh.addNodes(1, tag, nodes, np.pad(x[:, None], ((0, 0), (0, 2))).ravel())
        model.mesh.addElementsByType(tag, 1, [], np.stack([nodes[:-1], nodes[1:]], axis=1).ravel())
        model.addPhysicalGroup(1, [tag], tag)


def _number_nodes(
    bodies: Mapping[str, Link], members: Mapping[str, tuple[str, Member]], stations: list[Array]
) -> dict[str, Any]:
    """Number the nodes along the members of each link; nodes at a link's points are shared by its members."""
    links: list[int] = []
    places: list[Array] = []
    known: dict[str, int] = {}
    cell_nodes = []

    def node(name: str, link: int, place: Array) -> int:
        if name not in known:
            known[name] = len(known)
            links.append(link)
            places.append(place)
        return known[name]

    index = {name: i for i, name in enumerate(bodies)}
    for (label, (link, member)), s in zip(members.items(), stations):
        first, second = (np.array(bodies[link].points[end]) for end in member.ends)
        chain = [node(f"{link}.{member.ends[0]}", index[link], first)]
        chain += [node(f"{label}@{x:.12g}", index[link], first + x * (second - first)) for x in s[1:-1]]
        chain.append(node(f"{link}.{member.ends[1]}", index[link], second))
        cell_nodes.append(np.stack([chain[:-1], chain[1:]], axis=1))
    for link, body in bodies.items():
        if body.rigid is not None:
            node(f"{link}.centre", index[link], np.array(body.rigid.centre))
    return {
        "cell_nodes": np.concatenate(cell_nodes),
        "node_link": np.array(links),
        "node_xy": np.array(places),
        "node_name": tuple(known),
    }
