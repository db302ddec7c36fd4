"""Analyses by the equation of poses among themselves, and against limits."""

from dataclasses import replace

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech import Scene
from fenics_mech.answers.solved_by_poses import Solved
from fenics_mech.errors import SceneError
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS
from tests.frozen.freeze import SCENES as FROZEN

EXACT = {"effects": ("coupling", "large-rotations")}


def apart(one, other, name):
    """Largest difference over the largest value of all places."""
    known = other[name].to_numpy()
    found = one[name].transpose(*other[name].dims).to_numpy()
    return np.abs(found - known).max() / np.abs(known).max()


def test_power_balances_to_the_order_of_the_steps():
    changes = {**EXACT, "analysis.solver": "poses", "analysis.stability": False, "analysis.error_estimates": False}
    scene = fm.load(DEMOS / "slider_crank.toml").changed({**changes, "analysis.sub_intervals": 40})
    scenes = (scene.changed(analysis__sub_intervals=count) for count in (40, 120))
    coarse, fine = (fm.analyse(one).data.attrs["power_balance_error"] for one in scenes)
    assert fine < 1e-6
    assert coarse > 27 * fine  # order 3 or more


def test_joint_forces_of_a_support_are_its_force_on_the_frame():
    changes = {**EXACT, "analysis.solver": "poses", "analysis.stability": False, "analysis.error_estimates": False}
    data = fm.analyse(fm.load(DEMOS / "slider_crank.toml").changed({**changes, "analysis.sub_intervals": 24})).data
    bearing = data["joint_force"].sel(joint="O").to_numpy()
    np.testing.assert_allclose(data["support_force"].sel(support="O").to_numpy(), -bearing, rtol=1e-12)


def test_members_that_cannot_stretch_are_told_what_to_write_instead():
    scene = fm.load(DEMOS / "four_bar.toml").changed({"effects": ("coupling", "inextensible")})
    with pytest.raises(SceneError, match=r"'inextensible' is no effect any more.*100 times the `area`"):
        fm.analyse(scene)


def test_moments_of_stiff_members_have_a_limit_by_one_over_their_stiffness():
    """Areas grow and densities fall, so that masses and bending stay: what is advised instead of `inextensible`."""
    options = {"sub_intervals": 60, "stability": False, "error_estimates": False}
    found = []
    for factor in (1, 10, 100, 1e4):
        data = seed_four_bar(effects=("coupling",), analysis=options, damping={"material": 2e-4}).model_dump()
        for material in data["materials"].values():
            material["density"] /= factor
        for section in data["sections"].values():
            section["area"] *= factor
        found.append(fm.analyse(Scene.read(data)).data["moment"].to_numpy())
    *off, _ = (np.abs(x - found[-1]).max() / np.abs(found[-1]).max() for x in found)
    assert off[0] < 5e-3
    assert off[0] / off[1] == pytest.approx(10, rel=0.1)
    assert off[1] / off[2] == pytest.approx(10, rel=0.1)


@pytest.mark.slow
def test_forces_on_rigid_links_that_turn_are_those_of_stiff_members():
    """Both rigid links are uniform rods, so stiff members stand for them."""
    scene = fm.load(FROZEN / "rigid_links_16_large_rotations.toml")
    scene = scene.changed({f"analysis.{name}": False for name in ("error_estimates", "stability")})
    given = scene.model_dump()
    for name in ("left", "right"):
        link = given["links"][name]
        body, (first, second) = link.pop("rigid"), link["points"]
        length = np.linalg.norm(np.subtract(link["points"][second], link["points"][first]))
        assert body["inertia"] == pytest.approx(body["mass"] * length**2 / 12, rel=1e-6)
        given["materials"][name] = {"modulus": 200e9, "density": body["mass"] / length / 1e-4, "poisson": 0.3}
        given["sections"][name] = {"area": 1e-4, "inertia": 2e-9, "fibre": 5e-3}
        link["members"] = {"m": {"ends": (first, second), "section": name, "material": name}}
    stiff = fm.analyse(Scene.read(given).changed(analysis__solver="collocation")).data
    poses = fm.analyse(scene.changed(analysis__solver="poses")).data
    bending = stiff.sel(member=poses["member"])
    assert apart(poses, bending, "strain") < 5e-4  # 2.5e-4: steps and the stiff members' own bending


def test_what_is_read_off_a_damped_motion_does_not_hang_on_signs_of_modes():
    """Patterns of stress are eigenvectors, whose signs rounding may turn between two evaluations."""
    scene = fm.load(DEMOS / "four_bar.toml").changed({**EXACT, "analysis.sub_intervals": 24, "analysis.stations": 5})
    solved = Solved.of(scene)
    found, modes = solved.positions, solved.made.machine.mode_numbers[0]
    a = found.motion.a.copy()
    assert np.abs(a[:, modes]).max() > 0
    a[:, modes] *= -1
    turned = OfPoses(found.made, replace(found.motion, a=a))
    assert np.abs(turned.motion.found.force).max() < 1e-6
    for one, other in zip(found.joint_forces.values(), turned.joint_forces.values()):
        np.testing.assert_array_equal(one, other)
    np.testing.assert_array_equal(found.bare.moment, turned.bare.moment)


def test_a_traced_point_inside_a_member_has_a_node_in_the_finer_mesh_too():
    """Else its halves are those of other elements than the members have."""
    points = {"P": fm.TracedPoint(at="coupler@0.5", offset=(0.0, 0.06))}
    changes = {"points": points, "analysis.sub_intervals": 60, "analysis.allow_coarse": True}
    data = fm.analyse(fm.load(DEMOS / "four_bar.toml").changed(changes)).data
    assert 1e-3 < data["relative_error"].sel(source="mesh").item() < 0.05
    assert np.isfinite(data["point_acceleration_bent"].sel(point="P")).all()
