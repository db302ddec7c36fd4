"""The largest strain of a sweep over one number, sought between its points."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.studies.kept_points import Record
from fenics_mech.studies.sweep_points import stacked

MOST = 3  # analyses: parabolas through three points then meet the top of an oscillator's curve to 1 %
ENOUGH = 0.02  # of a step of the sweep, by which the top moves no more


def largest_between(
    values: Sequence[float], records: Sequence[Record], analysed: Callable[[float], Record], members: Sequence[str]
) -> str:
    """Seek the largest strain between the points beside the largest one, by parabolas; what was found, as JSON."""
    strains = stacked([_strains(record) for record in records]).reshape(len(records), -1)
    if np.isnan(strains).all():
        return ""
    k, member = map(int, np.unravel_index(int(np.nanargmax(strains)), strains.shape))
    if not 0 < k < len(values) - 1 or np.isnan(strains[k - 1 : k + 2, member]).any():
        return ""
    x, y = np.array(values[k - 1 : k + 2], dtype=float), strains[k - 1 : k + 2, member]
    step, best = min(np.diff(x)), None
    for _ in range(MOST):
        top = vertex(x, y)
        if not x[0] < top < x[2] or np.abs(top - x).min() < ENOUGH * step:
            break
        record = analysed(top)
        found = _strains(record)
        if found is None:
            break
        best = (top, record) if found[member] > y.max() else best
        x, y = _around_top(np.append(x, top), np.append(y, found[member]))
    if best is None:
        return ""
    value, record = best
    told = {"value": value, "member": members[member]}
    return json.dumps(told | {name: record["values"][f"peak_{name}"][member] for name in ("strain", "stress")})


def vertex(x: Array, y: Array) -> float:
    """Give where the parabola through three points has its top; NaN where it has none."""
    left, right = (y[1] - y[0]) / (x[1] - x[0]), (y[2] - y[1]) / (x[2] - x[1])
    bend = (right - left) / (x[2] - x[0])
    return float((x[0] + x[1]) / 2 - left / (2 * bend)) if bend < 0 else math.nan


def _around_top(x: Array, y: Array) -> tuple[Array, Array]:
    """Give the highest of points and those beside it."""
    order = np.argsort(x)
    x, y = x[order], y[order]
    k = min(max(int(y.argmax()), 1), len(x) - 2)
    return x[k - 1 : k + 2], y[k - 1 : k + 2]


def _strains(record: Record) -> list[float] | None:
    """Peak strains of a point with a stable motion, by member."""
    return None if record["error"] or record["unstable"] else record.get("values", {}).get("peak_strain")
