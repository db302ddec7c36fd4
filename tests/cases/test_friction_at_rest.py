"""Bodies that friction holds stay where they are, and those that it stops come to rest: against closed forms."""

import json
from pathlib import Path

import numpy as np
import pytest

import fenics_mech as fm
from tests.joints.scenes import G, bar, block
from tests.joints.test_bending import DENSITY, slider_crank

pytestmark = pytest.mark.slow  # seconds each: steps that cross rest
SCENES = Path(__file__).parent / "scenes"


def incline(angle: str, speed: float = 0.0, duration: str = "20 s", **values) -> fm.Scene:
    scene = fm.load(SCENES / "sticking_block.toml")
    turned = {"joints.G.angle": angle, "joints.G.turn": angle, "freedoms.G.speed": speed, "analysis.duration": duration}
    return scene.changed(turned | values)


@pytest.mark.parametrize("angle", ["15 deg", "-15 deg", "165 deg", "195 deg", "21.7 deg", "0 deg", "180 deg"])
def test_a_block_that_must_stick_does(angle):
    # tan 21.7 deg = 0.398 < 0.4; the creep allowed is 0.1 mm in 20 s, and that of the law is 1e-8 artanh(0.995) m/s
    place = fm.analyse(incline(angle, **{"analysis.sub_intervals": 10})).data["freedom_place"][:, 0]
    assert np.abs(place).max() < 1e-6


@pytest.mark.parametrize(
    ("angle", "static", "stribeck"),
    [("24 deg", 0.5, 1e-2), ("-24 deg", 0.5, 1e-2), ("22 deg", 0.5, 1e-3), ("24 deg", 0.6, 1e-4)],
)
def test_a_block_that_the_static_coefficient_holds_sticks(angle, static, stribeck):
    """A block in motion would slide on, as tan 22 deg = 0.404 > 0.4: a long step must not take that motion."""
    rubs = {"joint_laws.rub.static": static, "joint_laws.rub.stribeck": stribeck, "analysis.sub_intervals": 10}
    place = fm.analyse(incline(angle, **rubs)).data["freedom_place"][:, 0]
    assert np.abs(place).max() < 1e-6


@pytest.mark.parametrize(("angle", "sense"), [("30 deg", -1), ("150 deg", -1), ("90 deg", -1), ("270 deg", 1)])
def test_a_block_that_cannot_stick_slides(angle, sense):
    # x = g (sin a - mu cos a) t^2/2 down the guide; a guide straight up presses nothing
    steep = np.arctan(abs(np.tan(np.radians(float(angle.split()[0])))))
    data = fm.analyse(incline(angle, duration="1 s", **{"analysis.sub_intervals": 10})).data
    expected = sense * G * (np.sin(steep) - 0.4 * np.cos(steep)) / 2
    assert data["freedom_place"][-1, 0].item() == pytest.approx(expected, rel=1e-5)


@pytest.mark.long
@pytest.mark.parametrize("angle", ["0 deg", "10 deg", "-10 deg"])
def test_a_block_coasts_to_rest_and_stays_there(angle):
    # s = v^2/(2 g (mu cos a + sin a)); 1e-4: the step in which it stops is as long as the tolerance allows
    a, speed = np.radians(float(angle.split()[0])), 2.0
    data = fm.analyse(incline(angle, speed, "4 s", **{"analysis.sub_intervals": 40})).data
    place, end = data["freedom_place"][:, 0].to_numpy(), speed**2 / (2 * G * (0.4 * np.cos(a) + np.sin(a)))
    assert place[-1] == pytest.approx(end, rel=1e-4)
    assert np.ptp(place[data["time"] > 2.5]) < 1e-6


def wide_pin(**freedom) -> fm.Scene:
    """Give a mass 0.2 m beside a pin whose friction acts at 3 x 0.3 m = 0.9 m."""
    law = {"kind": "friction", "coefficient": 3.0, "radius": 0.3}
    body = fm.RigidBody(mass=1.0, centre=(0.2, 0))
    scene = bar(law, **{"links.bar.rigid": body, "freedoms": {"O": freedom}})
    return scene.changed({"analysis.sub_intervals": 10})


