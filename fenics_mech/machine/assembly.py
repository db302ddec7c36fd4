"""How bodies come together: coordinates that meet all rows, nearest to where the bodies are drawn, or by a search.

In a search the rows fall into groups that are closed one after the other, each with a few unknowns: those of Assur.
They are the blocks of the triangular form of the pattern of derivatives. In each group Newton's method starts from many
angles.

Source: Duff and Reid, An implementation of Tarjan's algorithm for the block triangularization of a matrix, ACM
Transactions on Mathematical Software 4 (1978).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index, solved
from fenics_mech._constants import TURN
from fenics_mech.machine.machine import Machine
from fenics_mech.terms import Look

CLOSED = 1e-13  # of rows without units, where Newton's method ends
MET, COARSELY_MET = 10 * CLOSED, 1e-9  # of rows, where they count as met; and on the way: of groups, between instants
LONGEST = 0.5  # rad in a step: the drawn position may be far away
SMALLEST = 1e-9  # of the largest singular value: directions that rows leave free
MOST, SEARCHED = 100, 40  # steps of Newton's method from one position, and in a search: 10 to 25 where it converges
STARTS, MOST_STARTS = 16, 512  # of a group with one angle, which each further one doubles; of any group
KEPT = 16  # assemblies that are followed from group to group
SAME = 1e-5  # rad, or of the extent: at a dead centre two assemblies are one to half the digits


@dataclass(frozen=True)
class Assemblies:
    """What a search found."""

    q: Array  # coordinates of every assembly, the nearest to the drawn position first, (assemblies, size)
    rest: Array  # coordinates that leave the least open, where there is none, (size,)
    names: frozenset[str] = frozenset()  # of the rows that may stay open then


def units_of(machine: Machine) -> Array:
    """Give sizes of coordinates that count as equal ``(coordinates,)``: the longest arm of a joint (m), and 1 rad."""
    turns, units = machine.places[:, machine.geometry.d :], np.full(machine.n, machine.arm)
    units[turns[turns >= 0]] = 1.0
    return units


def left_open(machine: Machine, t: float | Array, q: Array) -> tuple[Array, Array]:
    """Give what all rows miss, and its derivatives, without units: ``(positions, rows)`` and ``(..., coordinates)``."""
    # `t` is an instant, or one for each position.
    n, pattern, zero = machine.n, machine.pattern, np.zeros_like(q)
    t = np.broadcast_to(t, len(q))
    found = machine.residual(t, q, zero, zero, loads=0.0, moving=False)
    row, column = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)), pattern.indices
    by = (row >= n) & (column < n)
    derivatives = np.zeros((len(q), machine.size - n, n))
    derivatives[:, row[by] - n, column[by]] = found.K[:, by]
    sizes = _sizes(machine)
    return found.force[:, n:] / sizes, derivatives * units_of(machine) / sizes[:, None]


def _sizes(machine: Machine) -> Array:
    """Give the size of every row, by which it is without units ``(rows,)``."""
    sizes = np.full(machine.size - machine.n, machine.arm)
    for k, row in enumerate(machine.rows):
        if row.measure.look in {Look.ALIGNED, Look.ANGLE}:
            sizes[k] = 1.0
    return sizes


def judged(machine: Machine, t: Array, missed: Array) -> Array:
    """Give what rows miss without units, over how exactly they can be met: angles of many turns have fewer digits."""
    found = missed.copy()
    for k, row in enumerate(machine.rows):
        if row.measure.look in {Look.ALIGNED, Look.ANGLE}:
            found[:, k] /= 1 + np.abs(row.at(t))
    return found


def closed(
    machine: Machine,
    t: float | Array,
    q: Array,
    rows: Index | slice = slice(None),
    columns: Index | None = None,
    most: int = MOST,
) -> tuple[Array, Array]:
    """Meet rows by Newton's method with the least changes, from many positions at once."""
    # q (positions, size)
    q, columns = q.copy(), np.arange(machine.n) if columns is None else columns
    is_turn = np.isin(columns, machine.places[:, machine.geometry.d :])
    gaps, t = np.full(len(q), np.inf), np.broadcast_to(t, len(q))
    going = np.arange(len(q))
    for step in range(most + 1):
        missed, J = left_open(machine, t[going], q[going])
        gaps[going] = np.abs(judged(machine, t[going], missed)[:, rows]).max(axis=1, initial=0.0)
        kept = gaps[going] > CLOSED
        going = going[kept]
        if step == most or not len(going):
            break
        change = -(np.linalg.pinv(J[kept][:, rows][:, :, columns], SMALLEST) @ missed[kept][:, rows, None])[..., 0]
        longest = np.abs(change[:, is_turn]).max(axis=1, initial=0.0)
        change *= np.minimum(1.0, LONGEST / np.maximum(longest, LONGEST))[:, None]
        q[np.ix_(going, columns)] += change * units_of(machine)[columns]
    return q, gaps


def rates_of(
    machine: Machine, t: Array, q: Array, first: Array, second: Array, J: Array | None = None
) -> tuple[Array, Array]:
    """Give rates and accelerations of bodies that meet all rows, by those that the rows demand."""
    # t, q (instants, size) (s); first, second (instants, rows)
    n, zero, sizes = machine.n, np.zeros_like(q), _sizes(machine)
    J = left_open(machine, t, q)[1] if J is None else J

    def moved(demanded: Array) -> Array:
        found, right = zero.copy(), demanded / sizes
        square = J.shape[1] == J.shape[2]
        rates = solved(J, right) if square else (np.linalg.pinv(J, SMALLEST) @ right[..., None])[..., 0]
        found[:, :n] = rates * units_of(machine)
        return found

    v = moved(first)
    values = np.stack([row.at(t) for row in machine.rows], axis=1)[..., None]
    measured = machine.row_group.measure(machine.moved(t, q, v, zero), values)
    of_rates = np.einsum("temn,ten->te", measured.rate_by_variables, measured.ways)
    return v, moved(second - of_rates)


