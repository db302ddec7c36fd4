"""Dead centres, worst transmission, and what the drive can reach."""

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.machine.reach import reachable_range
from fenics_mech.scene.factories import four_bar, seed_four_bar

SECTION = {"area": 1e-4, "inertia": 1e-10, "fibre": 1e-3}


def linkage(crank, coupler, follower, ground):
    material = {"modulus": 7e10, "density": 2700}
    lengths = {"crank": crank, "coupler": coupler, "follower": follower, "ground": ground}
    return four_bar(**lengths, sections=[SECTION] * 3, material=material, speed=10.0)


def test_dead_centres_of_a_double_rocker_are_where_coupler_and_follower_are_in_line():
    reach = reachable_range(linkage(2.0, 1.2, 1.2, 1.9))
    limit = np.arccos((2**2 + 1.9**2 - 2.4**2) / (2 * 2 * 1.9))
    assert not reach.turns
    assert reach.high == pytest.approx(limit, abs=1e-9)
    assert reach.low == pytest.approx(-limit, abs=1e-9)
    assert [c.kind for c in reach.critical if c.value == 0] == ["dead centre", "dead centre"]
    assert set(reach.critical[0].links) == {"coupler", "follower"}


def test_crank_rocker_turns_and_transmits_worst_where_the_diagonal_is_shortest():
    # the angle between coupler and follower is farthest from 90 deg where the crank is in line with the ground
    reach = reachable_range(seed_four_bar())
    assert reach.turns
    worst = min(reach.critical, key=lambda critical: critical.value)
    assert worst.kind == "worst transmission"
    assert abs(np.angle(np.exp(1j * worst.theta))) < 0.35


def test_slider_like_stroke_of_a_locked_linkage_is_symmetric():
    reach = reachable_range(linkage(3.0, 1.0, 1.0, 2.5))
    assert reach.low == pytest.approx(-reach.high, abs=1e-9)


def test_transmission_angle_of_a_four_bar_is_that_of_the_law_of_cosines():
    (pair,) = reachable_range(seed_four_bar()).transmission
    diagonal, coupler, follower = 0.254 - 0.10795, 0.2794, 0.27051  # where the crank is in line with the ground
    angle = np.arccos((coupler**2 + follower**2 - diagonal**2) / (2 * coupler * follower))
    assert (pair.joint, pair.links) == ("B", ("coupler", "follower"))
    assert pair.angle == pytest.approx(angle, abs=1e-6)
    assert np.sin(pair.theta) == pytest.approx(0, abs=1e-5)


@pytest.mark.parametrize(
    ("demo", "angles"),
    [
        ("slider_crank", {"B": np.arccos((60 + 10) / 300)}),  # crank and offset over the rod
        (
            "quick_return",
            {"A": np.pi / 2, "E": np.arccos((390 - 400 * np.sqrt(1 - 0.4**2)) / 150)},
        ),  # its end swings to sin = 80/200
        ("manipulator", {}),
    ],
)
def test_transmission_angles_of_slides(demo, angles):
    reach = reachable_range(load(f"demos/{demo}.toml"))
    assert {pair.joint: pair.angle for pair in reach.transmission} == pytest.approx(angles, abs=1e-5)
    assert demo != "manipulator" or not reach.critical  # the drives move every link by itself: no position is worse


def test_critical_positions_of_a_cycle_are_from_0_to_360_degrees():
    reach = reachable_range(seed_four_bar())
    assert all(0 <= found.theta <= 2 * np.pi for found in (*reach.critical, *reach.transmission))
