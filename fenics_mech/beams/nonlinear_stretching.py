"""What tension and bending do to each other in an element."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech import _fenicsx
from fenics_mech._arrays import Array, each
from fenics_mech.beams.element_dofs import member_rotation
from fenics_mech.beams.forms import stretching
from fenics_mech.beams.layout import Layout


@dataclass(frozen=True)
class Stretching:
    """Elongation ``line v + v^T bow v/2`` of elements, in their dofs in link axes or in what moves these."""

    # It is the integral of von Karman's strain u' + w'^2/2.

    line: Array  # (elements, n)
    bow: Array  # int w' z' dx, (elements, n, n) (1/m ...)
    uneven: Array  # int (2 xi - 1) w' z' dx, xi from 0 to 1 in each element, (elements, n, n) (1/m ...)

    def bowed(self, a: Array, b: Array) -> Array:
        """``a^T bow b`` of two displacements ``(angles, elements, n)``, ``(angles, elements)`` (m)."""
        # a, b (angles, elements, n)
        return _product(self.bow, a, b)

    def by(self, shape: Array) -> Stretching:
        """Give it by what moves the elements' dofs; these are ``shape z``, ``(elements, dofs, n)``."""
        line, back = np.einsum("ei,ein->en", self.line, shape), shape.transpose(0, 2, 1)
        return Stretching(line, back @ self.bow @ shape, back @ self.uneven @ shape)

    @classmethod
    def of(cls, layout: Layout) -> Stretching:
        """Assemble the derivatives of the energy's stretching part for tensions of 1 N, even and uneven."""
        rotation = member_rotation(layout.mesh)
        first, *second = stretching(layout.space, layout.coefficient(np.ones(len(rotation))), layout.coordinate)
        line = np.einsum("ei,eij->ej", layout.vector_of_elements(first), rotation)
        return cls(line, *(_in_links(layout, form, rotation) for form in second))


def _product(blocks: Array, a: Array, b: Array) -> Array:
    return np.asarray(np.sum(a * each(blocks, b), axis=-1))


def _in_links(layout: Layout, form: Any, rotation: Array) -> Array:
    """Assemble a bilinear form: its blocks in the elements' dofs in link axes, ``(elements, 6, 6)``."""
    blocks = layout.of_elements(_fenicsx.assemble_matrix(form))
    return np.einsum("eia,eij,ejb->eab", rotation, blocks, rotation)
