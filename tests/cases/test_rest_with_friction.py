"""Equilibria that dry friction holds, and the range of them: against closed forms of Coulomb's law."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import fenics_mech as fm
from tests.joints.scenes import G, bar
from tests.response import test_free_motion as bent
from tests.response.test_rigid_motion import MACHINE, bars, slider_crank

SCENES = Path(__file__).parent / "scenes"
MASS, MU, STIFFNESS = 2.0, 0.4, 200.0  # of the block
STATIC = {"analysis": {"method": "static"}}
CLOSE = 1e-8  # of a range: bisected to the last digit, at a share of friction of 1 + 1e-9


def incline(angle: float, **changes) -> fm.Scene:
    turned = {"joints.G.angle": f"{angle} deg", "joints.G.turn": f"{angle} deg"}
    return fm.load(SCENES / "sticking_block.toml").changed(STATIC | turned | changes)


def on_spring(angle: float, **changes) -> fm.Scene:
    """Give the block on a spring along its guide, without force at stroke 0."""
    along = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
    spring = {"between": ("ground.W", "block.O"), "stiffness": STIFFNESS, "length": 1.0}
    return incline(angle, **{"ground.points.W": tuple(-along), "springs.s": spring} | changes)


def rest(scene: fm.Scene) -> tuple[float, float, float]:
    data = fm.analyse(scene).data
    return data["freedom_place"].item(), data["rest_lowest"].item(), data["rest_highest"].item()


@pytest.mark.parametrize("angle", [0, 15, -15, 165, 180, 195, 21.7])
def test_a_block_is_held_at_all_places_of_an_incline(angle):
    # |tan a| <= mu at each stroke; the friction is m g sin a, and takes tan a/mu of its limit
    result = fm.analyse(incline(angle))
    data, a = result.data, np.radians(angle)
    assert data["freedom_place"].item() == 0
    assert (data["rest_lowest"].item(), data["rest_highest"].item()) == (-np.inf, np.inf)
    assert data["law_effort"].item() == pytest.approx(MASS * G * np.sin(a), abs=1e-12)
    assert data["friction_used"].item() == pytest.approx(abs(np.tan(a)) / MU, abs=1e-12)
    np.testing.assert_allclose(data["joint_force"].to_numpy().ravel(), [0, MASS * G], atol=1e-12)
    assert "Friction holds the freedom at joint G at all places." in str(fm.summary(result))


@pytest.mark.parametrize("angle", [30, -30, 150, 60])
def test_a_block_on_a_steep_incline_is_held_nowhere(angle):
    times = f"it needs {abs(np.tan(np.radians(angle))) / MU:.4g} times the most that friction gives"
    with pytest.raises(fm.SolverError, match=f"{times}: see joint_laws.rub"):
        fm.analyse(incline(angle))


@pytest.mark.parametrize("angle", [90, 270])
def test_nothing_presses_a_guide_along_the_weight(angle):
    with pytest.raises(fm.SolverError, match="friction gives far too little, as where no force presses a joint"):
        fm.analyse(incline(angle))


@pytest.mark.parametrize("start", [0.0, 0.3, -0.3])
@pytest.mark.parametrize("angle", [0, 15, 30, 90, 180, 200, 270])
def test_a_block_on_a_spring_is_held_in_a_range(angle, start):
    # |k x + m g sin a| <= mu m g |cos a|; from elsewhere it goes to the nearest end of that
    a = np.radians(angle)
    middle, half = -MASS * G * np.sin(a) / STIFFNESS, MU * MASS * G * abs(np.cos(a)) / STIFFNESS
    place, lowest, highest = rest(on_spring(angle, **{"freedoms.G.start": start}))
    np.testing.assert_allclose([lowest, highest], [middle - half, middle + half], atol=CLOSE)
    assert place == pytest.approx(np.clip(start, middle - half, middle + half), abs=CLOSE)


def test_the_static_coefficient_holds():
    rubs = {"joint_laws.rub.static": 0.7, "joint_laws.rub.stribeck": 0.01}
    half = 0.7 * MASS * G / STIFFNESS
    np.testing.assert_allclose(rest(on_spring(0, **rubs)), [0, -half, half], atol=CLOSE)


@pytest.mark.parametrize("angle", [90, 270])
def test_a_side_load_presses_a_vertical_guide(angle):
    # held where mu F >= m g
    push = {"loads.push": {"at": "block.O", "force": (60.0, 0)}}
    assert rest(incline(angle, **push)) == (0, -np.inf, np.inf)
    with pytest.raises(fm.SolverError, match=r"it needs 1\.226 times"):  # m g/(mu 40 N)
        fm.analyse(incline(angle, **{"loads.push": {"at": "block.O", "force": (40.0, 0)}}))


def test_a_stop_bounds_the_range():
    # K d^1.5 <= (mu cos a - sin a) m g up, and <= (mu cos a + sin a) m g down
    a, stiffness = np.radians(15), 1e6
    stop = {"kind": "stop", "joint": "G", "lower": -0.1, "upper": 0.1, "contact": {"stiffness": stiffness}}
    place, lowest, highest = rest(incline(15, **{"joint_laws.stop": stop}))
    deep = [(MASS * G * (MU * np.cos(a) + sign * np.sin(a)) / stiffness) ** (2 / 3) for sign in (-1, 1)]
    assert place == 0
    np.testing.assert_allclose([lowest, highest], [-0.1 - deep[1], 0.1 + deep[0]], atol=CLOSE)


def test_a_stop_catches_what_slides():
    # it comes to rest where the stop carries (sin a - mu cos a) m g, and friction still pushes up at its limit
    a, stop = np.radians(30), {"kind": "stop", "joint": "G", "lower": -0.1, "contact": {"stiffness": 1e6}}
    place, lowest, highest = rest(incline(30, **{"joint_laws.stop": stop}))
    deep = [(MASS * G * (np.sin(a) + sign * MU * np.cos(a)) / 1e6) ** (2 / 3) for sign in (-1, 1)]
    np.testing.assert_allclose([place, lowest, highest], -0.1 - np.array([deep[0], deep[1], deep[0]]), atol=CLOSE)


PIN = {"kind": "friction", "coefficient": 0.2, "radius": "10 mm"}


@pytest.mark.parametrize(
    ("away", "found", "about"),
    [(0.0, 0.0, 0), (0.0035, 0.0035, 0), (0.02, 1, 0), (-0.5, -1, 0), (2.8, 1, 0), (np.pi - 0.003, np.pi - 0.003, 1)],
)
def test_a_pendulum_is_held_by_its_pin(away, found, about):
    # m g l sin phi <= mu r N with N = m g, both where it hangs and where it stands; 1 or -1 is that end of the range
    half = np.arcsin(0.2 * 0.01 / 0.5)
    scene = bar(PIN, freedoms={"O": {"start": -np.pi / 2 + away}}, **STATIC)
    place, lowest, highest = rest(scene.changed({"links.bar.angle": -np.pi / 2 + away}))
    middle = -np.pi / 2 + about * np.pi
    np.testing.assert_allclose([lowest, highest], [middle - half, middle + half], atol=CLOSE)
    expected = found * half if abs(found) == 1 else found
    assert place + np.pi / 2 == pytest.approx(expected, abs=CLOSE)


def test_a_pendulum_whose_place_is_not_stated_hangs_with_its_range():
    data = fm.analyse(bar(PIN, **STATIC).changed({"links.bar.angle": -1.2})).data
    assert data["freedom_place"].item() == pytest.approx(-np.pi / 2, abs=1e-9)
    assert data["rest_highest"].item() == pytest.approx(-np.pi / 2 + np.arcsin(0.004), abs=CLOSE)
    assert "rest_frequency" in data


@pytest.mark.parametrize("start", [0.6, 2.5, -0.7])
@pytest.mark.parametrize("mu", [0.1, 0.3])
def test_a_crank_is_held_by_the_friction_of_its_guide(mu, start):
    # a torque M on the crank, a force F on the piston, no weights: the rod's force S along it gives N = |S sin b|,
    # F + S cos b = share mu |N|, and M = S a sin(p + b), with sin b = a sin p/l
    a, rod, force = MACHINE.a, MACHINE.rod, -100.0
    rubs = {"kind": "friction", "joint": "G", "coefficient": mu}

    def share(crank: float, torque: float) -> float:
        b = np.arcsin(a * np.sin(crank) / rod)
        along = -torque / (a * np.sin(crank + b))  # push of the rod on the piston
        return -(along * np.cos(b) + force) / (mu * abs(along * np.sin(b)))

    torque = brentq(lambda torque: share(start, torque) - 0.3, *sorted((-1e-3 * np.sign(start), -20 * np.sign(start))))
    scene = slider_crank(joint_laws={"rub": rubs}, loads={"push": {"at": "piston.B", "force": (force, 0)}})
    turn = {"freedoms.O": {"start": start, "effort": torque}, "links.crank.angle": start}
    data = fm.analyse(scene.changed(STATIC | turn)).data
    assert data["freedom_place"].item() == start
    assert data["friction_used"].item() == pytest.approx(0.3, abs=1e-9)
    for end in ("rest_lowest", "rest_highest"):
        assert abs(share(data[end].item(), torque)) == pytest.approx(1, abs=1e-6)
    inside = np.linspace(data["rest_lowest"].item(), data["rest_highest"].item(), 50)[1:-1]
    assert all(abs(share(crank, torque)) < 1 for crank in inside)


def test_several_rubbing_joints_hold_one_freedom_together():
    # a bar along X on two pins in line with its weight: both pins turn by the same angle, and bear m g/2 each
    laws = {name: {"kind": "friction", "joint": name, "coefficient": 0.2, "radius": "10 mm"} for name in ("P", "Q")}
    scene = fm.Scene(
        name="parallel rockers",
        ground=fm.Ground(points={"A": (0, 0), "B": (1, 0)}),
        links={
            "left": fm.Link(points={"A": (0, 0), "C": (1, 0)}, angle="-90 deg", rigid=fm.RigidBody(mass=1e-9)),
            "right": fm.Link(points={"B": (0, 0), "D": (1, 0)}, angle="-90 deg", rigid=fm.RigidBody(mass=1e-9)),
            "table": fm.Link(points={"C": (0, 0), "D": (1, 0)}, rigid=fm.RigidBody(mass=3.0, centre=(0.5, 0))),
        },
        joints={
            "P": fm.Revolute(connect=("ground.A", "left.A")),
            "Q": fm.Revolute(connect=("ground.B", "right.B")),
            "C": fm.Revolute(connect=("left.C", "table.C")),
            "D": fm.Revolute(connect=("right.D", "table.D")),
        },
        gravity=(0, -G),
        freedoms={"P": {"start": -np.pi / 2 + 0.001}},
        joint_laws=laws,
        analysis=fm.Analysis(method="static"),
    )
    data = fm.analyse(scene).data
    assert data["freedom_place"].item() == -np.pi / 2 + 0.001
    used = data["friction_used"].to_numpy()
    np.testing.assert_allclose(used, used[0])
    # m g sin(phi) = 2 mu r m g/2 to the first order in mu r, as the moments of the pins load the table too
    assert data["rest_highest"].item() + np.pi / 2 == pytest.approx(0.002, rel=1e-2)


@pytest.mark.parametrize("start", [0.05, -0.05, 0.3])
def test_a_toggle_is_held_at_its_dead_centres(start):
    # near a dead centre the whole load F goes through the pins: F x'' p = mu r F sum of the pins' rates, to (mu r/a)^2
    a, rod, mu, radius = MACHINE.a, MACHINE.rod, 0.15, 0.01
    laws = {name: {"kind": "friction", "joint": name, "coefficient": mu, "radius": radius} for name in "OAB"}
    scene = slider_crank(joint_laws=laws, loads={"push": {"at": "piston.B", "force": (-100.0, 0)}})
    place, lowest, highest = rest(scene.changed(STATIC | {"freedoms.O.start": start, "links.crank.angle": start}))
    far, sign = (np.pi, -1) if abs(start) > 0.1 else (0.0, 1)
    turns = 1 + abs(1 + sign * a / rod) + a / rod
    half = mu * radius * turns / (a * (1 + sign * a / rod))
    np.testing.assert_allclose([lowest, highest], [far - half, far + half], atol=half * 6e-3)
    assert place == (lowest if far else start)


def ladder(angle: float) -> fm.Scene:
    """Give a bar of 2 m that leans on a wall and a floor, which rub."""
    return fm.Scene(
        name="ladder",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "bar": fm.Link(
                points={"A": (0, 0), "B": (2, 0)},
                angle=angle,
                rigid=fm.RigidBody(mass=1.0, inertia=1 / 3, centre=(1, 0)),
            )
        },
        joints={
            "A": fm.Slot(connect=("ground.O", "bar.A"), angle=0.0),
            "B": fm.Slot(connect=("ground.O", "bar.B"), angle="90 deg"),
        },
        gravity=(0, -G),
        freedoms={"A": {"start": -2 * np.cos(angle)}},
        joint_laws={name: {"kind": "friction", "joint": name, "coefficient": 0.3} for name in "AB"},
        analysis=fm.Analysis(method="static"),
    )


LEAST = np.arctan((1 - 0.3**2) / (2 * 0.3))  # of a ladder's angle to the floor, with the same friction at both ends


def test_a_ladder_leans():
    place, lowest, highest = rest(ladder(LEAST + 0.02))
    assert place == -2 * np.cos(LEAST + 0.02)
    np.testing.assert_allclose([lowest, highest], [-2 * np.cos(LEAST), 2 * np.cos(LEAST)], atol=CLOSE)


def test_a_ladder_that_leans_too_far_slides_down():
    with pytest.raises(fm.SolverError, match="no equilibrium of the freedom at joint A is found"):
        fm.analyse(ladder(LEAST - 0.05))


def test_friction_at_a_joint_that_a_drive_holds_holds_no_freedom():
    # two bars: the first is held level by its drive, and the second hangs from it without friction
    laws = {"rub": PIN | {"joint": "P0"}}
    scene = bars(2, 1e-5).changed(STATIC | {"drive": {"joint": "P0", "speed": 3.0}, "joint_laws": laws})
    data = fm.analyse(scene.changed({"freedoms.P1": {"start": -1.0}})).data
    assert data["freedom_place"].item() == pytest.approx(-np.pi / 2, abs=1e-8)
    assert "rest_lowest" not in data


def test_forces_of_friction_alone_hold_nothing():
    # without weights nothing but the spring acts: it pulls the piston until it is as long as without force
    laws = {name: PIN | {"joint": name} for name in "OAB"} | {
        "g": {"kind": "friction", "joint": "G", "coefficient": 0.15}
    }
    spring = {"s": {"between": ("ground.O", "piston.B"), "stiffness": 1000.0, "length": MACHINE.rod}}
    scene = slider_crank(joint_laws=laws, springs=spring)
    scene = scene.changed(STATIC | {"freedoms.G.start": 0.13, "links.crank.angle": 1.2})
    np.testing.assert_allclose(rest(scene), MACHINE.rod, atol=CLOSE)


def test_a_guide_that_jams_holds_any_load():
    # a push at 60 degrees across the guide: |F cos| <= mu |F sin| needs 0.577 < 0.6
    push = {"loads.push": {"at": "block.O", "force": (500.0, -1000.0 * np.sin(np.pi / 3))}, "gravity": (0, 0)}
    result = incline(0, **push).changed({"joint_laws.rub.coefficient": 0.6})
    data = fm.analyse(result).data
    assert data["friction_used"].item() == pytest.approx(1 / (0.6 * np.tan(np.pi / 3)), rel=1e-9)


def test_a_belt_that_runs_pushes_at_its_full_friction():
    # k x = mu m g
    belt = {"joint_laws.rub.belt_speed": 0.2, "joint_laws.rub.width": 1e-4}
    data = fm.analyse(on_spring(0, **belt)).data
    assert data["freedom_place"].item() == pytest.approx(MU * MASS * G / STIFFNESS, rel=1e-9)
    assert "rest_lowest" not in data


def test_the_viscous_share_damps_small_motions():
    data = fm.analyse(on_spring(0, **{"joint_laws.rub.coefficient": 0.0, "joint_laws.rub.viscous": 4.0})).data
    np.testing.assert_allclose(data["rest_decay"], 4.0 / (2 * MASS), rtol=1e-6)


def test_several_freedoms_with_friction_are_refused():
    scene = incline(
        0,
        **{
            "links.block.points.B": (0, 0),
            "links.arm": {"points": {"B": (0, 0)}, "rigid": {"mass": 1.0, "centre": (0.5, 0)}},
        },
    )
    scene = scene.changed({"joints.B": {"connect": ("block.B", "arm.B")}, "freedoms.B": {"start": -1.5}})
    with pytest.raises(fm.SceneError, match=r"joint_laws\.rub: .*one freedom of links that are rigid.*joint G, B"):
        fm.analyse(scene)


def test_links_that_bend_are_refused_beside_friction():
    rubs = {"rub": PIN | {"joint": "P0"}}
    with pytest.raises(fm.SceneError, match=r"joint_laws\.rub: .*links that bend. Write method = 'transient'"):
        fm.analyse(bent.bars(1).changed({"freedoms.P0": {}, "joint_laws": rubs, "analysis": {"method": "static"}}))


@pytest.mark.slow  # an equilibrium of a bending link
def test_friction_that_does_not_rub_changes_no_equilibrium_of_links_that_bend():
    rubs = {"rub": PIN | {"joint": "P0", "coefficient": 0.0}}
    scene = bent.bars(1).changed({"freedoms.P0": {}, "joint_laws": rubs, "analysis": {"method": "static"}})
    place = fm.analyse(scene.changed({"mesh.elements": 2})).data["freedom_place"].item()
    assert place == pytest.approx(-np.pi / 2, abs=1e-8)


def test_a_linkage_without_forces_rests_where_it_is():
    data = fm.analyse(incline(15, gravity=(0, 0))).data
    assert data["freedom_place"].item() == 0
    assert data["friction_used"].item() == 0


def test_drives_that_hold_all_links_are_told_beside_friction():
    rubs = {"kind": "friction", "joint": "G", "coefficient": 0.2}
    led = {"drive": {"joint": "O", "speed": 60.0}, "joint_laws": {"rub": rubs}}
    told = json.loads(fm.analyse(slider_crank().changed(STATIC | led)).data.attrs["warnings"])
    assert any("joint_laws.rub: the drives hold all links" in one for one in told)


def test_friction_in_a_clearance_is_told_to_be_left_out():
    springs = {"s": {"between": ("ground.O", "piston.B"), "stiffness": 100.0, "length": 0.1}}
    loose = {"joint": "B", "radial": 1e-6, "radius": 0.01, "contact": {"stiffness": 1e9}, "friction": 0.1}
    scene = slider_crank(gravity=(0, -G), springs=springs, joint_laws={"loose": {"kind": "clearance"} | loose})
    told = json.loads(fm.analyse(scene.changed(STATIC)).data.attrs["warnings"])
    assert any("joint_laws.loose.friction: friction of a contact at rest is left out" in one for one in told)
