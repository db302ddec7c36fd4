"""What a study varies: its variables as numbers in SI, and the scene with other values of them."""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene import Scene
from fenics_mech.scene.study import Study, Tied, Variable
from fenics_mech.scene.units import unit_written
from fenics_mech.studies.sweep_axes import placed, range_in_si, scene_data, unit_of, value_in_si


@dataclass(frozen=True)
class DesignVariable:
    """A variable of a study in SI."""

    name: str
    numbers: tuple[Tied, ...]  # the numbers of the scene that follow it
    # lower, upper: its bounds; of a choice the first and the last index
    lower: float
    upper: float
    start: float  # where a search begins
    unit: str = "1"  # SI unit, "1" where it has none
    choices: tuple[Any, ...] = ()  # values of a choice, whose variable is their index
    # the unit in which its bounds or its start are written, and how much of SI it is; None where they have none
    written: tuple[str, float] | None = None

    def values(self, value: float) -> dict[str, Any]:
        """Give the numbers of the scene at a value of the variable, by dotted path."""
        if self.choices:
            chosen = self.choices[round(value)]
            return {tied.number: chosen for tied in self.numbers}
        return {tied.number: tied.factor * value**tied.power for tied in self.numbers}

    def shown(self, value: float) -> Any:
        """Give a value as a user states it: the chosen one of a choice, else the number in SI."""
        return self.choices[round(value)] if self.choices else value


@dataclass(frozen=True)
class Design:
    """A scene with the variables of its study."""

    scene: Scene  # the scene, without its study and its measurements, which change no result
    study: Study
    variables: tuple[DesignVariable, ...]  # its variables, in order

    @classmethod
    def of(cls, scene: Scene, study: Study | None = None) -> Design:
        """Read the variables of a study."""
        study = study or scene.study
        if study is None:
            raise SceneError("the scene states no study", place="study", hint="Add a [study] with its variables")
        bare = scene.model_copy(update={"study": None, "measurements": ()})
        if not study.variables:
            raise SceneError("the study has no variables", place="study", hint="Add a table [study.variables]")
        found = tuple(_read(bare, f"study.variables.{name}", variable) for name, variable in study.variables.items())
        refuse_twice(found, "study.variables")
        return cls(bare, study, found)

    @property
    def start(self) -> list[float]:
        """The variables where a search begins, in SI."""
        return [variable.start for variable in self.variables]

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Smallest and largest value of each variable, in SI."""
        return [(variable.lower, variable.upper) for variable in self.variables]

    def changes(self, values: Sequence[float]) -> dict[str, Any]:
        """Give the numbers of the scene at values of the variables, by dotted path."""
        found: dict[str, Any] = {}
        for variable, value in zip(self.variables, values, strict=True):
            found |= variable.values(float(value))
        return found

    def at(self, values: Sequence[float]) -> Scene:
        """Give the scene at values of the variables."""
        return Scene.read(placed(scene_data(self.scene), self.changes(values)))

    def shown(self, values: Sequence[float]) -> dict[str, Any]:
        """Give the values as a user states them, by the variables' names."""
        return {variable.name: variable.shown(float(value)) for variable, value in zip(self.variables, values)}


def refuse_twice(variables: Sequence[DesignVariable], place: str) -> None:
    """Raise `SceneError` where two variables change one number."""
    seen: dict[str, str] = {}
    for variable in variables:
        for tied in variable.numbers:
            if tied.number in seen:
                raise SceneError(
                    f"{tied.number} follows this variable and {seen[tied.number]!r}",
                    place=f"{place}.{variable.name}",
                    hint="Leave it out of one of them",
                )
            seen[tied.number] = variable.name


@contextmanager
def named_at(place: str) -> Iterator[None]:
    """Let errors name a place in the study."""
    try:
        yield
    except SceneError as error:
        at = place if error.place.startswith(place) or not error.place else f"{place}: {error.place}"
        raise SceneError(error.message, place=at, hint=error.hint) from None


