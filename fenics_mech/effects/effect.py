"""What an effect is: its name, when it acts, what it adds, and how large it is."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

from fenics_mech.effects.terms import Situation, Terms
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams
    from fenics_mech.machine.from_scene import SceneMachine
    from fenics_mech.terms import Term


@dataclass(frozen=True)
class Survey:
    """Dimensionless numbers of a mechanism, measured before the run, by which effects estimate their size.

    Parameters
    ----------
    needs_vibration
        Whether something acts that is nothing without vibration: impulses, a motor, a motion in time.
    vibration
        Difference of the response from the quasi-static one, relative.
    sensitivity
        Relative change of the response over a relative change of stiffness: large near a resonance.
    turning
        Fastest link's rate over the lowest natural frequency.
    tension
        Largest share by which axial forces of loads and rigid motion change the stiffness of a mode.
    bow
        Largest distance of a member's axis from its chord, over its length, in the quasi-static response.
    slenderness
        Radius of gyration over length of the members, those that bend most counting most.
    gravity
        Quasi-static strains by gravity alone over all quasi-static strains.
    """

    needs_vibration: bool
    vibration: float
    sensitivity: float
    turning: float
    tension: float
    bow: float
    slenderness: float
    gravity: float


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
    acting
        What it exerts, by name: terms of poses (`fenics_mech.terms`), for a machine with all its poses, masses and
        joints (`machine.from_scene.SceneMachine`). So effects of other packages act; those of the program are terms
        of their own, or parts of the equation.
    terms
        What it adds to the equation of motion in link frames.
    beams
        How it changes the links' matrices.
    stated
        Whether a scene asks for it by what else it states: a spring, a load.
    stated_by
        The part of a scene file that asks for it so.
    size
        Estimate of how much of the strains it changes, for ``effects = "auto"``; None if it is never left out or added.
    estimate
        The formula of that estimate, as the table of effects shows it.
    missing_data
        Says what the effect needs and a scene does not state, or nothing. The program does not choose it then, and
        says why.
    without
        Changes of the scene that leave out an effect that it states, by path, as `Scene.changed` takes them.
    needs
        Names of effects without which it changes nothing.
    replaces
        Name of an effect that this one holds in itself.
    refuses
        Names of effects that it cannot act together with.
    work
        How the work of its loads counts, where `terms` gives some: "as load" as that of loads, or "own" by a rule of
        its own in `forces.virtual_work`.
    couples
        Whether rigid and elastic motion act on each other.
    stress_stiffening
        Whether axial forces act on the bent axis.
    nonlinear
        Whether its forces are nonlinear in the elastic displacement.
    loads_at_nodes
        Whether elements cannot carry loads inside them: each load has a node.
    solver
        The one periodic solver that knows it; empty where several do.
    """

    name: str
    meaning: str
    source: str
    acting: Callable[[SceneMachine], Mapping[str, Term]] | None = None
    terms: Callable[[Situation], Terms] | None = None
    beams: Callable[[Scene, Beams], Beams] | None = None
    stated: Callable[[Scene], bool] = lambda scene: False
    size: Callable[[Survey], float] | None = None
    estimate: str = ""
    missing_data: Callable[[Scene], str] = lambda scene: ""
    stated_by: str = ""
    without: Mapping[str, Any] = field(default_factory=dict)
    needs: tuple[str, ...] = ()
    replaces: str = ""
    refuses: tuple[str, ...] = ()
    work: Literal["", "as load", "own"] = ""
    couples: bool = False
    stress_stiffening: bool = False
    nonlinear: bool = False
    loads_at_nodes: bool = False
    solver: str = ""


@dataclass(frozen=True)
class Choice:
    """What was decided about an effect.

    Parameters
    ----------
    effect
        The effect.
    size
        Estimate of the share of the strains that it changes; None where nothing was estimated.
    acts
        Whether it acts.
    missing
        Why it does not act though it should: what it needs and the scene does not state; else empty.
    """

    effect: Effect
    size: float | None
    acts: bool
    missing: str = ""
