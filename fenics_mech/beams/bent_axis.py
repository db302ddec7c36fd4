"""Elements whose axes turn far: their shortening and their bending, for many states at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from fenics_mech import _fenicsx
from fenics_mech._arrays import Array, Index, each
from fenics_mech._fenicsx import ufl
from fenics_mech.beams.distributions import Distribution
from fenics_mech.beams.element_dofs import member_rotation
from fenics_mech.beams.forms.exact_strains import bending_beyond, bending_energy_beyond, shortening
from fenics_mech.beams.layout import Layout


@dataclass(frozen=True, eq=False)
class BentAxis:
    """Shortening and bending of elements in their dofs, ``(angles, elements, n)``.

    Parameters
    ----------
    kernels
        By name: of the shortening and its two derivatives, of the forces of bending and their two derivatives, and of
        the energy of bending.
    shape
        Dofs of the broken deflection by the dofs of each element, ``(elements, 4, n)``.
    """

    kernels: Mapping[str, _fenicsx.CellKernel]
    shape: Array

    @classmethod
    def of(cls, layout: Layout, stiffness: Distribution) -> BentAxis:
        """Give it in the nodal dofs of the elements in link axes; of a constant EI it is compiled once for all meshes.

        Parameters
        ----------
        layout
            The broken space of the mesh.
        stiffness
            EI (N m^2).
        """
        mesh, coefficient = layout.mesh, stiffness.coefficient
        if stiffness.varies:
            kernels = _kernels(mesh.mesh, mesh.cell, coefficient)
        else:
            kernels = {name: made.on(mesh.mesh, mesh.cell, coefficient) for name, made in _of_constant().items()}
        return cls(kernels, layout.broken_deflection @ member_rotation(mesh))

    def by(self, shape: Array) -> BentAxis:
        """Give it by what moves the elements' dofs; these are ``shape z``, ``(elements, dofs, n)``.

        Parameters
        ----------
        shape
            The elements' dofs by the coordinates z that move them, ``(elements, dofs, n)``.
        """
        return replace(self, shape=self.shape @ shape)

    def shortening(self, v: Array) -> tuple[Array, Array]:
        """Give by how much elements are shorter than their axes (m), and its gradient, ``(angles, elements, n)``.

        Parameters
        ----------
        v
            Displacement of the elements' dofs, ``(angles, elements, n)``.
        """
        w = self._deflection(v)
        return self.kernels["shortening"](w), self._carried(self.kernels["slope"](w))

    def shortening_curvature(self, v: Array) -> Array:
        """Give the second derivative of the shortening, ``(angles, elements, n, n)``.

        Parameters are those of `shortening`.
        """
        return self._matrices(self.kernels["curvature"](self._deflection(v)))

    def force(self, v: Array, rate: Array) -> Array:
        """Give the forces of bending, less the linear ones; the rate is times the retardation time.

        Parameters
        ----------
        v
            Displacement of the elements' dofs, ``(angles, elements, n)``.
        rate
            Its rate times the retardation time of the material, ``(angles, elements, n)``.
        """
        return self._carried(self.kernels["force"](self._deflection(v), self._deflection(rate)))

    def energy(self, v: Array) -> Array:
        """Give the strain energy of bending, less that of linear theory (J), ``(angles, elements)``.

        Parameters are those of `shortening`.
        """
        return self.kernels["energy"](self._deflection(v))

    def tangent(self, v: Array, rate: Array) -> Array:
        """Give the derivative of these forces by v, ``(angles, elements, n, n)``.

        Parameters are those of `force`.
        """
        return self._matrices(self.kernels["force by v"](self._deflection(v), self._deflection(rate)))

    def tangent_by_rate(self, v: Array, rate: Array) -> Array:
        """Give the derivative of these forces by the rate, ``(angles, elements, n, n)``.

        Parameters are those of `force`.
        """
        return self._matrices(self.kernels["force by rate"](self._deflection(v), self._deflection(rate)))

    def _deflection(self, v: Array) -> Array:
        return each(self.shape, v)

    def _carried(self, forces: Array) -> Array:
        return each(self.shape.transpose(0, 2, 1), forces)

    def _matrices(self, blocks: Array) -> Array:
        (elements, inner, outer), count = self.shape.shape, len(blocks)
        both = np.einsum("ebi,ecj->eijbc", self.shape, self.shape).reshape(elements, outer**2, inner**2)
        return each(both, blocks.reshape(count, elements, inner**2)).reshape(count, elements, outer, outer)


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
    force = bending_beyond(w, rate, stiffness, test)
    forms = {
        "shortening": shorter,
        "slope": slope,
        "curvature": ufl.derivative(slope, w, trial),
        "force": force,
        "force by v": ufl.derivative(force, w, trial),
        "force by rate": ufl.derivative(force, rate, trial),
        "energy": bending_energy_beyond(w, stiffness),
    }
    return {name: _fenicsx.CellKernel(form, (w, rate), cells) for name, form in forms.items()}
