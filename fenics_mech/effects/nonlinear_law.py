"""The law of elements whose axes turn far: an axis keeps its arc length as it bends."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, each, times

if TYPE_CHECKING:
    from fenics_mech.beams.bent_axis import BentAxis
    from fenics_mech.beams.nonlinear_stretching import Stretching
    from fenics_mech.effects.section_spin import SectionSpin


@dataclass(frozen=True)
class ArcLength:
    """Elements with the stretch ``u' + 1 - sqrt(1 - w'^2)``, its mean over each, and the curvature of the bent axis.

    Derivatives are along the axis itself, so that w' is the sine of its rotation. The mean keeps a bent element from
    locking. Source: Reissner, J. Appl. Math. Phys. 23 (1972) 795, for strains of bending and stretch alone.

    Its methods take the displacement v and the velocity v' of the links' coordinates, and give what adds to the linear
    elastic forces. Newton's method takes each element's tension as an unknown of its own, beside v. It then needs few
    steps and no small ones: a tension that is computed from a bending not yet right is a bad guess, as members are
    stiff along their axes. Source: Magisano, Leonetti and Garcea, Int. J. Numer. Meth. Engng 109 (2017) 1237.

    Parameters
    ----------
    axis
        Shortening and bending of the elements.
    stretching
        Elongation of each element for small rotations, whose rate modal damping acts on.
    dofs
        The links' coordinates of each, ``(elements, n)``: nodal dofs, or where links are reduced what moves these.
    rigidity
        EA over the length (N/m), ``(elements,)``.
    material
        Retardation time: the tension is ``EA (strain + material * rate of strain)`` (s), and so is the moment. The rate
        is that of the whole strain: on the linear part alone it would damp bending away, as u' follows the shortening.
    of_nodes
        The same by the nodal dofs, where the links are reduced.
    spin
        Inertia of the sections beyond that of linear theory; None where they have none.
    """

    axis: BentAxis
    stretching: Stretching
    dofs: Index
    rigidity: Array
    material: float
    of_nodes: ArcLength | None = None
    spin: SectionSpin | None = None

    @property
    def on_elements(self) -> ArcLength:
        """The same by the nodal dofs."""
        return self.of_nodes or self

    def tension(self, v: Array, rate: Array) -> Array:
        """Mean axial force of each element (N), ``(angles, elements)``."""
        return self._forces(v[:, self.dofs], rate[:, self.dofs])[0]

    def force(self, v: Array, rate: Array) -> Array:
        """Forces of stretch and bending less their linear parts, ``(angles, elements, n)``."""
        v, rate, line = v[:, self.dofs], rate[:, self.dofs], self.stretching.line
        tension, gradient = self._forces(v, rate)
        linear = self.rigidity * np.sum(line * (v + self.material * rate), axis=-1)
        stretch = tension[..., None] * gradient - linear[..., None] * line
        return np.asarray(stretch + self.axis.force(v, self.material * rate))

    def shortening(self, v: Array) -> Array:
        """By how much each element is shorter than its axis, without stretch (m), ``(angles, elements)``."""
        return self.axis.shortening(v[:, self.dofs])[0]

    def energy(self, v: Array) -> Array:
        """Strain energy less that of linear theory (J), ``(angles, elements)``."""
        straight = np.sum(self.stretching.line * v[:, self.dofs], axis=-1)
        whole = straight + self.shortening(v)
        return np.asarray(self.rigidity * (whole**2 - straight**2) / 2 + self.axis.energy(v[:, self.dofs]))

    def linearised(self, v: Array, rate: Array, tension: Array) -> tuple[Array, Array, Array]:
        """Force about v, v' and a tension, ``constant + by_v v + by_rate v'``.

        Returns
        -------
        tuple
            The constant ``(angles, elements, n)``, and two matrices ``(angles, elements, n, n)``.
        """
        v, rate, line, rigidity = v[:, self.dofs], rate[:, self.dofs], self.stretching.line, self.rigidity
        found, gradient = self._forces(v, rate)
        curved = self.axis.shortening_curvature(v)
        lift = (rigidity[:, None] * gradient)[..., :, None]
        by_v = lift * (gradient + self.material * times(curved, rate))[..., None, :] + tension[..., None, None] * curved
        by_v += self.axis.tangent(v, self.material * rate)
        constant = found[..., None] * gradient + self.axis.force(v, self.material * rate)
        straight = rigidity[:, None, None] * line[:, :, None] * line[:, None, :]
        if not self.material:
            return constant - times(by_v, v), by_v - straight, np.zeros_like(by_v)
        by_rate = self.material * (lift * gradient[..., None, :] + self.axis.tangent_by_rate(v, self.material * rate))
        constant -= times(by_v, v) + times(by_rate, rate)
        return constant, by_v - straight, by_rate - self.material * straight

    def predicted(self, v: Array, rate: Array, new_v: Array, new_rate: Array) -> Array:
        """Tension at a new state by the strain linearised about the old one (N), ``(angles, elements)``."""
        v, rate, new_v, new_rate = (array[:, self.dofs] for array in (v, rate, new_v, new_rate))
        found, gradient = self._forces(v, rate)
        turned = gradient + self.material * times(self.axis.shortening_curvature(v), rate)
        change = np.sum(turned * (new_v - v), -1) + self.material * np.sum(gradient * (new_rate - rate), -1)
        return found + self.rigidity * change

    def axial(self, v: Array) -> Array:
        """Axial force of each element by the linear strain (N), ``(angles, ..., elements)`` of ``(angles, ..., v)``."""
        return self.rigidity * np.sum(self.stretching.line * v[..., self.dofs], axis=-1)

    def gradient(self, v: Array) -> Array:
        """Gradient of what bending adds to each element's elongation, to its first order, ``(angles, elements, n)``."""
        return each(self.stretching.bow, v[:, self.dofs])

    @property
    def bow(self) -> Array:
        """Second derivative of each element's elongation where it is straight (1/m ...), ``(elements, n, n)``."""
        return self.stretching.bow

    def _forces(self, v: Array, rate: Array) -> tuple[Array, Array]:
        """Tension, and the gradient of the elements' elongation; no numbers where an axis turns by 90 degrees."""
        shorter, slope = self.axis.shortening(v)
        gradient = self.stretching.line + slope
        elongation = np.sum(self.stretching.line * v, axis=-1) + shorter
        return self.rigidity * (elongation + self.material * np.sum(gradient * rate, axis=-1)), gradient
