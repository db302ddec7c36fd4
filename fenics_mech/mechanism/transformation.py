"""P(theta): from the mechanism's coordinates q to the links' nodal dofs, with its time derivatives.

It is [Tr] of (4.40)-(4.56), for any joints. The joints' equations (see `constraints`) are solved for some of the nodal
dofs. What is left is q: nodal dofs in link axes, displacements of pins along the fixed X and Y axes, slides.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index, summed
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.kinematics import Motion
from fenics_mech.kinematics.motion import joined
from fenics_mech.mechanism.constraints import ConstraintEquation, Constraints, build_constraints
from fenics_mech.mechanism.elimination import Group, eliminate
from fenics_mech.mechanism.jets import Jets
from fenics_mech.scene import Scene
from fenics_mech.scene.numbering import GROUND

COMPONENTS = ("x", "y", "rotation")
ACROSS = {".x": "y", ".y": "x", ".X": "Y", ".Y": "X"}  # ends of coordinates' names, and those of the other direction


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
        Nodal dofs of all links.
    place
        Row of P of each nodal dof: the nodal dof itself, or its place among the links' coordinates where the links are
        reduced, -1 for a dof that is none of them.
    modes
        Number of the members' modes, where the links are reduced: each is a coordinate itself, and they come last.
    base
        B, where some of the unknowns are displacements relative to a base node (see `relative`), else None.
    """

    constraints: Constraints
    groups: tuple[Group, ...]
    free: Index
    coordinate: Index
    names: tuple[str, ...]
    height: int
    place: Index
    modes: int = 0
    base: sp.csr_matrix | None = None

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Links' coordinates by the mechanism's."""
        return int(self.place.max(initial=-1)) + 1 + self.modes, len(self.names)

    @cached_property
    def across(self) -> Index:
        """The coordinate of the same point in the direction normal to each one, ``(coordinates,)``.

        It is the coordinate itself where there is none: of rotations, slides, and points that follow others.
        """
        place = {name: i for i, name in enumerate(self.names)}
        others = [f"{name[:-1]}{ACROSS.get(name[-2:], '')}" for name in self.names]
        return np.array([place.get(other, i) for i, other in enumerate(others)], dtype=np.int64)

    def unit_of(self, stiffness: Array) -> Array:
        """Give what makes coordinates alike when they are multiplied by it, ``(coordinates,)``.

        It is the root of their mean stiffness. Both directions of a point have one, so that axes do not matter.

        Parameters
        ----------
        stiffness
            Stiffness of the links by each coordinate, ``(angles, coordinates)``.
        """
        mean = stiffness.mean(axis=0)
        return np.sqrt((mean + mean[self.across]) / 2)

    @cached_property
    def _pattern(self) -> tuple[Index, Index, list[NDArray[np.bool_]]]:
        """Rows and columns of the nonzeros of B^-1 P: free dofs, then each group's dependent nodal dofs."""
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
    def _layout(self) -> tuple[Index, Index, Index | sp.csr_matrix]:
        """Rows and columns of the nonzeros of P, sorted, and what makes their values from those of `_pattern`."""
        rows, columns, _ = self._pattern
        if self.base is None:
            rows, columns = self._with_modes(self.place[rows], columns)
            order = np.lexsort((columns, rows))
            return rows[order], columns[order], order
        carried = self.base[: self.height].tocsc()[:, rows].tocoo()  # the nodal dofs that each value moves
        inside = self.place[carried.row] >= 0
        rows, columns = self._with_modes(self.place[carried.row[inside]], columns[carried.col[inside]])
        data = np.append(carried.data[inside], np.ones(self.modes))
        source = np.append(carried.col[inside], len(self._pattern[0]) + np.arange(self.modes))
        place, which = np.unique(rows * np.int64(len(self.names)) + columns, return_inverse=True)
        gather = sp.csr_matrix((data, (which, source)), shape=(len(place), len(self._pattern[0]) + self.modes))
        return place // len(self.names), place % len(self.names), gather

    def _with_modes(self, rows: Index, columns: Index) -> tuple[Index, Index]:
        """Add the members' modes, which are the last of the rows and the last of the columns."""
        last = np.arange(-self.modes, 0)
        return np.append(rows, self.shape[0] + last), np.append(columns, self.shape[1] + last)

    @property
    def rows(self) -> Index:
        """Row of each nonzero, ascending."""
        return self._layout[0]

    @property
    def columns(self) -> Index:
        """Coordinate of each nonzero."""
        return self._layout[1]

    def values(self, motion: Motion) -> Array:
        """Nonzeros of P at all angles, ``(angles, nonzeros)``.

        Parameters
        ----------
        motion
            The rigid motion.
        """
        if motion.path is None:
            return self._jets(motion, 1)[0]
        return motion.path.once("P", (self,), lambda: self._jets(motion, 1)[0])

    def derivatives(self, motion: Motion) -> tuple[Array, Array]:
        """Nonzeros of the first and second time derivative of P, each ``(angles, nonzeros)`` (1/s, 1/s^2).

        Parameters
        ----------
        motion
            The rigid motion.
        """
        path, rate = motion.path, motion.rate
        if path is None:
            _, first, second = self._jets(motion, 3)
            return first, second
        _, slope, curvature = path.once("P by theta", (self,), lambda: self._jets(path.motion(1.0), 3))
        return rate * slope, rate**2 * curvature

    def rates_in(self, motions: Sequence[Motion]) -> list[Array]:
        """Nonzeros of the first time derivative of P in several motions of as many angles (1/s).

        Parameters
        ----------
        motions
            The motions.
        """
        if len(motions) < 2 or any(motion.path is not None for motion in motions):  # paths keep what is made of them
            return [self.derivatives(motion)[0] for motion in motions]
        return np.split(self._jets(joined(motions), 3)[1], len(motions))

    def _jets(self, motion: Motion, orders: int) -> Jets:
        count = len(motion.theta)
        ones = [np.ones((count, len(self.free))), *(np.zeros((count, len(self.free))),) * (orders - 1)]
        parts = [ones]
        for group, nodal in zip(self.groups, self._pattern[2]):
            parts.append([s[:, nodal].reshape(count, -1) for s in group.solution(motion, orders)])
        parts.append([np.full((count, self.modes), float(order == 0)) for order in range(orders)])
        gather = self._layout[2]
        joined = (np.concatenate(values, axis=1) for values in zip(*parts))
        if sp.issparse(gather):
            return [np.ascontiguousarray((gather @ j.T).T) for j in joined]
        return [np.take(j, gather, axis=1) for j in joined]  # by rows, as all that takes them needs

    def forward(self, values: Array, q: Array) -> Array:
        """``P q`` at all angles: ``(angles, ..., coordinates)`` to ``(angles, ..., links' coordinates)``.

        Parameters
        ----------
        values
            Nonzeros of P, ``(angles, nonzeros)``.
        q
            Coordinates of the mechanism.
        """
        return summed(values * np.take(q, self.columns, axis=-1), self.rows, self.shape[0])

    def backward(self, values: Array, force: Array) -> Array:
        """``P^T force`` at all angles: ``(angles, ..., links' coordinates)`` to ``(angles, ..., coordinates)``.

        Parameters
        ----------
        values
            Nonzeros of P, ``(angles, nonzeros)``.
        force
            Forces on the links' coordinates.
        """
        return summed(values * np.take(force, self.rows, axis=-1), self.columns, len(self.names))

    def backward_at(self, values: Array, dofs: Index, force: Array) -> Array:
        """``P^T force`` of forces on some of the links' coordinates, ``(angles, ...)`` of the shape of `dofs`.

        Parameters
        ----------
        values
            Nonzeros of P, ``(angles, nonzeros)``.
        dofs
            The links' coordinates.
        force
            Forces on them.
        """
        return self.backward(values, summed(force.reshape(len(force), -1), dofs.ravel(), self.shape[0]))

    def displacement_by_gaps(self, motion: Motion, gaps: Mapping[str, tuple[Array, Array]]) -> Array:
        """Links' coordinates, ``(angles, links' coordinates)``, where q is 0 and members are off their travelling pins.

        Parameters
        ----------
        motion
            The rigid motion.
        gaps
            By joint: by how much the member is displaced along its normal (m), and turned (rad), ``(angles,)`` each.
        """

        def off(equation: ConstraintEquation) -> Array:
            if equation.contact is None:
                return np.zeros((len(motion.theta), equation.rows))
            across, turn = gaps[equation.joint]
            if equation.rows == 1:
                return turn[:, None]
            angle = equation.contact.angle(motion)
            if equation.frame != GROUND:
                angle = angle - motion.angle[:, equation.frame]
            return across[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=-1)

        return self.displacement_off(motion, off)

    def displacement_off(self, motion: Motion, off: Callable[[ConstraintEquation], Array]) -> Array:
        """Links' coordinates, ``(angles, links' coordinates)``, where q is 0 and the joints' equations do not hold.

        Parameters
        ----------
        motion, off
            As of `Group.displacement_off`.
        """
        whole = np.zeros((len(motion.theta), self.height + len(self.constraints.names)))
        for group in self.groups:
            whole[:, group.dependent] = group.displacement_off(motion, off)
        nodal = whole[:, : self.height] if self.base is None else (self.base[: self.height] @ whole.T).T
        found = np.zeros((len(nodal), self.shape[0]))
        found[:, self.place[self.place >= 0]] = nodal[:, self.place >= 0]
        return found

    def on_unknowns(self, force: Array) -> Array:
        """Forces on the unknowns of the joints' equations, ``B^T force``, both ``(..., nodal dofs)``.

        Parameters
        ----------
        force
            Forces on the nodal dofs, ``(..., nodal dofs)``.
        """
        if self.base is None:
            return force
        carried = force.reshape(-1, self.height) @ self.base[: self.height, : self.height]
        return np.asarray(carried, dtype=float).reshape(force.shape)


