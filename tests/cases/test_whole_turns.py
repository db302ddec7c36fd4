"""Angles beyond one turn mean what they say: of springs, starts and stops, against closed forms."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import fenics_mech as fm
from fenics_mech.scene.plausibility import implausible

SCENES = Path(__file__).parent / "scenes"
G, MASS, ARM, STIFFNESS = 9.81, 0.05, 0.1, 0.004


def turned(degrees: float) -> str:
    return f"{degrees} deg"


def bar(free: str, start: str | None = "0 deg", **values) -> fm.Scene:
    """A bar that a soft coil holds against its weight; the coil is free at an angle."""
    return fm.Scene(
        name="bar on a coil",
        gravity=(0, -G),
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"bar": fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(mass=MASS, inertia=1e-4, centre=(ARM, 0)))},
        joints={"O": fm.Revolute(connect=("ground.O", "bar.O"))},
        springs={"coil": fm.HingeSpring(joint="O", stiffness=STIFFNESS, angle=free)},
        freedoms={"O": fm.Freedom(start=start)},
        analysis=fm.Analysis(method="static"),
    ).changed(values)


def bent_bar(free: str, start: str, **analysis) -> fm.Scene:
    """A steel strip of 0.3 m on a pin with a coil, which bends."""
    return fm.Scene(
        name="strip on a coil",
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
        springs={"coil": fm.HingeSpring(joint="O", stiffness=2.0, angle=free)},
        freedoms={"O": fm.Freedom(start=start)},
        mesh=fm.Mesh(elements=2),
        analysis=fm.Analysis(**analysis),
    )


def test_a_wound_rotor_swings_about_the_free_angle():
    # J phi'' = -k phi from rest at 900 deg: phi = 900 cos(sqrt(k/J) t); steps in time are of 1e-5 of the energy
    data = fm.analyse(fm.load(SCENES / "wound_spring.toml")).data
    place = np.degrees(data["freedom_place"][:, 0])
    expected = 900 * np.cos(np.sqrt(0.04 / 0.01) * data["time"])
    np.testing.assert_allclose(place, expected, atol=0.01)


@pytest.mark.parametrize("free", [0, 360, 720, 1080, -1440])
def test_a_bar_rests_where_its_wound_coil_bears_it(free):
    # k (phi - free) + m g s cos(phi) = 0, of which the first root that the bar meets on its way from 0
    def left(phi):
        return STIFFNESS * (phi - np.radians(free)) + MASS * G * ARM * np.cos(phi)

    grid = -np.sign(left(0.0)) * np.linspace(0, 30, 30_001)
    first = int(np.flatnonzero(np.sign(left(grid[1:])) != np.sign(left(0.0)))[0])
    root = brentq(left, *sorted(grid[first : first + 2]))
    found = fm.analyse(bar(turned(free))).data["freedom_place"].item()
    assert found == pytest.approx(root, abs=1e-8)


@pytest.mark.slow
def test_a_strip_that_bends_is_wound_by_whole_turns_too():
    # without weight the strip rests at the coil's free angle; with a load on its tip it turns by moment over stiffness
    pushed = {"at": "bar.T", "force": (0, 1.0), "follows": True}
    for free, start in ((1080, 900), (-360, -300)):
        scene = bent_bar(turned(free), turned(start), method="static")
        rest = fm.analyse(scene.changed({"loads.tip": pushed})).data
        # the load bends the strip too, by a slope at its end that does not turn its axis at the pin: 1e-5 of 0.15 rad
        assert rest["spring_force"].item() == pytest.approx(0.3, rel=1e-3)
        assert rest["freedom_place"].item() == pytest.approx(np.radians(free) + 0.3 / 2.0, abs=1e-3)


@pytest.mark.slow
def test_a_strip_that_bends_swings_from_beyond_two_turns():
    # 800 cos(sqrt(k/J) t), J = m L^2/3; a soft coil bends the strip by 1e-5 rad; 0.01 deg of 800 are the steps' 1e-5
    scene = bent_bar("0 deg", "800 deg", method="transient", duration="0.1 s", sub_intervals=5)
    scene = scene.changed({"springs.coil.stiffness": 0.02, "damping.material": "1e-4 s"})
    data = fm.analyse(scene).data
    inertia = 7850 * 1e-4 * 0.3**3 / 3
    expected = 800 * np.cos(np.sqrt(0.02 / inertia) * data["time"])
    np.testing.assert_allclose(np.degrees(data["freedom_place"][:, 0]), expected, atol=0.01)


def test_a_spring_between_two_moving_bodies_keeps_its_turns():
    # about each other they swing as one with J1 J2/(J1 + J2), and the first gives way by J2/(J1 + J2) of that
    scene = fm.Scene(
        name="two rotors",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            name: fm.Link(points=points, rigid=fm.RigidBody(mass=1.0, inertia=inertia))
            for name, points, inertia in (("a", {"O": (0, 0), "A": (0, 0)}, 0.02), ("b", {"A": (0, 0)}, 0.01))
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "a.O")),
            "A": fm.Revolute(connect=("a.A", "b.A")),
        },
        springs={"coil": fm.HingeSpring(joint="A", stiffness=0.04, angle="30 deg")},
        freedoms={"O": fm.Freedom(), "A": fm.Freedom(start="750 deg")},
        analysis=fm.Analysis(method="transient", duration="3 s", sub_intervals=30),
    )
    data = fm.analyse(scene).data
    swing = np.cos(np.sqrt(0.04 * 0.03 / 2e-4) * data["time"].to_numpy())
    found = np.degrees(data["freedom_place"].to_numpy())
    np.testing.assert_allclose(found[:, 1], 30 + 720 * swing, atol=0.01)
    np.testing.assert_allclose(found[:, 0], 240 * (1 - swing), atol=0.01)


def test_stops_beyond_a_turn_hold_where_they_are():
    # at 360 deg/s from 450 deg the rotor meets its stop at 800 deg after 350/360 s, and goes back at half its speed
    scene = bar("0 deg", "450 deg", gravity=(0, 0), springs={}).changed(
        {
            "freedoms.O.speed": "60 rpm",
            "joint_laws.end": {
                "kind": "stop",
                "joint": "O",
                "lower": "400 deg",
                "upper": "800 deg",
                "contact": {"stiffness": 1e5, "restitution": 0.5},
            },
            "analysis": {"method": "transient", "duration": "2 s", "sub_intervals": 20},
        }
    )
    data = fm.analyse(scene).data
    time, place = data["time"].to_numpy(), np.degrees(data["freedom_place"][:, 0].to_numpy())
    expected = np.where(time < 350 / 360, 450 + 360 * time, 800 - 180 * (time - 350 / 360))
    np.testing.assert_allclose(place, expected, atol=0.5)  # the contact itself takes 2 ms


def test_a_spring_that_begins_wound_by_more_than_half_a_turn_is_told():
    told = json.loads(fm.analyse(bar("-200 deg", None)).data.attrs["warnings"])
    assert told == [
        "springs.coil.angle: the joint begins at 0 deg and the spring is free at -200 deg, so that it is wound up at "
        'the start. Whole turns count: "160 deg" is less'
    ]


@pytest.mark.parametrize(("free", "start"), [("-200 deg", "0 deg"), ("720 deg", None), ("170 deg", None)])
def test_a_spring_that_is_meant_to_be_wound_is_not_questioned(free, start):
    assert json.loads(fm.analyse(bar(free, start)).data.attrs["warnings"]) == []


def test_degrees_are_not_thought_forgotten_where_they_stand():
    scene = bent_bar("1800 deg", "0 deg", method="static")
    assert implausible(scene) == ()
    assert implausible(scene.changed({"name": "copy"})) == ()  # a copy keeps that its unit was written
    assert '"1800 deg" is likely meant' in implausible(scene.changed({"springs.coil.angle": 1800.0}))[0]
    driven = scene.changed({"freedoms": {}, "springs": {}, "analysis": {"method": "quasi-static"}})
    law = {"kind": "harmonics", "sine": ("1000 deg",)}
    driven = driven.changed({"drive": {"joint": "O", "law": law, "period": "10 s"}})
    assert implausible(driven) == ()
    law = {"kind": "harmonics", "sine": (1000.0,)}
    assert "degrees are likely meant" in implausible(driven.changed({"drive.law": law}))[0]