def test_a_pin_whose_friction_acts_beyond_the_arm_of_its_mass_sticks():
    place = fm.analyse(wide_pin(start=0.5 - np.pi / 2)).data["freedom_place"]
    assert np.abs(place - place[0]).max() < 1e-7  # 1e-8 m/s artanh(0.2 sin(0.5)/0.9)/0.3 m in 1 s is 3.6e-9 rad


def test_a_pin_whose_friction_acts_beyond_the_arm_of_its_mass_jams_in_motion():
    with pytest.raises(fm.SolverError, match="a pin jams in motion where its coefficient times its radius exceeds"):
        fm.analyse(wide_pin(start=0.0, speed=2.0))


@pytest.mark.parametrize("away", [0.0035, -0.0035, 0.0])
def test_a_pendulum_is_held_by_the_friction_of_its_pin(away):
    # m g s sin(phi) < mu r N with N = m g: held up to 0.004 rad; a pin of 10 mm may creep by 1e-6 artanh(0.875) rad/s
    law = {"kind": "friction", "coefficient": 0.2, "radius": "10 mm"}
    scene = bar(law, **{"freedoms": {"O": {"start": -np.pi / 2 + away}}, "analysis.duration": 20.0})
    place = fm.analyse(scene.changed({"analysis.sub_intervals": 20})).data["freedom_place"][:, 0]
    assert np.abs(place + np.pi / 2 - away).max() < 5e-5


def test_a_pendulum_beyond_its_friction_swings_into_the_range_that_holds_it():
    law = {"kind": "friction", "coefficient": 0.2, "radius": "10 mm"}
    scene = bar(law, **{"freedoms": {"O": {"start": -np.pi / 2 + 0.02}}, "analysis.duration": 10.0})
    place = fm.analyse(scene.changed({"analysis.sub_intervals": 50})).data["freedom_place"][:, 0].to_numpy()
    # each half of a swing loses 2 x 0.004 rad: 0.02, -0.012, 0.004, where it is held. Small swings are exact to 1e-4
    np.testing.assert_allclose(place[-1] + np.pi / 2, 0.004, atol=1e-4)
    assert np.ptp(place[-20:]) < 1e-4


@pytest.mark.long
def test_several_rubbing_joints_hold_together():
    # a rocker on a rubbing pin that carries a block on a rubbing guide: 15 deg < atan(0.4), moment of 0 about the pin
    scene = incline("15 deg", **{"analysis.sub_intervals": 10, "analysis.duration": "5 s"})
    scene = scene.changed(
        {
            "links.table": {"points": {"O": (0, 0)}, "rigid": {"mass": 1.0, "inertia": 0.01}},
            "joints.P": {"connect": ("ground.O", "table.O")},
            "joints.G.connect": ("table.O", "block.O"),
            "freedoms.P": {"start": 0.0},
            "joint_laws.pin": {"kind": "friction", "joint": "P", "coefficient": 0.3, "radius": "20 mm"},
        }
    )
    place = fm.analyse(scene).data["freedom_place"].to_numpy()
    assert np.abs(place - place[0]).max() < 1e-5


def bending(scene: fm.Scene, **changes) -> fm.Scene:
    """Give a scene its bar of steel, 20 mm by 10 mm, that bends, with enough damping that its vibration dies out."""
    steps = {"start": "static", "error_estimates": False, "time_tolerance": 1e-3}
    common = {
        "materials.steel": fm.Material(modulus=2.1e11, density=DENSITY),
        "sections.bar": fm.RectangleSection(width="20 mm", height="10 mm"),
        "effects": ("coupling", "gravity"),
        "mesh": fm.Mesh(elements=1),
        "damping": fm.Damping(ratio=0.05),
    }
    return scene.changed(common | {f"analysis.{name}": value for name, value in steps.items()} | changes)


def post(angle: str, **changes) -> fm.Scene:
    """Give a bar of steel, 0.3 m, that stands on an incline in a guide that rubs."""
    arm = {
        "points": {"O": (0, 0), "A": (0, 0.3)},
        "members": {"arm": {"ends": ("O", "A"), "section": "bar", "material": "steel"}},
    }
    return bending(incline(angle, **{"analysis.sub_intervals": 10}), **{"links.block": arm} | changes)


