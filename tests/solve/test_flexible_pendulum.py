"""A double pendulum of two bars that bend, let go from the horizontal: large turns, fast waves, nothing that damps."""

import numpy as np
import pytest

from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine
from fenics_mech.solve import march
from tests.machine.builders import Bar, Members

# Exudyn 1.13.6, 4 cable elements (ANCF) a bar, 2000 steps of generalized alpha with a spectral radius of 0.9. With 1000
# steps it is 6e-5 m away. With 8 elements its Newton's method fails at 4000 steps, and 2000 are 1e-3 m away.
JOINT, TIP = (-0.48816902, -0.10812492), (-0.96543327, 0.04093479)


def after_one_second(elements, tolerance, inner=0):
    E, b, h, rho, L = 210e9, 0.01, 0.003, 7850.0, 0.5
    machine, axes = Machine(PLANE, [0, -9.81]), np.eye(2)
    top = machine.add_pose(np.zeros(2), axes, fixed="place")
    one = machine.add_pose(np.array([L, 0.0]), axes)
    other = machine.add_pose(np.array([L, 0.0]), axes, shared=one)
    tip = machine.add_pose(np.array([2 * L, 0.0]), axes)
    members, bar = Members(machine), Bar(E * b * h, [E * b * h**3 / 12], rho * b * h)
    members.add(top, one, elements, bar, inner=inner)
    members.add(other, tip, elements, bar, inner=inner)
    members.done()
    course = march(machine, np.zeros(machine.size), 1.0, tolerance=tolerance)
    return course.motion[-1].r[one], course.motion[-1].r[tip]


@pytest.mark.slow
def test_a_flexible_double_pendulum_falls_as_in_another_program():
    joint, tip = after_one_second(4, 1e-5)
    finer_joint, finer_tip = after_one_second(4, 1e-6)
    np.testing.assert_allclose([joint, tip], [finer_joint, finer_tip], atol=2e-4)  # m
    np.testing.assert_allclose([finer_joint, finer_tip], [JOINT, TIP], atol=1e-3)


@pytest.mark.slow
def test_it_falls_the_same_by_one_element_a_bar_with_places_inside():
    np.testing.assert_allclose(after_one_second(1, 1e-5, inner=2), after_one_second(4, 1e-5), atol=1e-5)  # m
