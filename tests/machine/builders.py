"""Machines of poses that several tests build: members of beam elements, the seed, pendulums, chains in space."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from scipy.optimize import fsolve

from fenics_mech._arrays import Array
from fenics_mech.geometry import PLANE, SPACE, End
from fenics_mech.machine import Machine, Row
from fenics_mech.terms import DeadLoad, Element, Look, Measure

STEEL, ALUMINIUM = 207e9, 71e9  # Pa


@dataclass
class Bar:
    """A uniform beam: stiffnesses (N, N m^2), mass per length (kg/m), rotary inertia per length (kg m)."""

    EA: float
    EI: Sequence[float]
    line_mass: float
    GJ: float = 0.0
    rotary: Sequence[float] = ()
    tau: float = 0.0


@dataclass
class Members:
    """Beam elements as they are gathered for a machine."""

    machine: Machine
    pairs: list[tuple[End, End]] = field(default_factory=list)
    elements: list[Element] = field(default_factory=list)
    damping: list[float] = field(default_factory=list)

    def add(self, a: int, b: int, count: int, bar: Bar, up: Array | None = None, inner: int = 0) -> list[int]:
        """Add a straight member of `count` elements between two poses, and give the poses between them.

        Each has `inner` places inside.
        """
        machine, g = self.machine, self.machine.geometry
        first, last = machine.r[a], machine.r[b]
        axes, length = g.axes(last - first, up), float(np.linalg.norm(last - first)) / count
        between = [machine.add_pose(first + (last - first) * k / count, axes) for k in range(1, count)]
        ends = [machine.end(pose, machine.r[pose], axes) for pose in (a, *between, b)]
        for pair in pairwise(ends):
            self.pairs.append(pair)
            if inner:
                made = Element.with_places(inner, length, bar.EA, bar.EI[0], bar.line_mass, sum(bar.rotary))
            else:
                made = Element.uniform(length, bar.EA, bar.EI, bar.GJ, bar.line_mass, bar.rotary)
            self.elements.append(made)
            self.damping.append(bar.tau)
        return between

    def done(self) -> None:
        """Give the elements to the machine."""
        self.machine.add_beams(self.pairs, self.elements, self.damping)


def load(machine: Machine, end: End, axis: int | None, force: float) -> None:
    """Add a force along an axis, or in the plane a moment, that does not vary."""
    machine.terms.append(DeadLoad(machine.at_ground(), end, axis, lambda t: np.full(len(t), force)))


def pin(machine: Machine, one: End, other: End) -> None:
    """Hold two ends at one place."""
    machine.rows += [Row((one, other), Measure(Look.PLACE, i), name="pin") for i in range(machine.geometry.d)]


def turning(speed: float, axes: Array):
    """Lead a pose in the plane around the origin."""
    return lambda t: (np.zeros((len(t), 2)), PLANE.turn((speed * t)[:, None]) @ axes, 0.0, speed, 0.0, 0.0)


def seed(count: int, speed: float = 32.3, tau: float = 1.3385736291698238e-4, inner: int = 0) -> Machine:
    """Build the four-bar of the dissertation with `count` elements a member, and material damping."""
    first, third = np.array([0.10795, 0.0]), np.array([0.254, 0.0])
    gaps = lambda x: [np.hypot(*(x - first)) - 0.2794, np.hypot(*(x - third)) - 0.27051]  # noqa: E731
    second = fsolve(gaps, [0.1977, 0.26459], xtol=1e-14)
    machine = Machine(PLANE)
    members, axes = Members(machine), PLANE.axes
    hub = machine.add_pose(np.zeros(2), axes(first), led=turning(speed, axes(first)))
    a = machine.add_pose(first, axes(first))
    coupler_a = machine.add_pose(first, axes(second - first), shared=a)
    b = machine.add_pose(second, axes(second - first))
    follower_b = machine.add_pose(second, axes(second - third), shared=b)
    c = machine.add_pose(third, axes(second - third), fixed="place")
    strip = Bar(2882600.0, [0.61557], 0.1101884, tau=tau)
    members.add(hub, a, count, Bar(7597000.0, [11.502], 0.290398, tau=tau), inner=inner)
    members.add(coupler_a, b, count, strip, inner=inner)
    members.add(c, follower_b, count, strip, inner=inner)
    members.done()
    for pose, mass in ((a, 0.0452), (b, 0.03755)):
        machine.masses.add_body(machine.end(pose), mass, np.zeros((2, 2)))
    return machine


def double_pendulum() -> tuple[Machine, tuple[int, int]]:
    """Build two rigid bars of 1 m and 1 kg, horizontal at rest; give the machine and the bars' poses."""
    machine, thin = Machine(PLANE, [0, -9.81]), np.eye(2) / 24  # of the moment 1/12 kg m^2
    first, second = machine.add_pose(np.zeros(2), fixed="place"), machine.add_pose(np.array([1.0, 0.0]))
    for pose, centre in ((first, 0.5), (second, 1.5)):
        machine.masses.add_body(machine.end(pose, np.array([centre, 0.0])), 1.0, thin)
    joint = np.array([1.0, 0.0])
    pin(machine, machine.end(first, joint), machine.end(second, joint))
    return machine, (first, second)


def chain(places: Array, bar: Bar, up: Array) -> tuple[Machine, int]:
    """Build a clamped beam in space, an element from place to place; give the machine and the pose of its tip."""
    machine = Machine(SPACE)
    poses = [machine.add_pose(places[0], fixed="place and turn"), *[machine.add_pose(place) for place in places[1:]]]
    pairs, elements = [], []
    for k in range(len(places) - 1):
        way = places[k + 1] - places[k]
        axes, length = SPACE.axes(way, up), float(np.linalg.norm(way))
        pairs.append((machine.end(poses[k], places[k], axes), machine.end(poses[k + 1], places[k + 1], axes)))
        elements.append(Element.uniform(length, bar.EA, bar.EI, bar.GJ, bar.line_mass, bar.rotary))
    machine.add_beams(pairs, elements)
    return machine, poses[-1]
