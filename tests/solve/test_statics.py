"""Equilibrium, buckling and large rotations against closed forms and an own rod program."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, fsolve

from fenics_mech.errors import SolverError
from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine, Row
from fenics_mech.solve import equilibrium, frequencies, tangents_at
from fenics_mech.terms import Look, Measure
from tests.common import ROOT
from tests.machine.builders import STEEL, Bar, Members, chain, load

REFERENCE = ROOT / "tests" / "data" / "spatial" / "statics_reference.npz"
FOOT, WIDTH, HEIGHT = 0.2, 0.02, 0.003  # m: of the column with a rigid arm
EI = STEEL * WIDTH * HEIGHT**3 / 12
CRITICAL = brentq(lambda x: x * np.tan(x) - 1, 0.1, 1.5) ** 2 * EI / FOOT**2  # k b tan(k a) = 1, b = a


def column(count, force, side=0.0, inner=0):
    """Build a clamped column with a rigid arm as long on top, pressed there and pushed aside; give its tip's pose."""
    machine = Machine(PLANE)
    foot = machine.add_pose(np.zeros(2), fixed="place and turn")
    tip = machine.add_pose(np.array([FOOT, 0.0]))
    members = Members(machine)
    members.add(foot, tip, count, Bar(STEEL * WIDTH * HEIGHT, [EI], 7850 * WIDTH * HEIGHT), inner=inner)
    members.done()
    top = machine.end(tip, np.array([2 * FOOT, 0.0]))
    machine.masses.add_body(machine.end(tip), 0.01, np.zeros((2, 2)))
    load(machine, top, 0, -force)
    load(machine, top, 1, side)
    return machine, tip


def softest(machine):
    """Give the least square of a frequency, which is 0 at the buckling load."""
    M, _, K = tangents_at(machine, *equilibrium(machine))
    return -float((frequencies(M, None, K, 1)[0][0] ** 2).real)


@pytest.mark.parametrize(("count", "bound"), [(1, 8e-4), (2, 6e-5), (4, 8e-6)])
def test_a_column_with_a_rigid_arm_buckles_at_its_load(count, bound):
    found = brentq(lambda force: softest(column(count, force)[0]), 0.7 * CRITICAL, 1.6 * CRITICAL, xtol=1e-9 * CRITICAL)
    assert abs(found / CRITICAL - 1) < bound  # 4e-6 of it is axial shortening, which the closed form leaves out


@pytest.mark.parametrize(("share", "deflection"), [(0.5, 1.214e-4), (0.9, 1.078e-3)])
def test_a_pressed_column_with_a_rigid_arm_bends_as_the_beam_column(share, deflection):
    """The deflections are those of the closed form of a beam column, printed with four digits."""
    machine, tip = column(4, share * CRITICAL, 1e-3 * share * CRITICAL)
    q, _ = equilibrium(machine)
    assert q[machine.places[tip, 1]] == pytest.approx(deflection, rel=5e-4)


def test_an_unloaded_machine_that_cannot_meet_its_rows_is_refused():
    machine = Machine(PLANE)
    pose = machine.add_pose(np.zeros(2), fixed="place")
    far = machine.end(pose, np.array([1.0, 0.0]))
    machine.rows += [Row((machine.at_ground(np.array([3.0, 0.0])), far), Measure(Look.PLACE, 0))]
    with pytest.raises(SolverError, match=r"has not converged|singular"):
        equilibrium(machine)


