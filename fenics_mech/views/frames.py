"""What each picture of an animation shows, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import MICRO
from fenics_mech.kinematics import solve_motion
from fenics_mech.recovery import Result
from fenics_mech.views.geometry import at_angles, ends_of, member_ends
from fenics_mech.views.joint_drawings import pin_places, rigid_bars, slider_angles
from fenics_mech.views.symbols import BLOCK_CORNERS, turned

DEFLECTED = 0.08  # of the linkage's size, for the largest deflection as drawn
COVERED = 0.98
ROUND = np.array([1, 2, 2.5, 5, 10])


@dataclass(frozen=True)
class Frames:
    """The mechanism at some drive angles, its deflection magnified.

    Parameters
    ----------
    theta
        Drive angles (rad), shape ``(frames,)``.
    rigid
        Ends of the members at rest (m), ``(frames, members, 2, 2)``.
    path
        Deformed centre lines (m), ``(frames, members, stations, 2)``.
    strain
        Of the "+" fibre (micrometres per metre), ``(frames, members, stations)``.
    pins
        Deformed positions of the joints (m), ``(frames, joints, 2)``.
    bars
        Sides of the rigid links (m), ``(frames, sides, 2, 2)``.
    sliders
        Corners of the blocks in their guides about the pin, of half width and height 1, ``(frames, sliders, 4, 2)``.
    slider_pins
        Positions of these pins (m), ``(frames, sliders, 2)``.
    """

    theta: Array
    rigid: Array
    path: Array
    strain: Array
    pins: Array
    bars: Array
    sliders: Array
    slider_pins: Array


def frames_at(result: Result, theta: Array, magnify: float) -> Frames:
    """Interpolate a result at drive angles (rad) and magnify its deflection."""
    scene, data, given = result.scene, result.data, result.data["theta"].to_numpy()
    deflection = at_angles(given, data["deflection"].transpose("theta", "member", "s", "component").to_numpy(), theta)
    strain = at_angles(given, data["strain"].sel(fibre="+").transpose("theta", "member", "s").to_numpy(), theta)
    ends, s = member_ends(scene, theta), data["s"].to_numpy()[:, None]
    path = (1 - s) * ends[:, :, None, 0] + s * ends[:, :, None, 1] + magnify * deflection
    motion = solve_motion(scene, theta)
    pins = pin_places(scene, motion, path)
    where, angle = slider_angles(scene, motion)
    return Frames(
        theta=theta,
        rigid=ends,
        path=path,
        strain=MICRO * strain,
        pins=pins,
        bars=rigid_bars(scene, motion, pins),
        sliders=turned(BLOCK_CORNERS, angle),
        slider_pins=pins[:, where],
    )


def cycle(result: Result, count: int) -> Array:
    """Drive angles (rad) of `count` frames over one turn, in the order of time."""
    if not result.scene.drives:
        return np.zeros(count)
    return result.scene.drive_angles(count)


def default_magnification(result: Result) -> float:
    """Round factor that draws the largest deflection at `DEFLECTED` of the linkage's size; 1 where nothing bends."""
    largest = float(np.linalg.norm(result.data["deflection"].transpose(..., "component"), axis=-1).max())
    if largest == 0:
        return 1.0
    points = ends_of(result).reshape(-1, 2)
    wanted = DEFLECTED * float(np.linalg.norm(np.ptp(points, axis=0))) / largest
    decade = 10.0 ** np.floor(np.log10(wanted))
    return float(decade * ROUND[np.abs(np.log(ROUND * decade / wanted)).argmin()])


def strain_limit(result: Result) -> tuple[float, bool]:
    """Round number (micrometres per metre) for the ends of the colour bar, and whether some strains exceed it.

    `COVERED` of the "+" fibre's strains lie within it, so that one short peak does not leave the rest colourless.
    """
    strain = MICRO * np.abs(result.data["strain"].sel(fibre="+").to_numpy())
    largest = float(np.quantile(strain, COVERED)) or float(strain.max())
    if largest == 0:
        return 1.0, False
    decade = 10.0 ** np.floor(np.log10(largest))
    limit = float(decade * next(step for step in (1, 2, 3, 4, 5, 6, 8, 10) if step * decade >= largest))
    return limit, bool(strain.max() > limit)


def angle_of_peak(result: Result) -> float:
    """Drive angle (rad) of the largest strain of the "+" fibre."""
    strain = np.abs(result.data["strain"].sel(fibre="+").transpose("theta", "member", "s").to_numpy())
    return float(result.data["theta"][strain.max(axis=(1, 2)).argmax()])
