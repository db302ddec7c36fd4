"""Points that move with the mechanism, as an animation shows them: traced points, masses, loads, and their trails."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from fenics_mech._arrays import Array, turned
from fenics_mech.kinematics import Motion
from fenics_mech.kinematics.load_factors import factor_in
from fenics_mech.recovery import Result
from fenics_mech.recovery.link_motion import place_in_link
from fenics_mech.recovery.result import at_place
from fenics_mech.scene import LineLoad, Load, Prismatic, Scene, Slot
from fenics_mech.views.geometry import Moments
from fenics_mech.views.symbols import ARROWS

MOST_INSTANTS = 360  # of a trail
STILL = 1e-6  # of the largest path, below which a joint does not move


def point_places(shown: Moments, points: list[str], magnify: float) -> Array:
    """Positions of points with the deflection magnified (m), ``(frames, points, 2)``."""
    scene, motion = shown.result.scene, shown.motion
    places = [motion.of_point(*_in_link(scene, point))[0] for point in points]
    rigid = np.stack(places, axis=1) if places else np.zeros((len(shown.at), 0, 2))
    return rigid + magnify * shown.of(places_of(shown.result, points, 1.0) - places_of(shown.result, points, 0.0))


def _in_link(scene: Scene, point: str) -> tuple[str, tuple[float, float]]:
    """Link of a point, or of one that the scene traces, and its place in the link's frame (m)."""
    return place_in_link(scene, scene.points[point]) if point in scene.points else scene.point(point)


def places_of(result: Result, points: list[str], magnify: float) -> Array:
    """Positions of points at those of the result (m), ``(positions, points, 2)``."""
    data = result.data
    if not points:
        return np.zeros((data.sizes["theta"], 0, 2))
    names = ["point_position"] + ["point_position_bent"] * ("point_position_bent" in data)
    rigid, *bent = (data[name].sel(point=points).transpose("theta", "point", "component").to_numpy() for name in names)
    return np.asarray(rigid + magnify * (bent[0] - rigid) if bent else rigid)


def mass_places(shown: Moments, magnify: float) -> tuple[Array, Array]:
    """Positions of the point masses (m), ``(frames, masses, 2)``, and the roots of their shares of the largest."""
    masses = shown.result.scene.masses.values()
    sizes = np.sqrt([mass.mass for mass in masses])
    return point_places(shown, [mass.at for mass in masses], magnify), sizes / sizes.max(initial=1e-300)


def load_arrows(shown: Moments, motion: Motion, lines: tuple[Array, Array], magnify: float) -> Array:
    """Where forces act (m), and the forces over the largest of their kind, ``(frames, arrows, 2, 2)``."""
    # A load along a member is some arrows beside each other. Its kind is force per length.
    scene = shown.result.scene
    at_points = [load for load in scene.loads.values() if isinstance(load, Load) and any(load.force)]
    along = [load for load in scene.loads.values() if isinstance(load, LineLoad)]
    arrows = [
        *_largest_is_one([_at_a_place(load, shown, motion, (lines[1], magnify)) for load in at_points], at_points),
        *_largest_is_one([_along_a_member(load, shown, motion, lines) for load in along], along),
    ]
    return np.concatenate([np.zeros((len(shown.at), 0, 2, 2)), *arrows], axis=1)


def load_names(scene: Scene) -> tuple[str, ...]:
    """Names of the loads in the order of `load_arrows`, one for each arrow: none but at the middle one of a line."""
    at_points = [name for name, load in scene.loads.items() if isinstance(load, Load) and any(load.force)]
    along = [name for name, load in scene.loads.items() if isinstance(load, LineLoad)]
    middle = ARROWS // 2
    return (*at_points, *(name if i == middle else "" for name in along for i in range(ARROWS)))


def _largest_is_one(arrows: list[Array], loads: Sequence[Load | LineLoad]) -> list[Array]:
    """Divide the forces of arrows, ``(frames, arrows, 2, 2)`` of each load, by the largest over the whole cycle."""
    ends = [load.force if isinstance(load, Load) else load.ends for load in loads]
    sizes = [float(np.linalg.norm(one, axis=-1).max()) for one in ends]
    largest = max((max(map(abs, load.factor_range)) * size for load, size in zip(loads, sizes)), default=0)
    scale = np.array([1.0, 1 / max(largest, 1e-300)])
    return [one * scale[:, None] for one in arrows]


