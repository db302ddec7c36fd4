"""What an effect is: its name, when it acts, what it adds, and how large it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from fenics_mech.beams import Beams
from fenics_mech.effects.terms import Situation, Terms
from fenics_mech.scene import Scene


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
    refuses
        Names of effects that it cannot act together with.
    """

    name: str
    meaning: str
    source: str
    terms: Callable[[Situation], Terms] | None = None
    beams: Callable[[Scene, Beams], Beams] | None = None
    stated: Callable[[Scene], bool] = _never
    refuses: tuple[str, ...] = ()
