"""From lines in groups to links: members between corners and named points, and the pins between links."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene.drawing.gmsh_files import DRAWING, Drawing

NAME = r"[A-Za-z_][A-Za-z0-9_\-]*"
SLIDE = rf"slide[ _]({NAME})[ _](-?\d+(?:\.\d+)?)"


@dataclass(frozen=True)
class DrawnMember:
    """A straight member: its first and last node, and its nodes as numbers from 0 to 1 along it."""

    ends: tuple[int, int]
    stations: tuple[float, ...]


@dataclass(frozen=True)
class DrawnLink:
    """A link: its origin, its points by name, as nodes of the drawing, and its members by name."""

    origin: int
    points: dict[str, int]
    members: dict[str, DrawnMember]


@dataclass(frozen=True)
class Pin:
    """A joint: the links in it, in the order of the drawing, the node where it is, and whether the ground is in it.

    One that slides on the ground has the angle (deg) of its guide.
    """

    links: tuple[str, ...]
    node: int
    on_ground: bool
    guide: float | None = None


def trace(drawing: Drawing) -> tuple[dict[str, DrawnLink], dict[str, Pin]]:
    """Find the links and pins of a drawing, each by name."""
    cells: dict[str, list[int]] = {}
    for group in drawing.line_groups:
        if not re.fullmatch(rf"{NAME}(\.{NAME})?", group):
            raise drawing.error(f"a group of lines is named {group!r}", 'Name it "link" or "link.member"')
        cells.setdefault(group.split(".")[0], [])
    for i, group in enumerate(drawing.line_group):
        cells[group.split(".")[0]].append(i)
    ends = {link: {node for i in of_link for node in drawing.lines[i].tolist()} for link, of_link in cells.items()}
    named, pins = _points(drawing, ends)
    return {link: _trace_link(drawing, link, of_link, named[link]) for link, of_link in cells.items()}, pins


def _points(drawing: Drawing, ends: dict[str, set[int]]) -> tuple[dict[str, dict[str, int]], dict[str, Pin]]:
    """Points of each link by name, and the pins, out of the groups of points."""
    named: dict[str, dict[str, int]] = {link: {} for link in ends}
    pins: dict[str, Pin] = {}
    size = float(np.ptp(drawing.nodes, axis=0).max())
    for group, nodes in drawing.point_groups.items():
        slide = re.fullmatch(SLIDE, group)
        words = re.fullmatch(rf"(?:(joint|ground|point)[ _])?({NAME})", group)
        if not words and not slide:
            known = '"joint A", "ground O", "slide B 30" with the angle of its guide, or "point D"'
            raise drawing.error(f"a group of points is named {group!r}", f"Name it {known}")
        kind, name = ("slide", slide[1]) if slide else (words[1] or "joint", words[2]) if words else ("", "")
        if not nodes:
            raise drawing.error(f"the group {group!r} is empty")
        for node in nodes:
            links = [link for link, of_link in ends.items() if node in of_link]
            if not links:
                hint = "A named point is the end of a line; a line that goes through it must be cut in two there"
                raise drawing.error(f"the point of {group!r} at {drawing.at(node)} is no end of a link's line", hint)
            for link in links:
                if name in named[link]:
                    raise drawing.error(f"link {link!r} has two points named {name!r}", "Give each a name of its own")
                if node in named[link].values():
                    raise drawing.error(f"the point at {drawing.at(node)} has two names", "Keep it in one group")
                named[link][name] = node
        if kind != "point":
            links = [link for link, points in named.items() if points.get(name) in nodes]
            _check_pin(drawing, group, nodes, links, kind, size)
            pins[name] = Pin(tuple(links), nodes[0], kind != "joint", float(slide[2]) if slide else None)
    return named, pins


def _check_pin(drawing: Drawing, group: str, nodes: tuple[int, ...], links: list[str], kind: str, size: float) -> None:
    """Raise unless a pin's points lie together and it joins two bodies."""
    for node in nodes:
        if np.linalg.norm(drawing.nodes[node] - drawing.nodes[nodes[0]]) > DRAWING.coincident * size:
            where = f"{drawing.at(nodes[0])} and {drawing.at(node)}"
            raise drawing.error(f"the points of {group!r} lie apart, at {where}", "Draw the mechanism assembled")
    if kind == "slide" and len(links) > 1:
        hint = "A slider that joins links needs a block: draw it as a joint, and give block and guide in the scene file"
        raise drawing.error(f"{group!r} at {drawing.at(nodes[0])} joins {len(links)} links", hint)
    if kind == "joint" and len(links) < 2:
        name = group.rsplit(" ", maxsplit=1)[-1]
        raise drawing.error(
            f"{group!r} at {drawing.at(nodes[0])} joins only link {links[0]!r}",
            "Its links share a point, or all their points are in the group. A pin in the ground is named "
            f'"ground {name}", a point that is no pin "point {name}"',
        )


