"""Physical effects, one a file: each is found here, and acts only in scenes that call for it."""

from __future__ import annotations

import pkgutil
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from difflib import get_close_matches
from importlib import import_module
from typing import TYPE_CHECKING, Any

from fenics_mech._plugins import Plugin, plugins
from fenics_mech.effects import offsets
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.given_axial_forces import AxialForces, AxialStiffness
from fenics_mech.effects.terms import (
    NOTHING,
    UNLOADED,
    AddedMatrices,
    Entries,
    Loads,
    Situation,
    Terms,
)
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.terms import Term
from fenics_mech.terms.added import ADDED

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams

__all__ = [
    "EFFECTS",
    "NOTHING",
    "UNLOADED",
    "AddedMatrices",
    "AxialForces",
    "AxialStiffness",
    "Effect",
    "Entries",
    "Loads",
    "Situation",
    "Terms",
    "active",
    "build_terms",
    "loads_at_nodes",
    "shaped",
]


def _found() -> dict[str, Effect]:
    modules = [import_module(f"{__name__}.{module.name}") for module in pkgutil.iter_modules(__path__)]
    effects = {module.EFFECT.name: module.EFFECT for module in modules if hasattr(module, "EFFECT")}
    for plugin in plugins("effects"):
        effects[plugin.name] = _plugged(plugin, plugin.name in effects)
    return effects


def _plugged(plugin: Plugin, taken: bool) -> Effect:
    """Load an effect of another package, whose errors name it."""
    effect: Effect = plugin.load(Effect)
    if taken or effect.name != plugin.name:
        raise plugin.refused(f"must have that name in its record too, found {effect.name!r}, and one not yet taken")
    if effect.acting is None or effect.terms is not None or effect.beams is not None:
        raise plugin.refused("must state by `acting` the terms of poses that it adds, and neither `terms` nor `beams`")
    values = {f.name: getattr(effect, f.name) for f in fields(effect)}
    called: dict[str, Any] = {name: plugin.blamed(work) for name, work in values.items() if callable(work)}
    return replace(effect, **called | {"acting": _checked(plugin, called["acting"])})


def _checked(plugin: Plugin, acting: Callable[[Any], Any]) -> Callable[[Any], dict[str, Term]]:
    """Give what states the terms of a plugin, which are such, and whose errors name it."""

    def terms(made: Any) -> dict[str, Term]:
        found = acting(made)
        if not isinstance(found, Mapping) or not all(isinstance(term, Term) for term in found.values()):
            raise plugin.refused("must give terms of `fenics_mech.terms` by name in `acting`")
        for term in found.values():
            for name in ("respond", "near", "energy"):
                setattr(term, name, plugin.blamed(getattr(term, name)))
        return {str(name): term for name, term in found.items()}

    return terms


EFFECTS = _found()
ADDED[:] = [effect for effect in EFFECTS.values() if effect.acting is not None]


def active(scene: Scene) -> tuple[Effect, ...]:
    """Give the effects that act in a scene: those that it names, and those that come with what it states.

    Of a scene that leaves the choice to the program, only the latter.

    Parameters
    ----------
    scene
        The scene.

    Returns
    -------
    tuple of Effect
        The effects, by the names of their modules.

    Raises
    ------
    SceneError
        When it names one that is not known, one that it does not state, or two that exclude each other.
    """
    for name in scene.named_effects:
        if name == "inextensible":
            raise SceneError(
                "'inextensible' is no effect any more: members stretch, which takes no more time",
                place="effects",
                hint="Leave it out. Members as stiff along as need be have sections of 100 times the `area` with the "
                "same `inertia`, of a material of 1/100 of the density",
            )
        if name not in EFFECTS:
            near = "".join(f"Did you mean {other!r}? " for other in get_close_matches(name, EFFECTS, n=1))
            raise SceneError(f"there is no effect {name!r}", place="effects", hint=f"{near}Known: {', '.join(EFFECTS)}")
        if EFFECTS[name].stated_by and not EFFECTS[name].stated(scene):
            raise SceneError(
                f"{name!r} is named here, and nothing in the scene states it",
                place="effects",
                hint=f"It acts by {EFFECTS[name].stated_by}, and need not be named",
            )
    acting = tuple(effect for effect in EFFECTS.values() if effect.name in scene.named_effects or effect.stated(scene))
    names = {effect.name for effect in acting}
    for effect in acting:
        if clash := names.intersection(effect.refuses):
            raise SceneError(
                f"{effect.name!r} and {min(clash)!r} exclude each other", place="effects", hint="Take one of them"
            )
    return acting


def loads_at_nodes(acting: Iterable[Effect]) -> bool:
    """Whether loads need nodes, as elements cannot carry them inside.

    Parameters
    ----------
    acting
        The effects that act.
    """
    return any(effect.loads_at_nodes for effect in acting)


def shaped(scene: Scene, beams: Beams) -> Beams:
    """Give the links' matrices as the scene's effects change them.

    Parameters
    ----------
    scene
        The scene.
    beams
        Its links by Euler and Bernoulli, as `assemble_beams` gives them.
    """
    for effect in active(scene):
        if effect.beams is not None:
            beams = effect.beams(scene, beams)
    return beams


def build_terms(situation: Situation) -> Terms:
    """Give what the scene's effects add to the equation of motion.

    Parameters
    ----------
    situation
        The scene, its links and its rigid motion.

    Raises
    ------
    SceneError
        When an effect of another package acts.
    TypeError
        When an effect gives loads and does not say how their work is counted.
    """
    found = []
    for effect in active(situation.scene):
        if effect.acting is not None:
            raise SceneError(
                f"{effect.name!r} acts by the equation of poses, and this analysis goes by link frames",
                place="analysis.solver",
                hint="Write solver = 'poses'",
            )
        if effect.terms is not None:
            found.append(effect.terms(situation))
            if found[-1].loads and not effect.work:
                raise TypeError(f"effect {effect.name!r} gives loads: its field `work` must say how theirs is counted")
    if situation.beams.layout.offsets is not None:
        found.append(offsets.terms(situation))
    return sum(found, NOTHING)
