"""Pins that ride along members that bend: an elastica over a pin, and the passage from element to element."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

from fenics_mech.geometry import PLANE
from fenics_mech.joints import Ride
from fenics_mech.machine import Machine
from fenics_mech.solve import equilibrium, march
from tests.machine.builders import Bar, Members

EI, LENGTH = 0.8, 0.5  # N m^2, m


def strip(count, pin):
    """Build a clamped strip along x that lies on a pin."""
    machine = Machine(PLANE)
    foot = machine.add_pose(np.zeros(2), fixed="place and turn")
    tip = machine.add_pose(np.array([LENGTH, 0.0]))
    members = Members(machine)
    members.add(foot, tip, count, Bar(3e6, [EI], 0.1))
    members.done()
    machine.rides.append(Ride(machine.at_ground(np.asarray(pin)), tuple(members.pairs), name="pin"))
    return machine


def elastica(pin):
    """Give the pin's force: it is normal to the strip there, where no moment is (Frisch-Fay, Flexible Bars, 1962)."""

    def at(unknown):
        force, place, slope = unknown
        push = force * np.array([-np.sin(slope), np.cos(slope)])
        arm = pin[0] * push[1] - pin[1] * push[0]  # moment at the foot

        def along(s, y):
            return [(arm - y[1] * push[1] + y[2] * push[0]) / EI, np.cos(y[0]), np.sin(y[0])]

        return solve_ivp(along, (0, place), [0, 0, 0], rtol=1e-11, atol=1e-13).y[:, -1]

    first = [3 * EI * pin[1] / pin[0] ** 3, np.hypot(*pin), 1.5 * pin[1] / pin[0]]
    return fsolve(lambda x: at(x) - [x[2], *pin], first, xtol=1e-12)[0]


@pytest.mark.parametrize("pin", [(0.4, 0.02), (0.3, 0.1), (0.33, -0.08)])
@pytest.mark.parametrize(("count", "bound"), [(4, 1.5e-3), (8, 2e-4), (16, 4e-6)])
def test_a_strip_over_a_pin_bends_as_the_elastica(pin, count, bound):
    """The pin presses inside an element, whose moment then has a corner that its strains do not have."""
    machine = strip(count, pin)
    _, a = equilibrium(machine)
    assert a[machine.n] == pytest.approx(elastica(pin), rel=bound)


def test_a_pin_goes_from_element_to_element_without_a_jump():
    """Beside a node its force varies as fast as inside an element, by 3 dx/x of a cantilever."""
    forces = []
    for place in (0.22, LENGTH / 2):
        sides = [equilibrium(strip(4, (place + side, 0.03)))[1][-1] for side in (-1e-5, 1e-5)]
        forces.append((sides[1] - sides[0]) / 2e-5 * place / sides[0])
    assert forces == pytest.approx([-3.0, -3.0], abs=0.15)  # of the deflection, 0.03 of 0.25 m, and of the mesh


def energy(machine, v):
    """Give the energy in the machine's chart (J)."""
    zero = np.zeros((1, machine.size))
    found = machine.residual(np.zeros(1), zero, zero, zero)
    M = machine.pattern.matrix(found.M[0])[: machine.n, : machine.n]
    stored = sum(float(term.energy(np.zeros(1), x.x).sum()) for term, x in zip(machine.terms, found.terms))
    return float(v[: machine.n] @ M @ v[: machine.n]) / 2 + stored


def test_a_bead_that_runs_along_a_shaking_strip_keeps_the_energy():
    """It passes three nodes. Its steps damp what is faster than they are, of 2 % that the strip has."""
    machine = strip(4, (0.1, 0.0))
    bead = machine.add_pose(np.array([0.1, 0.0]), fixed="turn")
    machine.masses.add_body(machine.end(bead), 0.05, np.zeros((2, 2)))
    machine.rides[0] = Ride(machine.end(bead), machine.rides[0].elements)
    v = np.zeros(machine.size)
    v[machine.places[bead, 0]] = 3.0
    v[machine.places[[2, 5, 4], 1]] = 1.0, 0.5, 0.2  # tip, and inner nodes beyond the bead's element
    first = energy(machine, v)
    last = march(machine, v, 0.1, h=1e-3).motion[-1]
    assert last.r[bead, 0] == pytest.approx(0.4, abs=0.01)
    moving = machine.places >= 0
    v[machine.places[moving]] = np.concatenate([last.v, last.w], axis=1)[moving]
    assert energy(machine, v) == pytest.approx(first, rel=1e-4)
