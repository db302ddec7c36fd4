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
    peak
        Where the member is that has the largest strain of the whole motion, at its place (m), ``(frames, 2)``.
    peak_strain
        That strain, with its sign (micrometres per metre).
    """

    theta: Array
    rigid: Array
    path: Array
    strain: Array
    pins: Array
    bars: Array
    sliders: Array
    slider_pins: Array
    peak: Array
    peak_strain: float


def frames_at(result: Result, theta: Array, magnify: float) -> Frames:
    """Interpolate a result at drive angles (rad) and magnify its deflection."""
    scene, data, given = result.scene, result.data, result.data["theta"].to_numpy()
    deflection = at_angles(given, data["deflection"].transpose("theta", "member", "s", "component").to_numpy(), theta)
    strain, most = at_angles(given, of_fibre(result), theta), peak_of(result)
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
        peak=path[:, most[1], most[2]],
        peak_strain=float(MICRO * of_fibre(result)[most]),
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


def of_fibre(result: Result) -> Array:
    """Strain of the "+" fibre, ``(angles, members, stations)``."""
    return result.data["strain"].sel(fibre="+").transpose("theta", "member", "s").to_numpy()


def peak_of(result: Result) -> tuple[int, ...]:
    """Give the numbers of the angle, member and station of the largest strain of the "+" fibre."""
    strain = np.abs(of_fibre(result))
    return tuple(int(i) for i in np.unravel_index(strain.argmax(), strain.shape))


def strain_limit(result: Result) -> float:
    """Round number (micrometres per metre) for the ends of the colour bar, which no strain of the motion exceeds."""
    largest = MICRO * float(np.abs(of_fibre(result)).max())
    if largest == 0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(largest))
    return float(decade * next(step for step in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if step * decade >= largest))


def angle_of_peak(result: Result) -> float:
    """Drive angle (rad) of the largest strain of the "+" fibre."""
    return float(result.data["theta"][peak_of(result)[0]])
