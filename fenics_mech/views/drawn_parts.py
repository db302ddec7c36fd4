"""Parts of a drawn mechanism: symbols, where members, pins and guides are at any instant, and what moves with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from fenics_mech._arrays import Array, turned
from fenics_mech._constants import TURN
from fenics_mech.errors import ResultError
from fenics_mech.kinematics import Motion
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.machine.load_factors import factor_in
from fenics_mech.recovery import Result
from fenics_mech.recovery.link_motion import place_in_link
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.rigid_places import ends_in
from fenics_mech.scene import LineLoad, Load, Prismatic, Scene, Slot
from fenics_mech.scene.joints import Joint
from fenics_mech.views.words import in_degrees, short

INK, SHADE, RIGID = "#222222", "#d9d9d9", "#a0a0a0"
OVERHANG = 0.15  # of a slider's travel, by which its guide is drawn longer
MOST_INSTANTS = 360  # of a trail
STILL = 1e-6  # of the largest path, below which a joint does not move


def ends_of(result: Result) -> Array:
    """Give the members' two ends in the rigid linkage (m), ``(angles, members, 2, 2)``, as the result holds them."""
    if "position" not in result.data:
        raise ResultError("the result has no positions: an older version wrote it. Analyse its scene again")
    return result.data["position"].transpose("theta", "member", "end", "component").to_numpy()


def motion_of(result: Result) -> Motion:
    """Give the rigid positions of a result's links, at rest."""
    data = result.data
    position = data["link_position"].transpose("theta", "link", "component").to_numpy()
    angle = data["link_angle"].transpose("theta", "link").to_numpy()
    still, links = np.zeros_like(position), tuple(str(name) for name in data["link"].to_numpy())
    theta, time = data["theta"].to_numpy(), data["time"].to_numpy()
    return Motion(theta, time, links, position, still, still, angle, still[..., 0], still[..., 0])


def member_ends(scene: Scene, theta: Array) -> Array:
    """Rigid-body positions of the members' two ends (m), ``(angles, members, 2, 2)`` with x, y last."""
    # theta: drive angles (rad), shape ``(angles,)``
    return ends_in(scene, solve_motion(scene, theta))


def one_turn(theta: Array, values: Array) -> tuple[Array, Array]:
    """Sort a periodic history by the drive angle in [0, 2 pi), with one more point before and one after it."""
    # theta: drive angles (rad) in any order and any turn, shape ``(angles,)``; values: shape ``(angles, ...)``
    angle = np.mod(np.round(theta, 12), TURN)
    order = np.argsort(angle, kind="stable")
    angle, values = angle[order], values[order]
    around = np.concatenate([angle[-1:] - TURN, angle, angle[:1] + TURN])
    return around, np.concatenate([values[-1:], values, values[:1]])


def at_angles(theta: Array, values: Array, wanted: Array) -> Array:
    """Interpolate a periodic history linearly at the angles `wanted` (rad), ``(wanted, ...)``."""
    return interpolated(*one_turn(theta, values), np.mod(np.round(wanted, 12), TURN))


def interpolated(knots: Array, values: Array, at: Array) -> Array:
    """Interpolate values ``(knots, ...)`` at ascending knots linearly, which may coincide, ``(at, ...)``."""
    before = np.clip(np.searchsorted(knots, at, side="right") - 1, 0, max(len(knots) - 2, 0))
    after = np.minimum(before + 1, len(knots) - 1)
    span = knots[after] - knots[before]
    share = np.divide(at - knots[before], span, out=np.zeros(len(at)), where=span > 0)
    share = share.reshape(-1, *[1] * (values.ndim - 1))
    return np.asarray((1 - share) * values[before] + share * values[after])


@dataclass(frozen=True)
class Moments:
    """Instants of a result."""

    result: Result  # the result
    at: Array  # drive angles (rad), or times (s) of a motion in time

    @property
    def in_time(self) -> bool:
        """Whether the instants are times."""
        return self.result.scene.analysis.method == "transient"

    @property
    def labels(self) -> tuple[str, ...]:
        """Each instant in words."""
        if self.in_time:
            return tuple(f"time {short(float(time))} s" for time in self.at)
        return tuple(f"drive angle {in_degrees(float(angle))}" for angle in self.at)

    def of(self, values: Array) -> Array:
        """Interpolate values at the positions of the result, ``(positions, ...)``, linearly."""
        if not self.in_time:
            return at_angles(self.result.data["theta"].to_numpy(), values, self.at)
        return interpolated(self.result.data["time"].to_numpy(), values, self.at)

    @cached_property
    def motion(self) -> Motion:
        """Give the rigid positions of the links there."""
        if not self.in_time:
            return solve_motion(self.result.scene, self.at)
        given = motion_of(self.result)
        place, angle = self.of(given.position), self.of(given.angle)
        still, held = np.zeros_like(place), np.zeros_like(angle)
        return Motion(self.of(given.theta), self.at, given.links, place, still, still, angle, held, held)


