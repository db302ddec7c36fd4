"""Cams and followers against the closed form of a follower that keeps to its cam."""

import numpy as np
import pytest

import fenics_mech as fm
from tests.documents import DOCS, blocks
from tests.joints.scenes import bar
from tests.joints.test_bending import BY_POSES

MASS, SPRING, PRELOAD, LIFT, STIFFNESS = 0.3, 2e4, 200.0, 10e-3, 1e8  # kg, N/m, N, m, N/m
HARMONIC = fm.Harmonics(mean=LIFT / 2, cosine=(-LIFT / 2,))
# the spring must give the acceleration that the end of the lift needs: F0 + k H = m w^2 H/2
LEAVES = np.sqrt((PRELOAD + SPRING * LIFT) / (MASS * LIFT / 2))


def valve(speed: float, **changes) -> fm.Scene:
    """Give a valve on a spring, on a cam that turns at a speed; it starts as deep as the force there presses it."""
    begin = -(PRELOAD + MASS * LIFT / 2 * speed**2) / STIFFNESS
    scene = fm.Scene(
        name="valve",
        ground=fm.Ground(points={"O": (0, 0), "S": (0, 0.2)}),
        links={
            "cam": fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(mass=1.0, inertia=1e-3)),
            "valve": fm.Link(points={"V": (0, 0)}, rigid=fm.RigidBody(mass=MASS)),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "cam.O")),
            "G": fm.Prismatic(connect=("ground.O", "valve.V"), angle="90 deg"),
        },
        drive=fm.Drive(joint="O", speed=speed),
        freedoms={"G": fm.Freedom(start=begin, speed=0.0)},
        springs={"s": fm.LineSpring(between=("ground.S", "valve.V"), stiffness=SPRING, length=0.2 + PRELOAD / SPRING)},
        joint_laws={"cam": fm.Cam(joint="O", drives="G", lift=HARMONIC, stiffness=STIFFNESS, damping=2.0)},
        analysis=fm.Analysis(
            method="transient", cycles=1, sub_intervals=60, time_tolerance=1e-6, error_estimates=False
        ),
    )
    return scene.changed(changes)


def pushed(theta, speed):
    """Force of the cam on a follower that keeps to it (N)."""
    bent = MASS * LIFT / 2 * speed**2 * np.cos(theta)
    return PRELOAD + SPRING * LIFT / 2 * (1 - np.cos(theta)) + bent


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.9, 0.99])
def test_below_the_speed_of_lift_off_the_follower_keeps_to_its_cam(share):
    speed = share * LEAVES
    data = fm.analyse(valve(speed)).data
    theta, largest = data["theta"].to_numpy(), pushed(0, speed)
    force = data["law_effort"].sel(law="cam:G").to_numpy()
    np.testing.assert_allclose(force, pushed(theta, speed), atol=1e-3 * largest)
    torque = pushed(theta, speed) * LIFT / 2 * np.sin(theta)  # of the virtual work, on a cam of constant speed
    np.testing.assert_allclose(data["input_torque"], torque, atol=1e-3 * np.abs(torque).max())
    np.testing.assert_allclose(data["law_effort"].sel(law="cam"), -torque, atol=1e-3 * np.abs(torque).max())
    assert data["indentation"].min() > 0
    assert data.attrs["power_balance_error"] < 1e-8
    assert data["law_effort"].attrs["units"] == "N m, N"


RUBBING = {"joint_laws.cam.friction": 0.1, "joint_laws.cam.radius": 0.02}


def rubs(data, speed):
    """Forces of a cam that rubs on its follower: push, friction, and torque of the drive, by the closed form."""
    theta = data["theta"].to_numpy()
    push = pushed(theta, speed)
    lift, slope = LIFT / 2 * (1 - np.cos(theta)), LIFT / 2 * np.sin(theta)
    return push, 0.1 * push, push * slope + 0.1 * push * (0.02 + lift)


