"""What tension and bending do to each other in an element."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech import _fenicsx
from fenics_mech._arrays import Array, each
from fenics_mech.beams.element_dofs import member_rotation
from fenics_mech.beams.forms import stretching
from fenics_mech.beams.layout import Layout


@dataclass(frozen=True)
class Stretching:
    """Elongation ``line v + v^T bow v/2`` of elements, in their dofs in link axes or in what moves these.

    It is the integral of von Karman's strain ``u' + w'^2/2``.

    Parameters
    ----------
    line
        ``(elements, n)``.
    bow
        ``int w' z' dx``, ``(elements, n, n)`` (1/m ...).
    """

    line: Array
    bow: Array

    def bowed(self, a: Array, b: Array) -> Array:
        """``a^T bow b`` of two displacements ``(angles, elements, n)``, ``(angles, elements)`` (m).

        Parameters
        ----------
        a, b
            The displacements, ``(angles, elements, n)``.
        """
        return np.asarray(np.sum(a * each(self.bow, b), axis=-1))

    def by(self, shape: Array) -> Stretching:
        """Give it by what moves the elements' dofs; these are ``shape z``, ``(elements, dofs, n)``.

        Parameters
        ----------
        shape
            The elements' dofs by the coordinates z that move them, ``(elements, dofs, n)``.
        """
        line = np.einsum("ei,ein->en", self.line, shape)
        return Stretching(line, shape.transpose(0, 2, 1) @ self.bow @ shape)

    @classmethod
    def of(cls, layout: Layout) -> Stretching:
        """Assemble the derivatives of the energy's stretching part for a tension of 1 N.

        Parameters
        ----------
        layout
            The broken space of the mesh.
        """
        rotation = member_rotation(layout.mesh)
        first, second = stretching(layout.space, layout.coefficient(np.ones(len(rotation))))
        broken = _fenicsx.assemble_matrix(second)
        line = np.einsum("ei,eij->ej", layout.vector_of_elements(first), rotation)
        bow = np.einsum("eia,eij,ejb->eab", rotation, layout.of_elements(broken), rotation)
        broken.destroy()
        return cls(line, bow)
