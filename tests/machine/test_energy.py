"""Energy of motions against closed forms of a bar that turns."""

import numpy as np

from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine
from fenics_mech.machine.assembly import closed, rates_of
from fenics_mech.machine.energy import energy_of_weight, kinetic_energy
from fenics_mech.machine.motion import Motion
from tests.machine.builders import Bar, Members

LENGTH, LINE_MASS, SPIN, BODY, GRAVITY = 0.7, 1.3, 5.0, 0.4, 9.81


def turning():
    """Give a bar that turns about the origin, with a body at its tip."""
    machine = Machine(PLANE, [0, -GRAVITY])
    top = machine.add_pose(np.zeros(2), fixed="place")
    tip = machine.add_pose(np.array([LENGTH, 0.0]))
    members = Members(machine)
    members.add(top, tip, 3, Bar(1e7, [1e3], LINE_MASS))
    members.done()
    machine.masses.add_body(machine.end(tip), BODY, np.eye(2) * 0.01)
    angle, radius = 0.6, np.array(machine.r)[:, 0]
    q, v = np.zeros((2, 1, machine.size))
    moved = (
        radius[:, None] * [np.cos(angle) - 1, np.sin(angle)],
        radius[:, None] * SPIN * np.array([-np.sin(angle), np.cos(angle)]),
    )
    for pose, places in enumerate(machine.places):
        for values, of_place, of_turn in ((q, moved[0], angle), (v, moved[1], SPIN)):
            there = places >= 0
            values[0, places[there]] = np.append(of_place[pose], of_turn)[there]
    return Motion(machine, np.zeros(1), q, v, 0 * q), angle


def test_kinetic_energy_is_that_of_the_moment_of_inertia():
    motion, _ = turning()
    inertia = LINE_MASS * LENGTH**3 / 3 + BODY * LENGTH**2 + 0.02
    np.testing.assert_allclose(kinetic_energy(motion), inertia * SPIN**2 / 2, rtol=1e-12)


def test_it_is_half_of_the_rates_times_the_mass_of_the_residual():
    motion, _ = turning()
    of_mass = motion.machine.pattern.times(motion.with_tangents.M, motion.v)
    np.testing.assert_allclose(kinetic_energy(motion), np.sum(motion.v * of_mass) / 2, rtol=1e-12)


def test_energy_of_weight_goes_with_the_height_of_the_mass():
    motion, angle = turning()
    moment = LINE_MASS * LENGTH**2 / 2 + BODY * LENGTH
    np.testing.assert_allclose(energy_of_weight(motion), GRAVITY * moment * np.sin(angle), rtol=1e-12)


def test_rates_of_bodies_are_those_of_a_slider_crank():
    """Crank r, rod l, slider on the x axis: x = r cos a + sqrt(l^2 - r^2 sin^2 a), and its derivatives."""
    r, rod, speed, spin_up = 0.3, 1.1, 2.0, 3.0
    machine = Machine(PLANE)
    crank, coupler = machine.add_pose(np.zeros(2)), machine.add_pose(np.array([r, 0.0]))
    slider = machine.add_pose(np.array([r + rod, 0.0]))
    machine.join("revolute", (machine.at_ground(), machine.end(crank)))
    machine.join("revolute", (machine.end(crank, np.array([r, 0.0])), machine.end(coupler)))
    machine.join("revolute", (machine.end(coupler, np.array([r + rod, 0.0])), machine.end(slider)))
    machine.join("prismatic", (machine.at_ground(), machine.end(slider)))
    machine.drive("revolute", "angle", (machine.at_ground(), machine.end(crank)), lambda t: 0.8 + 0 * t)
    angles = np.array([0.8])

    q, gaps = closed(machine, np.zeros(1), np.zeros((1, machine.size)))
    assert gaps.max() < 1e-12
    first, second = np.zeros((2, 1, len(machine.rows)))
    first[:, -1], second[:, -1] = speed, spin_up
    v, a = rates_of(machine, np.zeros(1), q, first, second)

    def place(angle):
        return r * np.cos(angle) + np.sqrt(rod**2 - r**2 * np.sin(angle) ** 2)

    step = 1e-4
    slope = (place(angles + step) - place(angles - step)) / (2 * step)
    bend = (place(angles + step) - 2 * place(angles) + place(angles - step)) / step**2
    x = machine.places[slider, 0]
    np.testing.assert_allclose(v[:, x], slope * speed, rtol=1e-7)
    np.testing.assert_allclose(a[:, x], slope * spin_up + bend * speed**2, rtol=1e-6)
