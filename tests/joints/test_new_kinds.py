"""A kind of joint that a contributor might add, as in `docs/theory/machines_of_poses.md`: a list of what it holds."""

import numpy as np

from fenics_mech.geometry import SPACE
from fenics_mech.joints import IN_SPACE, Kind
from fenics_mech.machine import Machine, mobility
from fenics_mech.solve import march
from fenics_mech.terms import Look, Measure


def trolley(g):
    """Hold a place in a plane, and a hinge parallel to it, along the first axis of the second end."""
    return Kind((Measure(Look.ALONG, 2), Measure(Look.ALIGNED, 2, 0)), {"angle": Measure(Look.ANGLE)})


def test_a_body_that_hangs_from_a_trolley_turns_steadily(monkeypatch):
    """Its centre rests; m g l = (Z - Y) W^2 cos(a), with the moments of its mass along the rod (Z) and across (Y)."""
    monkeypatch.setitem(IN_SPACE, "trolley", trolley)
    table = SPACE.axes(np.array([1.0, 2.0, -0.5]), np.array([0.3, 0.2, 1.0]))
    mass, arm, lean, tensor, up = 2.0, 0.4, 0.9, np.array([0.3, 0.2, 0.4]), table[:, 2]
    pivot, axes = np.array([0.2, -0.1, 0.3]), SPACE.about(table[:, 0], lean) @ table
    machine = Machine(SPACE, -9.81 * up)
    centre = pivot - arm * axes[:, 2]
    body = machine.add_pose(centre, axes)
    machine.masses.add_body(machine.end(body), mass, np.diag(tensor))
    machine.join("trolley", (machine.at_ground(pivot, table), machine.end(body, pivot, axes)))
    assert mobility(machine).freedoms == 4
    speed = np.sqrt(mass * 9.81 * arm / ((tensor[2] - tensor[1]) * np.cos(lean)))
    rates = np.zeros(machine.size)
    rates[machine.places[body]] = [0, 0, 0, *(speed * up)]
    course = march(machine, rates, 0.6, h=0.01)
    for t, motion in zip(course.t, course.motion):
        np.testing.assert_allclose(motion.r[body], centre, atol=1e-9)
        np.testing.assert_allclose(motion.R[body], SPACE.about(up, speed * t) @ axes, atol=1e-8)
    np.testing.assert_allclose(course.multipliers[-1], [-mass * 9.81, 0], atol=1e-5)  # minus what bears the body
