"""What each picture of an animation shows, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, turned
from fenics_mech.recovery import Result
from fenics_mech.recovery.rigid_places import between_ends, ends_in
from fenics_mech.views.geometry import ends_of
from fenics_mech.views.joint_drawings import pin_places, rigid_bars, slider_angles
from fenics_mech.views.moments import Moments
from fenics_mech.views.moving_points import load_arrows, mass_places, moving_guides, point_places, trails
from fenics_mech.views.symbols import BLOCK_CORNERS

DEFLECTED = 0.08  # of the linkage's size, for the largest deflection as drawn
ROUND = np.array([1, 2, 2.5, 5, 10])


@dataclass(frozen=True)
class Frames:
    """The mechanism at some instants, its deflection magnified.

    Parameters
    ----------
    labels
        Drive angle or time of each, in words.
    rigid
        Ends of the members at rest (m), ``(frames, members, 2, 2)``.
    path
        Deformed centre lines (m), ``(frames, members, stations, 2)``.
    half_width
        Half of the sections' sizes in the plane of motion (m), ``(members, stations)``.
    strain
        Of the "+" fibre, in the unit of the answer, ``(frames, members, stations)``.
    pins
        Deformed positions of the joints (m), ``(frames, joints, 2)``.
    bars
        Sides of the rigid links (m), ``(frames, sides, 2, 2)``.
    sliders
        Corners of the blocks in their guides about the pin, of half width and height 1, ``(frames, sliders, 4, 2)``.
    slider_pins
        Positions of these pins (m), ``(frames, sliders, 2)``.
    guides
        Guides on links that move (m), ``(frames, guides, 2, 2)``.
    traced, masses
        Positions of the points that the scene traces and of its point masses (m), ``(frames, points, 2)``.
    mass_sizes
        Square roots of the masses, over that of the largest, ``(masses,)``.
    loads
        Where loads act (m), and their forces over the largest of their kind, ``(frames, arrows, 2, 2)``.
    trails
        Paths of the joints that move, and then of the traced points, not magnified (m), ``(paths, instants, 2)``.
    peak
        Where the member is that has the largest strain of the whole motion, at its place (m), ``(frames, 2)``.
    peak_strain
        That strain, with its sign; not a number where no link bends.
    """

    labels: tuple[str, ...]
    rigid: Array
    path: Array
    half_width: Array
    strain: Array
    pins: Array
    bars: Array
    sliders: Array
    slider_pins: Array
    guides: Array
    traced: Array
    masses: Array
    mass_sizes: Array
    loads: Array
    trails: Array
    peak: Array
    peak_strain: float


def frames_at(result: Result, at: Array, magnify: float) -> Frames:
    """Interpolate a result at drive angles (rad), or times (s) of a motion in time, and magnify its deflection."""
    scene, shown = result.scene, Moments(result, at)
    motion = shown.motion
    ends, path = _lines(result, shown, magnify)
    pins = pin_places(scene, motion, path)
    where, angle = slider_angles(scene, motion)
    bends = bool(scene.members())
    most = peak_of(result) if bends else None
    masses, sizes = mass_places(shown, magnify)
    return Frames(
        labels=shown.labels,
        rigid=ends,
        path=path,
        half_width=_half_widths(result),
        strain=shown.of(of_fibre(result)) / scene.answer_units.size("strain") if bends else np.zeros(path.shape[:3]),
        pins=pins,
        bars=rigid_bars(scene, motion, pins),
        sliders=turned(BLOCK_CORNERS, angle[..., None]),
        slider_pins=pins[:, where],
        guides=moving_guides(result, motion, lambda points: point_places(shown, points, magnify)),
        traced=point_places(shown, list(scene.points), magnify),
        masses=masses,
        mass_sizes=sizes,
        loads=load_arrows(shown, motion, (ends, path), magnify),
        trails=trails(result),
        peak=np.full((len(at), 2), np.nan) if most is None else path[:, most[1], most[2]],
        peak_strain=np.nan if most is None else float(of_fibre(result)[most]) / scene.answer_units.size("strain"),
    )


def _lines(result: Result, shown: Moments, magnify: float) -> tuple[Array, Array]:
    """Ends of the members at rest, and their bent lines, as `Frames` has them."""
    data = result.data
    ends = ends_in(result.scene, shown.motion)
    if "deflection" not in data:
        return ends, np.zeros((len(ends), 0, 2, 2))
    bent = data["deflection"].transpose("theta", "member", "s", "component").to_numpy()
    return ends, between_ends(ends, data["s"].to_numpy()) + magnify * shown.of(bent)


def _half_widths(result: Result) -> Array:
    """Half of the distance of the outer fibres (m), ``(members, stations)``."""
    if not result.scene.members():
        return np.zeros((0, 2))
    found = [
        np.abs(np.diff(here.fibre, axis=-1)[:, 0]) / 2 for here in result.scene.rigidities(result.data["s"].to_numpy())
    ]
    return np.array(found)


def cycle(result: Result, count: int) -> Array:
    """Drive angles (rad) of `count` frames over one turn in the order of time, or times (s) of a motion in time."""
    if result.scene.analysis.method == "transient":
        time = result.data["time"].to_numpy()
        return np.linspace(time[0], time[-1], count)
    if result.data.sizes["theta"] == 1:
        return np.full(count, float(result.data["theta"][0]))
    return result.scene.drive_angles(count)


def default_magnification(result: Result) -> float:
    """Round factor that draws the largest deflection at `DEFLECTED` of the linkage's size; 1 where nothing bends."""
    if "deflection" not in result.data:
        return 1.0
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
    """Round number, in the unit of the answer, for the ends of the colour bar: no strain of the motion exceeds it."""
    largest = float(np.abs(of_fibre(result)).max()) if result.scene.members() else 0.0
    largest /= result.scene.answer_units.size("strain")
    if largest == 0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(largest))
    return float(decade * next(step for step in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if step * decade >= largest))


def moment_of_peak(result: Result) -> float:
    """Drive angle (rad) or time (s) of the largest strain of the "+" fibre, or joint force where no link bends."""
    if result.scene.members():
        k = peak_of(result)[0]
    else:
        force = result.data["joint_force"].transpose("theta", "joint", "component").to_numpy()
        k = int(np.linalg.norm(force, axis=-1).max(axis=1, initial=0.0).argmax())
    return float(result.data["time" if result.scene.analysis.method == "transient" else "theta"][k])
