"""Where members are pressed by more than they carry across the plane of motion, in which nothing is computed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fenics_mech.safety.shapes import shape_of
from fenics_mech.scene import Link, Prismatic, Scene
from fenics_mech.scene.sections import Stock

PLACES = np.linspace(0, 1, 11)  # of a member, at which its section is looked at
IN_LINE = 1e-6  # sine of the angle up to which two members are one


@dataclass(frozen=True)
class Sideways:
    """A member that its axial force presses, and at which force it buckles across the plane of motion."""

    member: str  # its label
    force: float  # the largest axial compression (N)
    theta: float  # the drive angle of that (rad)
    # pinned, clamped: axial force at which it buckles with ends that turn across the plane, and with ends that do not
    # (N); the same where the scene says how they are held
    pinned: float
    clamped: float
    free: bool  # whether an end is free: then both forces are those of a member that is clamped at the other

    @property
    def buckles(self) -> bool:
        """Whether it buckles however its ends are held."""
        return self.force > self.clamped


def buckled_sideways(scene: Scene, data: xr.Dataset) -> list[Sideways]:
    """Give the members whose largest compression is above the Euler load across the plane, the most pressed first.

    Parameters
    ----------
    scene, data
        As of `pressed_sideways`.
    """
    found = (one for one in pressed_sideways(scene, data) if one.force > one.pinned)
    return sorted(found, key=lambda one: one.clamped / one.force)


def pressed_sideways(scene: Scene, data: xr.Dataset) -> Iterator[Sideways]:
    """Give the largest compression of each member that is pressed, beside the Euler load across the plane."""
    # That load is ``pi^2 EI/L^2`` with pinned ends and 4 times that with clamped ones. L is the length between
    # joints: of members in line with none between them it is that of all. Sections that say no inertia across are not
    # judged, unless their numbers are those of a rectangle.
    # data: the result, with the axial force (N) over theta, member and s
    for label, (link, member) in scene.members().items():
        stock = Stock(scene.materials.get(member.material or ""), scene.materials, scene.sections)
        stiffness = shape_of(scene.sections[member.section]).bending_across(PLACES, stock)
        if stiffness is None:
            continue
        force = -data["axial_force"].sel(member=label).transpose("theta", "s").to_numpy().min(axis=1)
        k = int(force.argmax())
        length, free = between_joints(scene, data, link, member.ends)
        euler = math.pi**2 * float(stiffness.min()) / length**2
        highest = math.pi**2 * float(stiffness.max()) / length**2
        pinned, clamped = (euler / 4, highest / 4) if free else (euler, 4 * highest)
        if member.across is not None and not free:
            pinned = clamped = euler if member.across == "pinned" else 4 * euler
        if force[k] > 0:
            yield Sideways(label, float(force[k]), float(data["theta"][k]), pinned, clamped, free)


def between_joints(scene: Scene, data: xr.Dataset, link: str, ends: tuple[str, str]) -> tuple[float, bool]:
    """Give the length (m) between the joints, corners or ends beside a member, and whether one of them is free."""
    # What slides in a link that turns with it, as a piston rod in its barrel, is as long as up to the pins of that.
    body = scene.links[link]
    held = {point for joint in scene.joints.values() for point in joint.connect}
    here = {point for point in body.points if f"{link}.{point}" in held}
    stops = [_walked(body, *pair, here) for pair in (ends, ends[::-1])]
    free = any(stop not in here and len(list(_beside(body, stop))) == 1 for stop in stops)
    beyond = sum(_in_barrel(scene, data, name, {f"{link}.{stop}" for stop in stops}) for name in scene.joints)
    return math.dist(body.points[stops[0]], body.points[stops[1]]) + beyond, free


def _in_barrel(scene: Scene, data: xr.Dataset, name: str, stops: set[str]) -> float:
    """Give how far the pins of a barrel are beyond the slide in which a member stops (m); 0 of other joints."""
    joint = scene.joints[name]
    inside = [point for point in joint.connect if point in stops]
    if not isinstance(joint, Prismatic) or len(inside) != 1:
        return 0.0
    guide = joint.connect[1 - joint.connect.index(inside[0])]
    barrel = guide.split(".")[0]
    pins = [
        scene.point(point)[1]
        for other, held in scene.joints.items()
        for point in held.connect
        if other != name and point.split(".")[0] == barrel
    ]
    if barrel == "ground" or not pins:
        return 0.0
    stroke = float(np.abs(data["slide_place"].sel(slide=name)).max()) if "slide_place" in data else 0.0
    return stroke + max(math.dist(scene.point(guide)[1], pin) for pin in pins)


def _beside(body: Link, point: str) -> Iterator[str]:
    """Other ends of the members that end at a point."""
    for member in body.members.values():
        if point in member.ends:
            yield member.ends[1 - member.ends.index(point)]


def _walked(body: Link, before: str, point: str, held: set[str]) -> str:
    """Walk from a point to the next and straight on over points that no joint holds, and give the last one."""
    while point not in held and len(others := [other for other in _beside(body, point) if other != before]) == 1:
        first = np.subtract(body.points[point], body.points[before])
        second = np.subtract(body.points[others[0]], body.points[point])
        size = float(np.linalg.norm(first) * np.linalg.norm(second))
        turn = abs(float(first[0] * second[1] - first[1] * second[0]))
        if turn > IN_LINE * size or float(first @ second) < 0:
            break
        before, point = point, others[0]
    return point
