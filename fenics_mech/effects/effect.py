"""What an effect is: its name, when it acts, what it adds, and how large it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fenics_mech.beams import Beams
from fenics_mech.effects.terms import Situation, Terms
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class Survey:
    """Dimensionless numbers of a mechanism, measured before the run, by which effects estimate their size.

    Parameters
    ----------
    scene
        The scene.
    vibration
        Difference of the response from the quasi-static one, relative.
    sensitivity
        Relative change of the response over a relative change of stiffness: large near a resonance.
    turning
        Fastest link's rate over the lowest natural frequency.
    tension
        Largest axial force over the Euler load of its member on two pins.
    bow
        Largest distance of a member's axis from its chord, over its length, in the quasi-static response.
    slenderness
        Largest radius of gyration over the member's length.
    """

    scene: Scene
    vibration: float
    sensitivity: float
    turning: float
    tension: float
    bow: float
    slenderness: float


def _never(scene: Scene) -> bool:
    return False


@dataclass(frozen=True)
class Effect:
    """A physical effect. Every module of this package that has an `EFFECT` adds one to the program.

    Parameters
    ----------
    name
        Its name in a scene's `effects`.
    meaning
        What it is, in one line.
    source
        Where its equations stand.
    terms
        What it adds to the equation of motion.
    beams
        How it changes the links' matrices.
    stated
        Whether a scene asks for it by what else it states: a spring, a load.
    size
        Estimate of how much of the strains it changes, for ``effects = "auto"``; None if it is never left out or added.
    estimate
        The formula of that estimate, as the table of effects shows it.
    refuses
        Names of effects that it cannot act together with.
    """

    name: str
    meaning: str
    source: str
    terms: Callable[[Situation], Terms] | None = None
    beams: Callable[[Scene, Beams], Beams] | None = None
    stated: Callable[[Scene], bool] = _never
    size: Callable[[Survey], float] | None = None
    estimate: str = ""
    refuses: tuple[str, ...] = ()
