"""Factors F of the modes' damping ``F^T F``, over all coordinates or over few.

Both kinds give the same things to the equation of motion. `values` are F's numbers, ``(angles, modes, ...)``.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.nonlinear_law import ArcLength
from fenics_mech.mechanism.modal_forces import ModalForces
from fenics_mech.mechanism.reduced_damping import ReducedLinks

if TYPE_CHECKING:
    from fenics_mech.mechanism.equation import Equation


@dataclass(frozen=True, eq=False)
class FullFactor:
    """F over the coordinates.

    Parameters
    ----------
    values
        F, ``(angles, modes, coordinates)``.
    """

    values: Array

    def unit(self, equation: Equation) -> Array:
        """What F's columns are divided by for their numbers to be alike, ``(coordinates,)``."""
        return np.sqrt(equation.links_stiffness.diagonal.mean(axis=0))

    def strained(self, equation: Equation) -> Array:
        """Coordinates whose elastic forces are those of each mode, ``(angles, modes, coordinates)``."""
        return equation.links_stiffness.solve(self.values)

    def forces(self, equation: Equation, strained: Array) -> ModalForces:
        """Give the forces of modes that strain the links so; see `Equation.modal_strain`."""
        return ModalForces(self.values, self.values, equation.links_turning.transposed.times(strained))

    def axial(self, equation: Equation, strained: Array, law: ArcLength) -> Array:
        """Give the axial forces of the elements of modes that strain the links so, ``(angles, modes, elements)``."""
        return law.axial(equation.system.transformation.forward(equation.system.values[:, None], strained))


@dataclass(frozen=True, eq=False)
class ReducedFactor:
    """F over the coordinates of links by few.

    Parameters
    ----------
    values
        F, ``(angles, modes, reduced coordinates)``.
    links
        The links that are reduced.
    """

    values: Array
    links: ReducedLinks

    def unit(self, equation: Equation) -> Array:
        """What F's columns are divided by for their numbers to be alike, ``(reduced coordinates,)``."""
        return np.sqrt(self.links.stiffness(equation.system.motion).diagonal.mean(axis=0))

    def strained(self, equation: Equation) -> Array:
        """Few coordinates of the links whose elastic forces are those of each mode, ``(angles, modes, few)``."""
        return self.links.links_by(self.values, equation.system.motion)

    def forces(self, equation: Equation, strained: Array) -> ModalForces:
        """Give the forces of modes that strain the links so; see `Equation.modal_strain`."""
        return self.links.forces(strained, equation.system.values, equation.turned)

    def axial(self, equation: Equation, strained: Array, law: ArcLength) -> Array:
        """Give the axial forces of the elements of modes that strain the links so, ``(angles, modes, elements)``."""
        return self.links.axial(strained, law)


DampingFactor = FullFactor | ReducedFactor
