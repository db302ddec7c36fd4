"""How the links move by each drive alone: influence coefficients, and the rates of the drives in a motion."""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics.linkage import Path
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.motion import Motion, as_motion, coordinates
from fenics_mech.scene import Scene


def drive_influences(scene: Scene, motion: Motion) -> list[Motion]:
    """Give the velocities of the links when one drive moves at unit rate and the others stand still.

    Parameters
    ----------
    scene
        The linkage and its drives.
    motion
        Its positions; only these are used.

    Returns
    -------
    list of Motion
        One for each drive of the scene, at 1 rad/s or 1 m/s and without accelerations. Velocities are the derivatives
        of the positions by the drive's angle or stroke (Nikravesh, Computer-Aided Analysis of Mechanical Systems,
        1988, chapter 3).
    """
    if not scene.moved_joints:
        return []
    path = motion.path
    if path is None:
        loops, q = Loops.of(scene), coordinates(motion.position, motion.angle)
        still = np.zeros_like(q)
        return [as_motion(loops, motion.theta, motion.theta, q, rates, still) for rates in _influences(loops, q)]
    return path.once("influences", (), partial(_of_path, path))


def _of_path(path: Path) -> list[Motion]:
    still = np.zeros_like(path.q)
    return [replace(path, slope=rates, curvature=still).motion(1.0) for rates in _influences(path.loops, path.q)]


def _influences(loops: Loops, q: Array) -> Array:
    """Derivatives of the coordinates by each drive, ``(drives, angles, 3 links)``."""
    unit = np.broadcast_to(np.eye(loops.drives), (len(q), loops.drives, loops.drives))
    sides = np.stack([loops.driven(unit[:, i]) for i in range(loops.drives)], axis=-1)
    return np.asarray(np.moveaxis(np.linalg.solve(loops.jacobian(q), sides), -1, 0), dtype=float)


def drive_rates(scene: Scene, motion: Motion) -> Array:
    """Give the rates of the drives in a motion.

    Parameters
    ----------
    scene
        The linkage and its drives.
    motion
        Its positions and velocities.

    Returns
    -------
    array
        Angular velocity (rad/s), or speed along the guide (m/s), of each drive, ``(angles, drives)``.
    """
    loops = Loops.of(scene)
    driven = loops.jacobian(coordinates(motion.position, motion.angle))[:, len(loops.names) - loops.drives :]
    found = np.einsum("tdi,ti->td", driven, coordinates(motion.velocity, motion.omega))
    ordered = np.empty_like(found)
    ordered[:, list(loops.drive_order)] = found
    return ordered
