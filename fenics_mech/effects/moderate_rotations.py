"""Moderate rotations: bending shortens a member, and its axial force acts on the bent axis (von Karman)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array, Index, each, summed, times
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.effects.effect import Effect, Survey
from fenics_mech.effects.terms import Situation, Terms

if TYPE_CHECKING:
    from fenics_mech.beams.nonlinear_stretching import Stretching

NEAR_BUCKLING = 0.8  # of a mode's stiffness, that axial forces take


@dataclass(frozen=True)
class VonKarman:
    """Strings with the strain ``u' + w'^2/2``, its mean over each: a string is an element, or a member that is reduced.

    Parameters
    ----------
    stretching
        Elongation of each string, padded with zeros where strings have fewer dofs than others.
    dofs
        The links' coordinates of each, ``(strings, n)``.
    rigidity
        EA over the length (N/m), ``(strings,)``.
    material
        Retardation time: the tension is ``EA (strain + material * rate of strain)`` (s). The rate is that of the whole
        strain: on the linear part alone it would damp bending away, as u' follows -w'^2/2.
    on_elements
        The same, element by element.
    spread
        Stiffness by what the tension inside a string differs from its mean, ``(angles, strings, n, n)``.
    """

    stretching: Stretching
    dofs: Index
    rigidity: Array
    material: float
    on_elements: OnElements
    spread: Array | None = None

    def tension(self, v: Array, rate: Array) -> Array:
        """Mean axial force of each string (N), ``(angles, strings)``."""
        return self._forces(v[:, self.dofs], rate[:, self.dofs])[0]

    def force(self, v: Array, rate: Array) -> Array:
        """``N (line + bow v)`` less its linear part, ``(angles, strings, n)``."""
        v, rate = v[:, self.dofs], rate[:, self.dofs]
        tension, turned = self._forces(v, rate)
        linear = self.rigidity * np.einsum("ei,tei->te", self.stretching.line, v + self.material * rate)
        found = tension[..., None] * turned - linear[..., None] * self.stretching.line
        return found if self.spread is None else found + times(self.spread, v)

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
        by_v += tension[..., None, None] * bow - straight
        if self.spread is not None:
            by_v += self.spread
        return constant, by_v, by_rate - self.material * straight

    def predicted(self, v: Array, rate: Array, new_v: Array, new_rate: Array) -> Array:
        """Tension at a new state by the strain linearised about the old one (N), ``(angles, strings)``."""
        v, rate, new_v, new_rate = (array[:, self.dofs] for array in (v, rate, new_v, new_rate))
        found, turned = self._forces(v, rate)
        swing = self.material * each(self.stretching.bow, rate)
        change = np.sum((turned + swing) * (new_v - v), -1) + self.material * np.sum(turned * (new_rate - rate), -1)
        return found + self.rigidity * change

    def axial(self, v: Array) -> Array:
        """Axial force of each string by the linear strain (N), ``(angles, ..., strings)`` of ``(angles, ..., v)``."""
        return self.rigidity * np.sum(self.stretching.line * v[..., self.dofs], axis=-1)

    def gradient(self, v: Array) -> Array:
        """Gradient of the nonlinear part of each string's elongation, ``(angles, strings, n)``; it is linear in v."""
        return each(self.stretching.bow, v[:, self.dofs])

    @property
    def bow(self) -> Array:
        """Second derivative of each string's elongation (1/m ...), ``(strings, n, n)``."""
        return self.stretching.bow

    def _forces(self, v: Array, rate: Array) -> tuple[Array, Array]:
        """Tension, and the change of the string's elongation with its dofs, ``line + bow v``."""
        elongation, turned = self.stretching.elongation(v)
        return self.rigidity * (elongation + self.material * np.sum(turned * rate, -1)), turned


