"""Rigid motion of 75 linkages drawn at random, and of linkages in space, against closed forms of their loops."""

import numpy as np
import pytest

from fenics_mech.geometry import SPACE
from fenics_mech.machine import hold_idle, loosen, mobility
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import rigid_cycle
from tests.machine.drawn_linkages import POSITIONS, THETA, four_bar, inverted, slider_crank, stephenson, watt
from tests.machine.linkages import Bennett, Rssr


@pytest.mark.parametrize("number", [0, 1, *(pytest.param(k, marks=pytest.mark.slow) for k in range(2, 15))])
@pytest.mark.parametrize("kind", [four_bar, slider_crank, inverted, watt, stephenson], ids=lambda kind: kind.__name__)
def test_a_linkage_drawn_at_random_moves_as_its_loops_say(kind, number):
    rng = np.random.default_rng([number, len(kind.__name__)])
    drawn = kind(rng)
    made = machine_of(drawn.read(rng))
    at = rigid_cycle(made.machine, 2 * np.pi, POSITIONS).at(THETA)
    for link, points in drawn.links.items():
        for name, places in points.items():
            end = made.end(f"{link}.{name}")
            found = at.r[:, end.pose] + at.R[:, end.pose] @ end.offset
            assert np.abs(found[:, 0] + 1j * found[:, 1] - places).max() < 1e-12, f"{link}.{name}"  # m, of 1 m


@pytest.mark.parametrize("kind", ["ball", "universal"])
def test_an_rssr_turns_its_rocker_as_the_closed_form_says(kind):
    machine, _, _, rocker = Rssr.machine(kind, lambda t: t)
    if kind == "ball":
        hold_idle(machine, mobility(machine))
    at = rigid_cycle(machine, 2 * np.pi, POSITIONS).at(THETA)
    exact = Rssr.angle(THETA) - Rssr.angle(np.zeros(1))
    np.testing.assert_allclose(at.R[:, rocker], SPACE.about(np.array([0, 1.0, 0]), exact), atol=1e-12)


def test_bennetts_linkage_turns_its_output_as_the_closed_form_says():
    """Its rows depend on each other, and hold all the same: the slack takes no force."""
    start = 1.0
    machine, bodies, axes = Bennett.machine(start)
    loosen(machine, mobility(machine).redundant)
    machine.drive("revolute", "angle", machine.rows[0].pair, lambda t: t)
    at = rigid_cycle(machine, 2 * np.pi, POSITIONS).at(THETA)
    turned = Bennett.second(start + THETA) - Bennett.second(start)  # of the ground against the last body
    np.testing.assert_allclose(at.R[:, bodies[2]], SPACE.about(axes[3], turned), atol=1e-12)
