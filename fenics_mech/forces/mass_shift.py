"""How bending moves the mass of elements along their axes, where axial forces that change inside them act on it.

Bending draws the points of an axis together. An element's shape functions hold its ends, and its mean stretch is that
of its axial force; between them its mass moves along the axis by s in the mean. With ``int (2 xi - 1) w' z' dx`` as
matrix B of an element, ``s = v^T B v/4``. What changes the axial force along the element is inertia and loads along
it, half of which is the slope c of `AxialForces`. In s they do the work ``- 2 c ds = - c v^T B dv``, which is that of
the stiffness `AxialStiffness.uneven`. So torque and energy have s too.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.element_dofs import element_dofs, in_member_axes
from fenics_mech.beams.nonlinear_stretching import half_square_in_time
from fenics_mech.beams.shapes import AXIAL
from fenics_mech.effects import Loads
from fenics_mech.mechanism import System
from fenics_mech.terms.causes import Cause

if TYPE_CHECKING:
    from fenics_mech.forces.rates import Acceleration, Rates


@dataclass(frozen=True)
class MassShift:
    """The shift s of the mass of each element along its member.

    Parameters
    ----------
    system
        The mechanism, with uneven axial forces.
    jets
        Elastic displacement v in link axes and its two time derivatives, each ``(angles, nodal dofs)``.
    """

    system: System
    jets: tuple[Array, Array, Array]

    @cached_property
    def in_time(self) -> tuple[Array, Array, Array]:
        """Give s and its two time derivatives (m, m/s, m/s^2), each ``(angles, elements)``."""
        return half_square_in_time(self._pair, self.jets)

    def by_change(self, change: Array) -> Array:
        """Change of s by a small change of v, or of its rate by one of v', ``(angles, elements)``.

        Parameters
        ----------
        change
            The change in link axes, ``(angles, nodal dofs)``.
        """
        return self._pair(change, self.jets[0])

    def works(self, accelerations: Mapping[str, Acceleration], rates: Rates, rate: Array) -> dict[str, Array]:
        """Work of each cause of inertia in the shift, ``(angles,)`` each.

        Parameters
        ----------
        accelerations
            Accelerations of the straight links by cause, which the axial forces balance.
        rates
            Rates in which the inertia does work, true or virtual.
        rate
            The rate of s in these, ``(angles, elements)``.
        """
        omega, shift = self._of_elements(rates.turning), self.in_time[0]
        found: dict[str, Array] = {}
        for name, a in accelerations.items():
            along, turned = self._momenta(a.of_nodes, a.turning)
            found[name] = -np.sum(along * rate + omega * turned * shift, axis=1)
        return found

    def own_works(self, turning: Array, tangential: tuple[Array, float], rigid: Array) -> dict[str, Array]:
        """Work of the shift's own inertia and drag in rates of the rigid motion, ``(angles,)`` each.

        Parameters
        ----------
        turning
            Angular velocity of the link of each nodal dof, of the motion itself (rad/s), ``(angles, nodal dofs)``.
        tangential
            Angular acceleration (rad/s^2) like it, and the external drag per mass (1/s).
        rigid
            Velocity of the nodal dofs by the rates, ``(angles, nodal dofs)``.
        """
        (shift, first, second), (alpha, drag) = self.in_time, tangential
        omega, alpha = self._of_elements(turning), self._of_elements(alpha)
        along, turned = self._momenta(rigid, np.zeros_like(rigid))
        across = 2 * omega * first + alpha * shift
        found: dict[str, Array] = {}
        found[Cause.INERTIA] = -np.sum((second - omega**2 * shift) * along + across * turned, axis=1)
        if drag:
            found[Cause.EXTERNAL_DRAG] = -drag * np.sum(first * along + omega * shift * turned, axis=1)
        return found

    def momentum(self, rigid: Array, rate: Array, swing: Array | None = None) -> Array:
        """Product of the momentum of the shift with a velocity of the straight links (J), ``(angles,)``.

        Parameters
        ----------
        rigid
            That velocity of the nodal dofs, ``(angles, nodal dofs)``.
        rate
            Rate of s, ``(angles, elements)``.
        swing
            Angular velocity of the link of each nodal dof, which turns s, ``(angles, nodal dofs)``.
        """
        along, turned = self._momenta(rigid, np.zeros_like(rigid))
        found = along * rate
        if swing is not None:
            found += self._of_elements(swing) * turned * self.in_time[0]
        return np.asarray(found.sum(axis=1))

    def of_loads(self, loads: Loads, turned: Loads, turning: Array, rate: Array) -> Array:
        """Work of loads along the elements in the shift, ``(angles,)``.

        Parameters
        ----------
        loads, turned
            The loads, and the same turned by a quarter clockwise.
        turning
            Angular velocity of the link of each nodal dof (rad/s), ``(angles, nodal dofs)``.
        rate
            The rate of s, ``(angles, elements)``.
        """
        swung = self._of_elements(turning) * self.in_time[0]
        return np.asarray(np.sum(self._along(loads) * rate + self._along(turned) * swung, axis=1))

    def _along(self, loads: Loads) -> Array:
        """Loads on each element along its member (N), ``(angles, elements)``, but for those on nodes."""
        found = np.zeros_like(self.in_time[0])
        if loads.line is not None:
            found = found + loads.line[..., :2].mean(axis=-1) * self.system.beams.mesh.cell_length
        return found if loads.ends is None else found + loads.ends[..., AXIAL].sum(axis=-1)

    def _momenta(self, of_nodes: Array, turning: Array) -> tuple[Array, Array]:
        """Products of an acceleration, or velocity, with a unit shift of the mass and with the same turned by 1 rad."""
        beams, unit = self.system.beams, np.zeros(6)
        unit[AXIAL] = 1.0
        mass, gyroscopic = beams.element_mass @ unit, beams.element_gyroscopic @ unit
        a, t = in_member_axes(beams.mesh, of_nodes), in_member_axes(beams.mesh, turning)
        along = np.sum(a * mass - t * gyroscopic, axis=-1)  # the gyroscopic matrix is skew
        return along, np.sum(a * gyroscopic + t * mass, axis=-1)

    def _of_elements(self, of_dofs: Array) -> Array:
        """Values of the elements' links, ``(angles, elements)``, from those of the links of nodal dofs."""
        return of_dofs[:, element_dofs(self.system.beams.mesh)[:, 0]]

    def _pair(self, a: Array, b: Array) -> Array:
        """``a^T B b/2`` of each element (m), ``(angles, elements)``."""
        dofs = element_dofs(self.system.beams.mesh)
        return self.system.beams.stretching.unevenly_bowed(a[:, dofs], b[:, dofs]) / 2
