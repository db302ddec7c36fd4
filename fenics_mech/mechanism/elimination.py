"""Solving the joints' equations for some of their unknowns: which ones, and how the others give them.

The equations form groups that share no unknown, one per joint in a linkage of beams on pins; a rigid link
ties the groups of its joints together. Each group is solved on its own, for all angles at once.

The unknowns that are solved for are the same at all angles. Where a pin that cannot give way travels along a member, no
nodal dof of it will do, and the equations are written in displacements relative to a base (see `relative`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from fenics_mech._arrays import Array, Index, solved
from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.constraints import ConstraintEquation, Constraints
from fenics_mech.mechanism.contact import Contact
from fenics_mech.mechanism.jets import Jets
from fenics_mech.mechanism.relative import relative_to_base


@dataclass(frozen=True)
class EliminationLimits:
    """Limits by which the unknowns to solve for are chosen."""

    leverage: float = 1e8  # largest factor of an unknown that is kept in one that is solved for
    travelling_leverage: float = 30.0  # the same where a pin travels, rotations times its member's length
    condition: float = 1e14  # of the equations by the unknowns solved for: beyond it they count as singular
    pivot: float = 1e-6  # smallest pivot, relative to its column
    nodal_pivot: float = 0.1  # of a relative nodal dof, below which a joint's own coordinate is solved for instead


ELIMINATION = EliminationLimits()


def _divided(left: Array, right: Array) -> Array:
    """Solve with a matrix for a matrix at each angle."""
    return np.asarray(np.linalg.solve(left, right), dtype=np.float64)


@dataclass(frozen=True)
class Group:
    """Equations that share unknowns, ``G_d d + G_i i = 0``.

    Parameters
    ----------
    equations
        The equations.
    columns
        Columns of the nodal dofs and the joints' own coordinates that take part, ascending.
    dependent, independent
        Columns of the unknowns that are solved for, and of the others.
    base
        Gives the nodal dofs where the unknowns are relative displacements.
    """

    equations: tuple[ConstraintEquation, ...]
    columns: Index
    dependent: Index
    independent: Index
    base: csr_matrix | None = None

    def jets(self, motion: Motion, orders: int) -> tuple[Jets, Jets]:
        """Give G_d, ``(angles, rows, rows)``, and G_i, ``(angles, rows, independent)``, with time derivatives.

        Parameters
        ----------
        motion
            The motion at the angles.
        orders
            1 for values, 3 with two time derivatives.
        """
        parts = [equation.jets(motion, orders, self.columns) for equation in self.equations]
        whole = [np.concatenate(rows, axis=1) for rows in zip(*parts)]
        unknowns = np.sort(np.concatenate([self.dependent, self.independent]))
        if self.base is not None:
            carried = self.base[self.columns][:, unknowns].toarray()
            whole = [g @ carried for g in whole]
        d, i = np.searchsorted(unknowns, self.dependent), np.searchsorted(unknowns, self.independent)
        return [g[..., d] for g in whole], [g[..., i] for g in whole]

    def on_nodes(self, motion: Motion, multipliers: Array, size: int) -> Array:
        """Forces of the equations on the nodal dofs, ``(angles, size)``, from their multipliers, ``(angles, rows)``.

        Parameters
        ----------
        motion
            The motion at the angles.
        multipliers
            Forces of the equations on their bodies, ``(angles, rows)``.
        size
            Number of nodal dofs.
        """
        parts = [equation.jets(motion, 1, self.columns)[0] for equation in self.equations]
        nodal = self.columns < size
        forces = np.zeros((len(multipliers), size))
        forces[:, self.columns[nodal]] = np.einsum("trc,tr->tc", np.concatenate(parts, axis=1), multipliers)[:, nodal]
        return forces

    def solution(self, motion: Motion, orders: int = 1) -> Jets:
        """Give S of ``d = S i``, ``(angles, dependent, independent)``, with time derivatives where orders is 3.

        Parameters
        ----------
        motion
            The motion at the angles.
        orders
            1 for S alone, 3 with two time derivatives.
        """
        lead, rest = self.jets(motion, orders)
        solution = [-_divided(lead[0], rest[0])]
        if orders > 1:
            solution.append(-_divided(lead[0], rest[1] + lead[1] @ solution[0]))
            second = rest[2] + 2 * lead[1] @ solution[1] + lead[2] @ solution[0]
            solution.append(-_divided(lead[0], second))
        return solution

    def displacement_off(self, motion: Motion, off: Callable[[ConstraintEquation], Array]) -> Array:
        """Give d, ``(angles, dependent)``, where i is 0 and the equations do not hold.

        Parameters
        ----------
        motion
            The motion at the angles.
        off
            What the rows of an equation come to (m or rad), ``(angles, rows)``.
        """
        lead, _ = self.jets(motion, 1)
        return solved(lead[0], np.concatenate([off(equation) for equation in self.equations], axis=1))

    def multipliers(self, motion: Motion, residual: Array) -> Array:
        """Forces of the equations on their bodies, ``(..., angles, rows)``: they balance the residual.

        Parameters
        ----------
        motion
            The motion at the angles.
        residual
            Forces that the dependent unknowns need from outside, ``(..., angles, dependent)``.
        """
        return solved(self._lead(motion).transpose(0, 2, 1), residual)

    def _lead(self, motion: Motion) -> Array:
        """Give G_d, ``(angles, rows, rows)``; with positions that are kept it is made once for all rates."""
        if motion.path is None:
            return self.jets(motion, 1)[0][0]
        what = f"equations of joint {self.equations[0].joint}"
        return motion.path.once(what, (self,), lambda: self.jets(motion, 1)[0][0])


def eliminate(constraints: Constraints, motion: Motion, first_own: int) -> tuple[tuple[Group, ...], csr_matrix | None]:
    """Choose the unknowns to solve for, in every group.

    Parameters
    ----------
    constraints
        The equations of all joints.
    motion
        The motion at all angles: the choice must be good at each of them.
    first_own
        First column that is a joint's own coordinate; such are solved for last.

    Returns
    -------
    tuple
        The groups, and B of ``v = B z`` where some of the unknowns are relative displacements z, else None.

    Raises
    ------
    AssemblyError
        When no choice is good at every angle, as where rigid links are in line.
    """
    columns = [equation.columns(motion) for equation in constraints.equations]
    groups: list[Group] = []
    unyielding: list[Contact] = []
    for members in _connected(columns):
        equations, unknowns = _gathered(constraints, columns, members)
        contacts = [equation.contact for equation in equations if equation.contact is not None]
        try:
            groups.append(_pivoted(equations, unknowns, motion, first_own, constraints.bodies))
        except AssemblyError:
            if not contacts:
                raise
            unyielding += contacts
    if not unyielding:
        return tuple(groups), None
    base = relative_to_base(unyielding, first_own + len(constraints.names))
    return _relative_groups(constraints, columns, motion, first_own, base), base


def _relative_groups(
    constraints: Constraints, columns: list[Index], motion: Motion, first_own: int, base: csr_matrix
) -> tuple[Group, ...]:
    """Choose anew, with relative displacements where the base has some."""
    relative = np.flatnonzero(np.diff(base.indptr) > 1)
    groups = []
    for members in _connected([np.unique(base[c].indices).astype(np.int64) for c in columns]):
        equations, unknowns = _gathered(constraints, columns, members)
        if np.isin(unknowns, relative).any():
            groups.append(_pivoted_relative(equations, unknowns, motion, first_own, base))
        else:
            groups.append(_pivoted(equations, unknowns, motion, first_own, constraints.bodies))
    return tuple(groups)


def _one_by_one(left: Array, count: int, pick: Callable[[Array], int]) -> tuple[list[int], int]:
    """Choose columns of ``(angles, rows, columns)`` one after the other: a QR factorisation with common pivots.

    Parameters
    ----------
    left
        The matrices.
    count
        Number of columns to choose.
    pick
        Gives the best column by what is least left of each over the angles: its part at right angles to those chosen.

    Returns
    -------
    tuple
        The columns, fewer than asked for when nothing is left at some angle, and the number of that angle.
    """
    chosen: list[int] = []
    for _ in range(count):
        size = np.linalg.norm(left, axis=1)
        column = pick(size.min(axis=0))
        k = int(np.argmin(size[:, column]))
        if size[k, column] < ELIMINATION.pivot:
            return chosen, k
        direction = left[:, :, column] / size[:, column, None]
        left = left - direction[:, :, None] * (direction[:, None, :] @ left)
        chosen.append(column)
    return chosen, 0


def _gathered(
    constraints: Constraints, columns: list[Index], members: Index
) -> tuple[tuple[ConstraintEquation, ...], Index]:
    """Equations of a group, and their columns."""
    equations = tuple(constraints.equations[i] for i in members)
    return equations, np.unique(np.concatenate([columns[i] for i in members]))


def _connected(columns: list[Index]) -> list[Index]:
    """Equations that are connected by shared columns."""
    if not columns:
        return []
    rows = np.repeat(np.arange(len(columns)), [len(c) for c in columns])
    where = np.concatenate(columns)
    touched = csr_matrix((np.ones(len(rows)), (rows, where)), shape=(len(columns), int(where.max(initial=0)) + 1))
    count, label = connected_components(touched @ touched.T, directed=False)
    return [np.flatnonzero(label == i) for i in range(count)]


def _pivoted(
    equations: tuple[ConstraintEquation, ...], unknowns: Index, motion: Motion, first_own: int, bodies: Index
) -> Group:
    """Choose pivots by elimination at one angle, and try another one where they are bad somewhere.

    Solved for are, as far as they go: translations of beams' ends, then rotations, the joints' own coordinates, and
    last the dofs of rigid links. Those say most of what they move, and in axes that turn with the scene.
    """
    lengths = [float(e.contact.mesh.member_length[e.contact.member]) for e in equations if e.contact is not None]
    length = max(lengths, default=1.0)
    turning = np.concatenate([np.full(e.rows, e.rows == 1) for e in equations])  # slopes of members under pins
    whole = Group(equations, unknowns, np.zeros(0, dtype=np.int64), unknowns).jets(motion, 1)[1][0]
    whole = whole * np.where(turning, length, 1.0)[:, None]
    reach = np.abs(whole).max(axis=1)
    size = reach.max(axis=0)
    passed_by = reach.min(axis=0) < size / 2  # nodes that a travelling pin comes by and leaves
    rotations = (unknowns % 3 == 2) & (unknowns < first_own)
    order = np.lexsort((unknowns, rotations, passed_by, unknowns >= first_own, np.isin(unknowns, bodies)))
    unit = np.where(rotations, length, 1.0)
    limit = ELIMINATION.travelling_leverage if lengths else ELIMINATION.leverage
    k = 0
    for _ in range(5):
        chosen = _pivots(whole[k] / np.maximum(size, 1e-300), order)
        if len(chosen) == whole.shape[1]:
            rest = np.setdiff1d(np.arange(len(unknowns)), chosen)
            condition = np.linalg.cond(whole[..., chosen])
            k = int(np.argmax(condition))
            if not condition[k] < ELIMINATION.condition:
                continue
            moved = np.linalg.solve(whole[..., chosen], whole[..., rest]) * unit[chosen, None] / unit[rest]
            leverage = np.abs(moved).max(axis=(1, 2), initial=0.0)
            worst = int(np.argmax(leverage))
            if leverage[worst] < limit:
                return Group(equations, unknowns, unknowns[chosen], unknowns[rest])
            k = worst
        else:
            k = (k + len(whole) // 3) % len(whole)
    raise AssemblyError(
        f"the rigid links at joint {equations[0].joint} do not hold together at drive angle "
        f"{np.degrees(motion.theta[k]):.6g} deg: they are in line, or held more than once"
    )


def _pivoted_relative(
    equations: tuple[ConstraintEquation, ...], columns: Index, motion: Motion, first_own: int, base: csr_matrix
) -> Group:
    """Choose, one after the other, the relative unknown of which most is left at its worst angle.

    The joints' own coordinates come last: those of pins are in the fixed frame, and an answer
    must not depend on how that lies.
    """
    unknowns = np.unique(base[columns].indices).astype(np.int64)
    whole = Group(equations, columns, np.zeros(0, dtype=np.int64), unknowns, base).jets(motion, 1)[1][0]
    length = max(float(e.contact.mesh.member_length[e.contact.member]) for e in equations if e.contact is not None)
    rotations = (unknowns % 3 == 2) & (unknowns < first_own)
    rows = np.concatenate([np.full(e.rows, length if e.rows == 1 else 1.0) for e in equations])
    left = whole * rows[:, None] * np.where(rotations, 1 / length, 1.0)

    def nodal_first(least: Array) -> int:
        column = int(np.argmax(least * (unknowns < first_own)))
        return column if least[column] >= ELIMINATION.nodal_pivot else int(np.argmax(least))

    chosen, k = _one_by_one(left, len(rows), nodal_first)
    if len(chosen) < len(rows):
        joint = next(e.joint for e in equations if e.contact is not None)
        raise AssemblyError(
            f"the pin of joint {joint} locks the linkage at drive angle {np.degrees(motion.theta[k]):.6g} deg: it "
            "cannot move, and the member that it slides along is held there already"
        )
    return Group(equations, columns, unknowns[chosen], np.delete(unknowns, chosen), base)


def _pivots(matrix: Array, order: Index) -> list[int]:
    """Columns, early ones of `order` first, that make an invertible matrix: Gaussian elimination by columns."""
    left, chosen = matrix.copy(), []
    free = np.ones(len(left), dtype=bool)
    for column in order:
        row = int(np.argmax(np.abs(left[:, column]) * free))
        if not free[row] or abs(left[row, column]) < ELIMINATION.pivot:
            continue
        others = free.copy()
        others[row] = False
        left[others] -= np.outer(left[others, column] / left[row, column], left[row])
        free[row] = False
        chosen.append(int(column))
    return chosen