def test_force_of_a_flat_face_goes_through_the_bearing_of_the_cam_and_rubs():
    speed = 0.9 * LEAVES
    data = fm.analyse(valve(speed, **RUBBING)).data
    push, friction, torque = rubs(data, speed)
    near = {"atol": 2e-3 * push.max()}
    bearing, guide = (data["joint_force"].sel(joint=name).to_numpy() for name in ("O", "G"))
    np.testing.assert_allclose(bearing[:, 1], push, **near)  # of the frame on the cam
    np.testing.assert_allclose(bearing[:, 0], -friction, **near)  # the face drags the cam back
    np.testing.assert_allclose(guide[:, 0], friction, **near)
    np.testing.assert_allclose(guide[:, 1], 0, **near)
    np.testing.assert_allclose(data["input_torque"], torque, atol=2e-3 * np.abs(torque).max())
    assert data.attrs["power_balance_error"] < 1e-6


@pytest.mark.slow
def test_a_cam_of_a_member_rubs_as_a_rigid_one():
    speed = 0.5 * LEAVES
    bends = {
        "materials.stiff": {"modulus": 2e16, "density": 7850.0},
        "sections.bar": {"shape": "rectangle", "width": 0.02, "height": 0.01},
        "links.cam": {
            "points": {"O": (0, 0), "A": (0.03, 0)},
            "members": {"bar": {"ends": ("O", "A"), "section": "bar", "material": "stiff"}},
        },
        "effects": ("coupling",),
        "mesh.elements": 1,
        "analysis.time_tolerance": 1e-4,
        "analysis.sub_intervals": 12,
        "analysis.start": "smooth",
        **{f"analysis.{name}": value for name, value in BY_POSES.items()},
    }
    data = fm.analyse(valve(speed, **RUBBING, **bends)).data
    push, friction, torque = rubs(data, speed)
    guide = data["joint_force"].sel(joint="G").to_numpy()
    np.testing.assert_allclose(guide[:, 0], friction, atol=2e-3 * push.max())
    np.testing.assert_allclose(data["law_effort"].sel(law="cam"), -torque, atol=2e-3 * np.abs(torque).max())
    centrifugal = (
        7850.0 * 2e-4 * 0.03 * 0.015 * speed**2 * np.column_stack([np.cos(data["theta"]), np.sin(data["theta"])])
    )
    bearing = data["joint_force"].sel(joint="O").to_numpy() + centrifugal
    np.testing.assert_allclose(bearing, np.column_stack([-friction, push]), atol=2e-3 * push.max())
    assert data.attrs["power_balance_error"] < 1e-4


def test_error_of_steps_is_estimated_where_the_follower_keeps_to_its_cam():
    steps = {"analysis.error_estimates": True, "analysis.time_tolerance": 1e-3}
    data = fm.analyse(valve(0.9 * LEAVES, **steps)).data
    exact = fm.analyse(valve(0.9 * LEAVES, **{"analysis.time_tolerance": 1e-6})).data
    true = float(np.abs(data["joint_force"] - exact["joint_force"]).max())
    told, rounding = float(data["joint_force_error"].max()), 1e-7 * float(np.abs(exact["joint_force"]).max())
    assert 0.5 * true - rounding < told < 5 * true + rounding
    assert "not_estimated" not in data.attrs


def test_above_that_speed_it_leaves_and_flies_under_its_spring_alone():
    speed = 1.02 * LEAVES
    data = fm.analyse(valve(speed)).data
    theta, depth = data["theta"].to_numpy(), data["indentation"].to_numpy()[:, 0]
    assert data.attrs["contacts_closed"] >= 1
    assert (depth[(theta > 3.0) & (theta < 3.4)] < 0).all()
    assert (depth[theta < 2.6] > 0).all()
    flying = depth < 0
    np.testing.assert_array_equal(data["law_effort"].sel(law="cam:G").to_numpy()[flying], 0)
    place = data["freedom_place"].to_numpy()[flying, 0]
    force = data["joint_force"].sel(joint="G").to_numpy()[flying]
    np.testing.assert_allclose(force, 0, atol=1e-9)  # the guide bears nothing, as the spring lies along it
    acceleration = data["point_acceleration"].sel(point="valve.V", component="y").to_numpy()[flying]
    np.testing.assert_allclose(MASS * acceleration, -(PRELOAD + SPRING * place), rtol=1e-6)