def test_a_guide_turns_and_moves_with_the_member_that_carries_it():
    """A clamped strip whose tip slides in a guide of a pinned, loaded arm: against an own inextensible elastica."""
    length, back, force, pivot, start = 0.093, 0.1127, 20.0, np.array([0.276, -0.01]), 2.2
    modulus, width, height = 2.9e9, 0.0191, 0.006
    stiffness = modulus * width * height**3 / 12
    tip = length * np.array([np.cos(start), np.sin(start)])
    rest = np.arctan2(*(tip - pivot)[::-1])

    def elastica(unknown):
        """Bend the strip by its root's moment and the guide's force, normal to the arm at some angle."""
        moment, guide, arm = unknown
        push = guide * np.array([-np.sin(arm), np.cos(arm)])

        def along(s, y):
            return [y[1] / stiffness, push[0] * np.sin(y[0]) - push[1] * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

        end = solve_ivp(along, (0, length), [start, moment, 0, 0], rtol=1e-12, atol=1e-14).y[:, -1]
        way = end[2:] - pivot
        missed = np.sin(arm - np.arctan2(way[1], way[0]))
        return [end[1], force * back * np.cos(arm) - guide * np.hypot(*way), missed], end[2:]

    first = [0.0, force * back * np.cos(rest) / np.hypot(*(tip - pivot)), rest]
    found = fsolve(lambda unknown: elastica(unknown)[0], first, xtol=1e-13)
    guide, end = found[1], elastica(found)[1]
    machine = Machine(PLANE)
    axes, along = PLANE.axes(tip), PLANE.axes(tip - pivot)
    foot = machine.add_pose(np.zeros(2), axes, fixed="place and turn")
    at, arm = machine.add_pose(tip, axes), machine.add_pose(pivot, along, fixed="place")
    members = Members(machine)  # EA a thousand times as large: the elastica does not stretch
    members.add(foot, at, 4, Bar(1e3 * modulus * width * height, [stiffness], 0.16))
    members.done()
    machine.rows.append(Row((machine.end(arm), machine.end(at)), Measure(Look.ALONG, 1)))
    load(machine, machine.end(arm, pivot - back * along[:, 0]), 1, -force)
    q, a = equilibrium(machine)
    moved = q[machine.places[at, :2]]
    assert abs(a[machine.n]) == pytest.approx(abs(guide), rel=1e-6)  # the gate: 4e-7 with one element and 1e-9 stretch
    np.testing.assert_allclose(moved, end - tip, atol=2e-5 * np.hypot(*(end - tip)))  # of the mesh: h^4


def test_the_45_degree_bend_is_met_in_one_load_step_with_order_2():
    """Bathe and Bolourchi's bend, by an own rod program: straight elements along an arc leave an error of h^2."""
    tip, errors = np.load(REFERENCE)["bend45_600"], []
    for count in (4, 8):
        angle = np.linspace(0, np.pi / 4, count + 1)
        places = 100 * np.stack([1 - np.cos(angle), np.sin(angle), 0 * angle], axis=-1)
        machine, pose = chain(places, Bar(1e7, [1e7 / 12] * 2, 1.0, 0.5e7 * 0.140577), np.array([0, 0, 1.0]))
        load(machine, machine.end(pose), 2, 600.0)
        q, _ = equilibrium(machine)
        errors.append(np.linalg.norm(places[-1] + q[machine.places[pose, :3]] - tip) / np.linalg.norm(tip - places[-1]))
    assert errors[0] < 5e-3
    assert errors[1] < 1.3e-3
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(("force", "degrees"), [(8.896, 30), (13.345, 60)])
def test_the_princeton_beam_bends_and_twists_as_a_rod(force, degrees):
    """Dowell and Traybar's cantilever, turned about its axis and loaded at its tip: against an own rod program."""
    length, high, thin, E = 0.508, 12.77e-3, 3.2024e-3, 71.7e9
    torsion = high * thin**3 / 3 * (1 - 0.630 * thin / high + 0.052 * (thin / high) ** 5)
    bar = Bar(E * high * thin, [E * thin * high**3 / 12, E * high * thin**3 / 12], 1.0, E / 2.62 * torsion)
    errors, exact = [], np.load(REFERENCE)[f"princeton_{force}_{degrees}"][:3]
    for count in (2, 4):
        machine, pose = chain(np.linspace([0, 0, 0], [length, 0, 0], count + 1), bar, np.array([0, 1.0, 0]))
        for axis, share in ((1, np.cos), (2, np.sin)):
            load(machine, machine.end(pose), axis, force * share(np.radians(degrees)))
        q, _ = equilibrium(machine)
        errors.append(np.linalg.norm(q[machine.places[pose, :3]] - exact) / np.linalg.norm(exact))
    assert errors[1] < 1e-4
    assert np.log2(errors[0] / errors[1]) > 3.3  # order 4 in the limit, with the twist inside elements
