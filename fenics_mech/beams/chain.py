"""A member as a chain of elements, solved by statics: no stiffness matrix of the whole is ever built or factorised.

The stiffness of n elements in line has a condition number of order n^4. Their compliances only add up: forces are
summed from the chain's end to its start, displacements from its start to its end, and rounding grows no faster than n.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class Chain:
    """Elements in line, in the axes of their member; three dofs per node: u, w, phi."""

    length: Array  # length of each element (m), (elements,)
    # displacement of each element's second node by the force on it when the first is held, (elements, 3, 3)
    compliance: Array

    @classmethod
    def of(cls, length: Array, stiffness: Array) -> Chain:
        """Make a chain of element matrices in member axes, ``(elements, 6, 6)``."""
        # length (elements,) (m); stiffness (elements, 6, 6)
        return cls(length, np.asarray(np.linalg.inv(stiffness[:, 3:, 3:]), dtype=np.float64))

    def _forces(self, loads: Array) -> Array:
        """Forces on second nodes by loads on all nodes but the first, which is held, ``(..., elements, 3)`` both."""
        found = np.cumsum(loads[..., ::-1, :], axis=-2)[..., ::-1, :]
        arm = self.length[1:] * found[..., 1:, 1]  # of the shear force that the next element brings
        found[..., :-1, 2] += np.cumsum(arm[..., ::-1], axis=-1)[..., ::-1]
        return found

    def _displacements(self, forces: Array) -> Array:
        """Displacements of all nodes but the first by forces on second nodes, ``(..., elements, 3)`` both."""
        u, w, phi = np.moveaxis(np.einsum("eij,...ej->...ei", self.compliance, forces), -1, 0)
        turned = np.cumsum(phi, axis=-1)
        w[..., 1:] += self.length[1:] * turned[..., :-1]
        return np.stack([np.cumsum(u, axis=-1), np.cumsum(w, axis=-1), turned], axis=-1)

    @cached_property
    def end_stiffness(self) -> Array:
        """Force on the end by its displacement when the start is held, ``(3, 3)``."""
        found = np.linalg.inv(self._displacements(self._of_end(np.eye(3)))[:, -1].T)
        return (found + found.T) / 2

    @cached_property
    def stiffness(self) -> Array:
        """Forces on both ends by the displacements of both, ``(6, 6)``."""
        relative = np.concatenate([-self._swing, np.eye(3)], axis=1)
        return relative.T @ self.end_stiffness @ relative

    def carried(self, ends: Array) -> tuple[Array, Array]:
        """Give the displacements of the inner nodes, and the elements' forces, when the ends move and nothing acts."""
        # ends (..., 6)
        start, end = ends[..., :3], ends[..., 3:]
        forces = self._of_end((end - start @ self._swing.T) @ self.end_stiffness)
        found = self._displacements(forces)
        found += start[..., None, :]
        found[..., 1] += np.cumsum(self.length) * start[..., None, 2]
        return found[..., :-1, :], forces

    def clamped(self, loads: Array) -> tuple[Array, Array]:
        """Give the displacements of the inner nodes under loads, and the elements' forces, when the ends are held."""
        # loads (..., elements - 1, 3) (N, N m)
        padded = np.concatenate([loads, np.zeros((*loads.shape[:-2], 1, 3))], axis=-2)
        forces = self._forces(padded)
        released = self._displacements(forces)
        forces = forces - self._of_end(released[..., -1, :] @ self.end_stiffness)
        return self._displacements(forces)[..., :-1, :], forces

    def _of_end(self, force: Array) -> Array:
        """Forces on the second nodes of the elements by one on the end, ``(..., 3)`` to ``(..., elements, 3)``."""
        rest = np.cumsum(self.length[::-1])[::-1] - self.length  # from the second node to the end
        forces = np.repeat(force[..., None, :], len(rest), axis=-2)
        forces[..., 2] += rest * force[..., None, 1]
        return forces

    @property
    def _swing(self) -> Array:
        """Displacement of the end as the chain moves with its start, ``(3, 3)``."""
        return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, self.length.sum()], [0.0, 0.0, 1.0]])
