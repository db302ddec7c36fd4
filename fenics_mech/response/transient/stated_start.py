"""The starts of a motion in time that a scene can name: straight, bent at rest, and on the slow motion."""

from __future__ import annotations

import numpy as np

from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism import System
from fenics_mech.response.setup import moved
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.response.transient.free_motion import start_of
from fenics_mech.response.transient.free_state import FreeState
from fenics_mech.scene import Scene
from fenics_mech.scene.start_state import StartState


def stated_start(scene: Scene, system: System) -> StartState | None:
    """Give the state that `analysis.start` names; None where it is that of another result.

    Parameters
    ----------
    scene
        A scene with a drive.
    system
        Its mechanism.
    """
    start, still = scene.analysis.start, np.zeros(system.size)
    if start == "rigid":
        return StartState(0.0, still, still)
    if start == "static":
        here = moved(scene, system, solve_motion_in_time(scene, np.zeros(1)))
        return StartState(0.0, solve_static(here).displacement[0], still)
    if start == "smooth":
        return start_of(FreeState(scene, system))
    return None
