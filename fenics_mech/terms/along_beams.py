"""Forces that are spread along beams in the plane: loads along members, and the drag of the air."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.geometry import End
from fenics_mech.terms.beams import Beams
from fenics_mech.terms.inner_places import Shapes
from fenics_mech.terms.term import Look, Measure, Response, Term

QUARTER = np.array([[0.0, -1.0], [1.0, 0.0]])


@dataclass(frozen=True)
class Spread:
    """A force per length at places along beams, and its derivatives; None where there is none.

    Parameters
    ----------
    force
        ``(instants, places, 2)`` (N/m).
    by_place, by_tangent, by_velocity
        ``(instants, places, 2, 2)`` each.
    """

    force: Array
    by_place: Array | None = None
    by_tangent: Array | None = None
    by_velocity: Array | None = None


class Density(Protocol):
    """A force per length by where it acts, by the tangent dr/ds of the axis there, and by its velocity."""

    @property
    def points(self) -> int:
        """Points of Gauss's rule along an element, beside the places inside it."""

    def at(self, t: Array, element: Index, x: Array, place: Array, tangent: Array, velocity: Array) -> Spread:
        """Give it, and its derivatives."""
        # Elements count from 0 among those that are loaded (places,), and x is the share of their length (places,).
        # Places (m), tangents and velocities (m/s) are (instants, places, 2).


@dataclass(frozen=True)
class LineForce:
    """A load along members that is linear in each element.

    Parameters
    ----------
    ends
        At both ends of every loaded element ``(elements, 2, 2)`` (N/m).
    factor
        What it is multiplied by, by time ``(instants,)`` (s).
    follows
        Whether it is given along the bent axis and its normal, else along the fixed axes.
    """

    ends: Array
    factor: Callable[[Array], Array]
    follows: bool = False
    points: int = 4  # exact: a shape, the slope of another and a linear load have degree 6

    def at(self, t: Array, element: Index, x: Array, place: Array, tangent: Array, velocity: Array) -> Spread:
        """Give it; one that follows goes with the tangent's length, as the pressure on a stretched axis."""
        one, other = self.ends[element, 0], self.ends[element, 1]
        line = (1 - x)[:, None] * one + x[:, None] * other
        factor = np.asarray(self.factor(t))[:, None, None]
        if not self.follows:
            return Spread(np.broadcast_to(factor * line, tangent.shape))
        turns = factor[..., None] * (line[:, :1, None] * np.eye(2) + line[:, 1:, None] * QUARTER)
        return Spread(np.einsum("tpij,tpj->tpi", turns, tangent), by_tangent=turns)


@dataclass(frozen=True)
class AirForce:
    """Drag against the square of the velocity across the bent axis: -k |V| V along its normal.

    Source: Morison, O'Brien, Johnson and Schaaf, Petroleum Transactions AIME 189 (1950) 149, without the inertia.

    Parameters
    ----------
    factor
        k = rho C_D b/2 of every element ``(elements,)`` (kg/m^2).
    """

    factor: Array
    points: int = 8  # |V| V has a corner in its slope where V changes its side: 1e-4 of the largest are left

    def at(self, t: Array, element: Index, x: Array, place: Array, tangent: Array, velocity: Array) -> Spread:
        """Give it. As the normal n turns by n . d(tangent)/|tangent|, it changes by minus that times the axis."""
        size = np.linalg.norm(tangent, axis=-1, keepdims=True)
        axis = tangent / size
        normal = axis @ QUARTER.T
        across, k = np.sum(normal * velocity, axis=-1), self.factor[element]
        along = np.sum(axis * velocity, axis=-1)
        square, slope = k * np.abs(across) * across, 2 * k * np.abs(across)
        both = normal[..., :, None] * normal[..., None, :]
        turned = (slope * along)[..., None, None] * both + square[..., None, None] * axis[..., :, None] * normal[
            ..., None, :
        ]
        by_tangent, by_velocity = turned / size[..., None], -slope[..., None, None] * both
        return Spread(-square[..., None] * normal, by_tangent=by_tangent, by_velocity=by_velocity)


