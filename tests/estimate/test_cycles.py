"""Errors told by estimates of periodic motions, against motions by many more steps and elements."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.estimate import finer_mesh, finer_steps
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.section_forces import end_forces
from fenics_mech.solve import periodic, rigid_cycle
from tests.common import DEMOS
from tests.machine.builders import seed

PERIOD, CRANK_PERIOD = 2 * np.pi / 32.3, 2 * np.pi / 60
MEMBERS = [("crank", "OA"), ("rod", "AB")]


def moments(machine, found):
    """Moments at the second ends of all elements ``(instants, elements)`` (N m)."""
    return end_forces(machine.terms[0], machine.groups[0], found.terms[0], found.at).moment[..., 1, 0]


def middle(cycle, members=3):
    """Moments in the middles of the members at the ends of steps."""
    stages = cycle.t.shape[1]
    found = moments(cycle.machine, cycle.evaluation)[stages - 1 :: stages]
    each = found.reshape(len(found), members, -1)
    return each[:, :, each.shape[2] // 2 - 1]


def seed_cycle(elements, steps):
    machine = seed(elements)
    machine.chart = rigid_cycle(machine, PERIOD)
    return periodic(machine, PERIOD, steps)


def largest(difference):
    return np.abs(difference).max(axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("steps", [60, 120])
def test_told_errors_of_steps_are_those_against_240(steps):
    """They are 1 % and 0.04 % of the peak; two more stages have order 9 beside 5."""
    cycle, fine = seed_cycle(4, steps), seed_cycle(4, 240)
    true = largest(middle(cycle) - middle(fine)[240 // steps - 1 :: 240 // steps])
    told = largest(middle(finer_steps(cycle)) - middle(cycle))
    np.testing.assert_allclose(told / true, 1, atol=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("elements", [2, 4])
def test_told_errors_of_the_mesh_are_those_against_four_times_the_elements(elements):
    """They are 6 % and 0.4 % of the peak; the difference to half the length lacks a sixteenth at order 4."""
    cycle, fine = seed_cycle(elements, 120), seed_cycle(4 * elements, 120)
    halves = seed(2 * elements)
    halves.chart = rigid_cycle(halves, PERIOD)
    told = 16 / 15 * largest(middle(finer_mesh(cycle, halves)) - middle(cycle))
    np.testing.assert_allclose(told / largest(middle(cycle) - middle(fine)), 1, atol=0.1)


@pytest.mark.slow
def test_told_errors_of_the_mesh_of_a_scene_are_those_against_four_times_the_elements():
    """A slider-crank: a guide's row, a rigid slider, and members without inner poses."""
    cycles = []
    for elements in (2, 4, 8):
        changes = {"effects": (), "damping": {"material": 1e-4}}
        changes |= {f"links.{link}.members.{member}.mesh": {"elements": elements} for link, member in MEMBERS}
        machine = machine_of(fm.load(DEMOS / "slider_crank.toml").changed(changes)).machine
        machine.chart = rigid_cycle(machine, CRANK_PERIOD)
        start = finer_mesh(cycles[0], machine) if elements == 4 else periodic(machine, CRANK_PERIOD, 60)
        cycles.append(start)
    coarse, halves, fine = (middle(cycle, 2) for cycle in cycles)
    ratio = 16 / 15 * largest(halves - coarse) / largest(fine - coarse)
    np.testing.assert_allclose(ratio[1], 1, atol=0.1)  # of the rod; the crank bends as its rigid motion says
