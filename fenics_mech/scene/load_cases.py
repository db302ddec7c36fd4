"""Load cases: what differs from the scene in each, and the scenes that they make."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TypeVar

from fenics_mech.errors import MechanismError, SceneError, shortened
from fenics_mech.scene.base import check_known, place_in
from fenics_mech.scene.load_case import LoadCase
from fenics_mech.scene.scene_data import SceneData

AnyScene = TypeVar("AnyScene", bound=SceneData)
CHANGED = (  # parts that a case may change; members, joints and places are the same in all, so that peaks compare
    *("drive", "loads", "impulses", "gravity", "masses", "springs", "dampers", "joint_laws"),
    *("freedoms", "damping", "effects", "analysis"),
)
CYCLES = 5e8  # of the machine, that members are to last: those for which endurance of aluminium is given
WHOLE = 1e-6  # by which shares of time may differ from 1 in all


def in_case(scene: AnyScene, name: str) -> AnyScene:
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
    data["name"] = f"{scene.name}, case {name}"
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
def about_case(name: str) -> Iterator[None]:
    """Name a load case in errors about it."""
    try:
        yield
    except SceneError as error:
        raise SceneError(f"load case {name!r}: {error.message}", place=error.place, hint=error.hint) from error
    except MechanismError as error:
        error.args = (f"load case {name!r}: {error}",)
        raise


def refuse_cases(scene: SceneData, what: str) -> None:
    """Raise `SceneError` where a scene has load cases, and what is asked for is of one."""
    if scene.cases:
        names = ", ".join(case.name for case in scene.cases)
        hint = f"Take it in one of {names}: by in_case(scene, name), or SCENE@CASE.toml as the name of the file"
        raise SceneError(f"the scene has load cases, and {what} is of one", place="cases", hint=hint)


def scenes_of(scene: AnyScene) -> dict[str, AnyScene]:
    """Give the scene in each of its load cases, by their names."""
    return {case.name: in_case(scene, case.name) for case in scene.cases}


def cycles_of(scene: SceneData) -> dict[str, float]:
    """Give the cycles that the machine runs in each load case in its life; none where the cases do not state them."""
    if all(case.cycles is not None for case in scene.cases):
        return {case.name: float(case.cycles or 0.0) for case in scene.cases}
    if any(case.share is None for case in scene.cases):
        return {}
    rates = {case.name: float(case.share or 0.0) * _speed(scene, case) for case in scene.cases}
    in_all = (scene.design.cycles or CYCLES) / (sum(rates.values()) or 1.0)
    return {name: rate * in_all for name, rate in rates.items()}


def _speed(scene: SceneData, case: LoadCase) -> float:
    """Rate of the cycle in a case (rad/s)."""
    if not scene.drives:
        return 1.0
    driven = {path: value for path, value in case.values.items() if path.split(".")[0] == "drive"}
    return abs(scene.model_copy(update={"cases": ()}).changed(driven).cycle_rate)


def check_cases(scene: SceneData) -> None:
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
