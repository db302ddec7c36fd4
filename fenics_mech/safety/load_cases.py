"""Results of several load cases as one: the largest of each, and which case governs."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, norms
from fenics_mech.errors import ResultError
from fenics_mech.recovery.peaks import between_positions, curves_over_cycle
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.variables import ATTRIBUTES
from fenics_mech.safety.verdict import judge
from fenics_mech.scene import Scene
from fenics_mech.scene.load_cases import cycles_of

ENVELOPE = {  # variables of every case, by the dimension of what each is of
    "case_stress": "member",
    "case_strain": "member",
    "case_deflection": "member",
    "case_safety": "member",
    "case_joint_force": "joint",
    "case_effort": "drive",
}
LEAST = ("case_safety",)  # whose least governs


def of_cases(stated: Scene, results: Mapping[str, Result]) -> Result:
    """Give the results of a scene's load cases as one."""
    told = {
        name: Result(one.data.assign_attrs(case=name)) if one.case != name else one for name, one in results.items()
    }
    largest = _largest_of_each(told)
    governing = _governing(told, largest)
    cases = {"names": list(told), "cycles": cycles_of(stated), "scene": stated.model_dump_json()}
    data = told[governing].data.assign_coords(case=largest["case"]).assign(largest.data_vars)  # by its labels
    attributes = {"cases": json.dumps(cases)}
    for said in ("warnings", "notices"):
        attributes[said] = json.dumps(_said_of_all({name: getattr(one, said) for name, one in told.items()}))
    return Result(data.assign_attrs(attributes), told)


def envelope(result: Result) -> xr.Dataset:
    """Give the largest of all load cases of each member, joint and drive, and the case that governs it.

    Parameters
    ----------
    result
        A result of several load cases.

    Returns
    -------
    xarray.Dataset
        ``case_stress``, ``case_strain``, ``case_deflection``, ``case_joint_force``, ``case_effort`` without the cases,
        and the least ``case_safety``; beside each the name of its case as ``case_stress_in`` and so on.

    Raises
    ------
    ResultError
        When the result has no load cases.

    Examples
    --------
    >>> case = fm.LoadCase(name="slow", set={"drive": {"speed": "100 rpm"}})
    >>> scene = fm.load("demos/four_bar.toml").changed(cases=[case, {"name": "stated"}], effects=["coupling"])
    >>> fm.envelope(fm.analyse(scene))["case_stress_in"].sel(member="coupler").item()
    'stated'
    """
    if not result.cases:
        raise ResultError("the result has no load cases: state [[cases]] in its scene")
    names, found = np.array(result.data["case"].to_numpy(), dtype=object), {}
    for name in (name for name in ENVELOPE if name in result.data):
        values = result.data[name].transpose("case", ...)
        fill, best = (math.inf, np.argmin) if name in LEAST else (-math.inf, np.argmax)
        which = np.asarray(best(values.fillna(fill).to_numpy(), axis=0))
        most = values.min("case") if name in LEAST else values.max("case")
        found[name] = most.assign_attrs(values.attrs)
        found[f"{name}_in"] = most.copy(data=np.where(most.isnull(), "", names[which]).astype(object))
    return xr.Dataset(found)


def most_stressed(result: Result) -> str:
    """Name the load case with the largest stress, or of rigid links with the largest joint force."""
    name = "case_stress" if "case_stress" in result.data else "case_joint_force"
    most = result.data[name].fillna(-np.inf).max([dim for dim in result.data[name].dims if dim != "case"])
    return str(most["case"].to_numpy()[int(most.to_numpy().argmax())])


def _largest_of_each(results: Mapping[str, Result]) -> xr.Dataset:
    """Give the largest stress, strain, deflection, joint force and effort, and the least factor of safety, by case."""
    parts = {name: _largest(one) for name, one in results.items()}
    found: dict[str, Any] = {}
    for name, owner in ENVELOPE.items():
        if not all(name in part for part in parts.values()):
            continue
        labels = list(dict.fromkeys(label for part in parts.values() for label in part[name]))
        rows = [[part[name].get(label, math.nan) for label in labels] for part in parts.values()]
        unit, meaning = ATTRIBUTES[name]
        values = np.array(rows, dtype=float).reshape(len(parts), len(labels))
        found[name] = xr.DataArray(
            values, {"case": list(parts), owner: labels}, ("case", owner), attrs={"units": unit, "long_name": meaning}
        )
    return xr.Dataset(found)


def _largest(result: Result) -> dict[str, dict[str, float]]:
    """Give the largest of one case, between its positions too: of each member, joint and drive."""
    bends = bool(result.scene.members())
    data = between_positions(result).data if bends else result.data
    found = {"case_joint_force": _of_each(data["joint_force"], "joint", norms)}
    if "drive_effort" in result.data:
        effort = result.data["drive_effort"].transpose("theta", "drive")
        values = effort.to_numpy()
        curves = curves_over_cycle(result.scene, values) if bends else None
        most = np.abs(values).max(axis=0) if curves is None else np.abs(curves.largest()[1])
        found["case_effort"] = dict(zip(map(str, effort["drive"].to_numpy()), np.atleast_1d(most)))
    if not bends:
        return found
    strain = _of_each(data["strain"], "member", np.abs)
    closer = dict(zip(map(str, result.data["member"].to_numpy()), result.data["largest_strain"].to_numpy()))
    found["case_strain"] = {member: max(value, float(closer[member])) for member, value in strain.items()}
    found["case_stress"] = _of_each(data["stress"], "member", np.abs)
    found["case_deflection"] = _of_each(data["deflection"], "member", norms)
    verdict = judge(result)
    leasts = {member: verdict.least(member) for member in verdict.checks}
    found["case_safety"] = {member: math.nan if one is None else one.share for member, one in leasts.items()}
    return found


def _of_each(values: xr.DataArray, owner: str, size: Callable[[Array], Array]) -> dict[str, float]:
    vectors = ["component"] if "component" in values.dims else []
    sizes = size(values.transpose(owner, ..., *vectors).to_numpy())
    most = sizes.reshape(len(sizes), -1).max(axis=1)
    return dict(zip(map(str, values[owner].to_numpy()), map(float, most)))


def _governing(results: Mapping[str, Result], largest: xr.Dataset) -> str:
    """Name the case that decides whether the machine is safe."""
    names = list(results)
    for name in ("case_safety", "case_stress", "case_joint_force"):
        if name in largest and largest[name].size and largest[name].notnull().any():
            values = largest[name].to_numpy()
            if name in LEAST:
                return names[int(np.nanmin(np.where(np.isnan(values), math.inf, values), axis=1).argmin())]
            return names[int(np.nanmax(np.where(np.isnan(values), -math.inf, values), axis=1).argmax())]
    return names[0]


def _said_of_all(sentences: Mapping[str, tuple[str, ...]]) -> list[str]:
    """Give each sentence once; those that are not of all cases begin with the cases that they are of."""
    each = dict.fromkeys(one for said in sentences.values() for one in said)
    found = []
    for one in each:
        of = [name for name, said in sentences.items() if one in said]
        found.append(one if len(of) == len(sentences) else f"{' and '.join(of)}: {one}")
    return found
