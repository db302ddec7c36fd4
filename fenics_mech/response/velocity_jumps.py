"""What impulses do to the velocities of a mechanism."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.effects import NOTHING
from fenics_mech.effects.impulses import nodal_impulses
from fenics_mech.kinematics import solve_motion
from fenics_mech.kinematics.run_up import RUN_UP
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


def passages(scene: Scene, angle: float, start: float, end: float) -> Array:
    """Times (s) at which the drive comes to an angle, give or take whole cycles.

    Parameters
    ----------
    scene
        The scene.
    angle
        Drive angle (rad).
    start, end
        From when to when (s); a passage at the start counts at time 0 only.

    Returns
    -------
    numpy.ndarray
        Ascending, ``(passages,)``.
    """
    period, run_up = scene.period, scene.drives[0].run_up or 0.0
    sense = math.copysign(1, scene.cycle_rate)

    def turns(time: Array) -> Array:
        return sense * (scene.coordinate(time).value - angle) / TURN

    done = float(turns(np.array([run_up]))[0])
    first = run_up + period * (math.ceil(done - 1e-12) - done)
    found = [first + period * np.arange(math.ceil(end / period) + 2)]
    if run_up:
        grid = np.linspace(0, run_up, RUN_UP.places * (math.ceil(run_up / period) + 1))
        found.append(_crossings(turns, grid))
    times = np.unique(np.concatenate(found))
    same = RUN_UP.same_time * period
    times = times[np.diff(times, prepend=-np.inf) > same]
    return times[(times <= end + same) & ((times > start + same) | ((start == 0) & (times >= 0)))]


def _crossings(turns: Callable[[Array], Array], grid: Array) -> Array:
    """Times on a grid, and between its points, at which a number of turns is whole."""
    from scipy.optimize import brentq  # noqa: PLC0415  (slow to import, and few scenes have jumps)

    values = turns(grid)
    found = list(grid[values == np.round(values)])
    for before, after, low, high in zip(grid, grid[1:], values, values[1:]):
        for whole in range(math.floor(min(low, high)) + 1, math.ceil(max(low, high))):
            found.append(brentq(lambda time, whole=whole: turns(np.array([time]))[0] - whole, before, after))
    return np.array(found)
