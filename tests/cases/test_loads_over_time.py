"""Loads over time, place and rate, against closed forms; over the drive angle only where something is driven."""

from pathlib import Path

import numpy as np
import pytest

import fenics_mech as fm

SCENES = Path(__file__).parent / "scenes"
TORQUE, INERTIA = 2.0, 0.05


def wheel(factor: dict, **values) -> fm.Scene:
    """A free wheel on the ground, with a torque of 2 N m from outside times a factor."""
    return fm.Scene(
        name="wheel",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"wheel": fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(mass=3.0, inertia=INERTIA))},
        joints={"O": fm.Revolute(connect=("ground.O", "wheel.O"))},
        freedoms={"O": fm.Freedom(start=0.0)},
        loads={"shaft": fm.Load(at="wheel.O", moment=TORQUE)},
        analysis=fm.Analysis(method="transient", duration=1.0, sub_intervals=20),
    ).changed({"loads.shaft.factor": factor} | values)


def slider(factor: dict, **values) -> fm.Scene:
    """A mass of 2 kg on a guide at 30 deg, with a force of 10 N along it times a factor."""
    along = (10 * np.cos(np.pi / 6), 10 * np.sin(np.pi / 6))
    return fm.Scene(
        name="slider",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"block": fm.Link(points={"B": (0, 0)}, rigid=fm.RigidBody(mass=2.0))},
        joints={"G": fm.Prismatic(connect=("ground.O", "block.B"), angle="30 deg")},
        freedoms={"G": fm.Freedom(start=0.1)},
        loads={"push": fm.Load(at="block.B", force=along)},
        analysis=fm.Analysis(method="transient", duration=1.0, sub_intervals=20),
    ).changed({"loads.push.factor": factor} | values)


def motion(scene: fm.Scene) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    data = fm.analyse(scene).data
    return tuple(data[name].to_numpy().squeeze() for name in ("time", "freedom_place", "freedom_rate"))


def test_a_torque_over_time_turns_a_free_wheel():
    time, _, rate = motion(wheel({"kind": "formula", "formula": "sin(7 * t)"}))
    # J phi'' = T sin(w t); the tolerance of the steps is 1e-5 of the energy
    np.testing.assert_allclose(rate, TORQUE / (INERTIA * 7) * (1 - np.cos(7 * time)), atol=1e-4)


def test_a_torque_by_a_table_of_times():
    table = {"kind": "times", "times": ("0 s", "500 ms", "1 s"), "values": (0, 1, 0)}
    time, _, rate = motion(wheel(table))
    whole = TORQUE / INERTIA
    rises = np.where(time <= 0.5, time**2, 2 * time - time**2 - 0.5)
    np.testing.assert_allclose(rate, whole * rises, atol=1e-3)  # the corner lies inside a step


def test_a_force_in_proportion_to_the_place_is_a_spring():
    time, place, _ = motion(slider({"kind": "formula", "formula": "-8 * place", "joint": "G"}))
    np.testing.assert_allclose(place, 0.1 * np.cos(np.sqrt(80 / 2) * time), atol=1e-6)


def test_a_force_in_proportion_to_the_rate_is_a_damper():
    damps = {"kind": "formula", "formula": "-0.6 * rate", "joint": "G"}
    time, _, rate = motion(slider(damps, **{"freedoms.G.speed": 1.5}))
    np.testing.assert_allclose(rate, 1.5 * np.exp(-3 * time), atol=1e-5)


def test_a_load_over_the_place_has_its_equilibrium():
    # 2 N m (0.3 - phi) = 0: a spring, from which the statics takes its stiffness too
    data = fm.analyse(
        wheel({"kind": "formula", "formula": "0.3 - place", "joint": "O"}, analysis={"method": "static"})
    ).data
    assert data["freedom_place"].item() == pytest.approx(0.3, abs=1e-9)
    assert data["rest_frequency"][0].item() == pytest.approx(np.sqrt(TORQUE / INERTIA) / (2 * np.pi), rel=1e-6)


def test_a_driven_rigid_link_has_its_torque_over_time():
    scene = wheel({"kind": "formula", "formula": "sin(3 * t)"}, freedoms={})
    scene = scene.changed(
        {"analysis": {"method": "transient", "sub_intervals": 20}, "drive": {"joint": "O", "speed": 6.0}}
    )
    data = fm.analyse(scene).data
    np.testing.assert_allclose(data["input_torque"], -TORQUE * np.sin(3 * data["time"]), atol=1e-9)


@pytest.mark.slow
def test_a_strip_that_bends_turns_under_a_force_over_time():
    # the force follows the stiff strip: m L^2/3 phi'' = F L sin(w t); bending of 1e-5 rad is what is left
    scene = fm.Scene(
        name="strip",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "bar": fm.Link(
                points={"O": (0, 0), "T": (0.3, 0)},
                members={"m": fm.Member(ends=("O", "T"), section="strip", material="steel")},
            )
        },
        joints={"O": fm.Revolute(connect=("ground.O", "bar.O"))},
        materials={"steel": fm.Material(modulus="210 GPa", density=7850)},
        sections={"strip": fm.RectangleSection(width="10 mm", height="10 mm")},
        loads={"tip": fm.Load(at="bar.T", force=(0, 0.1), follows=True)},
        freedoms={"O": fm.Freedom(start=0.0)},
        mesh=fm.Mesh(elements=2),
        damping={"material": 1e-4},
        analysis=fm.Analysis(method="transient", duration=0.2, sub_intervals=10),
    ).changed({"loads.tip.factor": {"kind": "formula", "formula": "sin(20 * t)"}})
    time, _, rate = motion(scene)
    inertia = 7850 * 1e-4 * 0.3**3 / 3
    expected = 0.1 * 0.3 / (inertia * 20) * (1 - np.cos(20 * time))
    np.testing.assert_allclose(rate, expected, atol=0.01 * expected.max())


@pytest.mark.parametrize(
    "factor",
    [
        {"kind": "expression", "formula": "sin(theta)"},
        {"kind": "pulse", "start": "10 deg", "end": "90 deg"},
        {"kind": "table", "angles": (0, 1), "values": (0, 1)},
        {"kind": "harmonics", "sine": (1.0,)},
    ],
)
def test_a_factor_over_the_drive_angle_is_refused_where_nothing_is_driven(factor):
    with pytest.raises(fm.SceneError, match=r"loads\.shaft\.factor: .* nothing is driven.*kind = 'formula'"):
        wheel(factor)


def test_the_case_of_a_torque_over_the_drive_angle_is_refused():
    with pytest.raises(fm.SceneError, match="nothing is driven"):
        fm.load(SCENES / "torque_over_time.toml")


@pytest.mark.parametrize(
    ("factor", "message"),
    [
        ({"kind": "formula", "formula": "place"}, "name it with `joint`"),
        ({"kind": "formula", "formula": "theta"}, "theta"),
        ({"kind": "formula", "formula": "rate", "joint": "X"}, "no joint 'X'"),
        ({"kind": "times", "times": (0, 1, 0.5), "values": (0, 1, 0)}, "the times must increase"),
        ({"kind": "times", "times": (0, 1), "values": (0, 1, 0)}, "2 times and 3 values"),
    ],
)
def test_factors_that_cannot_be_are_refused(factor, message):
    with pytest.raises(fm.SceneError, match=message):
        wheel(factor)
