"""Rigid-body motion as a function of time, where the drive coordinate does not run at a constant rate: run-ups.

The linkage's coordinates depend on theta alone, so its branch is followed over one cycle and used again in every turn.
The chain rule gives the time derivatives from those by theta and those of the drive.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import SceneError
from fenics_mech.kinematics.assembly import AssemblyBranch, coordinates_at, derivatives, follow_branch
from fenics_mech.kinematics.conditioning import refuse_singular
from fenics_mech.kinematics.linkage import solve_motion
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.motion import Motion, as_motion
from fenics_mech.kinematics.start import assemble
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class RunUpLimits:
    """Limits of the motion while drives run up."""

    block: int = 2_000_000  # entries of the loop Jacobians that are held at a time
    same: float = 1e-9  # of the linkage's size, or rad: what a cycle may leave between two positions that are the same


RUN_UP = RunUpLimits()


def solve_motion_in_time(scene: Scene, time: Array) -> Motion:
    """Solve for the motion of a scene's links at given times, through the run-up of its drive and after it.

    All drives follow one coordinate theta. Without a run-up the motion is that of `solve_motion` at
    theta = rate times time.

    Parameters
    ----------
    scene
        The linkage and its drives.
    time
        Times (s) from 0 on, ascending, shape ``(times,)``.

    Returns
    -------
    Motion
        With one entry per time; velocities and accelerations are derivatives by time at the drive's true rate.

    Raises
    ------
    SceneError
        When the times are not finite, are negative, or do not ascend.
    AssemblyError
        When the links cannot be assembled at the start, or the drive cannot reach one of the angles.
    """
    time = np.asarray(time, dtype=float)
    _check(time)
    if not scene.drives:
        return replace(solve_motion(scene, np.zeros_like(time)), time=time)
    loops = Loops.of(scene)
    theta = scene.coordinate(time)
    branch, turns, step = _over_cycle(loops, theta.value)
    inside = theta.value - TURN * turns
    size = max(1, RUN_UP.block // (3 * len(loops.links)) ** 2)
    parts = []
    for start in range(0, len(time), size):
        angles = inside[start : start + size]
        q = coordinates_at(loops, angles, branch)
        refuse_singular(loops, angles, q)
        parts.append((q, *derivatives(loops, q, angles)))
    q, slope, curvature = (np.concatenate(part) for part in zip(*parts))
    rate, change = theta.first[:, None], theta.second[:, None]
    acceleration = slope * change + curvature * rate**2  # chain rule
    return as_motion(loops, theta.value, time, q + turns[:, None] * step, slope * rate, acceleration)


def _check(time: Array) -> None:
    if time.ndim != 1 or not len(time) or not np.isfinite(time).all():
        raise SceneError("the times must be a list of finite numbers", place="time")
    if time[0] < 0:
        raise SceneError(f"the motion starts at time 0, and {time[0]:g} s is before it", place="time")
    if (np.diff(time) < 0).any():
        raise SceneError("the times must ascend", place="time")


def _over_cycle(loops: Loops, theta: Array) -> tuple[AssemblyBranch, Array, Array]:
    """Find the branch over as much of theta as is needed, the whole cycles to take off each angle, and what one adds.

    A linkage whose links come back only after several cycles, or never, is followed all the way.
    """
    none = np.zeros_like(theta), np.zeros(3 * len(loops.links))
    if np.ptp(np.append(theta, 0.0)) > TURN:
        ends = np.array([0.0, TURN])
        branch = follow_branch(loops, assemble(loops), ends)
        first, last = coordinates_at(loops, ends, branch)
        step = (last - first).reshape(-1, 3)
        whole = np.zeros_like(step)
        whole[:, 2] = TURN * np.round(step[:, 2] / TURN)
        if np.abs((step - whole) / loops.unit.reshape(-1, 3)).max() < RUN_UP.same:
            return branch, np.floor(theta / TURN), whole.reshape(-1)
    return follow_branch(loops, assemble(loops), theta), *none
