"""Modal damping of many coordinates by few: the ends of the members, and their modes with clamped ends.

The modes that are damped are found in the displacements ``v = T P_r z`` of reduced members (Craig and Bampton). Their
viscous stress is that of such a displacement, so that a mode's rate is seen by few numbers: those of the members' ends,
and the share of each clamped mode in the motion of the inner nodes. What these are of the coordinates is the same at
all angles. What depends on the angle does not grow with the mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array, Index, summed
from fenics_mech._sparse import Stack
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.reduction import Reduction
from fenics_mech.effects import NOTHING
from fenics_mech.effects.nonlinear_law import ArcLength
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism.modal_forces import ModalForces
from fenics_mech.mechanism.system import System, build_system
from fenics_mech.mechanism.transformation import Transformation
from fenics_mech.scene import Scene


@dataclass(frozen=True, eq=False)
class ReducedLinks:
    """The links of a mechanism with all nodes, and by few coordinates.

    Parameters
    ----------
    whole
        P of the mechanism with all nodes.
    beams
        The links, whose members are reduced.
    transformation
        P_r, of the mechanism with these.
    """

    whole: Transformation
    beams: Beams
    transformation: Transformation

    @classmethod
    def of(cls, scene: Scene, system: System, members: Sequence[int], cutoff: float) -> ReducedLinks:
        """Reduce members of a mechanism.

        Parameters
        ----------
        scene
            The scene.
        system
            Its mechanism with all nodes.
        members
            Those that are reduced.
        cutoff
            Frequency up to which their clamped modes are kept (rad/s).
        """
        beams = replace(system.beams, reduction=Reduction.of(system.beams, system.beams, members, cutoff))
        return cls(system.transformation, beams, build_system(scene, beams, system.motion).transformation)

    def at(self, system: System) -> System:
        """Give the reduced mechanism in the place of one with all nodes, with its springs and given axial forces.

        Parameters
        ----------
        system
            The mechanism with all nodes, at any angles.
        """
        given = system.terms
        terms = replace(NOTHING, matrices=given.matrices, stiffening=given.stiffening, uneven=given.uneven)
        return System(self.beams, system.motion, self.transformation, terms)

    @property
    def _reduction(self) -> Reduction:
        assert self.beams.reduction is not None
        return self.beams.reduction

    @property
    def _shapes(self) -> sp.csr_matrix:
        """Clamped modes of the members, ``(nodal dofs, modes)``."""
        return self._reduction.shape[:, len(self._reduction.kept) :]

    @cached_property
    def _ends(self) -> tuple[Index, Index, Index, Index]:
        """Nonzeros of P on nodal dofs that are kept: themselves, their dofs' numbers, their columns, these columns."""
        rows, columns = self.whole.rows, self.whole.columns
        places = np.flatnonzero(np.isin(rows, self._reduction.kept))
        moved, number = np.unique(columns[places], return_inverse=True)
        return places, np.searchsorted(self._reduction.kept, rows[places]), number, moved

    @cached_property
    def _sizes(self) -> Array:
        """What a clamped mode is multiplied by for half the square of its share to be its energy, ``(modes,)``."""
        modal = (self._shapes.multiply(self.beams.mass @ self._shapes)).sum(axis=0)
        return self._reduction.mode_omega * np.sqrt(np.asarray(modal).ravel())

    @cached_property
    def seen(self) -> sp.csr_matrix:
        """What the modes see of the coordinates: those of the ends, and the share of each clamped mode in the rest."""
        moved, size = self._ends[3], self.whole.shape[1]
        inner = ~np.isin(self.whole.rows, self._reduction.kept)
        rows, columns = self.whole.rows[inner], self.whole.columns[inner]
        on_coordinates = sp.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=self.whole.shape)
        momenta = (self._shapes.T @ self.beams.mass) @ on_coordinates
        of_modes = sp.diags(self._reduction.mode_omega**2 / self._sizes) @ momenta
        of_ends = sp.csr_matrix((np.ones(len(moved)), (np.arange(len(moved)), moved)), shape=(len(moved), size))
        found = sp.vstack([of_ends, of_modes], format="csr")
        found.sort_indices()
        return found

    @cached_property
    def _forces_on_ends(self) -> sp.csr_matrix:
        """Elastic forces on the nodal dofs that are kept by the reduced links' coordinates, transposed."""
        kept = self._reduction.kept
        by_ends = self._reduction.stiffness[: len(kept), : len(kept)]
        by_modes = self._shapes.T @ self.beams.stiffness[:, kept]
        return sp.vstack([by_ends, by_modes], format="csr")

    def links_by(self, factor: Array, motion: Motion) -> Array:
        """Give the reduced links' coordinates of the strain that goes with forces on the reduced mechanism's.

        Parameters
        ----------
        factor
            Forces, ``(angles, modes, reduced coordinates)``.
        motion
            The rigid motion at the angles.

        Returns
        -------
        numpy.ndarray
            Shape ``(angles, modes, reduced links' coordinates)``.
        """
        bare = System(self.beams, motion, self.transformation)
        return self.transformation.forward(bare.values[:, None], self.stiffness(motion).solve(factor))

    def stiffness(self, motion: Motion) -> Stack:
        """Give the stiffness of the reduced links alone at the angles of a motion.

        Parameters
        ----------
        motion
            The rigid motion.
        """
        return System(self.beams, motion, self.transformation).held_matrices()[1]

    def forces(self, strained: Array, values: Array, turned: Array) -> ModalForces:
        """Give the forces on the mechanism with all nodes, of modes that strain the links so.

        Parameters
        ----------
        strained
            From `links_by`.
        values, turned
            Nonzeros of P and P' at the angles, ``(angles, nonzeros)``.
        """
        places, dof, number, moved = self._ends
        on_ends = (self._forces_on_ends.T @ strained.reshape(-1, strained.shape[-1]).T).T
        given = on_ends.reshape(*strained.shape[:2], -1)[..., dof]
        outward, by_place = (summed(part[:, None, places] * given, number, len(moved)) for part in (values, turned))
        of_modes = strained[..., len(self._reduction.kept) :] * self._sizes
        outward = np.concatenate([outward, of_modes], axis=-1)
        return ModalForces(outward, outward, np.pad(by_place, ((0, 0), (0, 0), (0, of_modes.shape[-1]))), self.seen)

    def axial(self, strained: Array, law: ArcLength) -> Array:
        """Give the axial forces of the elements of modes that strain the links so (N), ``(angles, modes, elements)``.

        Parameters
        ----------
        strained
            From `links_by`.
        law
            The elements.
        """
        return strained @ law.axial(self._reduction.shape.T.toarray()[None])[0]
