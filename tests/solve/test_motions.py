"""Motion in time, periodic motion and rigid motion against independent programs."""

import numpy as np
import pytest

from fenics_mech.geometry import SPACE
from fenics_mech.machine import Machine, Row
from fenics_mech.solve import march, periodic, rigid_cycle
from fenics_mech.terms import Look, Measure
from tests.common import ROOT
from tests.machine.builders import double_pendulum, seed

FINAL = (-0.54571031, -1.07506168)  # rad after 3 s: own program in two angles, eight digits


def angles(course, poses):
    return np.array([np.arctan2(course.motion[-1].R[pose][1, 0], course.motion[-1].R[pose][0, 0]) for pose in poses])


@pytest.mark.slow
def test_a_rigid_double_pendulum_converges_with_order_4_or_more():
    errors = []
    for steps in (150, 300):
        machine, poses = double_pendulum()
        errors.append(np.abs(angles(march(machine, np.zeros(machine.size), 3.0, h=3 / steps), poses) - FINAL).max())
    assert errors[1] < 3e-7
    assert np.log2(errors[0] / errors[1]) > 4  # 5 by Radau IIA of 3 stages


@pytest.mark.parametrize("tolerance", [1e-5, pytest.param(1e-7, marks=pytest.mark.slow)])
def test_steps_are_chosen_so_that_the_error_follows_the_tolerance(tolerance):
    machine, poses = double_pendulum()
    course = march(machine, np.zeros(machine.size), 3.0, tolerance=tolerance)
    gaps = [motion.r[poses[0]] + motion.R[poses[0]] @ [1, 0] - motion.r[poses[1]] for motion in course.motion]
    assert (
        np.abs(angles(course, poses) - FINAL).max() < 30 * tolerance
    )  # it sums over 100 steps, and the motion is wild
    assert np.abs(gaps).max() < 1e-10


@pytest.mark.slow
def test_the_seed_has_its_multiplier():
    """0.1643 +- 0.2198 i by linear collocation in link frames of an earlier release; 60 steps damp it by 0.7 %."""
    machine = seed(4)
    period = 2 * np.pi / 32.3
    machine.chart = rigid_cycle(machine, period)
    cycle = periodic(machine, period, 60)
    assert len(cycle.changes) <= 7
    assert np.abs(cycle.multipliers(2)) == pytest.approx([0.2744, 0.2744], rel=8e-3)


@pytest.mark.slow
def test_the_bricard_mechanism_swings_as_the_benchmark():
    """IFToMM library of benchmarks: five rigid bars and six revolutes, redundant by one row; 10 s of its swing."""
    places = np.array([[0, 0, 0], [1, 0, 0], [1, -1, 0], [1, -1, 1], [0, -1, 1], [0, 0, 1.0]])
    ways = [places[(i + 1) % 6] - places[i] for i in range(6)]
    machine = Machine(SPACE, [0, -9.81, 0])
    bars = [machine.add_pose(places[i] + ways[i] / 2, SPACE.axes(ways[i])) for i in range(5)]
    for bar in bars:
        machine.masses.add_body(machine.end(bar), 1.0, np.diag([1 / 12, 0, 0]))
    around = [machine.ground, *bars, machine.ground]
    measures = [*(Measure(Look.PLACE, k) for k in range(3)), Measure(Look.ALIGNED, 1, 0), Measure(Look.ALIGNED, 2, 0)]
    for i in range(6):
        axes = SPACE.axes(np.cross(ways[i - 1], ways[i]))
        ends = machine.end(around[i], places[i], axes), machine.end(around[i + 1], places[i], axes)
        machine.rows += [Row(ends, measure, slack=1e-9) for measure in measures]
    course = march(machine, np.zeros(machine.size), 10.0, h=0.02)
    found = np.array([motion.r[bars[2]] + motion.R[bars[2]][:, 0] / 2 for motion in course.motion[::5]])
    exact = np.load(ROOT / "tests" / "data" / "spatial" / "bricard_iftomm.npz")["P3"]
    energy = np.array([swing_energy(motion, bars) for motion in course.motion])
    # the slack is 1e-9 m/N: forces of 30 N move joints by 3e-8 m, and all rows store 2e-6 J
    np.testing.assert_allclose(found, exact, atol=1e-7)  # m, of 2 m
    np.testing.assert_allclose(energy, energy[0], atol=4e-6)  # J, of 29.4 J


def swing_energy(motion, bars):
    """Give the energy of bars of 1 kg and 1 m whose centres are poses (J)."""
    r, v, w, along = motion.r[bars], motion.v[bars], motion.w[bars], motion.R[bars][:, :, 0]
    across = w - along * np.sum(along * w, axis=1)[:, None]
    return np.sum(v**2) / 2 + np.sum(across**2) / 24 + 9.81 * np.sum(r[:, 1])