class AlongBeams(Term):
    """Forces per length along some of the beams of a machine.

    The axis of an element is a polynomial between some of its vectors, as it is sheared by forces at its ends. These
    vectors are known by places: those of both ends, places that both first axes reach to in its length, and the places
    inside. So each force is one on all these places.

    Parameters
    ----------
    ground
        An end that rests in the axes of the fixed frame.
    beams
        All beams.
    elements
        Numbers of those that are loaded.
    density
        The force per length.
    """

    measures = (Measure(Look.PLACE, 0), Measure(Look.PLACE, 1))

    external = True

    def __init__(self, ground: End, beams: Beams, elements: Sequence[int] | Index, density: Density) -> None:
        self.elements, self.density, self.shapes = np.asarray(elements, dtype=int), density, Shapes(beams.inner)
        self.length = np.array([beams.elements[e].length for e in elements])
        self.shear = np.array([beams.elements[e].shear for e in elements])
        pairs = []
        for e, length in zip(elements, self.length):
            for end in beams.pairs[e]:
                pairs += [(ground, end), (ground, End(end.pose, end.offset + length * end.turn[:, 0], end.turn))]
            pairs += [(ground, End(pose, np.zeros(2), np.eye(2))) for pose in beams.inside[e]]
        super().__init__(pairs)
        self.together = 4 + beams.inner

    def respond(self, t: Array, x: Array, v: Array) -> Response:
        """Give minus the forces on the places: integrals over the elements of the density times their shapes."""
        share, weights = self.shapes.rule(self.density.points)
        N, slopes = (self._of_places(self.shapes.at(share, order)) for order in (0, 1))
        slopes = slopes / self.length[:, None, None]
        sets, count, k = N.shape
        places, rates = (y.reshape(len(t), sets, k, 2) for y in (x, v))
        ways = ((slopes, places), (N, places), (N, rates))
        tangent, place, velocity = (
            np.einsum("egk,tekd->tegd", by, y).reshape(len(t), sets * count, 2) for by, y in ways
        )
        element = np.repeat(np.arange(sets), count)
        found = self.density.at(t, element, np.tile(share, sets), place, tangent, velocity)
        force = found.force.reshape(len(t), sets, count, 2)
        stress = -np.einsum("g,e,egk,tegd->tekd", weights, self.length, N, force)

        def spread(derivative: Array | None, shapes: Array) -> Array | float:
            """Give derivatives of the forces on all places by those of the density, through some shapes."""
            if derivative is None:
                return 0.0
            by = derivative.reshape(len(t), sets, count, 2, 2)
            return np.asarray(np.einsum("g,e,egk,tegij,egl->tekilj", weights, self.length, N, by, shapes))

        across = np.zeros((2, len(t), sets, k, 2, k, 2))
        across[0] -= spread(found.by_place, N)
        across[0] -= spread(found.by_tangent, slopes)
        across[1] -= spread(found.by_velocity, N)
        return Response(stress.reshape(x.shape), *across.reshape(2, len(t), sets, 2 * k, 2 * k))

    def _of_places(self, shapes: Array) -> Array:
        """Give the weights of places ``(elements, points, places)`` by those of the vectors ``(points, vectors)``."""
        # An axis is the way to the place that it reaches to. A sheared one is turned at both ends.
        made = np.repeat(shapes[None], len(self.shear), axis=0)
        made[:, :, :4] += shapes[:, [1, 3]].sum(axis=1)[:, None] * self.shear[:, None]
        made[:, :, [0, 2]] -= made[:, :, [1, 3]]
        return made

    def stiffening(self, present: Array, static: Array | None) -> Array:
        """Give the loads where axial forces act: that first axes get no shorter is a part of what those do."""
        return present if static is not None else np.zeros_like(present)

    def on_vectors(self, stress: Array) -> Array:
        """Give forces on the vectors of loaded elements by stresses ``(instants, elements, vectors, 2)`` (N, N m)."""
        # The first axes of both ends are vectors 1 and 3.
        force = stress.reshape(len(stress), len(self.length), self.together, 2).copy()
        force[:, :, [0, 2]] += force[:, :, [1, 3]]
        force[:, :, [1, 3]] *= self.length[:, None, None]
        return force

    def line(self, t: Array, element: Index, x: Array, place: Array, tangent: Array, velocity: Array) -> Array:
        """Give the force per length at places of any of the beams ``(instants, places, 2)`` (N/m); see `Density`."""
        own = np.flatnonzero(np.isin(element, self.elements))
        made, order = np.zeros(tangent.shape), np.argsort(self.elements)
        which = order[np.searchsorted(self.elements[order], element[own])]
        at = place[:, own], tangent[:, own], velocity[:, own]
        made[:, own] = self.density.at(t, which, x[own], *at).force
        return made
