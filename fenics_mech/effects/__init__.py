"""Physical effects: which there are, and which act in a scene."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields, replace
from difflib import get_close_matches
from typing import Any

from fenics_mech._plugins import Plugin, plugins
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.known import KNOWN
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene

__all__ = ["EFFECTS", "Effect", "active", "loads_at_nodes"]


def _found() -> dict[str, Effect]:
    effects = {effect.name: effect for effect in KNOWN}
    for plugin in plugins("effects"):
        effects[plugin.name] = _plugged(plugin, plugin.name in effects)
    return dict(sorted(effects.items()))


def _plugged(plugin: Plugin, taken: bool) -> Effect:
    """Load an effect of another package, whose errors name it."""
    effect: Effect = plugin.load(Effect)
    if taken or effect.name != plugin.name:
        raise plugin.refused(f"must have that name in its record too, found {effect.name!r}, and one not yet taken")
    if effect.acting is None:
        raise plugin.refused("must state by `acting` the terms of poses that it adds")
    values = {f.name: getattr(effect, f.name) for f in fields(effect)}
    called: dict[str, Any] = {name: plugin.blamed(work) for name, work in values.items() if callable(work)}
    return replace(effect, **called | {"acting": _checked(plugin, called["acting"])})


def _checked(plugin: Plugin, acting: Callable[[Any], Any]) -> Callable[[Any], dict[str, Any]]:
    """Give what states the terms of a plugin, which are such, and whose errors name it."""
    asked = "respond", "near", "energy"

    def terms(made: Any) -> dict[str, Any]:
        found = acting(made)
        if not isinstance(found, Mapping) or not all(hasattr(t, name) for t in found.values() for name in asked):
            raise plugin.refused("must give terms of `fenics_mech.terms` by name in `acting`")
        for term in found.values():
            for name in asked:
                setattr(term, name, plugin.blamed(getattr(term, name)))
        return {str(name): term for name, term in found.items()}

    return terms


EFFECTS = _found()


def active(scene: Scene) -> tuple[Effect, ...]:
    """Give the effects that act in a scene: those that it names, and those that come with what it states."""
    # Of a scene that leaves the choice to the program, only the latter.
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
    """Whether loads need nodes, as elements cannot carry them inside."""
    return any(effect.loads_at_nodes for effect in acting)
