"""Rigid motion against closed forms and high-order differences."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from fenics_mech.errors import AssemblyError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import four_bar, seed_four_bar
from tests.demos.machines import piston, welded_arm
from tests.validation.reference.mecqbar import mecqbar

SECTION = {"area": 1e-4, "inertia": 1e-10, "fibre": 1e-3}
THETA = np.linspace(0, 2 * np.pi, 73)


def linkage(crank, coupler, follower, ground, **rest):
    material = {"modulus": 7e10, "density": 2700}
    lengths = {"crank": crank, "coupler": coupler, "follower": follower, "ground": ground}
    return four_bar(**lengths, sections=[SECTION] * 3, material=material, **{"speed": 10.0} | rest)


def closed_form(a, b, c, ground, theta, side):
    """Angles of coupler and follower by the cosine rule on the diagonal (6.15)-(6.26)."""
    joint_a, pin = a * np.exp(1j * theta), ground
    diagonal = pin - joint_a
    cosine = (b**2 + np.abs(diagonal) ** 2 - c**2) / (2 * b * np.abs(diagonal))
    joint_b = joint_a + b * diagonal / np.abs(diagonal) * np.exp(1j * side * np.arccos(cosine))
    return np.angle(joint_b - joint_a), np.angle(joint_b - pin)


def test_seed_agrees_with_mecqbar():
    motion, printed = solve_motion(seed_four_bar(), THETA), mecqbar(THETA)
    for column, name in ((1, "2"), (2, "3")):
        assert np.allclose(motion.angle[:, column], printed[f"theta{name}_rad"], rtol=0, atol=1e-12)
        assert np.allclose(motion.omega[:, column], printed[f"omega{name}_rad_s"], rtol=0, atol=1e-10)
        assert np.allclose(motion.alpha[:, column], printed[f"alpha{name}_rad_s2"], rtol=0, atol=1e-8)


@example(shortest=0.99, others=(1.0, 1.945885375377158), fraction=0.5, branch="crossed")  # nearly a change point
@given(
    shortest=st.floats(0.05, 0.99),
    others=st.tuples(st.floats(1.0, 3.0), st.floats(1.0, 3.0)),
    fraction=st.floats(0.02, 0.98),
    branch=st.sampled_from(["open", "crossed"]),
)
def test_random_crank_rockers_agree_with_the_closed_form(shortest, others, fraction, branch):
    # Grashof: shortest + longest < sum of the others, the crank being the shortest
    middle, longest = min(others), max(others)
    ground = max(longest, longest + fraction * (middle - shortest))
    if shortest + ground >= middle + longest - 1e-2:
        ground = longest
    coupler, follower = middle, longest
    if shortest + longest >= middle + ground - 1e-2:
        return
    motion = solve_motion(linkage(shortest, coupler, follower, ground, branch=branch), THETA)
    theta2, theta3 = closed_form(shortest, coupler, follower, ground, THETA, 1 if branch == "open" else -1)
    for found, expected in ((motion.angle[:, 1], theta2), (motion.angle[:, 2], theta3)):
        assert np.abs(np.exp(1j * found) - np.exp(1j * expected)).max() < 1e-10


def test_point_acceleration_of_a_joint_is_the_same_from_both_links():
    motion = solve_motion(seed_four_bar(), THETA)
    for state_a, state_b in zip(motion.of_point("coupler", (0.2794, 0)), motion.of_point("follower", (0.27051, 0))):
        assert np.allclose(state_a, state_b, rtol=0, atol=1e-10 * np.abs(state_a).max())


def test_order_of_angles_does_not_matter(rng):
    scene, order = seed_four_bar(), rng.permutation(len(THETA))
    assert np.allclose(solve_motion(scene, THETA[order]).angle, solve_motion(scene, THETA).angle[order], atol=1e-12)


def test_turning_backwards_reverses_velocity_and_keeps_acceleration():
    forward, back = (solve_motion(seed_four_bar(drive__speed=s), THETA) for s in (32.3, -32.3))
    assert np.allclose(forward.omega, -back.omega, rtol=1e-12)
    assert np.allclose(forward.alpha, back.alpha, rtol=1e-12)


def test_crank_that_cannot_turn_names_where_it_locks():
    # at the dead centre coupler and follower are in line: 2.4^2 = 2^2 + 1.9^2 - 2 2 1.9 cos(theta)
    limit = np.degrees(np.arccos((2**2 + 1.9**2 - 2.4**2) / (2 * 2 * 1.9)))
    with pytest.raises(AssemblyError, match=rf"cannot turn beyond {limit:.3f}\d* deg"):
        solve_motion(linkage(2.0, 1.2, 1.2, 1.9), THETA)


def test_links_that_cannot_be_assembled_name_the_open_joint(seed):
    data = seed.model_dump()
    data["ground"]["points"]["C"] = (2.0, 0.0)
    with pytest.raises(AssemblyError, match=r"joint \w stays open by [\d.]+ m"):
        solve_motion(type(seed).model_validate(data), THETA)


def test_branch_far_from_the_rough_angles_is_refused():
    scene = seed_four_bar(links__coupler__angle=-1.6, links__follower__angle=1.0)
    with pytest.raises(AssemblyError, match="far from its rough angle"):
        solve_motion(scene, THETA)


def test_a_drive_may_dwell():
    """Where it rests rates are rounding, which no step along the branch resolves."""
    law = {"kind": "expression", "formula": "0.3*tanh(30*sin(theta))"}
    scene = seed_four_bar().changed(drive={"joint": "O", "law": law, "period": 0.2})
    motion = solve_motion(scene, THETA)
    assert motion.angle[:, 0] == pytest.approx(0.3 * np.tanh(30 * np.sin(THETA)), abs=1e-12)
    coupler, _ = closed_form(0.10795, 0.2794, 0.27051, 0.254, motion.angle[:, 0], 1)
    assert motion.angle[:, 1] == pytest.approx(coupler, abs=1e-12)


@pytest.mark.parametrize("away", [60.0, 90.0, 100.0, -90.0])
def test_a_rough_angle_that_a_joint_contradicts_is_refused(away):
    held = 15.0  # by the prismatic joint of this machine
    with pytest.raises(AssemblyError, match=r"joint G holds link piston at 15 deg to the ground.*say"):
        solve_motion(piston().changed(links__piston__angle=np.radians(held + away)), THETA)
    near = solve_motion(piston().changed(links__piston__angle=np.radians(held + 20.0)), THETA)
    # Newton's method ends at rounding, from wherever it starts
    assert near.angle == pytest.approx(solve_motion(piston(), THETA).angle, rel=0, abs=1e-14)


@pytest.mark.parametrize("direction", [0.0, 30.0, 45.0, 60.0])
def test_a_drive_along_a_slide_through_all_origins(direction):
    section = {"area": 1e-4, "inertia": 1e-10, "fibre": 1e-3}
    links = {"car": {"points": {"Q": (0, 0), "A": (0.1, 0)}}}
    links["car"]["members"] = {"QA": {"ends": ("Q", "A"), "section": "s", "material": "m"}}
    scene = Scene.read(
        {
            "materials": {"m": {"modulus": 7e10, "density": 2700}},
            "sections": {"s": section},
            "ground": {"points": {"O": (0, 0)}},
            "links": links,
            "joints": {"G": {"kind": "prismatic", "connect": ("ground.O", "car.Q"), "angle": f"{direction} deg"}},
            "drive": {"joint": "G", "law": {"kind": "harmonics", "sine": [0.02]}, "period": 0.5},
        }
    )
    place = 0.02 * np.sin(THETA)[:, None] * np.array([np.cos(np.radians(direction)), np.sin(np.radians(direction))])
    assert np.allclose(solve_motion(scene, THETA).of_point("car", (0.0, 0.0))[0], place, rtol=0, atol=1e-15)


def test_a_rough_angle_that_a_weld_contradicts_is_refused():
    with pytest.raises(AssemblyError, match=r"joint W holds link arm at -40 deg to link rocker.*say 50 deg"):
        solve_motion(welded_arm().changed(links__arm__angle=np.radians(140.0)), THETA)
