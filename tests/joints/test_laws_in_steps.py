"""Laws of joints in the march of poses: rates after contacts against closed forms, by the tolerance of its steps."""

import numpy as np
import pytest

from fenics_mech.in_time_by_poses import _start
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.kinematics.free_linkage import with_freedoms
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import steps_in_time
from tests.joints.test_contacts import FLOOR, ball, rattling


def followed(scene, times, **chosen):
    """Give places and rates of the first link at the ends of all steps, and the terms of its laws."""
    made = machine_of(with_freedoms(scene))
    found = []
    for step in steps_in_time(made.machine, _start(made), times, **chosen):
        end = step.at_end()
        found.append((end.t[0], *end.motion.r[0, 1], *end.motion.v[0, 1]))
    return np.array(found), [term for term in made.machine.terms if isinstance(term, LawTerm)]


@pytest.mark.parametrize(("restitution", "exponent"), [(0.9, 1.5), (0.5, 1.5), (0.2, 1.0), (1.0, 2.0)])
@pytest.mark.parametrize("share", [1e-3, 1e-6])
def test_a_ball_leaves_the_floor_at_the_stated_speed(restitution, exponent, share):
    """The rate that a contact leaves is as exact as the steps are told to be, by one force law or the other."""
    contact = {"stiffness": 1e7, "restitution": restitution, "exponent": exponent}
    scene = ball(FLOOR | {"contact": contact}, gravity=(0, 0), freedoms={"G": {"start": 0.1, "speed": -1.0}})
    found, (law,) = followed(scene, np.array([0.0, 0.3]), tolerance=1e-7, share=share)
    assert law.closings == 1
    assert found[-1, 3] == pytest.approx(restitution, abs=share)
    assert len(found) < 25 + 2 * share ** (-1 / 4)  # order 4 of the force's start with d^1.5


def test_steps_end_where_a_contact_closes_and_opens():
    """An elastic floor of exponent 1 is half a vibration: pi sqrt(m/K) after it is met."""
    scene = ball(
        FLOOR | {"contact": {"stiffness": 1e5, "exponent": 1.0}},
        gravity=(0, 0),
        freedoms={"G": {"start": 0.1, "speed": -1.0}},
    )
    found, (law,) = followed(scene, np.array([0.0, 0.3]), tolerance=1e-9, share=1e-7)
    met, left = law._since[1:]
    assert met == pytest.approx(0.1, abs=1e-12)
    assert left - met == pytest.approx(np.pi * np.sqrt(0.5 / 1e5), rel=1e-7)
    assert {met, left} <= set(found[:, 0])
    assert found[-1, 1] == pytest.approx(0.3 - left, abs=1e-8)


@pytest.mark.slow  # 300 steps
def test_rates_after_a_step_are_those_that_rows_allow():
    """A crank with a loose pin: short steps in contacts meet what longer ones before them left over."""
    scene = rattling(0.0)
    times = np.linspace(0.0, scene.period / 10, 5)
    coarse, fine = (followed(scene, times, tolerance=1e-10, share=share)[0][-1] for share in (1e-5, 1e-7))
    np.testing.assert_allclose(coarse, fine, atol=1e-5)
