"""The theories whose error is told by the answer itself, and the exact one above them."""

from __future__ import annotations

from collections.abc import Sequence

from fenics_mech.effects import EFFECTS
from fenics_mech.scene import Scene

(COUPLING,) = (name for name, effect in EFFECTS.items() if effect.couples and not effect.stated_by)
(EXACT_STRAINS,) = (name for name, effect in EFFECTS.items() if effect.nonlinear)
TENSION = EFFECTS[EXACT_STRAINS].replaces
LADDER = (COUPLING, TENSION, EXACT_STRAINS)  # effects that this estimate judges
UNKNOWN = "what the theory leaves out"  # as results say it where there is no estimate


def released(scene: Scene) -> Scene:
    """Give the scene with all nodes of members, as exact strains need it; itself if it is that.

    Parameters
    ----------
    scene
        The scene.
    """
    return scene if scene.analysis.reduction == "none" else scene.changed(analysis__reduction="none")


def judged(method: str) -> set[str]:
    """Give the effects that the estimate judges: the coupling only where the elastic motion has inertia."""
    return set(LADDER if method in ("periodic", "transient") else (TENSION, EXACT_STRAINS))


def exact_theory(scene: Scene) -> Scene:
    """Give the scene with exact strains, and where it moves with the coupling; itself if it has them."""
    needed = judged(scene.analysis.method) - {TENSION}
    if needed <= set(scene.named_effects):
        return scene
    return scene.model_copy(update={"effects": (*_beside(scene.named_effects), *sorted(needed))})


def _beside(effects: Sequence[str]) -> list[str]:
    """Give the effects that the estimate does not judge."""
    return [name for name in effects if name not in LADDER]
