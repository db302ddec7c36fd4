"""Branches of a scene's periodic motions by the equation of poses, over one number of it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import lru_cache

import numpy as np

from fenics_mech.answers.by_poses import planned
from fenics_mech.answers.solved_by_poses import Solved, built
from fenics_mech.effects.known import EXACT_STRAINS
from fenics_mech.errors import SceneError
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.planning.cycle_steps import Steps
from fenics_mech.scene import Scene
from fenics_mech.scene.sampling import SAMPLING
from fenics_mech.solve import Family, Point, continued

AtValue = Callable[[float], Scene]


def followable(scene: Scene) -> Scene:
    """Give a scene with its effects chosen, or refuse one whose motions cannot be followed."""
    if scene.analysis.method != "periodic" or not scene.drives:
        raise SceneError("only periodic motions are followed", place="analysis.method")
    scene = planned(scene)
    if EXACT_STRAINS not in scene.named_effects:
        raise SceneError(
            "under linear strains there is one motion at a value, which a sweep finds",
            place="effects",
            hint=f"Add {EXACT_STRAINS!r}, or sweep the number",
        )
    return scene


def followed(at: AtValue, path: str, ends: tuple[float, float], points: int) -> Iterator[tuple[Point, Solved]]:
    """Follow the motions of a scene over a number of it, from one end of a range until they leave the range."""
    first, last = (at(end) for end in ends)
    if first.cycle_rate * last.cycle_rate < 0:
        raise SceneError("the drive must keep its sense of turning over the range", place=path)
    shares, others = (Steps.of(scene).times / scene.period for scene in (first, last))
    if len(shares) != len(others) or np.abs(shares - others).max() > SAMPLING.same:
        raise SceneError("the angles at which a load jumps or impulses act must stay over the range", place=path)
    start = Solved.of(first)
    near = start.made.machine

    @lru_cache(maxsize=2)
    def made_at(value: float) -> SceneMachine:
        nonlocal near
        made = built(at(value), near=near)
        near = made.machine
        return made

    for point in continued(Family(made_at, ends), start.cycle, points):
        made = point.driven
        assert isinstance(made, SceneMachine)
        yield point, Solved(made.scene.changed({"analysis.allow_unstable": True}), made, point.cycle)
