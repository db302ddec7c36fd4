"""Moderate rotations: bending shortens a member, and its axial force acts on the bent axis (von Karman)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, each
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.effects.effect import Effect, Survey
from fenics_mech.effects.terms import Situation, Terms

if TYPE_CHECKING:
    from fenics_mech.beams.nonlinear_stretching import Stretching

NEAR_BUCKLING = 0.8  # of a mode's stiffness, that axial forces take


@dataclass(frozen=True)
class VonKarman:
    """Elements with the strain ``u' + w'^2/2``, its mean over each.

    Parameters
    ----------
    stretching
        Elongation of each element by its dofs.
    dofs
        The links' coordinates of each, ``(elements, n)``: nodal dofs, or where links are reduced what moves these.
    rigidity
        EA over the length (N/m), ``(elements,)``.
    material
        Retardation time: the tension is ``EA (strain + material * rate of strain)`` (s). The rate is that of the whole
        strain: on the linear part alone it would damp bending away, as u' follows -w'^2/2.
    of_nodes
        The same by the nodal dofs, where the links are reduced.
    """

    stretching: Stretching
    dofs: Index
    rigidity: Array
    material: float
    of_nodes: VonKarman | None = None

    @property
    def on_elements(self) -> VonKarman:
        """The same by the nodal dofs."""
        return self.of_nodes or self

    def tension(self, v: Array, rate: Array) -> Array:
        """Mean axial force of each element (N), ``(angles, elements)``."""
        return self._forces(v[:, self.dofs], rate[:, self.dofs])[0]

    def force(self, v: Array, rate: Array) -> Array:
        """``N (line + bow v)`` less its linear part, ``(angles, elements, n)``."""
        v, rate = v[:, self.dofs], rate[:, self.dofs]
        tension, turned = self._forces(v, rate)
        linear = self.rigidity * np.einsum("ei,tei->te", self.stretching.line, v + self.material * rate)
        return np.asarray(tension[..., None] * turned - linear[..., None] * self.stretching.line)

    def linearised(self, v: Array, rate: Array, tension: Array) -> tuple[Array, Array, Array]:
        """Force about v, v' and a tension, see `Law`."""
        v, rate = v[:, self.dofs], rate[:, self.dofs]
        found, turned = self._forces(v, rate)
        line, bow = self.stretching.line, self.stretching.bow
        gained = turned + self.material * each(bow, rate)  # change of the tension with v, over the rigidity
        known = np.sum(gained * v, -1) + self.material * np.sum(turned * rate, -1)
        constant = (found - self.rigidity * known)[..., None] * turned - tension[..., None] * each(bow, v)
        lift = (self.rigidity[:, None] * turned)[..., None]
        straight = self.rigidity[:, None, None] * line[:, :, None] * line[:, None, :]
        by_v = lift * gained[..., None, :]
        by_v += tension[..., None, None] * bow
        by_v -= straight
        by_rate = lift * (self.material * turned)[..., None, :]
        by_rate -= self.material * straight
        return constant, by_v, by_rate

    def predicted(self, v: Array, rate: Array, new_v: Array, new_rate: Array) -> Array:
        """Tension at a new state by the strain linearised about the old one (N), ``(angles, elements)``."""
        v, rate, new_v, new_rate = (array[:, self.dofs] for array in (v, rate, new_v, new_rate))
        found, turned = self._forces(v, rate)
        swing = self.material * each(self.stretching.bow, rate)
        change = np.sum((turned + swing) * (new_v - v), -1) + self.material * np.sum(turned * (new_rate - rate), -1)
        return found + self.rigidity * change

    def axial(self, v: Array) -> Array:
        """Axial force of each element by the linear strain (N), ``(angles, ..., elements)`` of ``(angles, ..., v)``."""
        return self.rigidity * np.sum(self.stretching.line * v[..., self.dofs], axis=-1)

    def gradient(self, v: Array) -> Array:
        """Gradient of the nonlinear part of each element's elongation, ``(angles, elements, n)``; it is linear in v."""
        return each(self.stretching.bow, v[:, self.dofs])

    @property
    def bow(self) -> Array:
        """Second derivative of each element's elongation (1/m ...), ``(elements, n, n)``."""
        return self.stretching.bow

    def _forces(self, v: Array, rate: Array) -> tuple[Array, Array]:
        """Tension, and the change of the element's elongation with its dofs, ``line + bow v``."""
        elongation, turned = self.stretching.elongation(v)
        return self.rigidity * (elongation + self.material * np.sum(turned * rate, -1)), turned


def terms(situation: Situation) -> Terms:
    """Give the law of the elements."""
    beams, material = situation.beams, situation.scene.damping.material
    rigidity = beams.rigidity.axial.mean / beams.mesh.cell_length
    of_nodes = VonKarman(beams.stretching, element_dofs(beams.mesh), rigidity, material)
    if beams.reduction is None:
        return Terms(law=of_nodes)
    coordinates, shape = beams.reduction.of_elements
    return Terms(law=VonKarman(beams.stretching.by(shape), coordinates, rigidity, material, of_nodes))


def size(survey: Survey) -> float:
    """Estimate what the elastic motion adds to axial forces, and how far bending shortens members.

    An arc of height a over a chord L is longer by ``(pi a)^2/(4 L)`` if it is a half-wave of a sine: over a itself, a
    share of ``pi^2 a/(4 L)`` of the deflection. Where axial forces come near to buckling, only the shortening holds the
    members.
    """
    near = survey.tension if survey.tension > NEAR_BUCKLING else 0.0
    bow = survey.bow * (1 + survey.vibration)
    return max(survey.tension * survey.vibration, math.pi**2 / 4 * bow, near) * survey.sensitivity


EFFECT = Effect(
    name="moderate-rotations",
    meaning="von Karman strains: bending shortens a member, axial forces act on its bent axis",
    source="von Karman (1910); Reddy, An Introduction to Nonlinear Finite Element Analysis, ch. 4",
    terms=terms,
    stress_stiffening=True,
    nonlinear=True,
    replaces="geometric-stiffness",
    refuses=("geometric-stiffness",),
    size=size,
    estimate="change of stiffness x vibration, or (pi^2/4) bow/length",
)
