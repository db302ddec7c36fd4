"""Which modes are damped in a periodic motion of many coordinates.

A mode that is much faster than the loads follows them without vibrating. Its damping 2 zeta/omega then changes its part
of the strain by that time its rate. This is small, and known before the motion is: from the static answer to the loads.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, summed
from fenics_mech._constants import TINY
from fenics_mech.eigenmodes import natural
from fenics_mech.forces.elastic_response import rate_of_cycle
from fenics_mech.mechanism import System
from fenics_mech.mechanism.beam_links import reducible
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.modal_forces import MATRICES
from fenics_mech.mechanism.reduced_damping import ReducedLinks
from fenics_mech.response.modal_damping import DampedModes, damping_ratios
from fenics_mech.response.mode_shapes import SHAPES, every, held, slowest
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.setup import moved
from fenics_mech.scene import Scene
from fenics_mech.scene.springs_dampers import HingeSpring


@dataclass(frozen=True)
class DampedModesLimits:
    """Which modes are damped."""

    small: int = 40  # coordinates, up to which all modes are damped: there full matrices are as fast
    left_out: float = 3e-5  # of a link's strain, that the damping of the other modes may change
    of_tolerance: float = 0.2  # the same of the tolerance, where there is one
    farther: float = 4.0  # times the bound of the frequency, up to which modes may be damped for a tolerance
    small_link: float = 0.1  # of the mechanism's largest root of energy: a link's own must be that to measure its loss
    least_ratio: float = 1e-3  # of damping, that limits a resonance
    fastest: float = 128.0  # times the lowest frequency, up to which modes are damped at most
    weak: float = 0.02  # ratio up to which that is enough; beyond it is more, as the root of the ratio
    resolved: float = 4.0  # rad in a step, up to which steps may resolve a vibration
    finer: int = 2  # bounds of the frequency in an octave
    angles: int = 48  # at which it is looked at what is left out
    most: int = 600  # coordinates, whose modes are all found there
    many: int = 120  # coordinates, from which modes are looked for by fewer
    reduced: float = 0.5  # of the coordinates, up to which fewer are worth their while
    beyond: float = 1 / 3  # of a clamped mode's 2 zeta/omega, for modes beyond them; told is 1.0 to 1.9 of the truth
    clamped: float = 2.0  # frequency of the members' clamped modes in them, over that of the fastest damped mode


DAMPED = DampedModesLimits()


@dataclass(frozen=True, eq=False)
class LeftOut:
    """Damping that a motion leaves out, at few angles of its cycle.

    Parameters
    ----------
    angles
        Which angles.
    equation
        The equation there, with all modes of unit stiffness.
    omega, damping
        Of these modes, the angular frequency (rad/s) and ``2 zeta/omega`` (s), ``(angles, modes)``.
    beyond
        A share of ``2 zeta/omega`` (s) of the fastest clamped mode of links by few coordinates; 0 where all modes are
        known.
    """

    angles: slice
    equation: Equation
    omega: Array
    damping: Array
    beyond: float

    @classmethod
    def of(cls, scene: Scene, system: System, modes: DampedModes) -> LeftOut | None:
        """Find all modes at few angles; None where there are too many.

        Parameters
        ----------
        scene
            The scene.
        system
            Its mechanism over a cycle.
        modes
            In whose coordinates the modes are found.
        """
        if modes.at(system).size > DAMPED.most:
            return None
        angles = slice(None, None, max(1, len(system.motion.theta) // DAMPED.angles))
        there = moved(scene, system, system.motion.part(angles))
        kept = natural(system)
        squares, forces = kept.once("all modes at few angles", lambda: every(*held(modes.at(there)))[:2], modes.links)
        inverse = np.sqrt(np.maximum(squares, 0.0))  # without mass it is 0, but for rounding
        omega = 1 / np.maximum(inverse, TINY)
        damping = 2 * damping_ratios(scene.damping.ratio, omega) * inverse
        clamped = math.inf if modes.links is None else modes.links.fastest
        beyond = DAMPED.beyond * 2 * float(np.atleast_1d(scene.damping.ratio)[-1]) / clamped
        return cls(angles, Equation(there, modes.factor(forces)), omega, damping, beyond)

    def forces(self, modes: DampedModes, rates: Array) -> Array:
        """Give the forces of the damping that is left out on the coordinates, ``(angles, coordinates)``.

        Parameters
        ----------
        modes
            Those that are damped.
        rates
            Rates of all modes, ``(angles, modes)``.
        """
        linear = self.equation.linear.modal
        assert linear is not None
        return linear.forces(self.damping * (1 - modes.share(self.omega)) * rates)

    def forces_beyond(self, q: Array, rate: Array) -> Array:
        """Give the forces of modes that links by few coordinates do not have, as `forces`.

        Parameters
        ----------
        q, rate
            Coordinates and their time derivatives, ``(angles, coordinates)``.
        """
        equation, linear = self.equation, self.equation.linear.modal
        assert linear is not None
        whole = equation.links_stiffness.times(rate) + equation.links_turning.times(q)
        return self.beyond * (whole - linear.forces(linear.rates(q, rate)))


def damped_modes(scene: Scene, system: System, enough: float | None = None) -> DampedModes | None:
    """Find which modes are damped in a periodic motion of many coordinates; None for all.

    These are all that its steps resolve, and so many of the others that the strains of the static answer to the loads
    lack 3e-5 by the damping of the rest. The frequency is relative to the lowest one, so that it is alike in similar
    scenes. All are damped beside torsional springs, which fast modes wind, and where the solver's steps let them ring:
    at Gauss points after impulses and jumps.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism over a cycle.
    enough
        Times the lowest frequency, up to which modes are damped at most that the steps do not resolve; None for that of
        `DAMPED`, which is farther for a tolerance. It is infinite for all.
    """
    wound = any(isinstance(spring, HingeSpring) for spring in scene.springs.values())
    rings = scene.analysis.scheme == "gauss" and Steps.of(scene).disturbed
    if not np.any(scene.damping.ratio) or system.size <= DAMPED.small or wound or rings or enough == math.inf:
        return None
    modal = natural(system)
    frequencies = modal.once("lowest frequencies", lambda: _lowest(modal))
    lowest = float(frequencies.min())
    if enough is None:
        enough = DAMPED.fastest * (DAMPED.farther if scene.tolerances else 1.0)
    enough *= lowest * math.sqrt(max(1.0, float(np.max(scene.damping.ratio)) / DAMPED.weak))
    resolved = DAMPED.resolved * scene.analysis.sub_intervals / abs(scene.period)
    least, most = (math.ceil(DAMPED.finer * math.log2(x / lowest)) for x in (resolved, max(enough, resolved)))
    bounds = lowest * 2.0 ** (np.arange(least, most + 1) / DAMPED.finer)
    links = _reduced(scene, system, float(bounds[-1]))
    fastest = _fastest(scene, system, links, frequencies, bounds)
    return modal.once("damped modes", lambda: _up_to(modal, links, fastest), (fastest, links))


def _lowest(system: System) -> Array:
    """Lowest natural frequency at all angles (rad/s), ``(angles,)``."""
    mass, stiffness = held(system)
    some = np.random.default_rng(0).standard_normal((SHAPES.more_shapes, mass.size))
    return 1 / np.sqrt(slowest(mass, stiffness, some, 1)[0][:, 0])


def _fastest(scene: Scene, system: System, links: ReducedLinks | None, frequencies: Array, bounds: Array) -> float:
    """Give the least of ascending frequencies (rad/s) up to which enough modes are damped, or the last."""
    undisturbed = scene.analysis.scheme == "radau" and not Steps.of(scene).disturbed
    left = LeftOut.of(scene, system, DampedModes(0, bounds[-1], links)) if undisturbed and len(bounds) > 1 else None
    if left is None:
        return float(bounds[-1])
    q = held(system)[1].solve(system.load)
    rate = rate_of_cycle(q, abs(scene.period))
    linear, there = left.equation.linear.modal, left.equation.system
    assert linear is not None
    rates, size = linear.rates(q[left.angles], rate[left.angles]), _of_links(system, q)
    unit, paces = np.sqrt(held(system)[1].diagonal.mean(axis=0)), frequencies / abs(scene.cycle_rate)
    rates = rates * _amplified(q, unit, paces, float(np.min(scene.damping.ratio)))
    size = np.maximum(size, max(DAMPED.small_link * size.max(), TINY))
    stated = min(scene.tolerances.values(), default=None)
    most = DAMPED.left_out if stated is None else DAMPED.of_tolerance * stated
    for bound in bounds[:-1]:
        forces = left.forces(DampedModes(0, bound), rates)
        if (_of_links(there, left.equation.links_stiffness.solve(forces)) <= most * size).all():
            return float(bound)
    return float(bounds[-1])


def _amplified(q: Array, unit: Array, slowest: Array, ratio: float) -> float:
    """By how much the slowest mode may amplify the rate of static answers over a cycle, ``(angles, coordinates)``.

    Its frequency at the angles is given over that of the cycle. A harmonic that it meets grows by its damping alone.
    """
    order = np.arange(len(q) // 2 + 1)
    apart = np.minimum(np.abs(1 - (order / slowest.min()) ** 2), np.abs(1 - (order / slowest.max()) ** 2))
    apart[(order >= slowest.min()) & (order <= slowest.max())] = 0.0
    size = order * np.linalg.norm(np.fft.rfft(q * unit, axis=0), axis=1)
    growth = np.maximum(1.0, 1 / np.maximum(apart, 2 * max(ratio, DAMPED.least_ratio)))
    return float(np.linalg.norm(growth * size) / max(float(np.linalg.norm(size)), TINY))


def _of_links(system: System, q: Array) -> Array:
    """Largest root of each link's elastic energy over the angles, ``(links,)``, by coordinates q."""
    v = system.to_links(q)
    energy = summed(v * (system.nodal_stiffness @ v.T).T, system.link_of_dof, len(system.motion.links))
    return np.sqrt(np.maximum(energy, 0.0).max(axis=0))


def _up_to(system: System, links: ReducedLinks | None, fastest: float) -> DampedModes | None:
    """Modes up to a frequency (rad/s), in links by few coordinates or in all; None if they are many."""
    mass, stiffness = held(system if links is None else links.at(system))
    slower = (stiffness + (-(fastest**2)) * mass).factors.pivots < 0  # as many as frequencies below it (Sylvester)
    count = int(np.sum(slower, axis=1).max())
    few = links is not None or count < MATRICES.few_modes * mass.size
    return DampedModes(count, fastest, links) if few else None


def _reduced(scene: Scene, system: System, fastest: float) -> ReducedLinks | None:
    """Links by few coordinates, for modes up to a frequency (rad/s); None where these are not few."""
    reduced = system.beams.reduction is not None or system.transformation.base is not None
    if reduced or system.terms.axial_stiffness or system.size < DAMPED.many:
        return None
    cutoff = DAMPED.clamped * fastest
    links = system.once(
        "links by few", lambda: ReducedLinks.of(scene, system, reducible(scene, system.beams), cutoff), cutoff
    )
    return links if links.transformation.shape[1] < DAMPED.reduced * system.size else None
