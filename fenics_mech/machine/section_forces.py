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

AT_ONCE = 1e-10  # of an element: a force as near to a station acts behind it, whatever rounding says
Line = Callable[[Array, Array, Array, Array], Array]


@dataclass(frozen=True)
class EndForces:
    """What acts on the ends of every element, in the fixed frame."""

    force: Array  # (instants, elements, 2, d) (N)
    moment: Array  # about the end (instants, elements, 2, turns) (N m)
    place: Array  # of the ends (instants, elements, 2, d) (m) and (instants, elements, 2, d, d)
    axes: Array


@dataclass(frozen=True)
class Sections:
    """Forces in sections, and where these are, ``(instants, stations)`` each."""

    axial: Array  # along the bent axis, and dM/ds (N)
    shear: Array
    moment: Array  # N m
    place: Array  # on the bent axis, (instants, stations, 2) (m)
    bow: Array  # of it what the forces make within an element whose ends do not move (instants, stations, 2) (m)


def end_forces(
    beams: Beams, group: Group, measured: Measured, at: Moved, loads: Sequence[tuple[AlongBeams, Array]] = ()
) -> EndForces:
    """Give what holds each element at its ends: against its stresses, for its motion, and against loads along it."""
    # loads (instants, places, d)
    # Gravity and drag count as accelerations of its mass, so that these forces balance within the element.
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
    """Give the same where pins ride inside elements: their ends hold the pins' loads too."""
    # at, a (instants, size)
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
    """Forces and moments that act inside elements."""

    element: Index  # the element of each (forces,)
    place: Array  # where they act, 0..1 along it (instants, forces)
    force: Array  # (instants, forces, 2) (N) and (instants, forces, 1) (N m)
    moment: Array

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
    bent: bool = True,
    softness: Callable[[Array], Array] | None = None,
    shear: Array | None = None,
) -> Sections:
    """Give the forces in sections at places inside elements."""
    # elements, places (stations,) each; line_mass (stations,) (kg/m); softness (stations,); shear (N)
    # It is the equilibrium of the part before the place, along the bent axis. That is a cubic between the ends, whose
    # slopes are as long as the axis is stretched there, and turned as it is sheared. On it is the bow of a clamped
    # beam under the mean of what acts across it. With places inside it is the polynomial through them.
    length = np.array([element.length for element in beams.elements])[elements]
    rotary = np.array([element.rotary[0] for element in beams.elements])[elements] / length  # kg m
    beside = np.array([element.moment[0] for element in beams.elements])[elements, None]  # rho A e (kg)
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
        place, velocity = (_between_all(shapes.at(x), y) for y in (vectors, rates))
        return line(x, place, slope, velocity)

    bows, longer = None, np.zeros_like(vectors)
    bending = length * np.array([element.stiffness[2, 2] for element in beams.elements])[elements]  # EI
    if not shapes.inner:
        rigidity = np.array([element.stiffness[0, 0] for element in beams.elements])[elements] / length  # EA
        pulls, shears = np.einsum("tskd,tskda,k->atsk", ends.force[:, elements], at_ends[1][..., :2], [-1.0, 1.0])
        stretched = at_ends[1][..., 0] * (pulls / rigidity[:, None])[..., None]
        if shear is not None:  # sections are not normal to the axis
            stretched += at_ends[1][..., 1] * (shears / shear[elements, None])[..., None]
        longer = _vectors(length, 0 * at_ends[0], stretched, at.r[:, within])
        bows = _bows(
            beams,
            ends,
            elements,
            [line_mass(np.full(len(elements), x)) for x in (0.0, 0.5, 1.0)],
            spread[0],
            [load_at(np.full(len(elements), x)) for x in (0.0, 0.5, 1.0)],
            bent,
        )

    turns: list[Array] = []  # second derivatives of the cubic at both ends
    if softness is not None:
        ones, across = np.ones(len(elements)), at_ends[1][..., 1].mean(axis=2)
        for x in (0.0, 1.0):
            turn = np.sum(_between_all(shapes.at(x * ones, 2), vectors) * across, axis=-1)
            turns.append(turn[..., None] * across)

    def bow(x: Array, derivative: int = 0, turned: float = 1.0) -> Array:
        """Give how far the axis is beside the cubic, or its derivative by the share; `turned` 0 for a straight one."""
        if bows is None:
            return np.zeros_like(vectors[:, :, 0])
        along = _between_all(shapes.at(x, derivative) * [0, 1, 0, 1], longer)
        if loads is not None and softness is None:
            for k, element in enumerate(loads.element):
                own = np.nonzero(elements == element)[0]
                across = ends.axes[:, element, :, :, 1].mean(axis=1)
                push = np.sum(loads.force[:, k] * across, axis=-1, keepdims=True) * across
                share = _clamped_under(loads.place[:, k, None], x[own], derivative)
                along[:, own] += (length[own] ** 3 / bending[own] * share)[..., None] * push[:, None]
                share = loads.moment[:, k] * _clamped_under_couple(loads.place[:, k, None], x[own], derivative)
                along[:, own] += (length[own] ** 2 / bending[own] * share)[..., None] * across[:, None]
        if softness is not None:
            return along + _bow_of_varying(x, bows, [turned * turn for turn in turns], softness, derivative)
        even, odd = x**2 * (1 - x) ** 2, 2 * x - 1
        slope = -2 * x * (1 - x) * odd
        first, second = (slope, 2 * even + odd * slope) if derivative else (even, odd * even)
        return along + bows[0] * first[:, None] + bows[1] * second[:, None]

    def axis(x: Array) -> Array:
        """Give places on the axis by which forces have levers."""
        cubic = _between_all(shapes.at(x), vectors)
        return cubic + bow(x) if bent else cubic

    cut = axis(places)
    moment = moment - _cross(at_ends[0][:, :, 0] - cut, -force)
    nodes, weights = np.polynomial.legendre.leggauss(5 + shapes.inner)  # mass times two shapes has degree 7 + 2 inner
    for node, weight in zip((nodes + 1) / 2, weights / 2):
        x, share = node * places, weight * places * length
        of_axis, of_normal = _between_all(shapes.at(x), accelerations), between(x, spread[1][1])
        held = line_mass(x)[:, None] * of_axis + beside * of_normal - load_at(x)
        force = force + share[:, None] * held
        moment = moment + share * _cross(axis(x) - cut, held)
        normal = between(x, at_ends[1][..., 1])  # on which mass beside the axis has an arm, and sections turn
        moment = moment + share * _cross(normal, beside * of_axis + rotary[:, None] * of_normal)
    for k, element in enumerate(() if loads is None else loads.element):
        assert loads is not None
        own = np.nonzero(elements == element)[0]
        before = loads.place[:, k, None] < places[own] - AT_ONCE
        push = before[..., None] * loads.force[:, k, None]
        acts = np.einsum("ti,tsid->tsd", shapes.at(loads.place[:, k]), vectors[:, own])
        force[:, own] -= push
        moment[:, own] -= _cross(acts - cut[:, own], push) + before * loads.moment[:, k]
    tangent = _between_all(shapes.at(places, 1), vectors) + (bow(places, 1) if bent else 0.0)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    place = cut if bent else cut + bow(places)
    return Sections(np.sum(force * tangent, axis=-1), _cross(force, tangent), moment, place, bow(places, turned=0.0))