@pytest.mark.long
@pytest.mark.parametrize("angle", ["15 deg", "-20 deg"])
def test_a_bar_that_bends_sticks_on_an_incline(angle):
    # where 91 % of the friction hold it, vibration at the start takes more for a moment, and it slides 0.02 mm
    place = fm.analyse(post(angle)).data["freedom_place"][:, 0].to_numpy()
    assert np.abs(place).max() < 1e-4
    assert np.ptp(place[5:]) < 2e-7  # 10 s at 1e-8 artanh(0.91) m/s


@pytest.mark.long
def test_a_bar_that_bends_is_pushed_below_its_limit_for_20_s():
    # 1 N of mu m g = 0.4 x 0.471 kg x 9.81 = 1.85 N, at its top
    place = fm.analyse(post("0 deg", loads={"push": {"at": "block.A", "force": (1.0, 0)}})).data["freedom_place"]
    assert np.abs(place).max() < 2e-6


@pytest.mark.long
def test_a_bar_that_bends_coasts_to_rest_and_stays_there():
    # s = v^2/(2 mu g): 2e-3 for the vibration that the friction starts, which takes and gives work
    data = fm.analyse(post("0 deg", **{"freedoms.G.speed": 1.0, "analysis.duration": 1.0})).data
    place = data["freedom_place"][:, 0].to_numpy()
    assert place[-1] == pytest.approx(1 / (2 * 0.4 * G), rel=2e-3)
    assert np.ptp(place[5:]) < 1e-6


@pytest.mark.long
@pytest.mark.parametrize("sign", [1, -1])
def test_a_pendulum_that_bends_coasts_to_rest_by_the_friction_of_its_pin(sign):
    # each half of a swing takes 2 mu r/(L/2) = 0.008 rad: 0.019, -0.011, 0.003, where it is held up to 0.004 rad
    scene = bar({"kind": "friction", "coefficient": 0.2, "radius": "10 mm"})
    start = {"freedoms": {"O": {"start": -np.pi / 2 + sign * 0.019}}, "analysis.duration": 5.0}
    bent = fm.Link(
        points={"O": (0, 0), "A": (1, 0)},
        members={"bar": fm.Member(ends=("O", "A"), section="bar", material="steel")},
    )
    scene = bending(scene, **start | {"links": {"bar": bent}, "analysis.sub_intervals": 25})
    swing = fm.analyse(scene).data["freedom_place"][:, 0].to_numpy() + np.pi / 2
    np.testing.assert_allclose(swing[-1], sign * 0.003, atol=5e-5)
    assert np.ptp(swing[-10:]) < 4e-6  # 1.8 s at 1e-6 artanh(0.75) rad/s


def test_a_slider_crank_that_bends_is_held_by_its_guide():
    # crank and rod have no weight beside the block: tan 15 deg = 0.268 < 0.4
    scene = bending(slider_crank(True, joint_laws={"rub": {"kind": "friction", "joint": "G", "coefficient": 0.4}}))
    turned = G * np.array([-np.sin(np.radians(15)), -np.cos(np.radians(15))])
    light = {"materials.steel.density": 1.0, "materials.stiff": fm.Material(modulus=2.1e11, density=1.0)}
    light["analysis.solver"] = "auto"  # poses have no ratios of modes where freedoms move
    steps = {"analysis.duration": 2.0, "analysis.sub_intervals": 10, "freedoms": {"O": {"start": 1.0}}}
    place = fm.analyse(scene.changed(light | steps | {"gravity": tuple(turned)})).data["freedom_place"][:, 0].to_numpy()
    assert np.ptp(place[5:]) < 1e-6  # rad, of a crank of 50 mm


def test_creep_by_a_wide_law_is_told():
    rubs = {"kind": "friction", "coefficient": 0.4, "width": "0.1 mm/s"}
    told = json.loads(fm.analyse(block(rubs, **{"analysis.duration": 2.0})).data.attrs["warnings"])
    assert told == [
        "joint_laws.law.width: where its bodies stick, they creep at up to about 0.0001 m/s, which is 0.2 mm in 2 s. "
        "A smaller width lets them creep less, and takes more steps"
    ]


def test_statics_finds_that_friction_holds_the_block():
    # tan 15 deg = 0.268 < 0.4
    scene = fm.load(SCENES / "sticking_block.toml").changed({"analysis": {"method": "static"}})
    assert fm.analyse(scene).data["freedom_place"].item() == 0.0