def _trace_link(drawing: Drawing, link: str, cells: list[int], named: dict[str, int]) -> DrawnLink:
    """Join the lines of a link to straight members, from corner to corner."""
    if not cells:
        raise drawing.error(f"the group of link {link!r} is empty")
    lines = {i: (int(drawing.lines[i, 0]), int(drawing.lines[i, 1])) for i in cells}
    meeting: dict[int, list[int]] = defaultdict(list)
    for i, line in lines.items():
        for node in line:
            meeting[node].append(i)
    _check_connected(drawing, link, lines, meeting)
    stops = set(named.values()) | {node for node, at in meeting.items() if _is_corner(drawing, lines, node, at)}
    chains: list[tuple[str, list[int]]] = []
    done: set[int] = set()
    for i in cells:
        if i not in done:
            chain, used = _chain(lines, meeting, stops, i)
            done |= used
            chains.append((drawing.line_group[i].partition(".")[2], chain))
    names = {node: name for name, node in reversed(named.items())}
    free = (name for k in range(1, len(meeting) + len(named) + 1) if (name := f"p{k}") not in named)
    for _, chain in chains:
        for node in (chain[0], chain[-1]):
            if node not in names:
                names[node] = next(free)
    members: dict[str, DrawnMember] = {}
    for own, chain in chains:
        alone = sum(name == own for name, _ in chains) == 1
        first, last = names[chain[0]], names[chain[-1]]
        name = own if own and alone else f"{own}-{first}-{last}".removeprefix("-")
        members[name] = DrawnMember((chain[0], chain[-1]), _stations(drawing.nodes[chain]))
    origin = next(iter(named.values()), chains[0][1][0])
    return DrawnLink(origin, named | {name: node for node, name in names.items() if name not in named}, members)


def _check_connected(
    drawing: Drawing, link: str, lines: dict[int, tuple[int, int]], meeting: dict[int, list[int]]
) -> None:
    """Raise when the lines of a link make several pieces."""
    start = next(iter(meeting))
    reached, edge = {start}, [start]
    while edge:
        new = {node for i in meeting[edge.pop()] for node in lines[i]} - reached
        reached |= new
        edge += new
    if separate := [node for node in meeting if node not in reached]:
        raise drawing.error(
            f"the lines of link {link!r} are not connected: "
            f"none leads from {drawing.at(start)} to {drawing.at(separate[0])}",
            "Lines that are welded share a point; two points in one place are not enough",
        )


def _is_corner(drawing: Drawing, lines: dict[int, tuple[int, int]], node: int, at: list[int]) -> bool:
    """Whether a member ends at a node: its lines are not two, not in one group, or not in one direction."""
    if len(at) != 2 or drawing.line_group[at[0]] != drawing.line_group[at[1]]:
        return True
    away = [drawing.nodes[sum(lines[i]) - node] - drawing.nodes[node] for i in at]
    before, after = (along / np.linalg.norm(along) for along in away)
    turn = abs(before[0] * after[1] - before[1] * after[0])
    return bool(turn > DRAWING.corner or before @ after > 0)


def _chain(
    lines: dict[int, tuple[int, int]], meeting: dict[int, list[int]], stops: set[int], start: int
) -> tuple[list[int], set[int]]:
    """Nodes of the member that a line belongs to, in the direction of that line, and the member's lines."""
    chain, used = list(lines[start]), {start}
    for forward in (True, False):
        while (node := chain[-1 if forward else 0]) not in stops:
            (ahead,) = (i for i in meeting[node] if i not in used)
            used.add(ahead)
            other = sum(lines[ahead]) - node
            chain = [*chain, other] if forward else [other, *chain]
    return chain, used


def _stations(places: Array) -> tuple[float, ...]:
    """Places of the nodes of a straight chain, 0 to 1 of its length."""
    along = places[-1] - places[0]
    s = (places - places[0]) @ along / (along @ along)
    return (0.0, *s[1:-1].tolist(), 1.0)
