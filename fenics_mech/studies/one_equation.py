"""One mesh, one set of steps and one set of effects for all points of a sweep, so that its curves have no steps.

Each point is first analysed as finely as it needs, and with the effects that it calls for. What any of them needs is
then taken for all: effects that act anywhere, and the finest mesh and steps unless these are far finer.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fenics_mech.effects import EFFECTS
from fenics_mech.planning.fine_enough import COUNTS, Numbers, free_numbers
from fenics_mech.scene import Scene
from fenics_mech.studies.kept_records import Record
from fenics_mech.studies.sweep_axes import placed

MOST_TIMES = 2.0  # as many elements or steps as usual, which all points may take: a sweep then takes 2 to 4 times
TAKEN_BY_ALL = "elements", "sub_intervals"


@dataclass(frozen=True)
class OneEquation:
    """What all points of a sweep are to have in common."""

    usual: Mapping[str, float]  # mesh and steps of points for which nothing finer was needed
    numbers: Mapping[str, float]  # those that all points are to have, where they differ
    effects: tuple[str, ...]  # effects that are to act at all points; none where the same act anyway

    @classmethod
    def of(cls, scene: Scene, records: Sequence[Record]) -> OneEquation | None:
        """Find what points need that have an answer; None where all have it."""
        answered = [record for record in records if not record["error"]]
        acting = {record["effects"] for record in answered}
        usual, found = free_numbers(scene), [numbers_of(record) for record in answered]
        numbers: dict[str, float] = {}
        for name in usual:
            values = {one.get(name, usual[name]) for one in found}
            if name in TAKEN_BY_ALL and len(values) > 1 and (most := max(values)) <= MOST_TIMES * float(usual[name]):
                numbers[name] = most
        effects = union(acting) if scene.effects == "auto" and len(acting) > 1 else ()
        return cls(usual, numbers, effects) if numbers or effects else None

    def scene(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """Give the scene of a sweep with what all points have in common."""
        return scene_with(data, self.numbers, self.effects or None)

    def lacks(self, record: Record) -> bool:
        """Whether a point has an answer with other effects, another mesh or other steps."""
        if record["error"]:
            return False
        numbers = numbers_of(record)
        others = any(numbers.get(name, self.usual[name]) != value for name, value in self.numbers.items())
        return others or bool(self.effects and set(self.effects) != set(union({record["effects"]})))

    def chosen(self, found: Record | None, before: Record) -> Record:
        """Give what was found of a point with what all have in common, where that has an answer."""
        if found is None or found["error"]:
            return before
        numbers = numbers_of(before) | dict(self.numbers)
        return found | {"numbers": json.dumps(numbers) if numbers else ""}


def numbers_of(record: Record) -> dict[str, Any]:
    """Give the numbers of mesh and steps that the program took at a point."""
    return dict(json.loads(record["numbers"] or "{}"))


def scene_with(scene: Mapping[str, Any], numbers: Numbers, effects: Sequence[str] | None) -> Record:
    """Give the scene of a sweep with numbers of mesh and steps, and with effects."""
    paths = {name: "mesh.elements" if name == "elements" else f"analysis.{name}" for name in numbers}
    whole = {"elements", *COUNTS}
    changes = {paths[name]: int(value) if name in whole else value for name, value in numbers.items()}
    return placed(dict(scene), changes | ({} if effects is None else {"effects": list(effects)}))


def union(acting: set[str]) -> tuple[str, ...]:
    """Give the effects that act at any point, but those that others of them hold, and those that a scene states."""
    names = {name for some in acting for name in some.split(", ")} & EFFECTS.keys()
    held = {EFFECTS[name].replaces for name in names}
    return tuple(name for name in EFFECTS if name in names - held and not EFFECTS[name].stated_by)
