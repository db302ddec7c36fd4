"""Machines of demos: rigid motion and freedoms."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech._arrays import turned
from fenics_mech.machine import mobility
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.solve import rigid_cycle
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


@pytest.mark.parametrize("demo", DRIVEN)
def test_the_drives_of_demos_lead_all_of_their_freedoms(demo):
    scene = fm.load(DEMOS / f"{demo}.toml").changed({"effects": (), "mesh.elements": 1})
    found = mobility(machine_of(scene).machine)
    assert (found.freedoms, len(found.idle), found.surplus) == (len(scene.drives), 0, 0)
