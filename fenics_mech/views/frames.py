"""What each picture of an animation shows, as arrays."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, turned
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.recovery.rigid_places import between_ends, ends_in
from fenics_mech.views.drawn_parts import (
    BLOCK_CORNERS,
    Moments,
    ends_of,
    load_arrows,
    mass_places,
    moving_guides,
    pin_places,
    point_places,
    rigid_bars,
    slider_angles,
    trails,
)
from fenics_mech.views.reading import Peak, reading_of, reading_of_members

DEFLECTED = 0.08  # of the linkage's size, for the largest deflection as drawn
ROUND = np.array([1, 2, 2.5, 5, 10])


@dataclass(frozen=True)
class Frames:
    """The mechanism at some instants, its deflection magnified."""

    labels: tuple[str, ...]  # drive angle or time of each, in words
    rigid: Array  # ends of the members at rest (m), ``(frames, members, 2, 2)``
    path: Array  # deformed centre lines (m), ``(frames, members, stations, 2)``
    half_width: Array  # half of the sections' sizes in the plane of motion (m), ``(members, stations)``
    # stress or strain of the "+" and the "-" side in the unit of the answer, ``(frames, members, stations, 2)``
    sides: Array
    pins: Array  # deformed positions of the joints (m), ``(frames, joints, 2)``
    bars: Array  # sides of the rigid links (m), ``(frames, sides, 2, 2)``
    # corners of the blocks in their guides about the pin, of half width and height 1, ``(frames, sliders, 4, 2)``
    sliders: Array
    slider_pins: Array  # positions of these pins (m), ``(frames, sliders, 2)``
    guides: Array  # guides on links that move (m), ``(frames, guides, 2, 2)``
    # traced, masses: positions of the points that the scene traces and of its point masses (m), ``(frames, points, 2)``
    traced: Array
    masses: Array
    mass_sizes: Array  # square roots of the masses, over that of the largest, ``(masses,)``
    loads: Array  # where loads act (m), and their forces over the largest of their kind, ``(frames, arrows, 2, 2)``
    # paths of the joints that move, and then of the traced points, not magnified (m), ``(paths, instants, 2)``
    trails: Array
    peak: Array  # where the place is that a run names as that of the peak (m), ``(frames, 2)``
    peak_value: float  # the stress or strain of that peak, with its sign; not a number where no link bends


def frames_at(result: Result, at: Array, magnify: float, quantity: str = "stress") -> Frames:
    """Interpolate a result at drive angles (rad), or times (s) of a motion in time, and magnify its deflection."""
    scene, shown = result.scene, Moments(result, at)
    motion = shown.motion
    ends, path = _lines(result, shown, magnify)
    half, sides = np.zeros((0, 2)), np.zeros((*path.shape[:3], 2))
    if scene.members():
        rigidities = scene.rigidities(result.data["s"].to_numpy())
        half = np.array([np.abs(np.diff(here.fibre, axis=-1)[:, 0]) / 2 for here in rigidities])
        values = result.data[quantity].sel(fibre=["+", "-"]).transpose("theta", "member", "s", "fibre").to_numpy()
        sides = shown.of(values) / reading_of(result).units.size(quantity)
    pins = pin_places(scene, motion, path)
    where, angle = slider_angles(scene, motion)
    most = peak_of(result, quantity)
    masses, sizes = mass_places(shown, magnify)
    return Frames(
        labels=shown.labels,
        rigid=ends,
        path=path,
        half_width=half,
        sides=sides,
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
        peak=np.full((len(at), 2), np.nan) if most is None else path[:, most.place.i, most.place.j],
        peak_value=np.nan if most is None else most.value,
    )


def _lines(result: Result, shown: Moments, magnify: float) -> tuple[Array, Array]:
    """Ends of the members at rest, and their bent lines, as `Frames` has them."""
    data = result.data
    ends = ends_in(result.scene, shown.motion)
    if "deflection" not in data:
        return ends, np.zeros((len(ends), 0, 2, 2))
    bent = data["deflection"].transpose("theta", "member", "s", "component").to_numpy()
    return ends, between_ends(ends, data["s"].to_numpy()) + magnify * shown.of(bent)


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


@dataclass(frozen=True)
class ShownPeak:
    """The peak of a result, as a run names it."""

    place: Peak  # its position, member, station and side
    value: float  # stress or strain there, in the unit of the answer
    limit: float  # round number for the ends of a colour bar, which no stress or strain of the motion exceeds
    words: str  # member, place, side and drive angle


def peak_of(result: Result, quantity: str = "stress") -> ShownPeak | None:
    """Find the peak stress of a result, or the largest strain at the peaks of its members; None where no link bends."""
    if not result.scene.members():
        return None
    reading = reading_of_members(result)
    curves = reading.stress if quantity == "stress" else reading.strain
    values = [float(curves[peak]) for peak in reading.peaks]
    i = int(np.abs(values).argmax())
    peak = reading.peaks[i]
    words = f"in {reading.members[i]}, {reading.place(peak)}, {reading.side(peak)}, at {reading.at(peak.k)}"
    return ShownPeak(peak, values[i], _rounded_up(float(np.abs(curves).max())), words)


def _rounded_up(largest: float) -> float:
    """Round number that is not below another."""
    if largest == 0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(largest))
    return float(decade * next(step for step in (1, 1.2, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10) if step * decade >= largest))


def moment_of_peak(result: Result, quantity: str = "stress") -> float:
    """Drive angle (rad) or time (s) of the peak, or of the largest joint force where no link bends."""
    name = "time" if result.scene.analysis.method == "transient" else "theta"
    if (peak := peak_of(result, quantity)) is not None:
        return float(between_positions(result).data[name][peak.place.k])
    force = result.data["joint_force"].transpose("theta", "joint", "component").to_numpy()
    return float(result.data[name][int(np.linalg.norm(force, axis=-1).max(axis=1, initial=0.0).argmax())])
