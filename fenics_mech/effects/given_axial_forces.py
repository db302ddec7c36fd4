"""Axial forces that are given: how they change along elements, and their stiffness against bending."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fenics_mech._arrays import Array

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams


@dataclass(frozen=True)
class AxialForces:
    """Axial forces ``mean + slope (2 xi - 1)`` along the elements, xi from 0 to 1 in each.

    Loads and inertia along an element, which are even over it, make such a force.

    Parameters
    ----------
    mean
        Mean over each element (N), ``(angles, elements)``.
    slope
        Half of what the force changes along each element (N), ``(angles, elements)``.
    """

    mean: Array
    slope: Array


@dataclass(frozen=True)
class AxialStiffness:
    """Stiffness of axial forces that are given, linear in the elastic displacement.

    Parameters
    ----------
    force
        Mean axial force of each element, or half of what it changes along the element (N), ``(angles, elements)``.
    blocks
        Blocks of the elements in link axes, ``(angles, elements, 6, 6)`` (N/m ...).
    """

    force: Array
    blocks: Array

    @classmethod
    def even(cls, beams: Beams, mean: Array) -> AxialStiffness:
        """Give ``int N w' z' dx`` with the mean axial force N of each element.

        Parameters
        ----------
        beams
            The links' matrices.
        mean
            As `AxialForces.mean`.
        """
        return cls(mean, mean[..., None, None] * beams.stretching.bow)

    @classmethod
    def uneven(cls, beams: Beams, slope: Array) -> AxialStiffness:
        """Give ``int n w' z' dx`` with ``n = slope (2 xi - 1)``, what the axial force changes along each element.

        Without it the error of a mesh falls with the second power of the elements' length instead of the fourth.

        Parameters
        ----------
        beams
            The links' matrices.
        slope
            As `AxialForces.slope`.
        """
        return cls(slope, slope[..., None, None] * beams.stretching.uneven)
