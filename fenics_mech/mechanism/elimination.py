"""Solving the joints' equations for some of their unknowns: which ones, and how the others give them.

The equations fall apart into groups that share no unknown, one per joint in a linkage of beams on pins; a rigid link
ties the groups of its joints together. Each group is solved on its own, for all angles at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.constraints import Constraints, Equation
from fenics_mech.mechanism.jets import Array, Jets

Index = NDArray[np.int64]
LARGEST_LEVERAGE = 1e8  # of an unknown that is kept on one that is solved for
SMALLEST_PIVOT = 1e-6


@dataclass(frozen=True)
class Group:
    """Equations that share unknowns, ``G_d d + G_i i = 0``.

    Parameters
    ----------
    equations
        The equations.
    dependent, independent
        Columns of the unknowns that are solved for, and of the others.
    """

    equations: tuple[Equation, ...]
    dependent: Index
    independent: Index

    def jets(self, motion: Motion, orders: int) -> tuple[Jets, Jets]:
        """Give G_d, ``(angles, rows, rows)``, and G_i, ``(angles, rows, independent)``, with time derivatives."""
        columns = np.sort(np.concatenate([self.dependent, self.independent]))
        parts = [equation.jets(motion, orders, columns) for equation in self.equations]
        whole = [np.concatenate(rows, axis=1) for rows in zip(*parts)]
        d, i = np.searchsorted(columns, self.dependent), np.searchsorted(columns, self.independent)
        return [g[..., d] for g in whole], [g[..., i] for g in whole]

    def solution(self, motion: Motion, orders: int = 1) -> Jets:
        """Give S of ``d = S i``, ``(angles, dependent, independent)``, with time derivatives where orders is 3."""
        lead, rest = self.jets(motion, orders)
        solution = [-np.linalg.solve(lead[0], rest[0])]
        if orders > 1:
            solution.append(-np.linalg.solve(lead[0], rest[1] + lead[1] @ solution[0]))
            second = rest[2] + 2 * lead[1] @ solution[1] + lead[2] @ solution[0]
            solution.append(-np.linalg.solve(lead[0], second))
        return solution

    def multipliers(self, motion: Motion, residual: Array) -> Array:
        """Forces of the equations on their bodies, ``(angles, rows)``: they balance what the bodies lack.

        Parameters
        ----------
        motion
            The motion at the angles.
        residual
            Forces that the dependent unknowns need from outside, ``(angles, dependent)``.
        """
        lead, _ = self.jets(motion, 1)
        return np.linalg.solve(lead[0].transpose(0, 2, 1), residual[..., None])[..., 0]


def eliminate(constraints: Constraints, motion: Motion, first_own: int) -> tuple[Group, ...]:
    """Choose the unknowns to solve for, in every group.

    Parameters
    ----------
    constraints
        The equations of all joints.
    motion
        The motion at all angles: the choice must be good at each of them.
    first_own
        First column that is a joint's own coordinate; such are solved for last.

    Raises
    ------
    AssemblyError
        When no choice is good at every angle, as where rigid links are in line.
    """
    columns = [equation.columns(motion) for equation in constraints.equations]
    groups = []
    for members in _connected(columns):
        equations = tuple(constraints.equations[i] for i in members)
        unknowns = np.unique(np.concatenate([columns[i] for i in members]))
        groups.append(_pivoted(equations, unknowns, motion, first_own))
    return tuple(groups)


def _connected(columns: list[Index]) -> list[Index]:
    """Equations that are connected by shared columns."""
    if not columns:
        return []
    rows = np.repeat(np.arange(len(columns)), [len(c) for c in columns])
    where = np.concatenate(columns)
    touched = csr_matrix((np.ones(len(rows)), (rows, where)), shape=(len(columns), int(where.max(initial=0)) + 1))
    count, label = connected_components(touched @ touched.T, directed=False)
    return [np.flatnonzero(label == i) for i in range(count)]


def _pivoted(equations: tuple[Equation, ...], unknowns: Index, motion: Motion, first_own: int) -> Group:
    """Choose pivots by elimination at one angle, and try another one where they are bad somewhere."""
    whole = Group(equations, np.zeros(0, dtype=np.int64), unknowns).jets(motion, 1)[1][0]
    reach = np.abs(whole).max(axis=1)
    size = reach.max(axis=0)
    passing = reach.min(axis=0) < size / 2  # nodes that a travelling pin comes by and leaves
    # translations of beams' ends first, then rotations, then the joints' own
    rotations = (unknowns % 3 == 2) & (unknowns < first_own)
    order = np.lexsort((unknowns, rotations, passing, unknowns >= first_own))
    k = 0
    for _ in range(5):
        chosen = _pivots(whole[k] / np.maximum(size, 1e-300), order)
        if len(chosen) == whole.shape[1]:
            rest = np.setdiff1d(np.arange(len(unknowns)), chosen)
            k = int(np.argmax(np.linalg.cond(whole[..., chosen]))) if chosen else k
            if not np.isfinite(np.linalg.cond(whole[k][:, chosen])):
                continue
            leverage = np.abs(np.linalg.solve(whole[..., chosen], whole[..., rest])).max(axis=(1, 2), initial=0.0)
            worst = int(np.argmax(leverage))
            if leverage[worst] < LARGEST_LEVERAGE:
                return Group(equations, unknowns[chosen], unknowns[rest])
            k = worst
        else:
            k = (k + len(whole) // 3) % len(whole)
    raise AssemblyError(
        f"the rigid links at joint {equations[0].joint} do not hold together at drive angle "
        f"{np.degrees(motion.theta[k]):.6g} deg: they are in line, or held more than once"
    )


def _pivots(matrix: Array, order: Index) -> list[int]:
    """Columns, early ones of `order` first, that make an invertible matrix: Gaussian elimination by columns."""
    left, chosen = matrix.copy(), []
    free = np.ones(len(left), dtype=bool)
    for column in order:
        row = int(np.argmax(np.abs(left[:, column]) * free))
        if not free[row] or abs(left[row, column]) < SMALLEST_PIVOT:
            continue
        others = free.copy()
        others[row] = False
        left[others] -= np.outer(left[others, column] / left[row, column], left[row])
        free[row] = False
        chosen.append(int(column))
    return chosen
