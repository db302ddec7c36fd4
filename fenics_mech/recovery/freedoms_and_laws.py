"""How freedoms run, the electrical power of their motors, and what joint laws exert, as variables of a result."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.freedoms import no_torque_speed


def of_freedoms(scene: Scene, place: Array, rate: Array) -> xr.Dataset:
    """Label angles and strokes of the freedoms, and their rates, ``(times, freedoms)`` each."""
    along = ("theta", "freedom")
    states = {"freedom_place": (along, place), "freedom_rate": (along, rate)}
    return xr.Dataset(states, {"freedom": list(scene.freedoms)})


def running(scene: Scene, time: Array, place: Array, rate: Array) -> xr.Dataset:
    """Describe how freedoms run in a motion in time."""
    # time: times (s), ``(times,)``; place, rate: angles and strokes of the freedoms and their rates, ``(times,
    # freedoms)`` each
    # Gives `last_turn_rate` (rad/s) and `last_turn_fluctuation` by `freedom`, where one that turns has come round:
    # the mean rate over the last turn, and the range of the rate over that. `electrical_power` (W) by `motor_at`,
    # where there are motors: the torque times the speed at which they have none. What it is more than that of the
    # torque at the shaft heats the rotor. Source: Fitzgerald, Kingsley and Umans, Electric Machinery (2003), chapters
    # 6 and 7.
    found, names = xr.Dataset(), list(scene.freedoms)
    turns = np.array([_last_turn(time, place[:, i], rate[:, i]) for i in range(len(names))]).reshape(-1, 2)
    turns[[isinstance(scene.joints[name], Slot | Prismatic) for name in names]] = np.nan
    if not np.isnan(turns).all():
        for i, variable in enumerate(("last_turn_rate", "last_turn_fluctuation")):
            found[variable] = (("freedom",), turns[:, i])
        found = found.assign_coords(freedom=names)
    motors = {}
    for i, (name, freedom) in enumerate(scene.freedoms.items()):
        if (speed := no_torque_speed(freedom.effort)) is not None:
            motors[name] = speed * freedom.effort_at(time, place[:, i], rate[:, i])
    if motors:
        found["electrical_power"] = (("theta", "motor_at"), np.stack(list(motors.values()), axis=1))
        found = found.assign_coords(motor_at=list(motors))
    return found


def _last_turn(time: Array, place: Array, rate: Array) -> tuple[float, float]:
    """Mean rate over the last turn, and the range of the rate over that; no numbers where there is no such turn."""
    whole = 2 * np.pi * np.sign(place[-1] - place[0])
    before = np.flatnonzero((place[-1] - place) * np.sign(whole) >= abs(whole))  # a turn or more before the end
    if not whole or not len(before):
        return np.nan, np.nan
    first = int(before[-1])
    share = (place[-1] - whole - place[first]) / (place[first + 1] - place[first])
    began, there = ((1 - share) * part[first] + share * part[first + 1] for part in (time, rate))
    rates = np.append(rate[first + 1 :], there)
    mean = whole / (time[-1] - began)
    return float(mean), float(np.ptp(rates) / abs(mean))


def law_efforts(
    found: OfPoses, inside: OfPoses | None = None, peaks: Mapping[str, float] | None = None, closings: int = 0
) -> xr.Dataset:
    """Label what joint laws exert, the most of it (N or N m), and how far and how often contacts closed."""
    # inside: the motion at the stages of its steps; peaks: the most between these, by law
    efforts, depths = found.laws(), found.depths()
    if not efforts:
        return xr.Dataset()
    seen = {name: [(peaks or {}).get(name, 0.0)] for name in efforts}
    for part in (efforts, {} if inside is None else inside.laws()):
        for name, effort in part.items():
            seen[name].append(float(np.abs(effort).max()))
    data = xr.Dataset(
        {
            "law_effort": (("theta", "law"), np.stack(list(efforts.values()), axis=1)),
            "largest_law_effort": (("law",), list(map(max, seen.values()))),
        },
        {"law": list(efforts)},
    )
    if depths:
        data["indentation"] = (("theta", "contact"), np.stack(list(depths.values()), axis=1))
        data = data.assign_coords(contact=list(depths)).assign_attrs(contacts_closed=closings)
    return data
