"""What holds the ends of elements in space: by the equilibrium of a bent arm, and of inner nodes in motion."""

import numpy as np

from fenics_mech.geometry import SPACE
from fenics_mech.machine import Machine
from fenics_mech.machine.section_forces import end_forces
from fenics_mech.solve import equilibrium, march
from tests.machine.builders import Bar, Members, chain, load

BAR = Bar(1e6, [20.0, 50.0], 1.5, GJ=15.0, rotary=[1e-4, 3e-4])


def held(machine, *motion):
    found = machine.residual(*motion)
    return end_forces(machine.terms[0], machine.groups[0], found.terms[0], found.at)


def test_a_bent_arm_in_space_is_held_by_its_load():
    """Force and moment about each place, where it has moved to; the arm turns by about 1 rad."""
    angle = np.linspace(0, np.pi / 4, 5)
    places = np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1)
    machine, tip = chain(places, BAR, np.array([0.0, 0, 1]))
    push = np.array([3.0, -5.0, 40.0])
    for axis in range(3):
        load(machine, machine.end(tip), axis, push[axis])
    q, a = equilibrium(machine)
    ends = held(machine, np.zeros(1), q[None], np.zeros((1, machine.size)), a[None])
    at = ends.place[0]
    assert np.linalg.norm(q[machine.places[tip, 3:]]) > 0.3
    np.testing.assert_allclose(ends.force[0, :, 1], np.tile(push, (4, 1)), atol=1e-8)
    np.testing.assert_allclose(ends.moment[0, :, 0], -np.cross(at[-1, 1] - at[:, 0], push), atol=1e-7)


def test_inner_nodes_in_motion_need_no_force():
    """A free beam that turns and bends in space: the ends of both elements at a node balance, and so do free ends."""
    machine = Machine(SPACE)
    first, last = machine.add_pose(np.zeros(3)), machine.add_pose(np.array([0.6, 0.1, 0.2]))
    members = Members(machine)
    members.add(first, last, 3, BAR, np.array([0.0, 0, 1]))
    members.done()
    v = np.random.default_rng(3).normal(size=machine.size)
    march(machine, v, 0.02, h=1e-3)  # the chart moves along
    zero = np.zeros((1, machine.size))
    found = machine.residual(np.zeros(1), zero, v[None], zero)
    a = np.linalg.solve(machine.pattern.matrix(found.M[0]).toarray(), -found.force[0])
    ends = held(machine, np.zeros(1), zero, v[None], a[None])
    scale = np.abs(ends.force).max()
    for one, other in ((ends.force, 1.0), (ends.moment, 0.2)):
        np.testing.assert_allclose(one[:, :-1, 1] + one[:, 1:, 0], 0, atol=1e-9 * scale * other)
        np.testing.assert_allclose(one[:, [0, -1], [0, 1]], 0, atol=1e-9 * scale * other)
    assert scale > 1.0
