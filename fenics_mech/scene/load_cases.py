"""Load cases: what differs from the scene in each, and the scenes that they make."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any, Self

from pydantic import Field, model_validator

from fenics_mech.errors import MechanismError, SceneError, shortened
from fenics_mech.scene.base import Name, Part, check_known
from fenics_mech.scene.paths import place_in
from fenics_mech.scene.units import Share

if TYPE_CHECKING:
    from fenics_mech.scene.models import Scene

MOST_CASES = 100
CHANGED = (  # parts that a case may change; members, joints and places are the same in all, so that peaks compare
    *("drive", "loads", "impulses", "gravity", "masses", "springs", "dampers", "joint_laws"),
    *("freedoms", "damping", "effects", "analysis"),
)
TAGS = {"kind", "shape"}  # a table with one of them is whole by itself
CYCLES = 5e8  # of the machine, that members are to last: those for which endurance of aluminium is given
WHOLE = 1e-6  # by which shares of time may differ from 1 in all


class LoadCase(Part):
    """A load case: what differs from the scene. One run answers all cases, and tells the governing one.

    Parameters
    ----------
    name
        Its name.
    set
        Values of keys of the scene in this case, as the scene states them: of its drive, loads, impulses, gravity,
        masses, springs, dampers, joint laws, freedoms, damping, effects or analysis.
    off
        Names of loads and impulses that do not act in it.
    cycles
        Cycles of the machine that it runs in this case in its life. They count where a material states a stress-life
        curve.
    share
        Or the share of the running time, of `design.cycles` in all.

    Examples
    --------
    >>> case = fm.LoadCase(name="overspeed", set={"drive": {"speed": "400 rpm"}})
    >>> scene = fm.load("demos/four_bar.toml").changed(cases=[case])
    >>> round(fm.in_case(scene, "overspeed").drive.speed, 3)
    41.888
    """

    name: Name
    set: dict[str, Any] = Field(default_factory=dict)
    off: tuple[Name, ...] = ()
    cycles: Annotated[float, Field(ge=0, le=1e15)] | None = None
    share: Annotated[Share, Field(ge=0, le=1)] | None = None

    @model_validator(mode="after")
    def _counts_one_way(self) -> Self:
        if self.cycles is not None and self.share is not None:
            raise ValueError("give either `cycles` or `share`, not both")
        return self

    @property
    def values(self) -> dict[str, Any]:
        """The changed values by dotted path."""
        return dict(_leaves(self.set, ""))


Cases = Annotated[tuple[LoadCase, ...], Field(max_length=MOST_CASES)]


def _leaves(table: Mapping[str, Any], above: str) -> Iterator[tuple[str, Any]]:
    """Give what nested tables state, by dotted path; a table that says of which kind it is stays whole."""
    for key, value in table.items():
        if isinstance(value, Mapping) and value and not TAGS & value.keys():
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value


def in_case(scene: Scene, name: str) -> Scene:
    """Give a scene as it is in one of its load cases; it has none itself.

    Parameters
    ----------
    scene
        The scene.
    name
        Name of the case.

    Raises
    ------
    SceneError
        When there is no such case, or what it states is not valid.

    Examples
    --------
    >>> fm.in_case(fm.load("demos/load_cases/engine.toml"), "overspeed").loads
    {}
    """
    known = {case.name: number for number, case in enumerate(scene.cases)}
    check_known(name, known, "load case", "cases")
    number = known[name]
    case, place = scene.cases[number], f"cases.{number}"
    data = scene.model_copy(update={"cases": ()}).stated_data(by_alias=True)
    for path, value in case.values.items():
        if (part := path.split(".")[0]) not in CHANGED:
            hint = f"A case changes {', '.join(CHANGED)}"
            raise SceneError(f"a load case does not change {shortened(part)}", place=f"{place}.set.{path}", hint=hint)
        try:
            place_in(data, path, value)
        except SceneError as error:
            raise SceneError(error.message, place=f"{place}.set.{path}", hint=error.hint) from error
    for load in case.off:
        check_known(load, [*scene.loads, *scene.impulses], "load or impulse", f"{place}.off")
        data["loads"].pop(load, None)
        data["impulses"].pop(load, None)
    data["name"] = title_of(scene.name, name)
    if (cycles := cycles_of(scene).get(name)) is not None:
        data["design"]["cycles"] = max(cycles, 1.0)
    try:
        return type(scene).read(data)
    except SceneError as error:
        changed = {path.split(".")[0] for path in case.values}
        inside = f"{place}.set.{error.place}" if error.place.split(".")[0] in changed else place
        told = error.message if inside != place else f"{error.place}: {error.message}".removeprefix(": ")
        raise SceneError(f"load case {name!r}: {told}", place=inside, hint=error.hint) from error


@contextmanager
def told_of_case(name: str) -> Iterator[None]:
    """Name a load case in errors about it."""
    try:
        yield
    except SceneError as error:
        raise SceneError(f"load case {name!r}: {error.message}", place=error.place, hint=error.hint) from error
    except MechanismError as error:
        error.args = (f"load case {name!r}: {error}",)
        raise


def refuse_cases(scene: Scene, what: str) -> None:
    """Raise `SceneError` where a scene has load cases, and what is asked for is of one."""
    if scene.cases:
        names = ", ".join(case.name for case in scene.cases)
        hint = f"Take it in one of {names}: by in_case(scene, name), or SCENE@CASE.toml as the name of the file"
        raise SceneError(f"the scene has load cases, and {what} is of one", place="cases", hint=hint)


def title_of(scene: str, case: str) -> str:
    """Name a scene in one of its cases."""
    return f"{scene}, case {case}"


def scenes_of(scene: Scene) -> dict[str, Scene]:
    """Give the scene in each of its load cases, by their names."""
    return {case.name: in_case(scene, case.name) for case in scene.cases}


def cycles_of(scene: Scene) -> dict[str, float]:
    """Give the cycles that the machine runs in each load case in its life; none where the cases do not state them."""
    if all(case.cycles is not None for case in scene.cases):
        return {case.name: float(case.cycles or 0.0) for case in scene.cases}
    if any(case.share is None for case in scene.cases):
        return {}
    rates = {case.name: float(case.share or 0.0) * _speed(scene, case) for case in scene.cases}
    in_all = (scene.design.cycles or CYCLES) / (sum(rates.values()) or 1.0)
    return {name: rate * in_all for name, rate in rates.items()}


def _speed(scene: Scene, case: LoadCase) -> float:
    """Rate of the cycle in a case (rad/s)."""
    if not scene.drives:
        return 1.0
    driven = {path: value for path, value in case.values.items() if path.split(".")[0] == "drive"}
    return abs(scene.model_copy(update={"cases": ()}).changed(driven).cycle_rate)


def check_cases(scene: Scene) -> None:
    """Raise `SceneError` where load cases have one name, count cycles in different ways, or are not valid."""
    names = [case.name for case in scene.cases]
    if twice := next((name for name in names if names.count(name) > 1), ""):
        raise SceneError(f"two load cases have the name {twice!r}", place="cases", hint="Give each its own")
    for key in ("cycles", "share"):
        lacking = [case.name for case in scene.cases if getattr(case, key) is None]
        if lacking and len(lacking) < len(names):
            hint = f"State `{key}` in all cases or in none; it may be 0"
            raise SceneError(f"load case {lacking[0]!r} states no `{key}`, as others do", place="cases", hint=hint)
    shares = [case.share for case in scene.cases if case.share is not None]
    if shares and not math.isclose(sum(shares), 1, abs_tol=WHOLE):
        raise SceneError(
            f"the shares of time are {100 * sum(shares):.6g} % in all", place="cases", hint="Let them be 100 %"
        )
    scenes_of(scene)
