"""Factors F of the modes' damping ``F^T F``, over all coordinates or over few.

Both kinds give the same things to the equation of motion. `values` are F's numbers, ``(angles, modes, ...)``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from fenics_mech._arrays import Array
from fenics_mech.effects.nonlinear_law import ArcLength
from fenics_mech.mechanism.modal_forces import ModalForces
from fenics_mech.mechanism.reduced_damping import ReducedLinks

if TYPE_CHECKING:
    from fenics_mech.mechanism.equation import Equation
    from fenics_mech.mechanism.system import System

MOST = 1_000_000  # numbers of F, up to which what is made of it is kept with the positions
Made = TypeVar("Made")


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
        return equation.system.transformation.unit_of(equation.links_stiffness.diagonal)

    def strained(self, equation: Equation) -> Array:
        """Coordinates whose elastic forces are those of each mode, ``(angles, modes, coordinates)``."""
        return self._once(equation.system, "strains of modes", lambda: equation.links_stiffness.solve(self.values))

    def forces(self, equation: Equation, strained: Array) -> ModalForces:
        """Give the forces of modes that strain the links so; see `Equation.modal_strain`."""
        path, transformation = equation.system.motion.path, equation.system.transformation

        def turning(turned: Array) -> ModalForces:
            by_place = equation.links_turning_by(turned).transposed.times(strained)
            return ModalForces(self.values, self.values, by_place)

        if path is None or not self._lasts(equation.system):
            return turning(equation.turned)
        slope = transformation.derivatives(path.motion(1.0))[0]
        known = self._once(equation.system, "forces of modes", lambda: turning(slope))
        return known.at_rate(equation.system.motion.rate)

    def axial(self, equation: Equation, strained: Array, law: ArcLength) -> Array:
        """Give the axial forces of the elements of modes that strain the links so, ``(angles, modes, elements)``."""
        forward, values = equation.system.transformation.forward, equation.system.values[:, None]
        return self._once(equation.system, "axial forces of modes", lambda: law.axial(forward(values, strained)))

    def _lasts(self, system: System) -> bool:
        """Whether F is that of all rates of the drive, as no axial force stiffens, and little enough to be kept."""
        terms = system.terms
        return self.values.size <= MOST and (terms.law is not None or not terms.axial_stiffness)

    def _once(self, system: System, what: str, make: Callable[[], Made]) -> Made:
        """Make something from F and the positions, once for all rates of the drive where F is that of all."""
        if system.motion.path is None or not self._lasts(system):
            return make()
        return system.motion.path.once(what, (system.beams, system.transformation, self.values), make)


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
        return self.links.transformation.unit_of(self.links.stiffness(equation.system.motion).diagonal)

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
