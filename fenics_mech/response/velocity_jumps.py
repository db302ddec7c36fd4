"""What impulses do to the velocities of a mechanism."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects import NOTHING
from fenics_mech.effects.impulses import nodal_impulses
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.scene import Scene


def velocity_jumps(scene: Scene, system: System, steps: Steps) -> Array | None:
    """Change velocities at the starts of the steps of a cycle.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.
    steps
        The steps of its cycle, which begin at impulses.

    Returns
    -------
    numpy.ndarray or None
        Change of q' at the starts of the steps, ``(steps, coordinates)``; None where nothing strikes.
    """
    if not scene.impulses:
        return None
    jump = np.zeros((len(steps.start), system.size))
    np.add.at(jump, steps.struck, jumps_at(scene, system, steps.start[steps.struck]))
    return jump


def jumps_at(scene: Scene, system: System, theta: Array) -> Array:
    """Solve ``M jump = P^T J`` for every impulse; the drives keep to their law meanwhile.

    Parameters
    ----------
    scene, system
        The scene and its mechanism.
    theta
        Drive angle of each impulse (rad).

    Returns
    -------
    numpy.ndarray
        Change of q' by each impulse, ``(impulses, coordinates)``.
    """
    motion = solve_motion(scene, theta, near=system.motion)
    struck = replace(system, motion=motion, terms=NOTHING)
    impulses, _ = nodal_impulses(scene.impulses.values(), scene.links, scene.joints, system.beams, motion)
    momenta = struck.on_coordinates(impulses)
    return Equation(struck).linear.mass.solve(momenta)
