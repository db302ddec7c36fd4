"""The state from which a motion in time starts."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from fenics_mech.errors import ResultError, SceneError
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism import System
from fenics_mech.recovery.result import Result
from fenics_mech.response.setup import moved
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.response.transient.course import StartState
from fenics_mech.scene import Scene

WANTED = "Give the result of a transient analysis of the same scene"
SAME_ANGLE = 1e-6  # rad, or of the angle turned, by which a start may miss the drive


def start_state(scene: Scene, system: System) -> StartState:
    """Give the state that `analysis.start` states: at rest, in static equilibrium, or the end of another result.

    Parameters
    ----------
    scene
        A scene with a drive.
    system
        Its mechanism.

    Raises
    ------
    SceneError
        When a result that is to be gone on from cannot be read, or does not fit the scene.
    """
    start, still = scene.analysis.start, np.zeros(system.size)
    if start == "rigid":
        return StartState(0.0, still, still)
    if start == "static":
        here = moved(scene, system, solve_motion_in_time(scene, np.zeros(1)))
        return StartState(0.0, solve_static(here).displacement[0], still)
    return _end_of(Path(start), scene, system)


def _end_of(start: Path, scene: Scene, system: System) -> StartState:
    """Give the state at the end of another result."""
    if not start.is_file():
        raise SceneError(
            f"there is no file {str(start)!r}",
            place="analysis.start",
            hint="Write 'rigid', 'static', or the file of a result of a transient analysis",
        )
    try:
        data = Result.load(start).data
    except ResultError as error:
        message = f"{str(start)!r} is not a result of this program"
        raise SceneError(message, place="analysis.start", hint=WANTED) from error
    goes_on = {"state", "time", "theta"} <= set(data.variables) and data["state"].dims == ("dof", "derivative")
    if not goes_on or data["state"].shape != (system.size, 2):
        held = f"{data.sizes['dof']} degrees of freedom" if goes_on else "no state"
        raise SceneError(
            f"{start} holds {held}, and the scene has {system.size}: it cannot go on from there",
            place="analysis.start",
            hint=WANTED,
        )
    time, angle = float(data["time"][-1]), float(data["theta"][-1])
    turned = float(scene.coordinate(np.array([time])).value[0])
    if abs(angle - turned) > SAME_ANGLE * max(1.0, abs(turned)):
        raise SceneError(
            f"{start} ends after {time:.6g} s at drive angle {math.degrees(angle):.6g} deg, where the scene's drive is "
            f"at {math.degrees(turned):.6g} deg: it cannot go on from there",
            place="analysis.start",
            hint=WANTED,
        )
    displacement, velocity = data["state"].transpose("derivative", "dof").to_numpy()
    return StartState(time, displacement, velocity)