def build_transformation(scene: Scene, beams: Beams, motion: Motion) -> Transformation:
    """Lay out the coordinates of a scene's mechanism.

    Parameters
    ----------
    scene
        The scene.
    beams
        The links' matrices.
    motion
        Its rigid motion.

    Raises
    ------
    AssemblyError
        When the joints' equations cannot be solved at some angle of the motion.
    """
    if motion.path is None:
        return _laid_out(scene, beams, motion)
    return motion.path.once("layout of P", (beams.mesh, beams.reduction), lambda: _laid_out(scene, beams, motion))


def _laid_out(scene: Scene, beams: Beams, motion: Motion) -> Transformation:
    mesh, reduction = beams.mesh, beams.reduction
    height = 3 * len(mesh.node_name)
    place = np.arange(height) if reduction is None else reduction.place
    constraints = build_constraints(scene, mesh)
    groups, base = eliminate(constraints, motion, height)
    dependent = np.concatenate([np.zeros(0, dtype=np.int64), *(group.dependent for group in groups)])
    coordinate = np.full(height + len(constraints.names), -1)
    kept = np.arange(len(coordinate)) if base is None else np.unique(base.indices)  # others have no part in B z
    left = np.setdiff1d(kept, np.append(dependent, np.flatnonzero(place < 0)))
    left = left[np.argsort(_places(groups, left, height), kind="stable")]
    coordinate[left] = np.arange(len(left))
    names = [f"{name}.{component}" for name in mesh.node_name for component in COMPONENTS] + list(constraints.names)
    if base is not None:
        names = [f"{name} relative" if many else name for name, many in zip(names, np.diff(base.indptr) > 1)]
    free = np.sort(left[left < height])
    modes = [] if reduction is None else [mesh.members[i] for i in reduction.mode_member]
    return Transformation(
        constraints=constraints,
        groups=groups,
        free=free,
        coordinate=coordinate,
        names=(*(names[i] for i in left), *(f"{label}.mode" for label in modes)),
        height=height,
        place=place,
        modes=len(modes),
        base=base,
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
