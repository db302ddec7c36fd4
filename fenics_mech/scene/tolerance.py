"""The tolerance of a scene: the largest relative errors of the quantities that it names."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any

from pydantic import BeforeValidator, WithJsonSchema

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.base import SCENE
from fenics_mech.scene.units import in_unit

QUANTITIES = ("strain", "deflection", "joint_force", "torque")  # that a tolerance may name


def _share(value: Any) -> float:
    share = float(in_unit("1")(value))
    smallest, largest = SCENE.smallest_tolerance, SCENE.largest_tolerance
    if not smallest < share < largest:
        advice = f': write "{share:.6g} %" for percent' if largest <= share < 100 else ""
        raise ValueError(f"must be more than {smallest:g} and less than {largest:g}, found {shortened(value)}{advice}")
    return share


def _read(value: Any) -> Any:
    """Read one share, which is of the strains, or a table of shares by quantity."""
    if value is None:
        return None
    if not isinstance(value, Mapping):
        return _share(value)
    names = ", ".join(QUANTITIES)
    if not value:
        raise ValueError(f"names no quantity; known are {names}")
    found: dict[str, float] = {}
    for name, share in value.items():
        if name not in QUANTITIES:
            raise ValueError(f"cannot be of {shortened(name)}; known quantities are {names}")
        try:
            found[name] = _share(share)
        except ValueError as error:
            raise ValueError(f"of {name}: {error}") from None
    return found


def _schema() -> dict[str, Any]:
    share = [{"type": "number"}, {"type": "string"}]
    each = {"anyOf": share, "description": "1, or a string with a unit"}
    table = {"type": "object", "properties": dict.fromkeys(QUANTITIES, each), "additionalProperties": False}
    kinds = [*share, table | {"minProperties": 1}, {"type": "null"}]
    return {"anyOf": kinds, "default": None, "description": "Share of the strains, or shares by quantity"}


Tolerance = Annotated[float | dict[str, float] | None, BeforeValidator(_read), WithJsonSchema(_schema())]


def stated(items: Sequence[str]) -> str | dict[str, str]:
    """Give the tolerance that options of the command state: "1e-3" of the strains, or "deflection=1e-2"."""
    if len(items) == 1 and "=" not in items[0]:
        return items[0]
    found: dict[str, str] = {}
    for item in items:
        name, _, share = item.rpartition("=")
        name = name.strip() or "strain"
        if name in found:
            raise SceneError(f"it is stated twice for {name}", place="--tol", hint="Give one for each quantity")
        found[name] = share
    return found
