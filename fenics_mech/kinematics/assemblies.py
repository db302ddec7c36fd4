"""Search for all ways in which a linkage can be assembled, where rough angles lead to none.

The loop equations fall into groups that are closed one after the other, each with a few unknowns: those of Assur. They
are the blocks of the triangular form of the Jacobian's pattern. In each group Newton's method starts from many angles.

Source: Duff and Reid, An implementation of Tarjan's algorithm for the block triangularization of a matrix, ACM
Transactions on Mathematical Software 4 (1978).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.kinematics.assembly import ASSEMBLY, newton
from fenics_mech.kinematics.loops import Loops

Group = tuple[Index, Index]  # rows and columns of the Jacobian


@dataclass(frozen=True)
class SearchLimits:
    """Limits of the search for assemblies."""

    starts: int = 16  # of a group with one unknown angle; each further angle doubles them
    most_starts: int = 512  # of a group
    iterations: int = 60  # of Newton's method: 10 to 25 where it converges
    longest_step: float = 0.5  # rad
    smallest: float = 1e-9  # of the largest singular value: directions that a group leaves free
    most_kept: int = 16  # assemblies that are followed from group to group, the nearest to the rough angles
    same: float = 1e-5  # rad, or of the linkage's size: at a dead centre two assemblies are one to half the digits
    at_once: int = 1024  # positions of which the Jacobian is held


SEARCH = SearchLimits()


@dataclass(frozen=True)
class Assemblies:
    """What a search found."""

    q: Array  # coordinates of every assembly, the nearest to the rough angles first, (assemblies, 3 links)
    rest: Array  # coordinates that leave the least open, where there is none, (3 links,)
    joints: frozenset[str] = frozenset()  # joints one of which stays open then


def every_assembly(loops: Loops, rough: Array, drive: Array) -> Assemblies:
    """Search for the assemblies of a linkage where its drives are held."""
    # rough (3 links,); drive (drives,)
    found, unsolved = rough[None], np.ones(len(rough), dtype=bool)
    for rows, columns in _groups(loops):
        unsolved[columns] = False
        starts = _starts(loops, found, columns)
        tried, left = zip(*(_closed(loops, part, drive, rows, columns) for part in starts))
        ends, open_by = np.concatenate(tried), np.concatenate(left)
        found = _apart(loops, ends[open_by < ASSEMBLY.closed_coarsely], rough)[: SEARCH.most_kept]
        if not len(found):
            rest = ends[open_by.argmin()]
            later = (np.abs(loops.without_units(rest[None])[0][:, unsolved]) > SEARCH.smallest).any(axis=1)
            return Assemblies(found, rest, frozenset(name for name, wait in zip(loops.names, later) if not wait))
    polished, closed = newton(loops, found, np.tile(drive, (len(found), 1)), iterations=100, damped=True)
    found = _apart(loops, polished[closed], rough)
    return Assemblies(found if len(loops.names) >= len(rough) else found[:1], rough)


def _groups(loops: Loops) -> list[Group]:
    """Equations and unknowns that are solved together, in the order in which they are solved."""
    from scipy.sparse import csr_matrix  # noqa: PLC0415  (slow to import, and few linkages are searched)
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching  # noqa: PLC0415

    anywhere = np.random.default_rng(0).uniform(-1.0, 1.0, 3 * len(loops.links)) * loops.unit
    pattern = np.abs(loops.without_units(anywhere[None])[0]) > SEARCH.smallest
    rows, columns = np.arange(pattern.shape[0]), np.arange(pattern.shape[1])
    solved_for = maximum_bipartite_matching(csr_matrix(pattern), perm_type="column")  # unknown of each equation
    if len(rows) != len(columns) or (solved_for < 0).any():  # held too often, or too seldom
        return [(rows, columns)]
    count, label = connected_components(csr_matrix(pattern[:, solved_for]), connection="strong")
    needs = np.zeros((count, count), dtype=bool)
    np.logical_or.at(needs, (label[:, None], label[None, :]), pattern[:, solved_for])
    np.fill_diagonal(needs, False)
    order: list[int] = []
    while len(order) < count:
        ready = [k for k in range(count) if k not in order and set(np.flatnonzero(needs[k])) <= set(order)]
        order += ready
    return [(np.flatnonzero(label == k), np.sort(solved_for[label == k])) for k in order]


def _starts(loops: Loops, found: Array, columns: Index) -> Iterator[Array]:
    """Coordinates to begin from, a block at a time: each found position with its group's links at many angles."""
    angles = columns[columns % 3 == 2]
    count = min(SEARCH.starts * 2 ** (len(angles) - 1), SEARCH.most_starts) if len(angles) else 1
    # an additive recurrence, which spreads evenly over a cube: Roberts, The unreasonable effectiveness of
    # quasirandom sequences (2018); its base is the root above 1 of x^(n + 1) = x + 1
    base = 2.0
    for _ in range(30):
        base = (1 + base) ** (1 / (len(angles) + 1))
    turns = np.arange(count)[:, None] * base ** -np.arange(1.0, len(angles) + 1) % 1.0
    starts = np.repeat(found, count, axis=0)
    starts[:, angles] += np.tile(np.remainder(2 * np.pi * turns + np.pi, 2 * np.pi) - np.pi, (len(found), 1))
    for first in range(0, len(starts), SEARCH.at_once):
        yield starts[first : first + SEARCH.at_once]


