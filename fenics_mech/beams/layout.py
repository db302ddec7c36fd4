"""How the broken space of the forms hangs together with the nodal dofs of the links.

The forms are assembled in the broken space, one cell by itself. The constant matrix `embedding` (broken <- nodal)
carries what joins inside a link: the Hermite functions with their element size, continuity, the members' angles and
the welds. Nodal dofs are three per node: displacement along the link's x and y axes, and rotation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp

from fenics_mech import _fenicsx
from fenics_mech._arrays import Array, Index
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.made_once import MadeOnce
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.offset_pins import Offsets
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, evaluate


@dataclass(frozen=True)
class Layout(MadeOnce):
    """The broken space of a mesh, and what a form in it becomes in nodal dofs."""

    mesh: BeamMesh  # the mesh
    space: Any  # the broken space, axial by normal displacement
    # Angle of shear of each element by w and phi of both its nodes, (elements, 4) (1/m, 1); None where beams are
    # rigid in shear. With it a nodal rotation phi is that of the section, not of the axis.
    shear_angle: Array | None = None
    # places of the neutral line and of the centre of mass; None where both are on the axes of all members
    offsets: Offsets | None = None

    @classmethod
    def of(cls, mesh: BeamMesh, offsets: Offsets | None = None) -> Layout:
        """Lay out the broken space DG1 x DG3 on a mesh."""
        if offsets is not None:
            return cls(mesh, mesh.space, offsets=offsets)
        return mesh.once("layout", lambda: cls(mesh, mesh.space))

    @property
    def coordinate(self) -> Any:
        """UFL coefficient of the place 0..1 in each element, along its member."""
        return _fenicsx.cellwise_coordinate(self.mesh.mesh, self.mesh.cell[self.mesh.cell_flipped])

    def sheared(self, angle: Array) -> Layout:
        """Give the layout with shear: the space has the angle of shear too, one per cell."""
        # angle (elements, 4)
        return replace(self, space=_fenicsx.broken_space(self.mesh.mesh, (1, 3, 0)), shear_angle=angle)

    def coefficient(self, by_element: Array) -> Any:
        """Give the UFL coefficient that takes one value per element, ``(elements,)``."""
        by_cell = np.empty_like(by_element)
        by_cell[self.mesh.cell] = by_element
        return _fenicsx.cellwise(self.mesh.constants, by_cell)

    def nodal(self, broken: sp.csr_matrix) -> sp.csr_matrix:
        """Carry a broken matrix to nodal dofs in link axes."""
        return (self.embedding.T @ broken @ self.embedding).tocsr()

    def of_elements(self, broken: sp.csr_matrix) -> Array:
        """Blocks of a broken matrix in the nodal dofs and member axes of each element, ``(elements, 6, 6)``."""
        dofs, hermite = self._hermite
        rows, columns = np.broadcast_arrays(dofs[:, :, None], dofs[:, None, :])
        blocks = np.asarray(broken[rows.ravel(), columns.ravel()]).reshape(rows.shape)
        return np.einsum("eai,eab,ebj->eij", hermite, blocks, hermite)

    @property
    def tied(self) -> bool:
        """Whether nodal dofs are not those of Hermite's functions."""
        return self.shear_angle is not None or self.offsets is not None

    @cached_property
    def tie(self) -> Array:
        """From nodal dofs to those of Hermite's functions, in member axes, ``(elements, 6, 6)``."""
        # Where the nodes have the rotation phi of the section, Hermite's functions have the slope w' = phi + gamma of
        # the axis. Where the neutral line is y beside the axis, they have its displacement u - y phi.
        tie = np.tile(np.eye(6), (len(self.mesh.cell), 1, 1)) if self.offsets is None else self.offsets.arms
        if self.shear_angle is not None:
            tie[:, NORMAL[1::2], 1:3] += self.shear_angle[:, None, :2]
            tie[:, NORMAL[1::2], 4:] += self.shear_angle[:, None, 2:]
        return tie

    @cached_property
    def _hermite(self) -> tuple[Index, Array]:
        """Broken dofs of each element, and the functions of its nodal dofs at them, in member axes."""
        # Dofs (elements, n) and values (elements, n, 6), n being 6, or 7 with shear: column j is the broken function
        # that nodal dof j (u, w, phi at both nodes) of the element makes: a linear one, or a cubic by Hermite.
        mesh = self.mesh
        (u_dofs, u_points), (w_dofs, w_points) = (_fenicsx.cell_dofs(self.space, part) for part in (0, 1))
        dofs = np.concatenate([u_dofs, w_dofs], axis=1)[mesh.cell]
        flipped = mesh.cell_flipped[:, None]
        linear = evaluate(LINEAR, np.where(flipped, 1 - u_points, u_points))
        cubic = evaluate(CUBIC, np.where(flipped, 1 - w_points, w_points))
        cubic[..., [1, 3]] *= mesh.cell_length[:, None, None]
        values = np.zeros((len(dofs), 6, 6))
        values[:, :2][..., AXIAL] = linear
        values[:, 2:][..., NORMAL] = cubic
        if self.shear_angle is None:
            return dofs, values @ self.tie if self.tied else values
        angle = np.zeros((len(dofs), 1, 6))
        angle[:, 0, NORMAL] = self.shear_angle
        dofs = np.concatenate([dofs, _fenicsx.cell_dofs(self.space, 2)[0][mesh.cell]], axis=1)
        return dofs, np.concatenate([values @ self.tie, angle], axis=1)

    @cached_property
    def embedding(self) -> sp.csr_matrix:
        """Broken <- nodal: column j is the broken function of nodal dof j (link axes)."""
        dofs, hermite = self._hermite
        values = hermite @ member_rotation(self.mesh)
        rows, columns = np.broadcast_arrays(dofs[:, :, None], element_dofs(self.mesh)[:, None, :])
        shape = (dofs.size, 3 * len(self.mesh.node_link))
        return sp.csr_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=shape)
