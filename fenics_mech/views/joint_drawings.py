"""Where pins, sliders, guides and rigid links are, for drawing."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.joints import Joint

OVERHANG = 0.15  # of a slider's travel, by which its guide is drawn longer


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
