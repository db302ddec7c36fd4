"""The rigid motion of the dissertation's room against closed forms and the linkages in link frames."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.classical.linkage import assembly, rigid_motion
from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics import solve_motion
from fenics_mech.scene.formulas.expression import Jet
from tests.common import DEMOS

OPEN = {"O": ("ground.O", "crank.O"), "A": ("crank.A", "coupler.A"), "B": ("coupler.B", "follower.B")}
PARALLELOGRAM = {
    "links.coupler.points.B": (0.254, 0.0),
    "links.coupler.angle": "0 deg",
    "links.follower.points.B": (0.10795, 0.0),
    "links.follower.angle": "60 deg",
    "drive.start": "60 deg",
}
FRAMES = ["four_bar", "slider_crank", "watt", "counterweighted_rocker", "manipulator"]


def at_rate(scene, theta):
    return Jet(theta, np.full_like(theta, scene.cycle_rate), np.zeros_like(theta))


@pytest.mark.parametrize("demo", FRAMES)
def test_poses_and_rates_of_demos_are_those_of_the_loop_equations(demo):
    scene = fm.load(DEMOS / f"{demo}.toml")
    theta = scene.drive_angles(17)
    ours, known = rigid_motion(scene, assembly(scene), at_rate(scene, theta)), solve_motion(scene, theta)
    for found, of_links in (
        (ours.pose[:, :-1, :2], known.position),
        (np.exp(1j * ours.pose[:, :-1, 2]), np.exp(1j * known.angle)),
        (ours.rate[:, :-1, 2], known.omega),
        (ours.second[:, :-1, :2], known.acceleration),
        (ours.second[:, :-1, 2], known.alpha),
    ):
        assert np.abs(found - of_links).max() < 1e-13 * np.abs(of_links).max()  # rounding


def test_a_slider_moves_as_its_closed_form():
    scene = fm.load(DEMOS / "slider_crank.toml")
    crank, rod, offset, rate = 0.06, 0.3, 0.01, 60.0
    theta = np.linspace(0, 30, 11)  # several turns
    motion = rigid_motion(scene, assembly(scene), at_rate(scene, theta))
    height = offset - crank * np.sin(theta)
    angle = np.arcsin(height / rod)
    np.testing.assert_allclose(np.sin(motion.pose[:, 1, 2]), height / rod, atol=1e-14)
    turning = -crank * np.cos(theta) * rate / (rod * np.cos(angle))
    np.testing.assert_allclose(motion.rate[:, 1, 2], turning, atol=1e-12 * rate)
    second = (crank * np.sin(theta) * rate**2 / rod + np.sin(angle) * turning**2) / np.cos(angle)
    np.testing.assert_allclose(motion.second[:, 1, 2], second, atol=1e-12 * rate**2)


def test_a_drive_that_starts_slowly_turns_its_crank_so():
    """An angle of t^2/2: the acceleration of the crank's pin has both parts."""
    scene = fm.load(DEMOS / "four_bar.toml")
    time = np.linspace(0, 3, 7)
    motion = rigid_motion(scene, assembly(scene), Jet(time**2 / 2, time, np.ones_like(time)))
    np.testing.assert_allclose(motion.rate[:, 0, 2], time, atol=1e-13)
    np.testing.assert_allclose(motion.second[:, 0, 2], 1.0, atol=1e-13)
    angle, pin = time**2 / 2, 0.10795 * np.array([1.0, 1.0])
    along = -(time**2) * np.array([np.cos(angle), np.sin(angle)]) + np.array([-np.sin(angle), np.cos(angle)])
    np.testing.assert_allclose(motion.second[:, 1, :2], along.T * pin, atol=1e-12)  # the coupler begins at the pin


def test_the_branch_is_followed_in_steps_that_are_small_enough(monkeypatch):
    """Links are in line but for 0.02 mm; in steps of 30 degrees it comes to the other branch."""
    links = {"follower.points.B": (0.1336, 0.0), "follower.angle": "90 deg", "coupler.angle": "10 deg"}
    changes = {f"links.{key}": value for key, value in links.items()} | {"drive.start": "150 deg"}
    scene = fm.load(DEMOS / "four_bar.toml").changed(changes)
    theta = scene.drive_angles(8)
    found = rigid_motion(scene, assembly(scene), at_rate(scene, theta)).pose[:, :-1, 2]
    assert np.abs(np.exp(1j * found) - np.exp(1j * solve_motion(scene, theta).angle)).max() < 1e-13
    monkeypatch.setattr("fenics_mech.classical.linkage.COARSE", 12)
    with pytest.raises(AssemblyError, match="passes next to a change point before drive angle 225 deg"):
        rigid_motion(scene, assembly(scene), at_rate(scene, theta))


@pytest.mark.parametrize("off", [(-40, 40), (40, -40), (0, 0)])
def test_rough_angles_lead_to_the_assembly_that_is_near(off):
    changes = {"links.follower.points.B": (0.2, 0.0), "drive.start": "180 deg"}
    scene = fm.load(DEMOS / "four_bar.toml").changed(changes)
    crank, b, c, ground = 0.10795, 0.2794, 0.2, 0.254
    diagonal = ground + crank  # from A to C, in line with the crank
    coupler = np.arccos((b**2 + diagonal**2 - c**2) / (2 * b * diagonal))
    assert assembly(scene)[0, 1, 2] == pytest.approx(coupler, abs=1e-13)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"links.coupler.points.B": (0.05, 0.0)}, "put together"),
        ({"links.follower.angle": "-120 deg", "links.coupler.angle": "-80 deg"}, None),
        ({"links.follower.angle": "-100 deg"}, "rough angle"),
        (PARALLELOGRAM, "not unique at drive angle 120 deg"),
        ({"joints": {name: {"connect": points} for name, points in OPEN.items()}}, "state as many drives"),
    ],
)
def test_what_cannot_be_put_together_is_refused(changes, message):
    scene = fm.load(DEMOS / "four_bar.toml").changed(changes)
    if message is None:  # the other branch, which is as good
        motion = rigid_motion(scene, assembly(scene), at_rate(scene, np.zeros(1)))
        assert np.sin(motion.pose[0, 2, 2]) < 0
        return
    with pytest.raises(AssemblyError, match=message):
        rigid_motion(scene, assembly(scene), at_rate(scene, np.zeros(1)))