def _closed(loops: Loops, q: Array, drive: Array, rows: Index, columns: Index) -> tuple[Array, Array]:
    """Close a group from many starts by least squares: coordinates, and what stays open without units."""
    q, unit = q.copy(), loops.unit[columns]
    given = np.tile(drive, (len(q), 1))
    turns = 1 + np.abs(drive).max(initial=0.0)
    places = columns % 3 != 2

    def left_open() -> Array:
        return loops.residual(q, given)[:, rows] / loops.scale[rows]

    for iteration in range(SEARCH.iterations):
        residual = left_open()
        active = np.abs(residual).max(axis=1) > ASSEMBLY.closed * turns
        if not active.any():
            break
        jacobian = loops.without_units(q[active])[:, rows][:, :, columns]
        if iteration == 0 and places.any():  # equations are linear in places: at first only these move
            jacobian = jacobian * places
        step = -(np.linalg.pinv(jacobian, rcond=SEARCH.smallest) @ residual[active][..., None])[..., 0]
        largest = np.abs(step[:, ~places]).max(axis=1, initial=0.0)
        step *= np.minimum(1.0, SEARCH.longest_step / np.maximum(largest, 1e-300))[:, None]
        q[np.ix_(active, columns)] += step * unit
    return q, np.abs(left_open()).max(axis=1)


def _apart(loops: Loops, q: Array, rough: Array) -> Array:
    """Positions without those that are there already, the nearest to the rough angles first."""
    q = _unwound(loops, q, rough)
    order = sorted(range(len(q)), key=lambda i: nearness(loops, q[i], rough))
    kept: list[Array] = []
    for place in q[order]:
        if not any(same(loops, place, other) for other in kept):
            kept.append(place)
    return np.array(kept).reshape(-1, len(rough))


def nearness(loops: Loops, q: Array, rough: Array) -> tuple[float, ...]:
    """How far the links are from their rough angles, by which assemblies are ordered."""
    # q, rough (3 links,) each
    away = np.remainder((q - rough)[2::3] + np.pi, 2 * np.pi) - np.pi
    stated = [link.position is not None for link in loops.scene.links.values()]
    moved = ((q - rough) / loops.unit).reshape(-1, 3)[stated, :2]
    return round(float((away**2).sum() + (moved**2).sum()), 6), *(-away.round(6)).tolist()


def same(loops: Loops, q: Array, other: Array) -> bool:
    """Whether two positions are one, but for whole turns."""
    # q, other (3 links,) each
    apart = (q - other) / loops.unit
    apart[2::3] = np.remainder(apart[2::3] + np.pi, 2 * np.pi) - np.pi
    return bool(np.abs(apart).max(initial=0.0) < SEARCH.same)


def _unwound(loops: Loops, q: Array, rough: Array) -> Array:
    """Take whole turns off links, and off those together of which an equation gives the angle between them."""
    q, bodies = q.copy(), np.concatenate([loops.angles.body, loops.driven_angles.body])
    group = np.arange(len(loops.links) + 1)  # the ground is the last
    for _ in group:
        for a, b in bodies:
            group[group == group[b]] = group[a]
    for name in set(group.tolist()) - {int(group[-1])}:
        links = np.flatnonzero(group[:-1] == name)
        whole = np.round((q - rough)[:, 3 * links[0] + 2] / (2 * np.pi))
        q[:, 3 * links + 2] -= 2 * np.pi * whole[:, None]
    return q