@dataclass(frozen=True)
class Proportions:
    """Half widths and radii over the extent of the motion, and margins of the picture."""

    ribbon: float = 0.008
    outline: float = 0.0102
    pin: float = 0.013
    hole: float = 0.008
    peak: float = 0.026
    traced: float = 0.009
    mass: float = 0.02  # of the largest point mass
    load: float = 0.14  # length of the arrow of the largest load
    head: float = 0.035  # of it, the length of its head
    name: float = 0.018  # from a pin to its name, in both directions
    support: float = 0.045
    block: float = 0.018
    margin: float = 0.06  # around the motion
    bar: float = 0.17  # of the picture's width, kept free for the colour bar
    text: float = 0.1  # of its height, kept free for text above and below


DRAWN = Proportions()


TRIANGLE = np.array([[0, 0], [-0.6, -1], [0.6, -1]])  # of a support, below its point; of height 1


BLOCK_CORNERS = np.array([[-1.6, -1.0], [1.6, -1.0], [1.6, 1.0], [-1.6, 1.0]])  # of a slider's block


ARROWS = 7  # of a load along a member


COILS = 5  # of a spring


def support_strokes() -> Array:
    """Give the line under a support's triangle, and its hatch, ``(strokes, 2, 2)``."""
    left = np.linspace(-0.9, 0.7, 6)
    hatch = np.stack([np.stack([left, left * 0 - 1.35], -1), np.stack([left + 0.3, left * 0 - 1], -1)], axis=1)
    return np.concatenate([[[[-0.95, -1], [0.95, -1]]], hatch])


def guide_strokes(guide: Array, extent: float) -> Array:
    """Give the line under a slider's block, and its hatch, ``(strokes, 2, 2)``."""
    # guide: both ends of the slider's travel (m), ``(2, 2)``; extent: of the motion (m)
    first, second = guide
    along = (second - first) / max(float(np.linalg.norm(second - first)), 1e-300)
    normal = np.array([-along[1], along[0]])
    below = DRAWN.block * extent * normal
    count = max(int(np.linalg.norm(second - first) / (0.32 * DRAWN.support * extent)), 2)
    tops = np.linspace(first - below, second - below, count)
    feet = tops - 0.35 * DRAWN.support * extent * (normal + 0.85 * along)
    return np.concatenate([[[tops[0], tops[-1]]], np.stack([feet, tops], axis=1)])


def coil(ends: Array, half_width: float) -> Array:
    """Give the zigzag of a spring between two points, ``(points, 2)``."""
    # ends: the points (m), ``(2, 2)``; half_width: of the zigzag (m)
    places = np.concatenate([[0, 0.2], 0.2 + 0.6 * (np.arange(2 * COILS) + 0.5) / (2 * COILS), [0.8, 1]])
    sides = np.concatenate([[0, 0], (-1.0) ** np.arange(2 * COILS), [0, 0]])
    return _beside(ends, places, half_width * sides)


def dashpot(ends: Array, half_width: float) -> list[Array]:
    """Give the strokes of a damper between two points: rod with piston, cylinder, and what holds it."""
    strokes = [
        ([0, 0.52], [0, 0]),
        ([0.52, 0.52], [-0.8, 0.8]),
        ([0.4, 0.62, 0.62, 0.4], [-1, -1, 1, 1]),
        ([0.62, 1], [0, 0]),
    ]
    return [_beside(ends, np.array(places), half_width * np.array(sides)) for places, sides in strokes]


def arc(centre: Array, radius: float, start: float, end: float) -> Array:
    """Give an arc of a circle, ``(points, 2)``."""
    # centre: its centre (m); radius: its radius (m); start, end: angles (rad); the arc runs from the one to the other
    turn = np.linspace(start, end, 40)
    return centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)


