"""Elements whose axes turn far: their shortening and their bending, for many states at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np

from fenics_mech import _fenicsx
from fenics_mech._arrays import Array, Index, each
from fenics_mech._fenicsx import ufl
from fenics_mech.beams.distributions import Distribution
from fenics_mech.beams.element_dofs import member_rotation
from fenics_mech.beams.forms.exact_strains import bending, bending_energy, shortening
from fenics_mech.beams.layout import Layout


@dataclass(frozen=True, eq=False)
class BentAxis:
    """Shortening and bending of elements, by their displacements w across their members."""

    # An element that is stretched lambda times bends as one that is not, whose ends move across by a share 1/lambda
    # and turn alike: its w/lambda, here its shape, has the sine of the axis' rotation as its slope.

    # by name: of the shortening and its two derivatives, of the forces of bending and their two derivatives, and of
    # the energy of bending
    kernels: Mapping[str, _fenicsx.CellKernel]
    broken: Array  # dofs of the broken deflection by those of w, the place and slope of each end, (elements, 4, 4)
    whole: Array  # dofs of w by the dofs of each element, (elements, 4, n)
    # stiffness of shear on the dofs of the shape, (elements, 4, 4); None where beams are rigid in shear
    shear: Array | None = None

    @classmethod
    def of(cls, layout: Layout, stiffness: Distribution, shear: Distribution | None = None) -> BentAxis:
        """Give it in the nodal dofs of the elements in link axes; for a constant EI it is compiled once."""
        mesh, coefficient = layout.mesh, stiffness.coefficient
        if stiffness.varies:
            kernels = _kernels(mesh.mesh, mesh.cell, coefficient)
        else:
            kernels = {name: made.on(mesh.mesh, mesh.cell, coefficient) for name, made in _of_constant().items()}
        across = [1, 2, 4, 5]  # of an element's dofs in its member's axes
        angle, resisted = layout.shear_angle, None
        if shear is not None and angle is not None:  # which is constant in an element
            resisted = (shear.mean * mesh.cell_length)[:, None, None] * angle[:, :, None] * angle[:, None, :]
        return cls(kernels, layout.broken_deflection[:, :, across], member_rotation(mesh)[:, across], resisted)

    def by(self, shape: Array) -> BentAxis:
        """Give it by what moves the elements' dofs; these are ``shape z``, ``(elements, dofs, n)``."""
        # shape (elements, dofs, n)
        return replace(self, whole=self.whole @ shape)

    @cached_property
    def linear(self) -> Array:
        """Stiffness of bending by linear theory on the dofs of w, ``(elements, 4, 4)``."""
        straight = np.zeros((1, *self.whole.shape[:2]))
        return self.tangent(straight, straight)[0]

    def shortened(self, shape: Array) -> tuple[Array, Array]:
        """Give by how much elements of a shape are shorter than their axes (m), and the gradient by its dofs."""
        # shape (angles, elements, 4)
        bent = each(self.broken, shape)
        return self.kernels["shortening"](bent), each(self._back, self.kernels["slope"](bent))

    def curvature(self, shape: Array) -> Array:
        """Give the second derivative of that, ``(angles, elements, 4, 4)``."""
        return self._matrices("curvature", shape)

    def force(self, shape: Array, rate: Array) -> Array:
        """Give the forces of bending and shear on the dofs of the shape, ``(angles, elements, 4)``."""
        # shape, rate (angles, elements, 4)
        found = each(self._back, self.kernels["force"](each(self.broken, shape), each(self.broken, rate)))
        return found if self.shear is None else found + each(self.shear, shape + rate)

    def tangent(self, shape: Array, rate: Array) -> Array:
        """Give the derivative of these forces by the shape, ``(angles, elements, 4, 4)``."""
        return self._with_shear(self._matrices("force by v", shape, rate))

    def energy(self, shape: Array) -> Array:
        """Give the strain energy of bending and shear (J), ``(angles, elements)``."""
        found = np.asarray(self.kernels["energy"](each(self.broken, shape)))
        return found if self.shear is None else found + np.sum(shape * each(self.shear, shape), axis=-1) / 2

    def _with_shear(self, matrices: Array) -> Array:
        return matrices if self.shear is None else matrices + self.shear

    @property
    def _back(self) -> Array:
        return self.broken.transpose(0, 2, 1)

    @cached_property
    def _both(self) -> Array:
        return np.einsum("ebi,ecj->eijbc", self.broken, self.broken).reshape(-1, 16, 16)

    def _matrices(self, name: str, *states: Array) -> Array:
        """Matrices of a kernel at states, on the dofs of w, ``(angles, elements, 4, 4)``."""
        blocks = self.kernels[name](*(each(self.broken, state) for state in states))
        return each(self._both, blocks.reshape(*blocks.shape[:2], 16)).reshape(blocks.shape)


@cache
def _of_constant() -> dict[str, _fenicsx.CellKernel]:
    """Compile the forms with one EI for each cell, on a mesh of one cell."""
    mesh = _fenicsx.one_cell()
    return _kernels(mesh, np.zeros(1, dtype=int), _fenicsx.cellwise(_fenicsx.broken_line(mesh, 0), np.ones(1)))


def _kernels(mesh: Any, cells: Index, stiffness: Any) -> dict[str, _fenicsx.CellKernel]:
    """Compile the forms for cells of a mesh of lines, with EI as UFL coefficient (N m^2)."""
    space = _fenicsx.broken_line(mesh, 3)
    w, rate = _fenicsx.fem.Function(space), _fenicsx.fem.Function(space)
    test, trial = ufl.TestFunction(space), ufl.TrialFunction(space)
    shorter = shortening(w)
    slope = ufl.derivative(shorter, w, test)
    force = bending(w, rate, stiffness, test)
    forms = {
        "shortening": shorter,
        "slope": slope,
        "curvature": ufl.derivative(slope, w, trial),
        "force": force,
        "force by v": ufl.derivative(force, w, trial),
        "force by rate": ufl.derivative(force, rate, trial),
        "energy": bending_energy(w, stiffness),
    }
    return {name: _fenicsx.CellKernel(form, (w, rate), cells) for name, form in forms.items()}
