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
class StressStiffening:
    """Stiffness of axial forces that are given, linear in the elastic displacement.

    Parameters
    ----------
    tension
        Mean axial force of each element (N), ``(angles, elements)``.
    blocks
        Blocks of the elements in link axes, ``(angles, elements, 6, 6)`` (N/m ...).
    """

    tension: Array
    blocks: Array

    @classmethod
    def of(cls, beams: Beams, tension: Array) -> StressStiffening:
        """Give ``int N w' z' dx`` with the mean axial force N of each element (N), ``(angles, elements)``.

        Parameters
        ----------
        beams
            The links' matrices.
        tension
            The axial forces.
        """
        return cls(tension, tension[..., None, None] * beams.stretching.bow)


@dataclass(frozen=True)
class UnevenTension:
    """Stiffness of what axial forces that are given change along the elements.

    Without it the force is its mean in each element, and the error of a mesh falls with the second power of the
    elements' length instead of the fourth.

    Parameters
    ----------
    slope
        Half of what the force changes along each element (N), ``(angles, elements)``.
    blocks
        Blocks of the elements in link axes, ``(angles, elements, 6, 6)`` (N/m ...).
    """

    slope: Array
    blocks: Array

    @classmethod
    def of(cls, beams: Beams, slope: Array) -> UnevenTension:
        """Give ``int n w' z' dx`` with ``n = slope (2 xi - 1)`` (N).

        Parameters
        ----------
        beams
            The links' matrices.
        slope
            As `AxialForces.slope`.
        """
        return cls(slope, slope[..., None, None] * beams.stretching.uneven)