def on_cubics(beams: Beams, group: Group, at: Moved, elements: Index, places: Array) -> Array:
    """Give places on the polynomials between the ends of elements, ``(instants, stations, 2)`` (m)."""
    length = np.array([element.length for element in beams.elements])[elements]
    columns = np.concatenate([at.r[:, :, None], np.swapaxes(at.R, -1, -2)], axis=2)
    within = np.array(beams.inside, dtype=int)[elements]
    vectors = _vectors(length, *_of_axes(beams, group, columns, elements, 0), at.r[:, within])
    return _between_all(Shapes(beams.inner).at(places), vectors)


def _bows(
    beams: Beams,
    ends: EndForces,
    elements: Index,
    line_masses: Sequence[Array],
    spread: tuple[Array, Array],
    loads: Sequence[Array | float],
    bent: bool,
) -> tuple[Array, Array]:
    """Give b and c of the deflection (b + c (2 x - 1)) x^2 (1 - x)^2 in elements ``(instants, stations, 2)`` (m)."""
    # The fourth derivative of the deflection times EI is p, N times the curvature and the load less the inertia
    # across the axis. With its mean, b is p length^4/(24 EI). With half its change from end to end, c is that over
    # 120. `line_masses` and `loads` are at the start, in the middle, and at the end. N acts where axes are `bent`.
    length = np.array([element.length for element in beams.elements])[elements]
    bending = length * np.array([element.stiffness[2, 2] for element in beams.elements])[elements]
    normal, along = ends.axes[:, elements].mean(axis=2).transpose(3, 0, 1, 2)[::-1]
    pull = bent * np.sum((ends.force[:, elements, 1] - ends.force[:, elements, 0]) / 2 * along, axis=-1)
    first, last = (sign * ends.moment[:, elements, end, 0] / bending for end, sign in ((0, -1), (1, 1)))  # curvatures
    places, axes = spread
    mean = places.mean(axis=2) + length[:, None] / 12 * (axes[:, :, 0] - axes[:, :, 1])  # of a cubic
    beside = [
        np.sum((load - mass[:, None] * at) * normal, axis=-1)
        for load, mass, at in zip(loads, line_masses, (places[:, :, 0], mean, places[:, :, 1]))
    ]
    evenly = pull * (first + last) / 2 + beside[1]
    apart = (pull * (last - first) + beside[2] - beside[0]) / 2
    scale = length**4 / bending
    return (evenly * scale / 24)[..., None] * normal, (apart * scale / 120)[..., None] * normal


