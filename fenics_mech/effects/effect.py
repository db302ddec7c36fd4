"""What an effect is: its name, when it acts, and what it adds."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from fenics_mech.scene import Scene


@dataclass(frozen=True)
class Effect:
    """A physical effect.

    Parameters
    ----------
    name
        Its name in a scene's `effects`.
    meaning
        What it is, in one line.
    source
        Where its equations stand.
    acting
        What it exerts, by name: terms of poses (`fenics_mech.terms`), for a machine with all its poses, masses and
        joints (`machine.from_scene.SceneMachine`). So effects of other packages act; those of the program are terms
        of their own, or parts of the equation.
    stated
        Whether a scene asks for it by what else it states: a spring, a load.
    stated_by
        The part of a scene file that asks for it so.
    missing_data
        Says what the effect needs and a scene does not state, or nothing. The program does not choose it then, and
        says why.
    replaces
        Name of an effect that this one holds in itself.
    refuses
        Names of effects that it cannot act together with.
    couples
        Whether rigid and elastic motion act on each other.
    stress_stiffening
        Whether axial forces act on the bent axis.
    nonlinear
        Whether its forces are nonlinear in the elastic displacement.
    loads_at_nodes
        Whether elements cannot carry loads inside them: each load has a node.
    """

    name: str
    meaning: str
    source: str
    acting: Callable[[Any], Mapping[str, Any]] | None = None
    stated: Callable[[Scene], bool] = lambda scene: False
    missing_data: Callable[[Scene], str] = lambda scene: ""
    stated_by: str = ""
    replaces: str = ""
    refuses: tuple[str, ...] = ()
    couples: bool = False
    stress_stiffening: bool = False
    nonlinear: bool = False
    loads_at_nodes: bool = False


@dataclass(frozen=True)
class Choice:
    """What was decided about an effect."""

    effect: Effect
    size: float | None  # estimate of the share of the strains that it changes; None where nothing was estimated
    acts: bool  # whether it acts
    missing: str = ""  # why it does not act though it should: what it needs and the scene does not state; else empty
