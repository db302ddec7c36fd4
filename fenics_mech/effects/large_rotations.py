"""Large rotations: an axis keeps its arc length as it bends, and axial forces act on the bent axis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, each, times
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.effects.effect import Effect, Survey
from fenics_mech.effects.given_axial_forces import UnevenTension
from fenics_mech.effects.terms import Situation, Terms

if TYPE_CHECKING:
    from fenics_mech.beams.bent_axis import BentAxis
    from fenics_mech.beams.nonlinear_stretching import Stretching

NEAR_BUCKLING = 0.8  # of a mode's stiffness, that axial forces take


@dataclass(frozen=True)
class ArcLength:
    """Elements with the stretch ``u' + 1 - sqrt(1 - w'^2)``, its mean over each, and the curvature of the bent axis.

    Derivatives are along the axis itself, so that w' is the sine of its rotation. The mean keeps a bent element from
    locking. Source: Reissner, J. Appl. Math. Phys. 23 (1972) 795, for strains of bending and stretch alone.

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
    """

    axis: BentAxis
    stretching: Stretching
    dofs: Index
    rigidity: Array
    material: float
    of_nodes: ArcLength | None = None

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
        """Force about v, v' and a tension, see `Law`."""
        v, rate, line, rigidity = v[:, self.dofs], rate[:, self.dofs], self.stretching.line, self.rigidity
        found, gradient = self._forces(v, rate)
        curved = self.axis.shortening_curvature(v)
        lift = (rigidity[:, None] * gradient)[..., :, None]
        by_v = lift * (gradient + self.material * times(curved, rate))[..., None, :] + tension[..., None, None] * curved
        bending_by_v, bending_by_rate = self.axis.tangents(v, self.material * rate)
        by_v += bending_by_v
        by_rate = self.material * (lift * gradient[..., None, :] + bending_by_rate)
        constant = found[..., None] * gradient + self.axis.force(v, self.material * rate)
        constant -= times(by_v, v) + times(by_rate, rate)
        straight = rigidity[:, None, None] * line[:, :, None] * line[:, None, :]
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


def terms(situation: Situation) -> Terms:
    """Give the law of the elements, and what axial forces of loads and rigid motion change along each."""
    beams, material = situation.beams, situation.scene.damping.material
    axis, stretching = beams.bent_axis, beams.stretching
    rigidity = beams.rigidity.axial.mean / beams.mesh.cell_length
    of_nodes = ArcLength(axis, stretching, element_dofs(beams.mesh), rigidity, material)
    uneven = (UnevenTension.of(beams, situation.uneven()),)
    if beams.reduction is None:
        return Terms(law=of_nodes, uneven=uneven)
    coordinates, shape = beams.reduction.of_elements
    law = ArcLength(axis.by(shape), stretching.by(shape), coordinates, rigidity, material, of_nodes)
    return Terms(law=law, uneven=uneven)


def size(survey: Survey) -> float:
    """Estimate what the elastic motion adds to axial forces, and how far bending shortens members.

    A half-wave of a sine of height a over a chord L is longer than the chord by ``(pi a)^2/(4 L)``. That is the share
    ``pi^2 a/(4 L)`` of the deflection a. Near buckling only the shortening holds the members.
    """
    near = survey.tension if survey.tension > NEAR_BUCKLING else 0.0
    bow = survey.bow * (1 + survey.vibration)
    return max(survey.tension * survey.vibration, math.pi**2 / 4 * bow, near) * survey.sensitivity


EFFECT = Effect(
    name="large-rotations",
    meaning="exact strains: bending shortens a member, axial forces act on its bent axis",
    source="Reissner (1972); Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 849",
    terms=terms,
    stress_stiffening=True,
    nonlinear=True,
    replaces="geometric-stiffness",
    refuses=("geometric-stiffness",),
    size=size,
    estimate="change of stiffness x vibration, or (pi^2/4) bow/length",
    loads_at_nodes=True,
)