def _clamped_under(place: Array, x: Array, derivative: int) -> Array:
    """Give the deflection of a clamped beam of length 1 and stiffness 1 under a force of 1, or its derivative."""
    left = place > x
    a, at = np.where(left, place, 1 - place), np.where(left, x, 1 - x)
    b = 1 - a
    if derivative:
        return np.asarray(np.where(left, 1, -1) * b**2 * at * (2 * a - at * (3 * a + b)) / 2)
    return np.asarray(b**2 * at**2 * (3 * a - at * (3 * a + b)) / 6)


def _clamped_under_couple(place: Array, x: Array, derivative: int) -> Array:
    """Give the same under a couple of 1: the derivative by the place of a force."""
    left = place > x
    a, at = np.where(left, place, 1 - place), np.where(left, x, 1 - x)
    b = 1 - a
    if derivative:
        return np.asarray(b * at * (b - 2 * a + 3 * a * at))
    return np.asarray(np.where(left, 1, -1) * b * at**2 * (b - 2 * a + 2 * a * at) / 2)


def _bow_of_varying(
    x: Array, bows: tuple[Array, Array], turns: Sequence[Array], softness: Callable[[Array], Array], derivative: int
) -> Array:
    """Give how far the axis of elements whose sections vary is beside the cubic ``(instants, stations, 2)`` (m)."""
    # With `derivative` 1 it is the derivative of that by the share.
    # Its second derivative is s (k + C + D x) less that of the cubic, with k that of the bow of even sections and s
    # the softness. C and D are the moments by which neither its ends nor their slopes are beside the cubic. `turns`
    # are the cubic's second derivatives at both ends.
    points, weights = np.polynomial.legendre.leggauss(8)  # shares of polynomials in 1/EI, to 1e-9 of tapers to a half
    points, weights = (points + 1) / 2, weights / 2

    def parts(at: Array) -> tuple[Array, Array]:
        """Give the softness at shares ``(stations,)``, and what of the second derivative C and D do not tell."""
        u, soft = (2 * at - 1)[:, None], softness(at)[:, None]
        even = ((bows[0] + bows[1] * u) * (12 * u**2 - 4) - 8 * bows[1] * u * (1 - u**2)) / 4
        return soft, soft * even - (1 - at)[:, None] * turns[0] - at[:, None] * turns[1]

    whole = [(w, xi, *parts(np.full(len(x), xi))) for xi, w in zip(points, weights)]
    B0, B1, B2 = (sum(w * xi**j * soft for w, xi, soft, _ in whole) for j in range(3))
    r0, r1 = (-sum(w * xi**j * rest for w, xi, _, rest in whole) for j in range(2))
    determinant = B0 * B2 - B1**2
    C, D = (B2 * r0 - B1 * r1) / determinant, (B0 * r1 - B1 * r0) / determinant
    bow = np.zeros_like(bows[0])
    for xi, w in zip(points, weights):
        at = xi * x
        soft, rest = parts(at)
        bow += w * (1 - xi) ** (1 - derivative) * (soft * (C + D * at[:, None]) + rest)
    return np.asarray(bow * (x ** (2 - derivative))[:, None])


def _of_axes(beams: Beams, group: Group, rates: Array, elements: Index, axis: int) -> tuple[Array, Array]:
    """Give places and one axis of both ends by those of the poses' vectors, ``(instants, stations, 2, d)``."""
    # They are second rates or rates, as those (instants, poses, 1 + d, d) of the poses.
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


def between(x: Array, values: Array) -> Array:
    """Give values between those of both ends ``(instants, stations, 2, d)``."""
    return np.asarray((1 - x)[:, None] * values[:, :, 0] + x[:, None] * values[:, :, 1])


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