@dataclass(frozen=True)
class OnElements:
    """Von Karman's strain on the elements: each has the tension of its string, and a given difference from it.

    Parameters
    ----------
    stretching, dofs, rigidity, material
        As of the strings, ``(elements, ...)``; the dofs are nodal.
    string
        String of each element, ``(elements,)``.
    spread
        What the tension of the elements differs from their string's (N), ``(angles, elements)``; 0 where they are one.
    """

    stretching: Stretching
    dofs: Index
    rigidity: Array
    material: float
    string: Index
    spread: Array | float = 0.0

    def mean(self, tension: Array) -> Array:
        """Mean of an axial force over each string, ``(angles, strings)``: that of the strain times the rigidity."""
        return self._of_strings(tension / self.rigidity)

    def tension(self, v: Array, rate: Array) -> Array:
        """Axial force of each element (N), ``(angles, elements)``."""
        return self._forces(v[:, self.dofs], rate[:, self.dofs])[0]

    def force(self, v: Array, rate: Array) -> Array:
        """Forces on the elements' ends in link axes, ``(angles, elements, 6)``, less the linear ones of the strings."""
        v, rate, line = v[:, self.dofs], rate[:, self.dofs], self.stretching.line
        tension, turned = self._forces(v, rate)
        linear = self._of_strings(np.einsum("ei,tei->te", line, v + self.material * rate))[:, self.string]
        return tension[..., None] * (turned - line) + (tension - self.spread - linear)[..., None] * line

    def of_stress(self) -> OnElements:
        """Give the law without the axial forces that are given, `spread`."""
        return replace(self, spread=0.0)

    def lengthening(self, v: Array) -> Array:
        """Elongation of each element beside that of linear theory (m), ``(angles, elements)``.

        Bending shortens an element, and the tension that comes of it stretches all elements of its string. Together
        they add up to 0 over a string: its ends have their displacement already.
        """
        bent = self.stretching.bowed(v[:, self.dofs], v[:, self.dofs]) / 2
        return self._of_strings(bent)[:, self.string] / self.rigidity - bent

    def turned(self, tension: Array, v: Array) -> Array:
        """Forces on the elements' ends by a tension of their strings on the bent axis, ``(angles, elements, 6)``."""
        return tension[:, self.string, None] * each(self.stretching.bow, v[:, self.dofs])

    def _forces(self, v: Array, rate: Array) -> tuple[Array, Array]:
        """Tension, and the gradient of the elements' elongation."""
        elongation, turned = self.stretching.elongation(v)
        elongation = elongation + self.material * np.sum(turned * rate, -1)
        return self._of_strings(elongation)[:, self.string] + self.spread, turned

    def _of_strings(self, elongation: Array) -> Array:
        """Axial force of each string by the elongation of its elements, ``(angles, strings)``."""
        count = int(self.string.max()) + 1
        return summed(elongation, self.string, count) / np.bincount(self.string, 1 / self.rigidity)


def terms(situation: Situation) -> Terms:
    """Give the law of the elements, or of the members that are reduced."""
    beams, material = situation.beams, situation.scene.damping.material
    rigidity, dofs = beams.rigidity.axial.mean / beams.mesh.cell_length, element_dofs(beams.mesh)
    bare = OnElements(beams.stretching, dofs, rigidity, material, np.arange(len(dofs)))
    if beams.reduction is None:
        return Terms(law=VonKarman(beams.stretching, dofs, rigidity, material, bare))
    strings = beams.reduction.strings
    bare = replace(bare, string=strings.of_element)
    tension = situation.tension()
    spread = tension - bare.mean(tension)[:, strings.of_element]
    on_elements = replace(bare, spread=spread)
    law = VonKarman(
        stretching=strings.stretching(beams.stretching),
        dofs=strings.coordinates,
        rigidity=1 / np.bincount(strings.of_element, 1 / rigidity),
        material=material,
        on_elements=on_elements,
        spread=strings.weighted(beams.stretching.bow, spread),
    )
    return Terms(law=law)


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
