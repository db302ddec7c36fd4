"""Machines of demos against the linkages in link frames, whose answers agree with Exudyn."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech._arrays import turned
from fenics_mech.kinematics import solve_motion
from fenics_mech.machine import mobility
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.section_forces import end_forces, with_rides
from fenics_mech.solve import periodic, rigid_cycle
from tests.common import DEMOS

DRIVEN = [
    "quick_return",
    "four_bar",
    "slider_crank",
    "jansen",
    "stephenson",
    "watt",
    "composite_four_bar",
    "manipulator",
]


@pytest.mark.parametrize("demo", DRIVEN)
def test_the_rigid_motion_of_demos_is_that_of_the_loop_equations(demo):
    """The unloaded equilibria of the machine, at 16 positions of the cycle."""
    scene = fm.load(DEMOS / f"{demo}.toml").changed({"effects": ()})
    made = machine_of(scene)
    chart = rigid_cycle(made.machine, scene.period, 16)
    motion = solve_motion(scene, scene.cycle_rate * scene.period * np.arange(16) / 16)
    for node, (link, at) in enumerate(zip(made.links.mesh.node_link, made.links.mesh.node_xy)):
        place = motion.position[:, link] + turned(at, motion.angle[:, link])
        assert np.abs(chart.r[:, made.node_pose[node]] - place).max() < 1e-12  # m, of machines of 0.3 to 2 m


FINE = 240  # positions of the linkage


@pytest.mark.slow
@pytest.mark.parametrize(
    ("demo", "steps"), [("slider_crank", 120), ("four_bar", 120), ("stephenson", 120), ("quick_return", 240)]
)
def test_moments_torque_and_multipliers_of_demos_are_those_of_linkages(demo, steps):
    exact = {"effects": ("coupling", "large-rotations"), "damping": {"material": 1e-4}}
    numbers = {"analysis.sub_intervals": FINE, "analysis.stations": 21}
    scene = fm.load(DEMOS / f"{demo}.toml").changed(exact | numbers)
    made = machine_of(scene)
    machine, mesh = made.machine, made.links.mesh
    machine.chart = rigid_cycle(machine, scene.period)
    cycle = periodic(machine, scene.period, steps)
    assert len(cycle.changes) <= 7
    forces = end_forces(machine.terms[0], machine.groups[0], cycle.evaluation.terms[0], cycle.evaluation.at)
    if machine.rides:
        a = cycle.a.reshape(-1, machine.size)
        forces = with_rides(forces, machine.terms[0], machine.riders, cycle.evaluation.at, a)
    stages = cycle.t.shape[1]
    result = fm.analyse(scene).data
    positions = (np.arange(steps) + 1) * (FINE // steps) % FINE
    told = 2 * (float(result.attrs["error_estimate"]) + 2e-4)  # of both, and of 120 steps; joint forces have more
    for number, member in enumerate(mesh.members):
        cells = np.nonzero(mesh.cell_member == number)[0]
        if len(cells) < 2:
            continue
        node = cells[len(cells) // 2 - 1]
        place = float(mesh.cell_start[node] + mesh.cell_length[node]) / float(mesh.member_length[number])
        there = result["moment"].sel(member=member).interp(s=place).to_numpy()[positions]
        found = forces.moment[stages - 1 :: stages, node, 1, 0]
        assert np.abs(found - there).max() < told * np.abs(there).max(), member
    torque = result["input_torque"].to_numpy()[positions]
    exerted = -cycle.a[:, -1, machine.n + made.driven[0]]  # a row's force is on the left of the equation
    assert np.abs(torque - exerted).max() < 2 * told * np.abs(torque).max()
    known = np.hypot(*result["multiplier"].to_numpy()[0])
    assert np.abs(cycle.multipliers(1)[0]) == pytest.approx(known, rel=5e-3)  # both damp by their steps


@pytest.mark.parametrize("demo", DRIVEN)
def test_the_drives_of_demos_lead_all_of_their_freedoms(demo):
    scene = fm.load(DEMOS / f"{demo}.toml").changed({"effects": (), "mesh.elements": 1})
    found = mobility(machine_of(scene).machine)
    assert (found.freedoms, len(found.idle), found.surplus) == (len(scene.drives), 0, 0)
