"""Forces in sections of beams, by equilibrium of what acts on the ends of an element and of its inertia."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.machine.groups import Group, Moved
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.rides import Rides
from fenics_mech.terms import AlongBeams, Beams, Shapes
from fenics_mech.terms.inertia import beside_line

Line = Callable[[Array, Array, Array], Array]


@dataclass(frozen=True)
class EndForces:
    """What acts on the ends of every element, in the fixed frame.

    Parameters
    ----------
    force
        ``(instants, elements, 2, d)`` (N).
    moment
        About the end ``(instants, elements, 2, turns)`` (N m).
    place, axes
        Of the ends ``(instants, elements, 2, d)`` (m) and ``(instants, elements, 2, d, d)``.
    """

    force: Array
    moment: Array
    place: Array
    axes: Array


@dataclass(frozen=True)
class Sections:
    """Forces in sections, and where these are, ``(instants, stations)`` each.

    Parameters
    ----------
    axial, shear
        Along the bent axis, and dM/ds (N).
    moment
        N m.
    place
        On the bent axis, ``(instants, stations, 2)`` (m).
    """

    axial: Array
    shear: Array
    moment: Array
    place: Array


def end_forces(
    beams: Beams, group: Group, measured: Measured, at: Moved, loads: Sequence[tuple[AlongBeams, Array]] = ()
) -> EndForces:
    """Give what holds each element at its ends: against its stresses, for its motion, and against loads along it.

    Gravity and drag count as accelerations of its mass, so that these forces balance within the element.

    Parameters
    ----------
    beams, group, measured
        The elements, where they lie, and their stresses.
    at
        The poses.
    loads
        Loads along elements, with their stresses ``(instants, places, d)``.
    """
    g, d, pose = group.geometry, group.geometry.d, group.pose
    offset, turn = (
        np.array([[getattr(end, name) for end in pair] for pair in beams.pairs]) for name in ("offset", "turn")
    )
    way = np.einsum("tekij,ekj->teki", at.R[:, pose], offset)
    axes = at.R[:, pose] @ turn
    along = np.einsum("temn,tem->ten", measured.gradient, measured.response.stress)
    force, by_chart = group.on_ends(along)
    moment = g.from_chart(at.c[:, pose], by_chart) - g.moment(way, force)  # the turn of the pose moves the arm, too

    columns = np.swapaxes(at.inert[:, :, 1:], -1, -2)[:, pose]  # second rates of R, (T, E, 2, d, d)
    of_place = at.inert[:, pose, 0] + np.einsum("tekij,ekj->teki", columns, offset)
    of_axes = columns @ turn
    vectors = np.stack([of_place, of_axes[..., 0]], axis=3).reshape(*along.shape[:2], 4, d)
    mass = np.array([element.mass for element in beams.elements])
    rotary = np.array([element.rotary for element in beams.elements]) / 6
    beside = np.array([beside_line(element.length, element.moment) for element in beams.elements])
    inside = at.inert[:, np.array(beams.inside, dtype=int), 0]
    inert = np.einsum("eij,tejd->teid", mass[:, :4], np.concatenate([vectors, inside], axis=2))
    for load, stress in loads:
        inert[:, load.elements] += load.on_vectors(stress)[:, :, :4]
    for bend in range(d - 1):
        normal = of_axes[..., 1 + bend]
        inert = inert + np.einsum("eik,tekd->teid", beside[:, bend], normal)
        sections = rotary[None, :, bend, None, None] * (normal + normal.sum(axis=2, keepdims=True))
        sections = sections + np.einsum("eik,teid->tekd", beside[:, bend], vectors)
        moment = moment + g.moment(axes[..., 1 + bend], sections)
    inert = inert.reshape(*along.shape[:2], 2, 2, d)
    moment = moment + g.moment(axes[..., 0], inert[:, :, :, 1])
    return EndForces(force + inert[:, :, :, 0], moment, at.r[:, pose] + way, axes)


def with_rides(forces: EndForces, beams: Beams, rides: Rides, at: Moved, a: Array) -> EndForces:
    """Give the same where pins ride inside elements: their ends hold the pins' loads too.

    Parameters
    ----------
    forces
        What holds the elements against stresses and inertia.
    beams, rides
        The elements, and the pins that ride on some of them.
    at, a
        The poses, and accelerations with multipliers ``(instants, size)``.
    """
    number = _ridden(beams, rides)
    load = rides.loads(at, a)
    push, way = load[..., : at.r.shape[-1]], forces.place[:, number] - at.r[:, rides.pose[:, :2]]
    force, moment = forces.force.copy(), forces.moment.copy()
    about_end = load[..., -1:] - rides.geometry.moment(way, push)
    for k, e in enumerate(number):
        force[:, e] += push[:, k]
        moment[:, e] += about_end[:, k]
    return replace(forces, force=force, moment=moment)


def _ridden(beams: Beams, rides: Rides) -> list[int]:
    """Give the numbers of the elements that pins ride on."""
    numbers = {id(pair): e for e, pair in enumerate(beams.pairs)}
    return [numbers[id(pair)] for ride in rides.rides for pair in ride.elements]


@dataclass(frozen=True)
class InnerForces:
    """Forces that act inside elements.

    Parameters
    ----------
    element
        The element of each ``(forces,)``.
    place
        Where they act, 0..1 along it ``(instants, forces)``.
    force
        ``(instants, forces, 2)`` (N).
    """

    element: Index
    place: Array
    force: Array

    @classmethod
    def of_rides(cls, beams: Beams, rides: Rides, at: Moved, a: Array) -> InnerForces:
        """Give what pins exert on the elements that they ride on."""
        return cls(np.array(_ridden(beams, rides), dtype=int), *rides.pushes(at, a))


def inside(
    beams: Beams,
    group: Group,
    at: Moved,
    ends: EndForces,
    elements: Index,
    places: Array,
    line_mass: Callable[[Array], Array],
    loads: InnerForces | None = None,
    line: Line | None = None,
) -> Sections:
    """Give the forces in sections at places inside elements.

    It is the equilibrium of the part before the place, along the bent axis. That is a cubic between the ends, and the
    bow of a clamped beam under the mean of what acts across it; with places inside, the polynomial through them.

    Parameters
    ----------
    beams, group, at, ends
        The elements, and what acts on their ends.
    elements, places
        Element of each station, and its place in it, 0..1 ``(stations,)``.
    line_mass
        Mass per length (kg/m) by a share of each station's element ``(stations,)``.
    loads
        Forces inside elements.
    line
        Gives the load per length by a share of each station's element, the tangent of the axis and its velocity there.
    """
    length = np.array([element.length for element in beams.elements])[elements]
    rotary = np.array([element.rotary[0] for element in beams.elements])[elements] / length  # kg m
    spread = [_of_axes(beams, group, at.inert, elements, axis) for axis in (0, 1)]
    at_ends = ends.place[:, elements], ends.axes[:, elements]
    force, moment = -ends.force[:, elements, 0], -ends.moment[:, elements, 0, 0]
    shapes, within = Shapes(beams.inner), np.array(beams.inside, dtype=int)[elements]
    vectors = _vectors(length, at_ends[0], at_ends[1][..., 0], at.r[:, within])
    accelerations = _vectors(length, *spread[0], at.inert[:, within, 0])
    rates = _vectors(length, *_of_axes(beams, group, at.rates, elements, 0), at.rates[:, within, 0])

    def load_at(x: Array) -> Array | float:
        """Give the load per length."""
        if line is None:
            return 0.0
        slope = _between_all(shapes.at(x, 1), vectors) / length[:, None]
        return line(x, slope, _between_all(shapes.at(x), rates))

    half = np.full(len(elements), 0.5)
    bow = 0.0 if shapes.inner else _bow(beams, ends, elements, line_mass(half), spread[0], load_at(half))

    def axis(x: Array) -> Array:
        """Give places on the bent axis."""
        return _between_all(shapes.at(x), vectors) + bow * (x**2 * (1 - x) ** 2)[:, None]

    cut = axis(places)
    moment = moment - _cross(at_ends[0][:, :, 0] - cut, -force)
    nodes, weights = np.polynomial.legendre.leggauss(5 + shapes.inner)  # mass times two shapes has degree 7 + 2 inner
    for node, weight in zip((nodes + 1) / 2, weights / 2):
        x, share = node * places, weight * places * length
        held = line_mass(x)[:, None] * _between_all(shapes.at(x), accelerations) - load_at(x)
        here = axis(x)
        force = force + share[:, None] * held
        moment = moment + share * _cross(here - cut, held)
        normal = _between(x, at_ends[1][..., 1])
        moment = moment + share * rotary * _cross(normal, _between(x, spread[1][1]))
    for k, element in enumerate(() if loads is None else loads.element):
        assert loads is not None
        own = np.nonzero(elements == element)[0]
        push = (loads.place[:, k, None] < places[own])[..., None] * loads.force[:, k, None]
        acts = np.einsum("ti,tsid->tsd", shapes.at(loads.place[:, k]), vectors[:, own])
        force[:, own] -= push
        moment[:, own] -= _cross(acts - cut[:, own], push)
    tangent = _between_all(shapes.at(places, 1), vectors)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    return Sections(np.sum(force * tangent, axis=-1), _cross(force, tangent), moment, cut)


def _bow(
    beams: Beams, ends: EndForces, elements: Index, line_mass: Array, spread: tuple[Array, Array], load: Array | float
) -> Array:
    """Give b of the deflection b x^2 (1 - x)^2 within elements ``(instants, stations, 2)`` (m).

    The fourth derivative of the deflection times EI is N times the curvature, and the load less the inertia across the
    axis. With the means of all, b is their sum times length^4/(24 EI).
    """
    length = np.array([element.length for element in beams.elements])[elements]
    bending = length * np.array([element.stiffness[2, 2] for element in beams.elements])[elements]
    normal, along = ends.axes[:, elements].mean(axis=2).transpose(3, 0, 1, 2)[::-1]
    pull = np.sum((ends.force[:, elements, 1] - ends.force[:, elements, 0]) / 2 * along, axis=-1)
    curvature = (ends.moment[:, elements, 1, 0] - ends.moment[:, elements, 0, 0]) / (2 * bending)
    places, axes = spread
    mean = places.mean(axis=2) + length[:, None] / 12 * (axes[:, :, 0] - axes[:, :, 1])  # of a cubic
    across = pull * curvature + np.sum((load - line_mass[:, None] * mean) * normal, axis=-1)
    return np.asarray((across * length**4 / (24 * bending))[..., None] * normal)


def _of_axes(beams: Beams, group: Group, rates: Array, elements: Index, axis: int) -> tuple[Array, Array]:
    """Give places and one axis of both ends by those of the poses' vectors, ``(instants, stations, 2, d)``.

    They are second rates or rates, as those ``(instants, poses, 1 + d, d)`` of the poses.
    """
    pose = group.pose[elements]
    offset, turn = (
        np.array([[getattr(end, name) for end in beams.pairs[e]] for e in elements]) for name in ("offset", "turn")
    )
    columns = np.swapaxes(rates[:, :, 1:], -1, -2)[:, pose]
    place = rates[:, pose, 0] + (columns @ offset[..., None])[..., 0]
    return place, (columns @ turn[..., axis, None])[..., 0]


def _vectors(length: Array, place: Array, axis: Array, inside: Array) -> Array:
    """Give what the shapes of elements weigh, of both ends and of places inside ``(instants, stations, shapes, d)``."""
    of_ends = np.stack([place, axis * length[:, None, None]], axis=3)
    return np.concatenate([of_ends.reshape(*place.shape[:2], 4, -1), inside], axis=2)


def _between_all(shapes: Array, vectors: Array) -> Array:
    return np.asarray((shapes[:, None] @ vectors)[:, :, 0])


def _between(x: Array, values: Array) -> Array:
    """Give values between those of both ends ``(instants, stations, 2, d)``."""
    return np.asarray((1 - x)[:, None] * values[:, :, 0] + x[:, None] * values[:, :, 1])


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
