"""Points that move with the mechanism, as an animation shows them: traced points, masses, loads, and their trails."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fenics_mech._arrays import Array, turned
from fenics_mech.kinematics import Motion
from fenics_mech.recovery import Result
from fenics_mech.recovery.link_motion import place_in_link
from fenics_mech.scene import Load, Prismatic, Scene, Slot
from fenics_mech.views.moments import Moments

MOST_INSTANTS = 360  # of a trail
STILL = 1e-6  # of the largest path, below which a joint does not move


def point_places(shown: Moments, points: list[str], magnify: float) -> Array:
    """Positions of points with the deflection magnified (m), ``(frames, points, 2)``.

    Parameters
    ----------
    shown
        The instants.
    points
        Names of the points, as the result has them.
    magnify
        Factor on the deflection.
    """
    scene, motion = shown.result.scene, shown.motion
    places = [motion.of_point(*_in_link(scene, point))[0] for point in points]
    rigid = np.stack(places, axis=1) if places else np.zeros((len(shown.at), 0, 2))
    return rigid + magnify * shown.of(places_of(shown.result, points, 1.0) - places_of(shown.result, points, 0.0))


def _in_link(scene: Scene, point: str) -> tuple[str, tuple[float, float]]:
    """Link of a point, or of one that the scene traces, and its place in the link's frame (m)."""
    return place_in_link(scene, scene.points[point]) if point in scene.points else scene.point(point)


def places_of(result: Result, points: list[str], magnify: float) -> Array:
    """Positions of points at those of the result (m), ``(positions, points, 2)``.

    Parameters
    ----------
    result
        The result.
    points, magnify
        As of `point_places`.
    """
    data = result.data
    if not points:
        return np.zeros((data.sizes["theta"], 0, 2))
    names = ["point_position"] + ["point_position_bent"] * ("point_position_bent" in data)
    rigid, *bent = (data[name].sel(point=points).transpose("theta", "point", "component").to_numpy() for name in names)
    return np.asarray(rigid + magnify * (bent[0] - rigid) if bent else rigid)


def mass_places(shown: Moments, magnify: float) -> tuple[Array, Array]:
    """Positions of the point masses (m), ``(frames, masses, 2)``, and the roots of their shares of the largest.

    Parameters
    ----------
    shown, magnify
        As of `point_places`.
    """
    masses = shown.result.scene.masses.values()
    sizes = np.sqrt([mass.mass for mass in masses])
    return point_places(shown, [mass.at for mass in masses], magnify), sizes / sizes.max(initial=1e-300)


def load_arrows(shown: Moments, motion: Motion, magnify: float) -> Array:
    """Where forces act (m), and the forces over the largest of all loads, ``(frames, loads, 2, 2)``.

    Those at places along members and along lines are left out.

    Parameters
    ----------
    shown, magnify
        As of `point_places`.
    motion
        The rigid motion at the instants.
    """
    scene = shown.result.scene
    loads = [load for load in scene.loads.values() if isinstance(load, Load) and any(load.force) and "@" not in load.at]
    points = [_point_of(scene, load.at) for load in loads]
    places = point_places(shown, points, magnify)
    found, largest = np.zeros((len(shown.at), len(loads), 2, 2)), 1e-300
    for i, (load, point) in enumerate(zip(loads, points)):
        angle = motion.angle[:, motion.links.index(point.split(".")[0])] if load.follows else np.zeros(len(shown.at))
        force = load.factor_at(motion.theta)[:, None] * turned(np.array(load.force), angle)
        found[:, i] = np.stack([places[:, i], force], axis=1)
        largest = max(largest, max(map(abs, load.factor_range)) * float(np.hypot(*load.force)))
    found[:, :, 1] /= largest
    return found


def moving_guides(result: Result, motion: Motion, place: Callable[[list[str]], Array]) -> Array:
    """Guides on links that move (m), as far as their pins travel, ``(frames, guides, 2, 2)``.

    A guide along a member is not among them: it is drawn as the member.

    Parameters
    ----------
    result
        The result.
    motion
        The rigid motion at some instants.
    place
        Gives the positions of points there (m), ``(frames, points, 2)``.
    """
    scene, lines = result.scene, []
    for name, joint in scene.joints.items():
        if not isinstance(joint, Slot | Prismatic) or joint.connect[0].startswith("ground."):
            continue
        if getattr(joint, "member", None) or "slide_place" not in result.data:
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


def trails(result: Result, magnify: float) -> Array:
    """Paths of the joints that move, and then of the traced points (m), ``(paths, instants, 2)``.

    Parameters
    ----------
    result
        The result.
    magnify
        Factor on the deflection.
    """
    scene, count = result.scene, result.data.sizes["theta"]
    if count == 1:
        return np.zeros((0, 1, 2))
    held = [_point_of(scene, name) for name in scene.joints]
    joints = np.moveaxis(places_of(result, held, 0.0), 1, 0)
    moves = np.ptp(joints, axis=1).max(axis=1, initial=0.0)
    paths = [
        *joints[moves > STILL * moves.max(initial=0.0)],
        *np.moveaxis(places_of(result, [*scene.points], magnify), 1, 0),
    ]
    if not paths:
        return np.zeros((0, 1, 2))
    whole = np.array(paths)[:, :: max(1, count // MOST_INSTANTS)]
    closed = scene.analysis.method != "transient"
    return np.concatenate([whole, whole[:, :1]], axis=1) if closed else whole
