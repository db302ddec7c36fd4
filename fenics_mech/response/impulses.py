"""What impulses do to the velocities of a mechanism."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.effects import NOTHING
from fenics_mech.effects.impulses import nodal_impulses
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.steps import Steps
from fenics_mech.scene import Scene

Array = NDArray[np.float64]


def velocity_jumps(scene: Scene, system: System, steps: Steps) -> Array | None:
    """Solve ``M jump = P^T J`` at every impulse; the drives keep to their law meanwhile.

    Returns
    -------
    numpy.ndarray or None
        Change of q' at the starts of the steps, ``(steps, coordinates)``; None where nothing strikes.
    """
    if not scene.impulses:
        return None
    motion = solve_motion(scene, steps.start[steps.struck], near=system.motion)
    struck = replace(system, motion=motion, terms=NOTHING)
    momenta = struck.transformation.backward(struck.values, nodal_impulses(scene, system.beams, motion))
    jump = np.zeros((len(steps.start), system.size))
    np.add.at(jump, steps.struck, np.linalg.solve(Equation(struck).linear.mass, momenta[..., None])[..., 0])
    return jump
