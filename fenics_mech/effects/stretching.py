"""What tension and bending do to each other in an element; shared by geometric stiffness and moderate rotations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech.beams import Beams
from fenics_mech.beams.forms import stretching
from fenics_mech.beams.layout import member_rotation
from fenics_mech.effects.terms import Array


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
    def of(cls, beams: Beams) -> Stretching:
        """Assemble the derivatives of the energy's stretching part for a tension of 1 N."""
        layout, rotation = beams.layout, member_rotation(beams.mesh)
        first, second = stretching(layout.space, layout.coefficient(np.ones(len(rotation))))
        broken = layout.assemble(second)
        line = np.einsum("ei,eij->ej", layout.vector_of_elements(first), rotation)
        bow = np.einsum("eia,eij,ejb->eab", rotation, layout.of_elements(broken), rotation)
        broken.destroy()
        return cls(line, bow)
