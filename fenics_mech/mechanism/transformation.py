"""P(theta): from the mechanism's coordinates q to the links' nodal dofs, with its time derivatives.

It is [Tr] of (4.40)-(4.56), for any joints: the joints' equations (see `constraints`) are solved for some of the nodal
dofs, and all that is left is q: nodal dofs in link axes, displacements of pins along the fixed X and Y axes, slides.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech.beams import BeamMesh
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.constraints import Constraints, build_constraints
from fenics_mech.mechanism.elimination import Group, eliminate
from fenics_mech.mechanism.jets import Array, Jets
from fenics_mech.scene import Scene

Index = NDArray[np.int64]
COMPONENTS = ("x", "y", "rotation")


@dataclass(frozen=True)
class Transformation:
    """Layout of P.

    Parameters
    ----------
    constraints
        The joints' equations.
    groups
        How they are solved.
    free
        Nodal dofs that are coordinates themselves.
    coordinate
        Coordinate of each column of the joints' equations, -1 for those that are solved for.
    names
        Name of each coordinate q: "joint.X", "joint.Y", "joint.slide", or "node.x", "node.y", "node.rotation".
    height
        Number of rows: nodal dofs of all links.
    """

    constraints: Constraints
    groups: tuple[Group, ...]
    free: Index
    coordinate: Index
    names: tuple[str, ...]
    height: int

    @property
    def shape(self) -> tuple[int, int]:
        """Nodal dofs by coordinates."""
        return self.height, len(self.names)

    @cached_property
    def _pattern(self) -> tuple[Index, Index, list[NDArray[np.bool_]]]:
        """Rows and columns of the nonzeros before sorting: free dofs, then each group's dependent nodal dofs."""
        rows, columns = [self.free], [self.coordinate[self.free]]
        keep = []
        for group in self.groups:
            nodal = group.dependent < self.height
            keep.append(nodal)
            r, c = np.meshgrid(group.dependent[nodal], self.coordinate[group.independent], indexing="ij")
            rows.append(r.ravel())
            columns.append(c.ravel())
        return np.concatenate(rows), np.concatenate(columns), keep

    @cached_property
    def _order(self) -> Index:
        rows, columns, _ = self._pattern
        return np.lexsort((columns, rows))

    @cached_property
    def rows(self) -> Index:
        """Row of each nonzero, ascending."""
        return self._pattern[0][self._order]

    @cached_property
    def columns(self) -> Index:
        """Coordinate of each nonzero."""
        return self._pattern[1][self._order]

    def values(self, motion: Motion) -> Array:
        """Nonzeros of P at all angles, ``(angles, nonzeros)``."""
        return self._jets(motion, 1)[0]

    def derivatives(self, motion: Motion) -> tuple[Array, Array]:
        """Nonzeros of the first and second time derivative of P, each ``(angles, nonzeros)`` (1/s, 1/s^2)."""
        _, first, second = self._jets(motion, 3)
        return first, second

    def _jets(self, motion: Motion, orders: int) -> Jets:
        count = len(motion.theta)
        ones = [np.ones((count, len(self.free))), *(np.zeros((count, len(self.free))),) * (orders - 1)]
        parts = [ones]
        for group, nodal in zip(self.groups, self._pattern[2]):
            parts.append([s[:, nodal].reshape(count, -1) for s in group.solution(motion, orders)])
        return [np.concatenate(values, axis=1)[:, self._order] for values in zip(*parts)]

    def forward(self, values: Array, q: Array) -> Array:
        """``P q`` at all angles: ``(angles, ..., coordinates)`` to ``(angles, ..., nodal dofs)``."""
        return _summed(values * q[..., self.columns], self.rows, self.height)

    def backward(self, values: Array, force: Array) -> Array:
        """``P^T force`` at all angles: ``(angles, ..., nodal dofs)`` to ``(angles, ..., coordinates)``."""
        return _summed(values * force[..., self.rows], self.columns, len(self.names))


def _summed(terms: Array, target: Index, size: int) -> Array:
    """Sum the last axis of `terms` over the entries that share a target."""
    collect = sp.csr_matrix((np.ones(len(target)), (target, np.arange(len(target)))), shape=(size, len(target)))
    flat = terms.reshape(-1, terms.shape[-1])
    return np.asarray(collect @ flat.T).T.reshape(*terms.shape[:-1], size)


def build_transformation(scene: Scene, mesh: BeamMesh, motion: Motion) -> Transformation:
    """Lay out the coordinates of a scene's mechanism.

    Raises
    ------
    AssemblyError
        When the joints' equations cannot be solved at some angle of the motion.
    """
    height = 3 * len(mesh.node_name)
    constraints = build_constraints(scene, mesh)
    groups = eliminate(constraints, motion, height)
    dependent = np.concatenate([np.zeros(0, dtype=np.int64), *(group.dependent for group in groups)])
    coordinate = np.full(height + len(constraints.names), -1)
    left = np.setdiff1d(np.arange(len(coordinate)), dependent)
    left = left[np.argsort(_places(groups, left, height), kind="stable")]
    coordinate[left] = np.arange(len(left))
    names = [f"{name}.{component}" for name in mesh.node_name for component in COMPONENTS] + list(constraints.names)
    return Transformation(
        constraints, groups, np.sort(left[left < height]), coordinate, tuple(names[i] for i in left), height
    )


def _places(groups: tuple[Group, ...], columns: Index, height: int) -> Array:
    """Where each column comes among the nodal dofs: a joint's own coordinates come beside the dofs that they move."""
    place = columns.astype(float)
    for group in groups:
        beside = np.concatenate([group.dependent, group.independent])
        nodal = beside[beside < height]
        own = np.isin(columns, group.independent) & (columns >= height)
        place[own] = nodal.min(initial=height)
    return place
