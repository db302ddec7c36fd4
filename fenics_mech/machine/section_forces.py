"""Forces in sections of beams, by equilibrium of what acts on the ends of an element and of its inertia."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.groups import Group, Moved
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.rides import Rides
from fenics_mech.terms import Beams
from fenics_mech.terms.inertia import beside_line


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


def end_forces(beams: Beams, group: Group, measured: Measured, at: Moved) -> EndForces:
    """Give what holds each element of a planar machine at its ends: against its stresses, and for its motion.

    Gravity counts as an acceleration of its mass, so that these forces balance within the element.

    Parameters
    ----------
    beams, group, measured
        The elements, where they lie, and their stresses.
    at
        The poses.
    """
    d = at.r.shape[-1]
    pose = group.pose
    offset, turn = (
        np.array([[getattr(end, name) for end in pair] for pair in beams.pairs]) for name in ("offset", "turn")
    )
    way = np.einsum("tekij,ekj->teki", at.R[:, pose], offset)
    axes = at.R[:, pose] @ turn
    along = np.einsum("temn,tem->ten", measured.gradient, measured.response.stress)
    force = np.stack([-along[..., :d], along[..., :d]], axis=2)
    moment = np.stack([along[..., d : d + 1], along[..., d + 1 :]], axis=2)
    moment = moment - _cross(way, force)[..., None]  # the gradient by a turn of the pose holds the arm's

    columns = np.swapaxes(at.acc[:, :, 1:], -1, -2)[:, pose]  # second rates of R, (T, E, 2, d, d)
    of_place = at.acc[:, pose, 0] + np.einsum("tekij,ekj->teki", columns, offset)
    of_axes = columns @ turn
    vectors = np.stack([of_place, of_axes[..., 0]], axis=3).reshape(*along.shape[:2], 4, d)
    mass = np.array([element.mass for element in beams.elements])
    beside = np.array([beside_line(element.length, element.moment)[0] for element in beams.elements])
    inert = np.einsum("eij,tejd->teid", mass, vectors) + np.einsum("eik,tekd->teid", beside, of_axes[..., 1])
    inert = inert.reshape(*along.shape[:2], 2, 2, d)
    force = force + inert[:, :, :, 0]
    moment = moment + _cross(axes[..., 0], inert[:, :, :, 1])[..., None]
    rotary = np.array([element.rotary[0] for element in beams.elements]) / 6
    sections = rotary[None, :, None, None] * (of_axes[..., 1] + of_axes[..., 1].sum(axis=2, keepdims=True))
    sections = sections + np.einsum("eik,teid->tekd", beside, vectors)
    moment = moment + _cross(axes[..., 1], sections)[..., None]
    return EndForces(force, moment, at.r[:, pose] + way, axes)


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
    numbers = {id(pair): e for e, pair in enumerate(beams.pairs)}
    number = [numbers[id(pair)] for ride in rides.rides for pair in ride.elements]
    load = rides.loads(at, a)
    push, way = load[..., : at.r.shape[-1]], forces.place[:, number] - at.r[:, rides.pose[:, :2]]
    force, moment = forces.force.copy(), forces.moment.copy()
    about_end = load[..., -1:] - _cross(way, push)[..., None]
    for k, e in enumerate(number):
        force[:, e] += push[:, k]
        moment[:, e] += about_end[:, k]
    return replace(forces, force=force, moment=moment)


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
