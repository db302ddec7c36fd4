"""Labels of what is found beside a motion with freedoms: its section, exponents, and multipliers where it repeats."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.response.transient.beside import Beside
from fenics_mech.response.transient.disturbances import quarters_of
from fenics_mech.response.transient.shooting import RepeatedMotion
from fenics_mech.scene import Scene


def beside_motion(scene: Scene, beside: Beside | None, time: Array, repeated: RepeatedMotion | None) -> xr.Dataset:
    """Label what is found beside a motion.

    Parameters
    ----------
    scene
        The scene.
    beside
        What was followed beside the motion.
    time
        Times of the positions (s), ``(times,)``.
    repeated
        The motion that repeats, if it is one.
    """
    found = xr.Dataset()
    if beside is not None and beside.section is not None:
        points = beside.section.points()
        along = "section_point", "freedom"
        states = {"section_place": (along, points.place), "section_rate": (along, points.rate)}
        found = found.merge(
            xr.Dataset(states, {"section_time": ("section_point", points.time), "freedom": list(scene.freedoms)})
        )
    if beside is not None and beside.growth is not None:
        found = found.merge(_of_growth(beside.growth.of_each, time))
    return found if repeated is None else found.merge(_of_repeated(repeated), combine_attrs="no_conflicts")


def _of_growth(of_each: list[tuple[float, Array]], time: Array) -> xr.Dataset:
    """Logarithms of what disturbances grow by, and the exponents: their rates over the second half of the motion."""
    ends = np.append(time[0], [end for end, _ in of_each])
    grown = np.vstack([np.zeros_like(of_each[0][1]), *(growth for _, growth in of_each)])
    at = np.stack([np.interp(time, ends, column) for column in grown.T], axis=1)
    quarters = quarters_of(time)
    there = np.stack([np.interp(quarters, ends, column) for column in grown.T], axis=1)
    rates = np.diff(there, axis=0) / np.diff(quarters)[:, None]
    exponents = (there[-1] - there[0]) / (quarters[-1] - quarters[0])
    order = np.argsort(-exponents, kind="stable")
    of_all: dict[str, Any] = {
        "lyapunov_exponent": ("exponent", exponents[order]),
        "lyapunov_change": ("exponent", np.abs(rates[1] - rates[0])[order]),
        "disturbance_growth": (("theta", "exponent"), at[:, order]),
    }
    return xr.Dataset(of_all, {"exponent": np.arange(1, len(order) + 1)})


def _of_repeated(repeated: RepeatedMotion) -> xr.Dataset:
    """Multipliers of a motion that repeats, and its period."""
    attributes = {"repeats_after": repeated.period, "own_period": int(repeated.own), "closing_error": repeated.change}
    values = repeated.multipliers
    if not len(values):
        return xr.Dataset(attrs=attributes)
    parts = np.stack([values.real, values.imag], axis=1)
    rates = np.log(np.maximum(np.abs(values), np.finfo(float).tiny)) / repeated.period
    of_all: dict[str, Any] = {"multiplier": (("disturbance", "part"), parts), "growth_rate": ("disturbance", rates)}
    return xr.Dataset(of_all, {"disturbance": np.arange(1, len(values) + 1), "part": ["real", "imaginary"]}, attributes)
