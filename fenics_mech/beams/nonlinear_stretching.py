"""What tension and bending do to each other in an element."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech import _fenicsx
from fenics_mech.beams.forms import stretching
from fenics_mech.beams.layout import Layout, member_rotation

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Stretching:
    """Mean strain of each element, ``(line v + v^T bow v/2)/h``, in its dofs in link axes.

    Parameters
    ----------
    line
        ``(elements, 6)``.
    bow
        ``int w' z' dx``, ``(elements, 6, 6)`` (1/m ...).
    """

    line: Array
    bow: Array

    @classmethod
    def of(cls, layout: Layout) -> Stretching:
        """Assemble the derivatives of the energy's stretching part for a tension of 1 N."""
        rotation = member_rotation(layout.mesh)
        first, second = stretching(layout.space, layout.coefficient(np.ones(len(rotation))))
        broken = _fenicsx.assemble(second)
        line = np.einsum("ei,eij->ej", layout.vector_of_elements(first), rotation)
        bow = np.einsum("eia,eij,ejb->eab", rotation, layout.of_elements(broken), rotation)
        broken.destroy()
        return cls(line, bow)
