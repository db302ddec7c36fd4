"""Moderate rotations: bending shortens a member, and its axial force acts on the bent axis (von Karman)."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import each, times
from fenics_mech.beams.layout import element_dofs
from fenics_mech.beams.stretching import Stretching
from fenics_mech.effects.effect import Effect, Survey
from fenics_mech.effects.terms import Array, Index, Situation, Terms

NEAR_BUCKLING = 0.8  # of a mode's stiffness, that axial forces take


@dataclass(frozen=True)
class VonKarman:
    """Elements with the strain ``u' + w'^2/2``, its mean over each element.

    Parameters
    ----------
    stretching
        Strain of the elements.
    dofs
        Nodal dofs of the elements, ``(elements, 6)``.
    rigidity
        EA over the element's length (N/m), ``(elements,)``.
    material
        Retardation time: the tension is ``EA (strain + material * rate of strain)`` (s). The rate is that of the whole
        strain: on the linear part alone it would damp bending away, as u' follows -w'^2/2.
    """

    stretching: Stretching
    dofs: Index
    rigidity: Array
    material: float

    def tension(self, v: Array, rate: Array) -> Array:
        """Axial force of each element (N), ``(angles, elements)``."""
        return self._forces(v[:, self.dofs], rate[:, self.dofs])[0]

    def force(self, v: Array, rate: Array) -> Array:
        """``N (line + bow v)`` less its linear part, ``(angles, elements, 6)``."""
        v, rate = v[:, self.dofs], rate[:, self.dofs]
        tension, turned = self._forces(v, rate)
        linear = self.rigidity * np.einsum("ei,tei->te", self.stretching.line, v + self.material * rate)
        return tension[..., None] * turned - linear[..., None] * self.stretching.line

    def linearised(self, v: Array, rate: Array, tension: Array) -> tuple[Array, Array, Array]:
        """Force about v, v' and a tension, see `Law`."""
        v, rate = v[:, self.dofs], rate[:, self.dofs]
        found, turned = self._forces(v, rate)
        line, bow, rigidity = self.stretching.line, self.stretching.bow, self.rigidity[:, None, None]
        swing = self.material * each(bow, rate)  # change of the strain's rate with v
        lift = turned[..., :, None]
        by_v = rigidity * lift * (turned + swing)[..., None, :]
        by_rate = self.material * rigidity * lift * turned[..., None, :]
        constant = found[..., None] * turned - times(by_v, v) - times(by_rate, rate)
        constant -= tension[..., None] * each(bow, v)
        straight = rigidity * line[:, :, None] * line[:, None, :]
        return constant, by_v + tension[..., None, None] * bow - straight, by_rate - self.material * straight

    def predicted(self, v: Array, rate: Array, new_v: Array, new_rate: Array) -> Array:
        """Tension at a new state by the strain linearised about the old one (N), ``(angles, elements)``."""
        v, rate, new_v, new_rate = (array[:, self.dofs] for array in (v, rate, new_v, new_rate))
        found, turned = self._forces(v, rate)
        swing = self.material * each(self.stretching.bow, rate)
        change = np.sum((turned + swing) * (new_v - v), -1) + self.material * np.sum(turned * (new_rate - rate), -1)
        return found + self.rigidity * change

    def _forces(self, v: Array, rate: Array) -> tuple[Array, Array]:
        """Tension, and the change of the element's elongation with its dofs, ``line + bow v``."""
        bent = each(self.stretching.bow, v)
        turned = self.stretching.line + bent
        elongation = np.sum((self.stretching.line + bent / 2) * v, -1)
        return self.rigidity * (elongation + self.material * np.sum(turned * rate, -1)), turned


def terms(situation: Situation) -> Terms:
    """Give the law of the elements."""
    beams = situation.beams
    rigidity = beams.axial_rigidity / beams.mesh.cell_length
    material = situation.scene.damping.material
    return Terms(law=VonKarman(beams.stretching, element_dofs(beams.mesh), rigidity, material))


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
    replaces="geometric-stiffness",
    refuses=("geometric-stiffness",),
    size=size,
    estimate="change of stiffness x vibration, or (pi^2/4) bow/length",
)
