"""Terms that a contributor might add, each a class of a few lines: the machine does the rest, and power balances."""

import numpy as np
import pytest

from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine
from fenics_mech.solve import march
from fenics_mech.terms import Look, Measure, Response, Term
from fenics_mech.terms.term import diagonal


class Detent(Term):
    """A torque that goes with the sine of several times the angle: a rotor that clicks."""

    measures = (Measure(Look.ANGLE),)
    torque, clicks = 0.5, 4

    def respond(self, t, x, v):
        return Response(
            self.torque * np.sin(self.clicks * x), diagonal(self.torque * self.clicks * np.cos(self.clicks * x))
        )

    def energy(self, t, x):
        return self.torque / self.clicks * np.sum(1 - np.cos(self.clicks * x), axis=-1)


class MagneticSpring(Term):
    """A repulsion by the inverse cube of the distance."""

    measures = (Measure(Look.DISTANCE),)
    strength = 1e-4  # N m^3

    def respond(self, t, x, v):
        return Response(-self.strength / x**3, diagonal(3 * self.strength / x**4))

    def energy(self, t, x):
        return self.strength / 2 * np.sum(x**-2, axis=-1)


class Drag(Term):
    """A drag against the square of the velocity of a place."""

    measures = (Measure(Look.PLACE, 0), Measure(Look.PLACE, 1))
    factor = 0.3  # N s^2/m^2

    def respond(self, t, x, v):
        speed = np.linalg.norm(v, axis=-1)[..., None]
        along = v[..., :, None] * v[..., None, :] / np.maximum(speed, 1e-12)[..., None]
        return Response(self.factor * speed * v, by_rate=self.factor * (speed[..., None] * np.eye(2) + along))


def wheel(term, inertia=0.01, arm=0.2, mass=0.5):
    """Give a rigid arm on a pin at the origin, with a term between the ground and a place on it."""
    machine = Machine(PLANE)
    pose = machine.add_pose(np.zeros(2), fixed="place")
    tip = np.array([arm, 0.0])
    machine.masses.add_body(machine.end(pose, tip), mass, np.eye(2) * inertia / 2)
    machine.terms.append(term([(machine.at_ground(np.array([0.5, 0.0])), machine.end(pose, tip))]))
    return machine


@pytest.mark.parametrize("term", [Detent, MagneticSpring, Drag])
def test_a_new_term_is_a_class_whose_power_balances(term):
    """The kinetic energy changes by the power that the term takes, and stored energy comes back."""
    machine = wheel(term)
    rate, inertia = np.array([3.0]), 0.01 + 0.5 * 0.2**2
    course = march(machine, rate, 0.4, h=2e-3)
    spins = np.array([motion.w[1, 0] for motion in course.motion])
    turned = np.array([np.arctan2(motion.R[1][1, 0], motion.R[1][0, 0]) for motion in course.motion])
    kinetic = inertia * spins**2 / 2
    if term is Drag:  # J w' = -c l^3 w^2
        np.testing.assert_allclose(1 / spins - 1 / 3.0, 0.3 * 0.2**3 / inertia * course.t, rtol=1e-6, atol=1e-9)
        return
    distance = np.hypot(0.5 - 0.2 * np.cos(turned), 0.2 * np.sin(turned))
    measured = turned if term is Detent else distance
    stored = term(()).energy(course.t, measured[:, None, None])[:, 0]
    np.testing.assert_allclose(kinetic + stored, kinetic[0] + stored[0], rtol=1e-7)