def _beside(ends: Array, places: Array, across: Array) -> Array:
    """Points at shares of the line between two points, and at distances across it, ``(points, 2)``."""
    line = ends[1] - ends[0]
    normal = np.array([-line[1], line[0]]) / max(float(np.linalg.norm(line)), 1e-300)
    return np.asarray(ends[0] + places[:, None] * line + across[:, None] * normal)


def pin_places(scene: Scene, motion: Motion, path: Array) -> Array:
    """Positions of the joints (m), ``(angles, joints, 2)``: on the drawn members where one ends in the joint."""
    # path: centre lines of the members as drawn (m), ``(angles, members, stations, 2)``
    ends = {
        f"{link}.{point}": (index, station)
        for index, (link, member) in enumerate(scene.members().values())
        for end, station in zip(member.ends, (0, -1))
        for point in scene.links[link].points
        if scene.links[link].end_at(point) == end
    }
    places: list[Array] = []
    moved: dict[str, Array] = {}  # by deflection, of links' pins
    for joint in scene.joints.values():
        points = _held(joint)
        drawn = [path[:, *ends[point]] for point in points if point in ends]
        places.append(drawn[0] if drawn else motion.of_point(*scene.point(points[0]))[0])
        if drawn:
            moved |= {point.split(".")[0]: drawn[0] - motion.of_point(*scene.point(point))[0] for point in points}
    for i, joint in enumerate(scene.joints.values()):
        if isinstance(joint, Prismatic) and joint.connect[1] not in ends:  # a rigid block goes where its pin goes
            places[i] = places[i] + moved.get(joint.connect[1].split(".")[0], 0.0)
    return np.stack(places, axis=1) if places else np.zeros((len(motion.theta), 0, 2))


def rigid_bars(scene: Scene, motion: Motion, pins: Array) -> Array:
    """Sides of the rigid links' polygons (m), ``(angles, sides, 2, 2)``, that meet the `pins` as drawn."""
    joint_of = {point: i for i, joint in enumerate(scene.joints.values()) for point in _held(joint)}
    sides = []
    for link, body in scene.links.items():
        if body.rigid is None:
            continue
        corners = [
            pins[:, joint_of[name]] if (name := f"{link}.{point}") in joint_of else motion.of_point(link, place)[0]
            for point, place in body.points.items()
        ]
        around = [*corners, corners[0]] if len(corners) > 2 else corners
        sides += [np.stack(side, axis=1) for side in pairwise(around)]
    return np.stack(sides, axis=1) if sides else np.zeros((len(motion.theta), 0, 2, 2))


def slider_angles(scene: Scene, motion: Motion) -> tuple[list[int], Array]:
    """Indices of the joints with a guide, and the directions of the guides (rad), ``(angles, guides)``."""
    found, angles = [], [np.zeros((len(motion.theta), 0))]
    for i, joint in enumerate(scene.joints.values()):
        if isinstance(joint, Slot | Prismatic):
            body = joint.connect[0].split(".")[0]
            turned = 0.0 if body == "ground" else motion.angle[:, motion.links.index(body)]
            found.append(i)
            angles.append(np.broadcast_to(turned + scene.guide_angle(joint), len(motion.theta))[:, None])
    return found, np.concatenate(angles, axis=1)


def ground_points(scene: Scene) -> Array:
    """Points of the ground that pins go through (m), ``(points, 2)``."""
    points = [point for joint in scene.joints.values() for point in _held(joint) if point.startswith("ground.")]
    return np.array([scene.point(point)[1] for point in points]).reshape(-1, 2)


def guides_of(scene: Scene, motion: Motion, least: float = 0.0) -> Array:
    """Guides on the ground (m), from one end of their slider's travel to the other, ``(guides, 2, 2)``."""
    # least: how far they reach beyond the travel at least (m)
    guides = []
    for joint in scene.joints.values():
        if isinstance(joint, Slot | Prismatic) and joint.connect[0].startswith("ground."):
            along = np.array([np.cos(joint.angle), np.sin(joint.angle)])
            start = np.array(scene.point(joint.connect[0])[1])
            travel: Array = (motion.of_point(*scene.point(joint.connect[1]))[0] - start) @ along
            more = max(OVERHANG * np.ptp(travel), least)
            guides.append([start + (travel.min() - more) * along, start + (travel.max() + more) * along])
    return np.array(guides, dtype=float).reshape(-1, 2, 2)


def _held(joint: Joint) -> tuple[str, ...]:
    """Points that a joint's pin goes through."""
    return joint.connect[1:] if isinstance(joint, Slot | Prismatic) else joint.connect


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
