"""The rigid motion of the dissertation's room against a closed form and the linkages in link frames."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.classical.bodies import Bodies
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.linkage import solve_motion
from tests.common import DEMOS

FRAMES = ["four_bar", "slider_crank", "watt", "counterweighted_rocker", "manipulator"]


@pytest.mark.parametrize("demo", FRAMES)
def test_poses_and_rates_of_demos_are_those_of_the_loop_equations(demo):
    scene = fm.load(DEMOS / f"{demo}.toml").changed(effects=())
    theta = scene.drive_angles(17)
    ours, known = Bodies(machine_of(scene)).links(theta / scene.cycle_rate), solve_motion(scene, theta)
    for found, of_links in (
        (ours.position, known.position),
        (np.exp(1j * ours.angle), np.exp(1j * known.angle)),
        (ours.omega, known.omega),
        (ours.acceleration, known.acceleration),
        (ours.alpha, known.alpha),
    ):
        assert np.abs(found - of_links).max() < 1e-12 * np.abs(of_links).max()  # rounding


def test_a_slider_moves_as_its_closed_form():
    scene = fm.load(DEMOS / "slider_crank.toml")
    crank, rod, offset, rate = 0.06, 0.3, 0.01, 60.0
    theta = np.linspace(0, 30, 11)  # several turns
    motion = Bodies(machine_of(scene)).links(theta / rate)
    height = offset - crank * np.sin(theta)
    angle = np.arcsin(height / rod)
    np.testing.assert_allclose(np.sin(motion.angle[:, 1]), height / rod, atol=1e-13)
    turning = -crank * np.cos(theta) * rate / (rod * np.cos(angle))
    np.testing.assert_allclose(motion.omega[:, 1], turning, atol=1e-12 * rate)
    second = (crank * np.sin(theta) * rate**2 / rod + np.sin(angle) * turning**2) / np.cos(angle)
    np.testing.assert_allclose(motion.alpha[:, 1], second, atol=1e-12 * rate**2)