@pytest.mark.slow
def test_the_cam_of_the_documents_turns_its_table_and_lets_it_rest(tmp_path):
    page = blocks(DOCS / "how-to" / "cams_and_gears.md")
    shown = next(block.text for block in page if "indexing cam" in block.text)
    (tmp_path / "scene.toml").write_text(shown)
    data = fm.analyse(fm.load(tmp_path / "scene.toml")).data
    rests = data["law_effort"].sel(law="cam:T").to_numpy()[[0, 45, 55, 100]]  # before the move, after it, and back
    np.testing.assert_allclose(rests, 5 * np.radians([60, 90, 90, 60]), rtol=1e-4)
    assert float(data["freedom_place"][45, 0]) == pytest.approx(np.radians(30) - rests[1] / 1e5, rel=1e-6)
    moving = data["law_effort"].sel(law="cam:T").to_numpy()[12:30]
    theta = (np.arange(12, 30) / 100 - 0.1) / 0.2  # of the move
    turned = np.radians(30) * (theta - np.sin(2 * np.pi * theta) / (2 * np.pi))
    gained = np.radians(30) * 2 * np.pi * np.sin(2 * np.pi * theta) / 0.2**2  # rad/s^2 of a cycloid
    np.testing.assert_allclose(moving, 5 * (np.radians(60) + turned) + 0.01 * gained, rtol=1e-3)


@pytest.mark.slow
def test_a_table_of_lifts_is_as_good_as_their_formula():
    angles = 2 * np.pi * np.arange(40) / 40
    table = fm.Table(values=tuple(LIFT / 2 * (1 - np.cos(angles))))
    changed = fm.analyse(valve(0.9 * LEAVES, **{"joint_laws.cam.lift": table})).data
    data = fm.analyse(valve(0.9 * LEAVES)).data
    np.testing.assert_allclose(changed["law_effort"], data["law_effort"], atol=0.1)  # of 560 N


@pytest.mark.slow
def test_a_follower_that_turns_starts_on_its_cam_and_moves_with_it():
    rocker = bar({"kind": "friction", "coefficient": 0.0, "radius": 0.01}).changed(
        {
            "ground.points.C": (0.3, 0),
            "links.cam": {"points": {"C": (0, 0)}, "rigid": {"mass": 1.0, "inertia": 0.01}},
            "joints.C": {"connect": ("ground.C", "cam.C")},
            "joint_laws.cam": fm.Cam(joint="C", drives="O", lift=fm.Harmonics(sine=(0.2,)), stiffness=1e6, damping=1.0),
            "freedoms": {"C": {"start": 0.5, "speed": 2.0}},
            "analysis.duration": 0.2,
            "analysis.error_estimates": False,
        }
    )
    found = fm.analyse(rocker).data
    data = found.sel(freedom="O")
    assert float(data["freedom_place"][0]) == pytest.approx(0.2 * np.sin(0.5), abs=1e-12)
    assert float(data["freedom_rate"][0]) == pytest.approx(0.4 * np.cos(0.5), abs=1e-12)
    cam = found["freedom_place"].sel(freedom="C").to_numpy()
    np.testing.assert_allclose(data["freedom_place"], 0.2 * np.sin(cam), atol=2e-5)  # its weight presses it on


def test_a_valve_at_rest_is_pressed_by_its_preload():
    still = valve(1.0).changed({"analysis.method": "static", "analysis.position": np.pi / 2})
    data = fm.analyse(still).data
    force = (PRELOAD + SPRING * LIFT / 2) * STIFFNESS / (STIFFNESS + SPRING)  # the indentation lets the spring out
    assert float(data["law_effort"].sel(law="cam:G")[0]) == pytest.approx(force, rel=1e-8)
    assert float(data["input_torque"][0]) == pytest.approx(force * LIFT / 2, rel=1e-8)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"joint_laws.cam.drives": "X"}, "X"),
        ({"joint_laws.cam.drives": "O"}, "a cam moves a follower on another joint of two bodies"),
        ({"joint_laws.cam.joint": "G"}, "is at a joint of kind revolute"),
        ({"joint_laws.cam.stiffness": 0.0}, "greater than 0"),
        ({"joint_laws.cam.damping": -1.0}, "greater than or equal to 0"),
        ({"joint_laws.cam.friction": 0.1}, "needs the `radius` of its base circle"),
        (RUBBING | {"joints.G": {"kind": "slot", "connect": ("ground.O", "valve.V")}}, "along a prismatic joint"),
        ({"joint_laws.cam.lift": {"kind": "expression", "formula": "theta"}}, "not periodic"),
    ],
)
def test_bad_cams_are_one_clear_error(changes, words):
    with pytest.raises(fm.SceneError, match=words):
        valve(100.0).changed(changes)