def _at_a_place(load: Load, shown: Moments, motion: Motion, drawn: tuple[Array, float]) -> Array:
    """Place (m) and force (N) of a load at a point or at a place along a member, ``(frames, 1, 2, 2)``."""
    # `drawn` has the bent lines of the members and the factor on the deflection.
    scene, path = shown.result.scene, drawn[0]
    if "@" in load.at:
        label, s = load.at.split("@")
        place, link = _on_line(shown, path, label, np.array([float(s)])), scene.place(load.at)[0]
    else:
        point = _point_of(scene, load.at)
        place, link = point_places(shown, [point], drawn[1]), point.split(".")[0]
    angle = motion.angle[:, motion.links.index(link)] if load.follows else np.zeros(len(shown.at))
    force = factor_in(shown.result.scene, load, motion)[:, None] * turned(np.array(load.force), angle)
    return np.stack([place, force[:, None]], axis=2)


def _along_a_member(load: LineLoad, shown: Moments, motion: Motion, lines: tuple[Array, Array]) -> Array:
    """Places (m) and forces per length (N/m) of a load along a member, ``(frames, ARROWS, 2, 2)``."""
    ends, path = lines
    s = np.linspace(0, 1, ARROWS)
    chord = np.diff(ends[:, [*shown.result.scene.members()].index(load.member)], axis=1)[:, 0]
    angle = np.arctan2(chord[:, 1], chord[:, 0]) if load.axes == "member" else np.zeros(len(shown.at))
    force = turned((1 - s[:, None]) * load.ends[0] + s[:, None] * load.ends[1], angle[:, None])
    force *= factor_in(shown.result.scene, load, motion)[:, None, None]
    return np.stack([_on_line(shown, path, load.member, s), force], axis=2)


def _on_line(shown: Moments, path: Array, member: str, s: Array) -> Array:
    """Places (m) along the bent line of a member, ``(frames, places, 2)``."""
    line = np.moveaxis(path[:, [*shown.result.scene.members()].index(member)], 1, -1)
    stations = shown.result.data["s"].to_numpy()
    return np.moveaxis(at_place(line, stations, s), -1, 1)


def moving_guides(result: Result, motion: Motion, place: Callable[[list[str]], Array]) -> Array:
    """Guides on links that move (m), as far as their pins travel, ``(frames, guides, 2, 2)``."""
    # A guide along a member is not among them: it is drawn as the member.
    # place: gives the positions of points there (m), ``(frames, points, 2)``
    scene, lines = result.scene, []
    for name, joint in scene.joints.items():
        if not isinstance(joint, Slot | Prismatic) or joint.connect[0].startswith("ground."):
            continue
        if joint.member or "slide_place" not in result.data:
            continue
        angle = motion.angle[:, motion.links.index(joint.connect[0].split(".")[0])] + scene.guide_angle(joint)
        travel = result.data["slide_place"].sel(slide=name).to_numpy()
        along = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        ends = [min(travel.min(), 0.0), max(travel.max(), 0.0)]
        lines.append(place([joint.connect[0]]) + np.stack([end * along for end in ends], axis=1))
    return np.stack(lines, axis=1) if lines else np.zeros((len(motion.theta), 0, 2, 2))


def _point_of(scene: Scene, at: str) -> str:
    """Name of a point of a link: that itself, or one of a joint."""
    if at not in scene.joints:
        return at
    return next(point for point in scene.joints[at].connect if not point.startswith("ground."))


def trails(result: Result) -> Array:
    """Paths of the joints that move, and then of the traced points (m), ``(paths, instants, 2)``; none is magnified."""
    scene, count = result.scene, result.data.sizes["theta"]
    if count == 1:
        return np.zeros((0, 1, 2))
    held = [_point_of(scene, name) for name in scene.joints]
    joints = np.moveaxis(places_of(result, held, 1.0), 1, 0)
    moves = np.ptp(joints, axis=1).max(axis=1, initial=0.0)
    paths = [
        *joints[moves > STILL * moves.max(initial=0.0)],
        *np.moveaxis(places_of(result, [*scene.points], 1.0), 1, 0),
    ]
    if not paths:
        return np.zeros((0, 1, 2))
    whole = np.array(paths)[:, :: max(1, count // MOST_INSTANTS)]
    closed = scene.analysis.method != "transient"
    return np.concatenate([whole, whole[:, :1]], axis=1) if closed else whole
