"""Rigid linkages in space that several tests build."""

import numpy as np

from fenics_mech.geometry import SPACE
from fenics_mech.machine import Machine


def hinge(axis, towards=None):
    """Give axes whose last is the given one."""
    return SPACE.axes(np.asarray(axis, dtype=float), towards)[:, [1, 2, 0]]


def loop(places, axes, gravity=None):
    """Close a chain of rigid bodies between revolutes on the ground; give the machine and the bodies."""
    machine = Machine(SPACE, gravity)
    bodies = [machine.add_pose(place) for place in places[:-1]]
    around = [machine.ground, *bodies, machine.ground]
    for k, (place, axis) in enumerate(zip(places, axes)):
        one, other = (machine.end(pose, place, hinge(axis)) for pose in around[k : k + 2])
        machine.join("revolute", (one, other), name=f"joint {k + 1}")
    return machine, bodies


class Bennett:
    """Bennett's four-bar: skew hinges with b sin(alpha) = a sin(beta), Hunt, Kinematic Geometry of Mechanisms, 1978."""

    a, alpha, b = 1.0, np.pi / 3, 0.8
    beta = float(np.arcsin(0.8 * np.sin(np.pi / 3)))

    @classmethod
    def second(cls, first):
        """Give the angle at the second hinge: tan(x/2) tan(y/2) = sin((beta + alpha)/2)/sin((beta - alpha)/2)."""
        ratio = np.sin((cls.beta + cls.alpha) / 2) / np.sin((cls.beta - cls.alpha) / 2)
        return 2 * np.arctan2(ratio * np.cos(first / 2), np.sin(first / 2))

    @classmethod
    def frames(cls, first):
        """Multiply the links' transforms (Denavit and Hartenberg), the last of which closes the loop."""
        second, frames = cls.second(first), [np.eye(4)]
        links = [(cls.a, cls.alpha), (cls.b, cls.beta)] * 2
        for angle, (length, twist) in zip((first, second, -first, -second), links):
            turn, link = np.eye(4), np.eye(4)
            turn[:3, :3] = SPACE.about(np.array([0, 0, 1.0]), angle)
            link[:3, :3], link[0, 3] = SPACE.about(np.array([1.0, 0, 0]), twist), length
            frames.append(frames[-1] @ turn @ link)
        return frames

    @classmethod
    def machine(cls, first, off=0.0):
        """Build it at a first angle, the axis of its third hinge turned off by an angle."""
        frames = cls.frames(first)
        places, axes = ([frame[:3, k] for frame in frames[:4]] for k in (3, 2))
        axes[2] = SPACE.about(frames[2][:3, 0], off) @ axes[2]
        return *loop(places, axes), axes


def bricard(gravity=None):
    """Build the Bricard mechanism of the IFToMM library of benchmarks: five bars of 1 m along the edges of a cube."""
    places = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1.0]])
    ways = np.roll(places, -1, axis=0) - places
    return loop(places, [np.cross(ways[k - 1], ways[k]) for k in range(6)], gravity)


class Rssr:
    """A crank about z and a rocker about y, which a bar between two balls couples."""

    crank, coupler, rocker, pivot = 0.1, 0.4, 0.25, np.array([0.3, 0.1, 0.05])

    @classmethod
    def angle(cls, turn):
        """Give the rocker's angle about y, from z towards x: |Q + c (cos p z + sin p x) - A| = b in closed form."""
        way = cls.pivot - cls.crank * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
        wanted = (cls.coupler**2 - cls.rocker**2 - np.sum(way**2, axis=-1)) / (2 * cls.rocker)
        return np.arctan2(way[..., 0], way[..., 2]) + np.arccos(wanted / np.hypot(way[..., 0], way[..., 2]))

    @classmethod
    def machine(cls, kind="ball", law=None):
        """Build it at rest with the crank along x; `kind` is that of the joint between crank and coupler."""
        machine, z, y = Machine(SPACE), np.array([0, 0, 1.0]), np.array([0, 1.0, 0])
        p = float(cls.angle(np.array(0.0)))
        first, out = np.array([cls.crank, 0, 0]), cls.rocker * np.array([np.sin(p), 0, np.cos(p)])
        second = cls.pivot + out
        crank = machine.add_pose(np.zeros(3), fixed="place")
        coupler, rocker = machine.add_pose(first), machine.add_pose(cls.pivot, fixed="place")
        bearing = machine.at_ground(axes=hinge(z)), machine.end(crank, axes=hinge(z))
        machine.join("revolute", bearing, name="bearing")
        cross = hinge(z), hinge(np.cross(z, second - first))
        ends = machine.end(crank, first, cross[0]), machine.end(coupler, axes=cross[1])
        machine.join(kind, ends, name="first")
        machine.join("ball", (machine.end(coupler, second), machine.end(rocker, second)), name="second")
        machine.join("revolute", (machine.at_ground(cls.pivot, hinge(y)), machine.end(rocker, axes=hinge(y))))
        machine.drive("revolute", "angle", bearing, law or (lambda t: 2 * np.pi * t))
        return machine, crank, coupler, rocker
