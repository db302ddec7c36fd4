"""Derivatives of motions, multipliers and static answers against closed forms of oscillators."""

import numpy as np
import pytest

from fenics_mech.errors import DerivativeError
from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine
from fenics_mech.solve import (
    Beside,
    Cycle,
    cycle_change,
    equilibrium,
    periodic,
    rest_change,
    running_change,
    running_modes,
)
from fenics_mech.solve.statics import stiffness
from fenics_mech.terms import Damper, DeadLoad, Look, Spring

INERTIA, MOMENT, SPEED, STEP = 0.02, 0.3, 5.0, 1e-4


def rotors(omega, zeta=0.05, speed=SPEED):
    """Rotors on torsional springs and dampers, each turned by a moment of one harmonic."""
    machine = Machine(PLANE)
    for rate in omega:
        end = machine.end(machine.add_pose(np.zeros(2), fixed="place"))
        pair = [(machine.at_ground(), end)]
        machine.masses.add_body(end, 1.0, np.eye(2) * INERTIA / 2)
        machine.terms.append(Spring(pair, INERTIA * rate**2, 0.0, Look.ANGLE))
        machine.terms.append(Damper(pair, 2 * zeta * INERTIA * rate, Look.ANGLE))
        machine.terms.append(DeadLoad(*pair[0], None, lambda t: MOMENT * np.cos(speed * t)))
    return machine


def response(omega, zeta, speed, t):
    """Angle of a rotor in closed form."""
    omega = np.array(omega)
    return np.real(MOMENT / INERTIA / (omega**2 - speed**2 + 2j * zeta * omega * speed) * np.exp(1j * speed * t))


def sides(omega, more, zeta=0.05, pace=0.0):
    """Machines on both sides, whose frequencies and drives are a step faster and slower."""
    return [
        Beside(
            rotors(np.array(omega) + sign * STEP * np.array(more), zeta, SPEED * (1 + sign * STEP * pace)),
            1 + sign * STEP * pace,
        )
        for sign in (1.0, -1.0)
    ]


@pytest.mark.parametrize(("more", "pace"), [((1.0, -2.0), 0.0), ((0.0, 0.0), 1.0)])
def test_a_forced_vibration_has_the_derivatives_of_the_closed_form(more, pace):
    omega, zeta = np.array([7.0, 3.0]), 0.05
    cycle = periodic(rotors(omega), 2 * np.pi / SPEED, 60)
    change = cycle_change(cycle, *sides(omega, more, pace=pace))
    angles = SPEED * cycle.path.starts[:, None]
    ahead, behind = (
        response(
            omega + s * STEP * np.array(more),
            zeta,
            SPEED * (1 + s * STEP * pace),
            angles / SPEED / (1 + s * STEP * pace),
        )
        for s in (1, -1)
    )
    exact = (ahead - behind) / 2
    np.testing.assert_allclose(change.q0[:, :2], exact, atol=1e-6 * np.abs(exact).max())


@pytest.mark.parametrize("pace", [0.0, 1.0])
def test_a_vibration_that_decays_has_the_derivatives_of_the_closed_form(pace):
    """log(mu) = (-zeta + i sqrt(1 - zeta^2)) omega T; steps of 1/160 change it by less than 1e-7."""
    omega, more, zeta = np.array([2.0, 4.1]), np.array([0.3, -0.2]), 0.02  # the second turns by more than half
    period = 2 * np.pi / SPEED
    cycle = periodic(rotors(omega, zeta), period, 160)
    both = sides(omega, more, zeta, pace)
    change, running = cycle_change(cycle, *both), running_modes(cycle)
    found = [
        (other, Cycle(other.machine, other.path(cycle.path.moved(change, sign)), []))
        for other, sign in zip(both, (1.0, -1.0))
    ]
    changes = running_change(cycle, running, *found)
    rate = -zeta + 1j * np.sqrt(1 - zeta**2)
    exact = rate * (more - pace * omega)[running.modes] * STEP * period
    exact = np.where(
        np.abs(np.angle(np.exp(rate * omega * period))[running.modes] - np.angle(running.multipliers)) < 1e-6,
        exact,
        exact.conj(),
    )
    np.testing.assert_allclose(changes, exact, rtol=1e-6)
    ahead, behind = (running.changed(s * changes, period, period / (1 + s * STEP * pace)).rates for s in (1, -1))
    np.testing.assert_allclose((ahead - behind) / (2 * STEP), (rate * more)[running.modes], rtol=1e-5)


def test_multipliers_that_are_alike_have_no_derivatives():
    for omega, zeta, said in (([2.0, 2.0], 0.05, "one of several that are alike"), ([0.5], 1.0, "alike|meets another")):
        cycle, both = periodic(rotors(omega, zeta), 2 * np.pi / SPEED, 40), sides(omega, np.ones(len(omega)), zeta)
        found = [(other, Cycle(other.machine, other.path(cycle.path), [])) for other in both]
        with pytest.raises(DerivativeError, match=said):
            running_change(cycle, running_modes(cycle), *found)


def test_a_static_answer_has_the_derivative_of_the_closed_form():
    omega = np.array([7.0])
    machine = rotors(omega)
    q, a = (x[None] for x in equilibrium(machine))
    zero = np.zeros_like(q)
    values = stiffness(machine, machine.residual(np.zeros(1), q, zero, a))
    dq, _ = rest_change(machine, np.zeros(1), q, a, *sides(omega, [1.0]), values, True)
    assert dq[0, 0] == pytest.approx(-2 * MOMENT / INERTIA / omega[0] ** 3 * STEP, rel=1e-7)
