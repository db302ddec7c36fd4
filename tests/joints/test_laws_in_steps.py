"""Laws of joints in the march of poses: rates after contacts against closed forms, by the tolerance of its steps."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.in_time_by_poses import _start
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.kinematics.free_linkage import with_freedoms
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import steps_in_time
from tests.joints.scenes import G, bar, block
from tests.joints.test_bending import slider_crank
from tests.joints.test_contacts import FLOOR, ball, rattling

RUBS = {"kind": "friction", "coefficient": 0.2}


def followed(scene, times, link=0, **chosen):
    """Give places and rates of a link at the ends of all steps, and the terms of its laws."""
    made = machine_of(with_freedoms(scene))
    found = []
    for step in steps_in_time(made.machine, _start(made), times, **chosen):
        end = step.at_end()
        found.append((end.t[0], *end.motion.r[0, 1 + link], *end.motion.v[0, 1 + link]))
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


@pytest.mark.slow
@pytest.mark.long  # 800 steps
def test_rates_after_a_step_are_those_that_rows_allow():
    """Else short steps in the contacts of a loose pin meet what longer ones left over, and shrink without end."""
    scene = rattling(0.0)
    times = np.linspace(0.0, scene.period / 5, 5)
    coarse, fine = (followed(scene, times, 2, tolerance=1e-10, share=share)[0] for share in (1e-5, 1e-6))
    assert len(coarse) < len(fine) < 600
    np.testing.assert_allclose(coarse[-1, 1], fine[-1, 1], atol=1e-8)
    np.testing.assert_allclose(coarse[-1, 3], fine[-1, 3], atol=1e-4)


def test_a_block_that_coasts_stops_where_its_energy_ends():
    """v^2/(2 mu g): then it rests, and the steps grow to as long as they may be."""
    scene = block(RUBS, spring=None, freedoms={"G": {"speed": 1.0}})
    found, _ = followed(scene, np.array([0.0, 20.0]), tolerance=1e-9, longest=1.0)
    assert found[-1, 1] == pytest.approx(1 / (2 * 0.2 * G), abs=1e-8)
    rests = found[found[:, 0] > 1 / (0.2 * G) + 1e-6]
    assert np.ptp(rests[:, 1]) < 1e-12
    assert len(found) < 60


def test_a_block_that_sticks_creeps_by_its_width_alone():
    """It goes with w arctanh(tan(15 deg)/mu) for 20 s, by the law that the scene states."""
    scene = fm.load("tests/cases/scenes/sticking_block.toml")
    found, _ = followed(scene, np.linspace(0.0, 20.0, 101), tolerance=1e-7)
    creep = 1e-8 * np.arctanh(np.tan(np.radians(15)) / 0.4) * 20
    assert np.hypot(*found[-1, 1:3]) < 1.01 * creep


def test_a_block_between_stick_and_slip_goes_as_its_piecewise_closed_form():
    """Each half of a swing ends by 2 mu m g/k nearer to the middle, until the spring cannot move the block any more."""
    spring, shift = 100.0, 0.2 * G / 100
    half = np.pi / np.sqrt(spring)
    changes = {"freedoms": {"G": {"start": 0.15}}, "springs.s.length": 1.0, "analysis.duration": 5 * half}
    scene = block(RUBS | {"width": 1e-8}, **changes)
    found, _ = followed(scene, np.linspace(0.0, 5 * half, 41), tolerance=1e-9)
    t, place = found[:, 0], found[:, 1]
    expected, start, sign = np.empty_like(t), 0.15, 1.0
    for k in range(5):
        inside = (t >= k * half - 1e-12) & (t <= (k + 1) * half + 1e-12)
        expected[inside] = sign * shift + (start - sign * shift) * np.cos(np.sqrt(spring) * (t[inside] - k * half))
        start, sign = -(start - 2 * sign * shift), -sign
        if abs(start) <= shift:
            expected[t > (k + 1) * half] = start
            break
    np.testing.assert_allclose(place, expected, atol=2e-8)


@pytest.mark.parametrize("stribeck", [{}, {"static": 0.3, "stribeck": 0.05}])
def test_tangents_of_friction_are_those_of_differences(stribeck):
    """By rates, and by the multipliers of the pin's rows: forces of 1 N are linear to 1e-7 in 1e-4 of them."""
    scene = with_freedoms(bar(RUBS | stribeck | {"radius": 0.1, "width": 0.02}, freedoms={"O": {"speed": 0.3}}))
    machine = machine_of(scene).machine
    rng = np.random.default_rng(1)
    t, q, v, a = np.zeros(1), np.zeros((1, machine.size)), *rng.uniform(-0.3, 0.3, (2, 1, machine.size))
    a[:, machine.n :] *= 20
    found = machine.residual(t, q, v, a)
    for matrix, number in ((found.M, 2), (found.C, 1)):
        dense = found.pattern.dense(matrix[0])[: machine.n]
        for column in range(machine.size if number == 2 else machine.n):
            beside = []
            for step in (1e-6, -1e-6):
                moved = [q.copy(), v.copy(), a.copy()]
                moved[number][0, column] += step
                beside.append(machine.residual(t, *moved, tangents=False).force[0, : machine.n])
            np.testing.assert_allclose(dense[:, column], (beside[0] - beside[1]) / 2e-6, atol=1e-7)


def test_a_pin_that_rubs_has_rows_between_links_that_bend():
    """Its force is told as that of a pin without rows, which shares a place."""
    changes = {"analysis.duration": 0.01, "analysis.sub_intervals": 4, "analysis.start": "smooth"}
    small = {"rod": {"kind": "friction", "coefficient": 1e-9, "joint": "A", "radius": 0.01, "width": 1e-2}}
    with_rows, without = (fm.analyse(slider_crank(True, joint_laws=laws, **changes)).data for laws in (small, {}))
    force, shared = (data["joint_force"].to_numpy() for data in (with_rows, without))
    np.testing.assert_allclose(force, shared, atol=1e-3 * np.abs(shared).max())  # both by their steps
    found = np.abs(with_rows["law_effort"].to_numpy()[1:, 0])
    np.testing.assert_allclose(found, 1e-11 * np.linalg.norm(force[1:, 1], axis=-1), rtol=1e-3)
