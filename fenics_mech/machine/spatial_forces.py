"""Forces in sections of beams in space, and forces of joints, by equilibrium."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.section_forces import EndForces, between, end_forces
from fenics_mech.machine.spatial import MemberInSpace, SpatialMachine

GAUSS = np.polynomial.legendre.leggauss(5)  # inertia times a lever is of the degree 7 along an element


@dataclass(frozen=True)
class SpatialSections:
    """Forces at stations of a member, in the axes of its section: along it, and both principal axes.

    Parameters
    ----------
    force, moment
        ``(instants, stations, 3)`` (N, N m): axial and both shear forces, torsion and both bending moments.
    place, axes
        ``(instants, stations, 3)`` (m) and ``(instants, stations, 3, 3)``.
    """

    force: Array
    moment: Array
    place: Array
    axes: Array


def of_members(made: SpatialMachine, motion: Motion, stations: Array) -> dict[str, SpatialSections]:
    """Give the forces in the sections of every member at shares of its length ``(stations,)``.

    Parameters
    ----------
    made
        The machine.
    motion
        Its motion.
    stations
        Shares, 0 to 1, ascending.
    """
    if not made.members:
        return {}
    machine, beams = made.machine, made.machine.beams
    group = machine.groups[machine.terms.index(beams)]
    ends = end_forces(beams, group, motion.of_term(beams), motion.found.at)
    return {own.label: _along(made, motion, own, ends, stations) for own in made.members}


def _along(
    made: SpatialMachine, motion: Motion, own: MemberInSpace, ends: EndForces, stations: Array
) -> SpatialSections:
    """Hold the part of an element before each station: against its end, its inertia, and that of its sections."""
    at = np.clip(np.searchsorted(own.nodes, stations, side="right") - 1, 0, len(own.elements) - 1)
    numbers = np.array(own.elements)[at]
    span = np.diff(own.nodes)[at]
    x, length = (stations - own.nodes[at]) / span, span * own.length
    place, axes = ends.place[:, numbers], ends.axes[:, numbers]  # (T, S, 2, 3), (T, S, 2, 3, 3)
    acceleration, of_axes = _second_rates(made, motion, numbers)
    line_mass = own.density * own.section.area
    rotary = own.density * np.array(own.section.inertia)

    pull = np.sum(ends.force[:, numbers] * axes[..., 0], axis=-1) * [-1.0, 1.0]  # at both ends (N)
    stretched = axes[..., 0] * (1 + pull / (own.modulus * own.section.area))[..., None]
    axis = _cubic(place, stretched, length)
    inert = _cubic(acceleration, of_axes[..., 0], length)
    cut = axis(x) + _bow(x, length, axes, [-line_mass * inert(np.full_like(x, end)) for end in (0.0, 1.0)], own)
    force = -ends.force[:, numbers, 0]
    moment = -ends.moment[:, numbers, 0] - np.cross(place[:, :, 0] - cut, ends.force[:, numbers, 0])
    for node, weight in zip((GAUSS[0] + 1) / 2, GAUSS[1] / 2):
        there, share = node * x, (weight * x * length)[:, None]
        held = share * line_mass * inert(there)
        force = force + held
        moment = moment + np.cross(axis(there) - cut, held)
        for k in range(2):  # of the sections, which turn
            normal, second = (between(there, y[..., 1 + k]) for y in (axes, of_axes))
            moment = moment + share * rotary[k] * np.cross(normal, second)
    frame = _frames(axis(x, 1), between(x, axes[..., 1]))
    of_force, of_moment = (np.einsum("tsdi,tsd->tsi", frame, y) for y in (force, moment))
    return SpatialSections(of_force, of_moment, cut, frame)


def _bow(x: Array, length: Array, axes: Array, loads: list[Array], own: MemberInSpace) -> Array:
    """Give how far the axis is beside the cubic, by a load per length that is linear within an element (N/m).

    It is the deflection of a clamped beam, p L^4/(24 E I) x^2 (1 - x)^2 for an even load.
    """
    even, bow = x**2 * (1 - x) ** 2 * length**4, np.zeros_like(loads[0])
    for k, inertia in enumerate(own.section.inertia):
        normal = axes[..., 1 + k].mean(axis=2)
        first, last = (np.sum(load * normal, axis=-1) for load in loads)
        size = (first + last) / 48 + (last - first) / 240 * (2 * x - 1)
        bow = bow + (even / (own.modulus * inertia) * size)[..., None] * normal
    return bow


def _second_rates(made: SpatialMachine, motion: Motion, numbers: Index) -> tuple[Array, Array]:
    """Give second rates, less gravity, of places and axes of the ends of elements."""
    pairs, inert = made.machine.beams.pairs, motion.found.at.inert
    pose = np.array([[end.pose for end in pair] for pair in pairs])[numbers]
    offset, turn = (np.array([[getattr(end, name) for end in pair] for pair in pairs])[numbers] for name in PARTS)
    columns = np.swapaxes(inert[:, :, 1:], -1, -2)[:, pose]  # second rates of R (T, S, 2, 3, 3)
    return inert[:, pose, 0] + np.einsum("tskij,skj->tski", columns, offset), columns @ turn


PARTS = "offset", "turn"


def _cubic(values: Array, slopes: Array, length: Array):  # type: ignore[no-untyped-def]
    """Give the Hermite polynomial between values and slopes at both ends ``(T, S, 2, 3)``, by shares ``(S,)``."""

    def at(x: Array, derivative: int = 0) -> Array:
        if derivative:
            shapes = [6 * x * (x - 1), (1 - 4 * x + 3 * x * x) * length, 6 * x * (1 - x), (3 * x * x - 2 * x) * length]
        else:
            y = 1 - x
            shapes = [(1 + 2 * x) * y * y, x * y * y * length, (3 - 2 * x) * x * x, -x * x * y * length]
        parts = values[:, :, 0], slopes[:, :, 0], values[:, :, 1], slopes[:, :, 1]
        return np.asarray(sum(shape[:, None] * part for shape, part in zip(shapes, parts)))

    return at


def _frames(tangent: Array, towards: Array) -> Array:
    """Give axes along tangents, the second towards a vector ``(T, S, 3, 3)``."""
    e = tangent / np.linalg.norm(tangent, axis=-1, keepdims=True)
    n = towards - e * np.sum(e * towards, axis=-1, keepdims=True)
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    return np.stack([e, n, np.cross(e, n)], axis=-1)


def of_joints(made: SpatialMachine, motion: Motion) -> dict[str, tuple[Array, Array]]:
    """Give what every joint exerts on its second link, force and moment about its point ``(instants, 3)`` each.

    Drives have no part in it.

    Parameters
    ----------
    made
        The machine.
    motion
        Its motion.
    """
    machine, g = made.machine, made.machine.geometry
    if not machine.rows:
        return {}
    group, at = machine.row_group, motion.found.at
    values = [row.value(motion.t) if callable(row.value) else np.full(len(motion.t), row.value) for row in machine.rows]
    measured = group.measure(at, np.stack(values, axis=1)[..., None])
    pulls = motion.a[:, machine.n : machine.n + len(machine.rows), None]
    force, by_chart = group.on_ends(np.einsum("temn,tem->ten", measured.gradient, pulls))
    offset = np.array([[end.offset for end in row.pair] for row in machine.rows])
    arm = np.einsum("tekij,ekj->teki", at.R[:, group.pose], offset)
    moment = g.from_chart(at.c[:, group.pose], by_chart) - g.moment(arm, force)
    found = {}
    for name in made.joints:
        own = [k for k, row in enumerate(machine.rows) if row.name == name and k not in made.driven]
        found[name] = -force[:, own, 1].sum(axis=1), -moment[:, own, 1].sum(axis=1)
    return found