def led(machine: Machine, q: Array, instants: Array) -> tuple[Array, np.ndarray]:
    """Follow drives from instant to instant, from many positions at once."""
    # q (positions, size)
    found, runs, side = [q, q], np.ones(len(q), dtype=bool), None
    for t in instants:
        here = found[-1].copy()
        here[runs], gaps = closed(machine, t, (2 * found[-1] - found[-2])[runs], most=20)
        J = left_open(machine, t, here)[1]
        now = np.linalg.slogdet(J)[0] if J.shape[1] == J.shape[2] else np.ones(len(q))
        side = now if side is None else side
        runs[runs] = gaps < COARSELY_MET
        runs &= now == side
        found.append(here)
    return np.array(found[2:]), runs


def assemblies(machine: Machine, t: float, weight: Array) -> Assemblies:
    """Search for all ways in which the bodies of a plane machine come together."""
    # weight (coordinates,)
    turns = machine.places[machine.places[:, 2] >= 0, 2]
    found, unsolved = np.zeros((1, machine.size)), np.ones(machine.n, dtype=bool)
    for rows, columns in _groups(machine, t):
        unsolved[columns] = False
        starts = _starts(found, columns[np.isin(columns, turns)])
        places = columns[~np.isin(columns, turns)]  # rows are linear in these: at first only they move
        ends, gaps = closed(machine, t, closed(machine, t, starts, rows, places, 1)[0], rows, columns, SEARCHED)
        found = _apart(machine, ends[gaps < COARSELY_MET], turns, weight)[:KEPT]
        if not len(found):
            rest = ends[gaps.argmin()]
            later = (np.abs(left_open(machine, t, rest[None])[1][0][:, unsolved]) > SMALLEST).any(axis=1)
            names = frozenset(row.name for row, waits in zip(machine.rows, later) if not waits)
            return Assemblies(found, rest, names)
    ends, gaps = closed(machine, t, found)
    found = _apart(machine, ends[gaps < MET], turns, weight)
    return Assemblies(found if len(machine.rows) >= machine.n else found[:1], np.zeros(machine.size))


def _groups(machine: Machine, t: float) -> list[tuple[Index, Index]]:
    """Give rows and coordinates that are solved together, in the order in which they are solved."""
    from scipy.sparse import csr_matrix  # noqa: PLC0415  (slow to import, and few machines are searched)
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching  # noqa: PLC0415

    anywhere = np.zeros((1, machine.size))
    anywhere[0, : machine.n] = np.random.default_rng(0).uniform(-1.0, 1.0, machine.n) * units_of(machine)
    pattern = np.abs(left_open(machine, t, anywhere)[1][0]) > SMALLEST
    rows, columns = np.arange(pattern.shape[0]), np.arange(pattern.shape[1])
    solved_for = maximum_bipartite_matching(csr_matrix(pattern), perm_type="column")  # unknown of each row
    if len(rows) != len(columns) or (solved_for < 0).any():  # held too often, or too seldom
        return [(rows, columns)]
    count, label = connected_components(csr_matrix(pattern[:, solved_for]), connection="strong")
    needs = np.zeros((count, count), dtype=bool)
    np.logical_or.at(needs, (label[:, None], label[None, :]), pattern[:, solved_for])
    np.fill_diagonal(needs, False)
    order: list[int] = []
    while len(order) < count:
        order += [k for k in range(count) if k not in order and set(np.flatnonzero(needs[k])) <= set(order)]
    return [(np.flatnonzero(label == k), np.sort(solved_for[label == k])) for k in order]


def _starts(found: Array, turns: Index) -> Array:
    """Give where to begin ``(starts, size)``: each found position with the turns of a group at many angles."""
    # They are an additive recurrence, which spreads evenly over a cube: Roberts, The unreasonable effectiveness of
    # quasirandom sequences (2018). Its base is the root above 1 of x^(n + 1) = x + 1.
    count = min(STARTS * 2 ** (len(turns) - 1), MOST_STARTS) if len(turns) else 1
    base = 2.0
    for _ in range(30):
        base = (1 + base) ** (1 / (len(turns) + 1))
    shares = np.arange(count)[:, None] * base ** -np.arange(1.0, len(turns) + 1)
    starts = np.repeat(found, count, axis=0)
    starts[:, turns] += np.tile(_within_half(TURN * shares), (len(found), 1))
    return starts


def _apart(machine: Machine, q: Array, turns: Index, weight: Array) -> Array:
    """Give positions without those that are there already, the nearest to the drawn one first."""
    # Of mirrored ones, which are as near, that one is first whose bodies are turned counter-clockwise.
    q, n = q.copy(), machine.n
    q[:, turns] = _within_half(q[:, turns])
    sizes = q[:, :n] / units_of(machine)
    keys = np.column_stack([-sizes[:, turns[::-1]].round(6), np.sum(weight * sizes**2, axis=1).round(6)])
    kept: list[int] = []
    for i in np.lexsort(keys.T):
        away = sizes[kept] - sizes[i]
        away[:, turns] = _within_half(away[:, turns])
        if not (np.abs(away).max(axis=1, initial=0.0) < SAME).any():
            kept.append(int(i))
    return np.asarray(q[kept])


def _within_half(angle: Array) -> Array:
    """Take whole turns off angles (rad)."""
    return np.asarray(np.remainder(angle + np.pi, TURN) - np.pi)
