"""The state from which a motion in time starts."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.errors import ResultError, SceneError
from fenics_mech.kinematics import coordinates
from fenics_mech.recovery.result import Result
from fenics_mech.scene import Cam, Scene
from fenics_mech.scene.analysis_options import STATED_STARTS
from fenics_mech.scene.free_motion_checks import refuse_late_impulses
from fenics_mech.scene.start_state import StartState

WANTED = "Give the result of a transient analysis of the same scene"
SAME_TIME = 1e-9  # of a motion, by which a time may differ from that of a position
SAME_ANGLE = 1e-6  # rad, or of the angle turned, by which a start may miss the drive


def state_to_go_on_from(scene: Scene) -> StartState | None:
    """Give the state of another result, from which rigid links with freedoms go on; None where the scene names none."""
    start = scene.analysis.start
    if scene.analysis.method != "transient" or start in STATED_STARTS:
        return None
    if not scene.freedoms:
        raise SceneError(
            "a motion whose drives lead all rigid links, or with joint laws alone, goes on from no result",
            place="analysis.start",
            hint="Write 'rigid', or name the joint that moves by itself under [freedoms]",
        )
    data = _read(Path(start))
    needed = {"time", "theta", "freedom_place", "freedom_rate", "link_position", "link_angle"}
    k = _refuse_other(scene, data, needed <= set(data.variables))
    along = {name: data[name].transpose("theta", ...)[k].to_numpy() for name in needed - {"time", "theta"}}
    links = coordinates(along["link_position"][None], along["link_angle"][None])[0]
    return StartState(float(data["time"][k]), along["freedom_place"], along["freedom_rate"], links)


@dataclass(frozen=True)
class GoneOn:
    """The end of another result, from which a motion of poses goes on."""

    time: float  # s
    state: Array  # coordinates of the poses, and their rates ``(2, coordinates)``
    freedoms: Array  # angles and strokes of the freedoms, and their rates ``(2, freedoms)``; they tell whole turns
    # measures of every term of the machine, which tell them instead; None where they are not known
    angles: Sequence[Array] | None = None


def poses_to_go_on_from(scene: Scene, size: int) -> GoneOn | None:
    """Give the state of another result, from which a motion of poses goes on; None where the scene names none."""
    if scene.analysis.start in STATED_STARTS:
        return None
    data = _read(Path(scene.analysis.start))
    state = _bent(scene, data, size)
    _refuse_other(scene, data, "freedom_rate" in data)
    along = [data[f"freedom_{what}"].transpose("theta", ...)[-1] for what in ("place", "rate") if scene.freedoms]
    return GoneOn(float(data["time"][-1]), state, np.array(along).reshape(2, len(scene.freedoms)))


def _refuse_other(scene: Scene, data: xr.Dataset, free: bool) -> int:
    """Give the position from which a motion goes on; raise `SceneError` where another result is not of its machine."""
    names = data["freedom"].to_numpy().tolist() if free else []
    if names != list(scene.freedoms):
        found, own = (f"the freedoms {', '.join(x)}" if x else "no freedoms" for x in (names, scene.freedoms))
        raise _unfit(f"{scene.analysis.start} has {found}, and the scene {own}")
    k = _number(scene, data)
    if "indentation" in data:
        _refuse_touching(scene, data, k)
    time, angle = float(data["time"][k]), float(data["theta"][k])
    turned = float(scene.coordinate(np.array([time])).value[0]) if scene.drives else angle
    if abs(angle - turned) > SAME_ANGLE * max(1.0, abs(turned)):
        raise _unfit(
            f"{scene.analysis.start} is after {time:.6g} s at drive angle {math.degrees(angle):.6g} deg, where the "
            f"scene's drive is at {math.degrees(turned):.6g} deg"
        )
    refuse_late_impulses(scene, time)
    return k


def _number(scene: Scene, data: xr.Dataset) -> int:
    """Number of the position from which the motion goes on."""
    time, wanted = data["time"].to_numpy(), scene.analysis.start_time
    if wanted is None:
        return len(time) - 1
    k = int(np.abs(time - wanted).argmin())
    if abs(time[k] - wanted) > SAME_TIME * max(float(np.ptp(time)), abs(wanted)):
        raise SceneError(
            f"{scene.analysis.start} has no position at {wanted:.10g} s; next to that is {time[k]:.10g} s",
            place="analysis.start_time",
            hint="Give a time of the result, or leave it out to go on from the end",
        )
    return k


def _refuse_touching(scene: Scene, data: xr.Dataset, k: int) -> None:
    """Raise where a contact is closed whose force goes by the rate at which it began."""
    for name, depth in zip(data["contact"].to_numpy(), data["indentation"].transpose("theta", ...)[k].to_numpy()):
        law = scene.joint_laws.get(str(name).partition(":")[0])
        if depth > 0 and law is not None and not isinstance(law, Cam):
            raise SceneError(
                f"at {float(data['time'][k]):.6g} s the bodies of joint {law.joint!r} touch, and how fast they met is "
                "not kept",
                place="analysis.start_time",
                hint="Go on from a time at which they do not touch",
            )


def _unfit(what: str) -> SceneError:
    return SceneError(f"{what}: it cannot go on from there", place="analysis.start", hint=WANTED)


def _read(start: Path) -> xr.Dataset:
    """Read another result."""
    if not start.is_file():
        raise SceneError(
            f"there is no file {str(start)!r}",
            place="analysis.start",
            hint="Write 'rigid', 'static', 'smooth', 'periodic', or the file of a result of a transient analysis",
        )
    try:
        return Result.load(start).data
    except ResultError as error:
        message = f"{str(start)!r} is not a result of this program"
        raise SceneError(message, place="analysis.start", hint=WANTED) from error


def _bent(scene: Scene, data: xr.Dataset, size: int) -> Array:
    """Coordinates of bending links and their rates at the end of another result, ``(2, coordinates)``."""
    start, held = scene.analysis.start, "no state of bending links"
    if {"state", "time", "theta"} <= set(data.variables) and data["state"].dims == ("dof", "derivative"):
        if data["state"].shape == (size, 2):
            if _number(scene, data) != data.sizes["theta"] - 1:
                raise _unfit(f"{start} holds the state of bending links at its end only")
            return data["state"].transpose("derivative", "dof").to_numpy()
        held = f"{data.sizes['dof']} coordinates"
    raise _unfit(f"{start} holds {held}, and the scene has {size}")