def _read(scene: Scene, place: str, variable: Variable) -> DesignVariable:
    """Read one variable."""
    with named_at(place):
        numbers = tied_numbers(scene, variable.numbers)
        return _choice(scene, place, numbers, variable) if variable.choices else _range(scene, place, numbers, variable)


def tied_numbers(scene: Scene, numbers: Sequence[str | Tied]) -> tuple[Tied, ...]:
    """Give the numbers of the scene that follow a variable."""
    found = tuple(tied if isinstance(tied, Tied) else Tied(number=tied) for tied in numbers)
    for tied in found:
        _refuse_unknown(scene, tied.number)
    return found


def _refuse_unknown(scene: Scene, path: str) -> None:
    """Raise `SceneError` where a scene has no number at a path, with those that are spelled nearly so."""
    known = dict(_leaves(scene_data(scene)))
    if path in known:
        return
    near = difflib.get_close_matches(path, known, n=3, cutoff=0.5)
    hint = f"Did you mean {' or '.join(near)}?" if near else "Write the keys that lead to it, with dots between them"
    raise SceneError("the scene states no such number", place=path, hint=hint)


def _leaves(data: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Give every value of nested data with its dotted path."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    for key, value in items:
        where = f"{path}.{key}" if path else str(key)
        yield where, value
        yield from _leaves(value, where)


def _choice(scene: Scene, place: str, numbers: tuple[Tied, ...], variable: Variable) -> DesignVariable:
    """Read a variable that is a choice; every choice must be valid in the scene."""
    for chosen in variable.choices:
        Scene.read(placed(scene_data(scene), {tied.number: chosen for tied in numbers}))
    stated = variable.start if variable.start is not None else dict(_leaves(scene_data(scene)))[numbers[0].number]
    if variable.start is not None and stated not in variable.choices:
        raise SceneError(f"the start {shortened(stated)} is none of the choices", place=f"{place}.start")
    start = variable.choices.index(stated) if stated in variable.choices else 0
    name, last = place.rsplit(".", maxsplit=1)[-1], float(len(variable.choices) - 1)
    return DesignVariable(name, numbers, 0.0, last, float(start), "1", variable.choices)


def _range(scene: Scene, place: str, numbers: tuple[Tied, ...], variable: Variable) -> DesignVariable:
    """Read a variable with bounds, in the unit of its first number where that follows it as it is."""
    name, first = place.rsplit(".", maxsplit=1)[-1], numbers[0]
    assert variable.between is not None
    plain = (first.factor, first.power) == (1.0, 1.0)
    if plain:
        lower, upper = range_in_si(scene, first.number, variable.between)
        start = value_in_si(scene, first.number, variable.start)
    else:
        if not all(isinstance(end, int | float) for end in variable.between):
            raise SceneError(
                "the first number follows with a factor or a power, so that bounds have no unit",
                place=place,
                hint="Write numbers in SI, or begin with a number that is the variable itself",
            )
        lower, upper = (float(end) for end in variable.between)
        now = value_in_si(scene, first.number, None)
        start = float(variable.start) if variable.start is not None else (now / first.factor) ** (1 / first.power)
    if not lower < upper:
        low, high = variable.between
        message = f"the lower bound {shortened(low)} is not below the upper bound {shortened(high)}"
        raise SceneError(message, place=f"{place}.between", hint="Write [smallest, largest]")
    if not lower <= start <= upper:
        raise SceneError(
            f"it starts at {start:.6g}, outside of its bounds {lower:.6g} and {upper:.6g} (SI)",
            place=place,
            hint="Give `start`, or other bounds",
        )
    unit = unit_of(scene, first.number) if plain else "1"
    texts = [str(value) for value in (*variable.between, variable.start)]
    written = unit_written(texts, (lower, upper, start)) if plain else None
    return DesignVariable(name, numbers, lower, upper, start, unit, written=written)
