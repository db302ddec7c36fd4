"""What a contributor might add, each of a few lines: terms, whose power balances, and a quantity of a cycle."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import simpson

from fenics_mech.geometry import PLANE, SPACE, End, Rest, harmonics
from fenics_mech.machine import Machine
from fenics_mech.solve import frequencies, march, periodic, tangents_at
from fenics_mech.terms import Element, Look, Measure, Response, Spring, Term, hermite_mass
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


class LineDrag(Term):
    """A drag per length along beams, c v: the frame and both ends of an element, written as pairs of places.

    Its power is a quadratic form in the rates of four places of each element, two on each first axis. So it is a sum
    of squares of the rates between them and to the ground; some have a factor below 0, but never their sum.
    """

    def __init__(self, beams, ground, factor):
        pairs, factors = [], []
        for ends, element in zip(beams.pairs, beams.elements):
            reach = element.length
            places = [p for e in ends for p in (e, End(e.pose, e.offset + reach * e.turn[:, 0], e.turn))]
            by_places = np.kron(np.eye(2), [[1, 0], [-1 / reach, 1 / reach]])  # places and first axes by the four
            form = by_places.T @ hermite_mass(reach, factor) @ by_places
            between = list(zip(*np.triu_indices(4, 1)))
            pairs += [*((ground, place) for place in places), *((places[i], places[j]) for i, j in between)]
            factors += [*form.sum(axis=1), *(-form[i, j] for i, j in between)]
        super().__init__(pairs)
        self.measures = tuple(Measure(Look.PLACE, i) for i in range(len(ground.offset)))
        self.factors = np.array(factors)[:, None]

    def respond(self, t, x, v):
        return Response(self.factors * v, by_rate=diagonal(np.broadcast_to(self.factors, x.shape)))


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


LINE_MASS, LINE_DRAG = 0.4, 0.6  # kg/m, N s/m^2


def dragged(g, count, fixed=""):
    """Give a beam of 0.5 m that air drags."""
    machine = Machine(g)
    places = [np.eye(g.d)[0] * x for x in np.linspace(0, 0.5, count + 1)]
    poses = [machine.add_pose(place, fixed="" if k else fixed) for k, place in enumerate(places)]
    bar = Element.uniform(0.5 / count, 1e5, [2.0, 3.0][: g.d - 1], 1.5, LINE_MASS)
    machine.add_beams([(machine.end(a), machine.end(b)) for a, b in pairwise(poses)], [bar] * count)
    machine.terms.append(LineDrag(machine.terms[0], machine.at_ground(), LINE_DRAG))
    return machine


def energies(machine, motion):
    """Give the kinetic energy of a motion and the stored one (J)."""
    machine.chart, zero = Rest(machine.geometry, motion.r, motion.R), np.zeros((1, machine.size))
    found, rates = machine.residual(np.zeros(1), zero, zero, zero), np.zeros(machine.size)
    moving = machine.places >= 0
    rates[machine.places[moving]] = np.concatenate([motion.v, motion.w], axis=1)[moving]
    stored = sum(float(term.energy(np.zeros(1), x.x).sum()) for term, x in zip(machine.terms, found.terms))
    return rates @ machine.pattern.matrix(found.M[0]) @ rates / 2, stored


@pytest.mark.parametrize("g", [PLANE, SPACE], ids=lambda g: g.name)
def test_a_drag_that_is_spread_as_the_mass_damps_all_modes_at_one_rate(g):
    """All go with exp(-c t/(2 m))."""
    machine = dragged(g, 3, fixed="place and turn")
    rates, _ = frequencies(*tangents_at(machine, np.zeros(machine.size), np.zeros(machine.size)), 4)
    np.testing.assert_allclose(rates.real, -LINE_DRAG / LINE_MASS / 2, rtol=1e-6)
    assert (rates.imag > 30).all()


def test_a_beam_that_flies_and_bends_loses_what_the_drag_takes():
    """Its power is 2 c/m times the kinetic energy, that of bending and turning too."""
    machine = dragged(PLANE, 2)
    course = march(machine, np.random.default_rng(1).normal(size=machine.size), 2e-3, h=2e-5)
    kinetic, stored = np.array([energies(machine, motion) for motion in course.motion]).T
    lost = 2 * LINE_DRAG / LINE_MASS * simpson(kinetic, x=course.t)
    assert stored.max() > 0.1 * kinetic[0]
    # the steps damp the fastest waves by 2e-6 of what the drag takes
    assert kinetic[0] + stored[0] - kinetic[-1] - stored[-1] == pytest.approx(lost, rel=1e-5)


def jerk(cycle, end):
    """Give instants (s) and the jerk of an end ``(steps, d)`` (m/s^3): the third rate of the harmonics of its place."""
    t, q, v, a = (x[:, 0] for x in cycle.path.at(np.zeros(1)))
    at = cycle.machine.residual(t, q, v, a, tangents=False).at
    place = at.r[:, end.pose] + at.R[:, end.pose] @ end.offset
    rates, sizes = harmonics(place, cycle.path.period)
    return t, np.tensordot(np.exp(np.outer(t, rates)) * rates**3, sizes, 1).real


def test_a_quantity_of_a_cycle_is_a_function_of_its_path():
    """A mass on a spring whose other end is shaken by A cos wt: its jerk is w^3 A k/(k - m w^2) sin wt."""
    w, size, stiffness, mass, errors = 20.0, 0.01, 900.0, 1.0, []

    def shaken(t):
        x, v = (np.stack([size * wave, 0 * t], axis=1) for wave in (np.cos(w * t), -w * np.sin(w * t)))
        return x, np.eye(2), v, 0.0, -(w**2) * x, 0.0

    machine = Machine(PLANE)
    base = machine.add_pose(np.zeros(2), led=shaken)
    block = machine.end(machine.add_pose(np.array([0.5, 0.0]), fixed="turn"))
    machine.masses.add_body(block, mass, np.zeros((2, 2)))
    machine.join("slot", (machine.at_ground(), block))
    machine.terms.append(Spring([(machine.end(base), block)], stiffness, 0.5))
    for steps in (20, 40):
        t, found = jerk(periodic(machine, 2 * np.pi / w, steps), block)
        exact = w**3 * size * stiffness / (stiffness - mass * w**2) * np.sin(w * t)
        errors.append(np.abs(found[:, 0] - exact).max() / np.abs(exact).max())
    assert errors[1] < 1e-7
    assert np.log2(errors[0] / errors[1]) > 4.5  # 5 by Radau IIA of 3 stages
