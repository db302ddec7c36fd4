"""A motion that was found with another mesh and other steps, for Newton's method to begin from."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech._sparse import Congruence
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.other_mesh import elemental_on, nodal_on
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.newton import Beginning, Orbit

STRAIGHT = 0.15  # of a motion, by which another differs, up to which a straight line through both goes on
NEAR = 3  # points on either side of a place, from which values there are interpolated
UNEVEN = 10.0  # times that a polynomial magnifies values, up to which it is taken; with equal steps it is below 4


@dataclass(frozen=True)
class KnownMotion:
    """A periodic motion of links with a nonlinear law, apart from the equation that it was found with.

    Parameters
    ----------
    mesh
        The mesh of the links.
    turned
        By how much the drive has turned at its positions (rad), rising from 0 to 2 pi, ``(positions,)``.
    displacement, velocity
        Of the nodal dofs in link axes (m, rad, m/s, rad/s), ``(positions, nodal dofs)``.
    tension
        Axial force of each element (N), ``(positions, elements)``.
    """

    mesh: BeamMesh
    turned: Array
    displacement: Array
    velocity: Array
    tension: Array

    @classmethod
    def of(cls, equation: Equation, orbit: Orbit) -> KnownMotion | None:
        """Take a motion by collocation; None where strains are linear or links are reduced.

        Parameters
        ----------
        equation
            The equation of motion at the collocation points.
        orbit
            The motion there.
        """
        system, law = equation.system, equation.system.terms.law
        if law is None or system.beams.reduction is not None:
            return None
        state = equation.in_links(orbit.displacement, orbit.velocity)
        return cls(system.beams.mesh, np.abs(system.motion.theta), *state, law.tension(*state))

    def beyond(self, before: KnownMotion, share: float) -> KnownMotion:
        """Go on as from another motion to this one.

        Parameters
        ----------
        before
            The other motion, with the same mesh.
        share
            How far, as a share of the difference.

        Returns
        -------
        KnownMotion
            This one, where the other is too far away for a straight line, or has other positions.
        """
        if not np.array_equal(self.turned, before.turned):
            return self
        apart = float(np.linalg.norm(self.displacement - before.displacement))
        if apart > STRAIGHT * float(np.linalg.norm(self.displacement)):
            return self
        names = ("displacement", "velocity", "tension")
        mine, others = ([getattr(motion, name) for name in names] for motion in (self, before))
        return replace(self, **{name: a + share * (a - b) for name, a, b in zip(names, mine, others)})

    def at(self, equation: Equation) -> Beginning:
        """Carry the motion to the points of another equation, whose mesh is of the same members.

        In time it is a polynomial through the nearest positions, and inside elements what their shape functions make of
        it. The coordinates are those whose displacements are nearest to it.

        Parameters
        ----------
        equation
            The equation of motion at collocation points.
        """
        system, transformation = equation.system, equation.system.transformation
        values = np.concatenate([self.displacement, self.velocity, self.tension], axis=1)
        found = interpolation(self.turned, np.abs(system.motion.theta)) @ values
        many = self.displacement.shape[1]
        nodes, elements = (of(system.beams.mesh, self.mesh) for of in (nodal_on, elemental_on))
        v, rate = ((nodes @ part.T).T for part in (found[:, :many], found[:, many : 2 * many]))
        p, first, _ = equation.jets
        place = np.arange(transformation.shape[0])
        pairs = Congruence.of(*transformation.shape, transformation.rows, transformation.columns, [(place, place)])
        normal = pairs.products(p, (np.ones((1, len(place))), p))
        q = normal.solve(transformation.backward(p, v))
        if first is not None:
            rate = rate - transformation.forward(first, q)
        velocity = normal.solve(transformation.backward(p, rate))
        return Beginning(q, velocity, (elements @ found[:, 2 * many :].T).T)


def interpolation(turned: Array, places: Array) -> sp.csr_matrix:
    """Give the matrix that interpolates values over a cycle, by Lagrange's polynomials through the nearest points.

    Where some of these are far closer together than others, as in short pulses, it is by straight lines.

    Parameters
    ----------
    turned
        Angles of the points at which values are known, rising within one turn (rad), ``(points,)``.
    places
        Angles at which they are wanted, also beyond that turn (rad), ``(places,)``.

    Returns
    -------
    scipy.sparse.csr_matrix
        Of shape ``(places, points)``.
    """
    places = turned[0] + np.mod(places - turned[0], TURN)
    turns, points = np.divmod(np.searchsorted(turned, places)[:, None] + np.arange(-NEAR, NEAR), len(turned))
    away, same = turned[points] + TURN * turns - places[:, None], np.eye(2 * NEAR)
    parts = np.where(same, 1.0, away[:, None, :]) / (same + away[:, None, :] - away[:, :, None])
    found, begins = parts.prod(axis=2), np.arange(0, points.size + 1, 2 * NEAR)
    uneven = np.abs(found).sum(axis=1) > UNEVEN
    before, after = away[uneven, NEAR - 1], away[uneven, NEAR]
    found[uneven] = 0.0
    found[uneven, NEAR - 1], found[uneven, NEAR] = after / (after - before), -before / (after - before)
    return sp.csr_matrix((found.ravel(), points.ravel(), begins), (len(places), len(turned)))
