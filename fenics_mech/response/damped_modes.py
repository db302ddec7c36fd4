"""Which modes are damped in a periodic motion of many coordinates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fenics_mech.mechanism import System
from fenics_mech.mechanism.beam_links import reducible
from fenics_mech.mechanism.modal_forces import MATRICES
from fenics_mech.mechanism.reduced_damping import ReducedLinks
from fenics_mech.response.modal_damping import DampedModes
from fenics_mech.response.mode_shapes import SHAPES, held, slowest
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.scene import Scene
from fenics_mech.scene.springs_dampers import HingeSpring


@dataclass(frozen=True)
class DampedModesLimits:
    """Which modes are damped."""

    small: int = 40  # coordinates, up to which all modes are damped: there full matrices are as fast
    fastest: float = 128.0  # times the lowest frequency; measured: 2e-4 of a member that is strained little
    weak: float = 0.02  # ratio up to which that is enough; beyond it is more, as the root of the ratio
    resolved: float = 4.0  # rad in a step, up to which steps may resolve a vibration
    many: int = 120  # coordinates, from which modes are looked for by fewer
    reduced: float = 0.5  # of the coordinates, up to which fewer are worth their while
    clamped: float = 2.0  # frequency of the members' clamped modes in them, over that of the fastest damped mode


DAMPED = DampedModesLimits()


def damped_modes(scene: Scene, system: System, enough: float = DAMPED.fastest) -> DampedModes | None:
    """Find which modes are damped in a periodic motion of many coordinates; None for all.

    These are all that its steps resolve, and those up to some times the lowest frequency. Faster ones follow the loads
    without vibrating: their damping would change the strains of the seed four-bar by 2e-5, and in a member that is
    strained little 2e-4 of its own. The frequency is relative to the lowest one, so that it is alike in similar scenes.
    All are damped beside torsional springs, which fast modes wind, and where the solver's steps let them ring: at
    Gauss points after impulses and jumps.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism over a cycle.
    enough
        Times the lowest frequency, up to which modes are damped that the steps do not resolve.
    """
    wound = any(isinstance(spring, HingeSpring) for spring in scene.springs.values())
    rings = scene.analysis.scheme == "gauss" and Steps.of(scene).disturbed
    if not np.any(scene.damping.ratio) or system.size <= DAMPED.small or wound or rings:
        return None
    enough *= math.sqrt(max(1.0, float(np.max(scene.damping.ratio)) / DAMPED.weak))
    resolved = DAMPED.resolved * scene.analysis.sub_intervals / abs(scene.period)
    return system.once("damped modes", lambda: _up_to(scene, system, enough, resolved), (enough, resolved))


def _up_to(scene: Scene, system: System, enough: float, resolved: float) -> DampedModes | None:
    """Modes up to so many times the lowest frequency, and to one that is resolved (rad/s); None if they are many."""
    mass, stiffness = held(system)
    some = np.random.default_rng(0).standard_normal((SHAPES.more_shapes, mass.size))
    lowest = float(1 / np.sqrt(slowest(mass, stiffness, some, 1)[0].max()))
    fastest = lowest * 2.0 ** math.ceil(math.log2(max(enough, resolved / lowest)))
    links = _reduced(scene, system, fastest)
    if links is not None:
        mass, stiffness = held(links.at(system))
    slower = (stiffness + (-(fastest**2)) * mass).factors.pivots < 0  # as many as frequencies below it (Sylvester)
    count = int(np.sum(slower, axis=1).max())
    few = links is not None or count < MATRICES.few_modes * mass.size
    return DampedModes(count, fastest, links) if few else None


def _reduced(scene: Scene, system: System, fastest: float) -> ReducedLinks | None:
    """Links by few coordinates, for modes up to a frequency (rad/s); None where these are not few."""
    reduced = system.beams.reduction is not None or system.transformation.base is not None
    if reduced or system.terms.axial_stiffness or system.size < DAMPED.many:
        return None
    links = ReducedLinks.of(scene, system, reducible(scene, system.beams), DAMPED.clamped * fastest)
    return links if links.transformation.shape[1] < DAMPED.reduced * system.size else None
