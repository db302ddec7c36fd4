"""Datasets of several load cases in one: that of the governing case as it is, others under names that begin with it."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr
from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fenics_mech._read_back import STRICT, NotNegative

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_\-]*")
OTHERS = "other_cases"  # attribute with the attributes of the other cases, as JSON


class _Told(TypedDict):
    """What a result says of its load cases."""

    __pydantic_config__ = STRICT  # type: ignore[misc]
    names: list[str]
    cycles: dict[str, NotNegative]
    scene: str


TOLD = TypeAdapter(_Told)


def names_of(told: str, known: set[str]) -> list[str]:
    """Give the names of the load cases that a file holds."""
    try:
        names = TOLD.validate_json(told)["names"]
    except ValidationError as error:
        raise ValueError("it does not tell its load cases") from error
    if sorted(names) != sorted(known) or not all(map(NAME.fullmatch, names)):
        raise ValueError("it tells of other load cases than it holds")
    return names


def packed(data: xr.Dataset, others: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Put the datasets of other load cases into that of the governing one."""
    if not others:
        return data
    found = data.copy()
    for case, other in others.items():
        names = {str(name): f"{case}.{name}" for name in {*other.variables, *other.dims}}
        renamed = {names[str(name)]: _renamed(variable, names) for name, variable in other.variables.items()}
        coords = {names[str(name)] for name in other.coords}
        found = found.assign_coords({name: one for name, one in renamed.items() if name in coords})
        found = found.assign({name: one for name, one in renamed.items() if name not in coords})
    attributes = {case: other.attrs for case, other in others.items()}
    return found.assign_attrs({OTHERS: json.dumps(attributes, default=_plain)})


def _renamed(variable: xr.Variable, names: Mapping[str, str]) -> xr.Variable:
    return xr.Variable([names[str(dim)] for dim in variable.dims], variable.to_numpy(), variable.attrs)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)


def unpacked(stored: xr.Dataset) -> tuple[xr.Dataset, dict[str, xr.Dataset]]:
    """Take apart what `packed` has put together."""
    if OTHERS not in stored.attrs:
        return stored, {}
    attributes = json.loads(str(stored.attrs[OTHERS]))
    if not isinstance(attributes, dict) or not all(map(NAME.fullmatch, attributes)):
        raise ValueError("it does not tell its load cases")
    found = {}
    for case, of_case in attributes.items():
        begin = f"{case}."
        names = {name: name.removeprefix(begin) for name in map(str, {*stored.variables, *stored.dims})}
        own = [name for name in map(str, stored.variables) if name.startswith(begin)]
        parts = {names[name]: _renamed(stored.variables[name], names) for name in own}
        coords = {names[name] for name in own if name in stored.coords}
        found[case] = xr.Dataset(
            {name: part for name, part in parts.items() if name not in coords},
            {name: part for name, part in parts.items() if name in coords},
            of_case,
        )
    of_others = [name for name in stored.variables if any(str(name).startswith(f"{case}.") for case in attributes)]
    data = stored.drop_vars(of_others)
    data.attrs = {key: value for key, value in stored.attrs.items() if key != OTHERS}
    return data, found
