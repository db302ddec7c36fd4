"""Figures of the stresses by which members are judged: range, mean and ratio, utilisation, and damage by fatigue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.errors import MechanismError, ResultError
from fenics_mech.recovery.faces import faces_by_member
from fenics_mech.recovery.peaks import curves_over_cycle
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.signal import last_cycle
from fenics_mech.scene import Scene
from fenics_mech.scene.bodies import StressLife

HOUR = 3600.0  # seconds
SWINGS = "stress_range", "stress_mean", "stress_ratio"
NO_STRESS = (
    1e-5  # of the largest of the member, or of one material in it: as at a free end; linear motions round to 1e-6
)


def stress_figures(scene: Scene, data: xr.Dataset, part: slice | None) -> xr.Dataset:
    """Give range, mean and ratio of the stresses at every place, and how far members use their strength."""
    # data: its result, with the stress (Pa)
    stress = data.variables["stress"].transpose("theta", "member", "s", "fibre").to_numpy()
    found: dict[str, Any] = {}
    along = "member", "s", "fibre"
    if part is not None:
        curves = curves_over_cycle(scene, stress[part], "stress")
        swings = _swings(curves.highest()[1], curves.lowest()[1], (1, 2))
        found = {name: (along, values) for name, values in zip(SWINGS, swings)}
    fibres = [str(fibre) for fibre in data.variables["fibre"].to_numpy()]
    plus, minus = (stress[..., fibres.index(fibre)] for fibre in "+-")
    shares = _used(scene, plus, minus, part)
    if np.isfinite(shares).any():
        found["utilisation"] = (("member",), shares)
    return xr.Dataset(found)


def _swings(largest: Array, least: Array, places: int | tuple[int, ...]) -> tuple[Array, Array, Array]:
    """Give range, mean (Pa) and ratio from the largest and the least stress; `places` are the axes within a member."""
    size = np.maximum(np.abs(largest), np.abs(least))
    stressed = np.abs(largest) > NO_STRESS * size.max(axis=places, keepdims=True)
    ratio = least / np.where(stressed, largest, np.nan)
    return largest - least, (largest + least) / 2, ratio


def _used(scene: Scene, plus: Array, minus: Array, part: slice | None) -> Array:
    """Give the largest stress over the strength, of all materials of each member; NaN where none states it."""
    # `plus` and `minus` are the stresses of both outer fibres (Pa), ``(angles, members, stations)``.
    shares = np.full(plus.shape[1], np.nan)
    for i, faces in enumerate(faces_by_member(scene).values()):
        for face in faces:
            if (strength := scene.materials[face.material].strength) is None:
                continue
            stress = face.stress(plus[:, i], minus[:, i])
            largest = np.abs(stress).max()
            if part is not None:
                curves = curves_over_cycle(scene, stress[part], "stress")
                largest = max(largest, curves.highest()[1].max(), -curves.lowest()[1].min())
            shares[i] = np.fmax(shares[i], largest / strength)
    return shares


def fatigue(result: Result) -> xr.Dataset:
    """Give the damage by fatigue at every place of the members, by rainflow counting and Miner's rule.

    A periodic motion is counted as one that goes on, from its largest stress on, so that every cycle closes. A motion
    in time that does not repeat itself is counted once. Cycles are those of ASTM E1049.

    Parameters
    ----------
    result
        A result whose materials state `fatigue`, a stress-life curve.

    Returns
    -------
    xarray.Dataset
        `damage` of one cycle of the machine, or of the motion in time, by member, s and fibre: at 1 it breaks. Of inner
        plies and parts it counts for the nearer outer fibre. Of a motion that repeats also `stress_range`,
        `stress_mean` and `stress_ratio` of the material that has this damage. By member `life_cycles` and `life_hours`
        of its worst place, infinite where nothing is damaged.

    Raises
    ------
    ResultError
        When no material states a curve, or there is one position only.
    MechanismError
        When the library `rainflow` is not installed.

    Examples
    --------
    >>> curve = fm.StressLife(range="40 MPa", slope=5)
    >>> scene = fm.load("demos/four_bar.toml").changed({"materials.aluminium.fatigue": curve, "effects": ()})
    >>> result = fm.analyse(scene.changed({"analysis.method": "quasi-static", "analysis.sub_intervals": 36}))
    >>> float(fm.fatigue(result)["life_hours"].sel(member="coupler")) > 1000
    True
    """
    scene = result.scene
    faces = [face for all_faces in faces_by_member(scene).values() for face in all_faces]
    if not any(scene.materials[face.material].fatigue for face in faces):
        raise ResultError("no material states `fatigue`, its stress-life curve: fatigue = { range = ..., slope = ... }")
    if result.data.sizes["theta"] < 2:
        raise ResultError("a single position has no cycles of stress")
    part = last_cycle(scene.analysis, scene.drives, result.data)
    stress = result.data["stress"].transpose("member", "s", "fibre", "theta")
    stress = stress if part is None else stress.isel(theta=part)
    of_worst = _damages(scene, stress, part is not None)
    duration = scene.period if part is not None else float(np.ptp(result.data["time"].to_numpy()))
    any_time = stress.isel(theta=0, drop=True)
    found = xr.Dataset({name: any_time.copy(data=values) for name, values in of_worst.items()})
    worst = found["damage"].max(("s", "fibre"))
    found["life_cycles"] = xr.where(worst > 0, 1 / worst.where(worst > 0), np.inf).where(worst.notnull())
    found["life_hours"] = found["life_cycles"] * duration / HOUR
    for name in found:
        unit, meaning = MEANINGS[str(name)]
        found[name].attrs = {"units": unit, "long_name": meaning}
    return found


def life_used(result: Result) -> xr.Dataset:
    """Give the share of their life that members use in each load case, and in all, by the cycles that cases state."""
    if not result.cases:
        raise ResultError("the result has no load cases: state [[cases]] in its scene")
    each = {name: fatigue(one)["damage"] for name, one in result.cases.items()}
    first = next(iter(each.values()))
    if any(not np.array_equal(first["s"], one["s"]) for one in each.values()):  # the worst place stands for all
        each = {name: xr.ones_like(first) * one.max(("s", "fibre")) for name, one in each.items()}
    damage = xr.concat(each.values(), xr.Variable("case", list(each)), coords="minimal", compat="override")
    found = xr.Dataset({"damage": damage.assign_attrs(units="1", long_name="damage of one cycle of the machine")})
    if result.cycles:
        cycles = xr.DataArray([result.cycles[name] for name in each], {"case": list(each)}, ("case",))
        spent = (damage * cycles).transpose("member", "case", "s", "fibre")
        total = spent.sum("case", skipna=False).stack(place=("s", "fibre"))
        worst = total.fillna(-1.0).argmax("place")
        found["used"] = spent.stack(place=("s", "fibre")).isel(place=worst).drop_vars(["place", "s", "fibre"])
        found["life_used"] = total.max("place")
    return found


def _damages(scene: Scene, stress: xr.DataArray, repeats: bool) -> dict[str, Array]:
    """Give the damage on both sides of the sections ``(members, stations, fibres)``: of the worst material there."""
    # Where the motion repeats, the swings of the stress in that material are beside it. `stress` is that of the outer
    # fibres over member, s, fibre and theta.
    waves, fibres = np.moveaxis(stress.to_numpy(), -1, 0), [str(fibre) for fibre in stress["fibre"].to_numpy()]
    names = ("damage", *(SWINGS if repeats else ()))
    worst = np.full((len(names), *stress.shape[:3]), np.nan)
    for i, faces in enumerate(faces_by_member(scene).values()):
        for face in faces:
            if (curve := scene.materials[face.material].fatigue) is None:
                continue
            wave = face.stress(*(waves[:, i, :, fibres.index(fibre)] for fibre in "+-"))
            swings: list[Array] = []
            if repeats:  # else the end does not go on at the start
                curves = curves_over_cycle(scene, wave, "stress")
                wave, swings = curves.turning(), [*_swings(curves.highest()[1], curves.lowest()[1], 0)]
            damage = np.array([_damage(one, curve, repeats) for one in wave.T])
            here = worst[:, i, :, fibres.index(face.side)]
            worse = ~(here[0] >= damage)
            here[:, worse] = np.stack([damage, *swings])[:, worse]
    return dict(zip(names, worst))


MEANINGS = {
    "stress_range": ("Pa", "stress range over the cycle, of the material with the largest damage on this side"),
    "stress_mean": ("Pa", "half of its largest and its least stress over the cycle"),
    "stress_ratio": ("1", "its least over its largest stress in the cycle"),
    "damage": ("1", "damage of one cycle of the machine, or of the motion in time; at 1 the place breaks"),
    "life_cycles": ("1", "cycles of the machine until the worst place of the member breaks"),
    "life_hours": ("h", "time until the worst place of the member breaks"),
}


def stress_cycles(stress: Array, repeats: bool) -> Array:
    """Count the cycles of a stress by rainflow."""
    # stress: stress (Pa) over time, ``(steps,)``
    # Gives range (Pa), mean (Pa) and count (1 or 0.5) of each cycle, ``(cycles, 3)``.
    try:
        from rainflow import extract_cycles  # noqa: PLC0415  (an extra that few need)
    except ImportError as error:
        advice = "pip install 'fenics_mech[fatigue]'"
        raise MechanismError(f"counting cycles needs the library rainflow: {advice}") from error
    if repeats:
        start = int(stress.argmax())
        stress = np.append(np.roll(stress, -start), stress[start])
    cycles: Sequence[tuple[float, ...]] = [cycle[:3] for cycle in extract_cycles(stress.tolist())]
    return np.array(cycles, dtype=float).reshape(-1, 3)


def _damage(stress: Array, curve: StressLife, repeats: bool) -> float:
    """Damage of all cycles of a stress, ``(steps,)``, by the rule of Palmgren and Miner."""
    ranges, mean, count = stress_cycles(stress, repeats).T
    return float(count @ curve.damage(ranges, mean))
