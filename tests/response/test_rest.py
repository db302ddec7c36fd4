"""Equilibria of linkages with freedoms, and small motions about them, against closed forms and other methods."""

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import brentq

import fenics_mech as fm
from tests.joints.scenes import bar
from tests.response import test_free_motion as bent
from tests.response.test_rigid_motion import MACHINE, G, bars, slider_crank

STATIC = {"analysis.method": "static", "analysis.duration": None}
OPEN_STOP = {"kind": "stop", "lower": -9.0, "contact": {"stiffness": 1e5}}


def test_a_chain_of_three_bars_hangs_and_swings_in_its_three_modes():
    scene = bars(3, 1e-5).changed(STATIC | {"links.b0.angle": 2.0, "links.b1.angle": 0.3})
    data = fm.analyse(scene).data
    np.testing.assert_allclose(np.exp(1j * np.cumsum(data["freedom_place"][0])), -1j, atol=1e-8)
    count = np.arange(3)
    mass = 2.5 - np.maximum.outer(count, count) - np.eye(3) / 6  # absolute angles, L = 1 m, m = 1 kg
    omega = np.sqrt(eigh(np.diag(G * (2.5 - count)), mass, eigvals_only=True))
    np.testing.assert_allclose(2 * np.pi * data["rest_frequency"], omega, rtol=1e-6)
    np.testing.assert_array_equal(data["rest_decay"], 0)


def test_a_bar_on_a_spring_and_a_damper_rests_where_their_moments_balance():
    stiffness, damping, inertia = 6.0, 0.3, 1 / 3
    springs = {"s": {"joint": "O", "stiffness": stiffness, "angle": 0.0}}
    scene = bar(OPEN_STOP, springs=springs, dampers={"d": {"joint": "O", "damping": damping}}, **STATIC)
    data = fm.analyse(scene).data
    place = brentq(lambda angle: stiffness * angle + G / 2 * np.cos(angle), -1.5, 0)
    assert float(data["freedom_place"][0, 0]) == pytest.approx(place, abs=1e-9)
    decay, square = damping / (2 * inertia), (stiffness - G / 2 * np.sin(place)) / inertia
    assert float(data["rest_decay"][0]) == pytest.approx(decay, rel=1e-6)
    assert 2 * np.pi * float(data["rest_frequency"][0]) == pytest.approx(np.sqrt(square - decay**2), rel=1e-6)


def test_friction_takes_nothing_where_a_bar_hangs_and_a_strong_damper_lets_nothing_oscillate():
    rubs = {"kind": "friction", "joint": "O", "coefficient": 0.5, "radius": 0.1}
    scene = bar(OPEN_STOP, dampers={"d": {"joint": "O", "damping": 20.0}}, **STATIC)
    data = fm.analyse(scene.changed({"joint_laws.rubs": rubs})).data
    assert float(data["freedom_place"][0, 0]) == pytest.approx(-np.pi / 2, abs=1e-9)
    np.testing.assert_allclose(np.prod(data["rest_decay"]), G / 2 * 3, rtol=1e-6)  # of s^2 + c s/J + m g L/(2 J)
    np.testing.assert_array_equal(data["rest_frequency"], 0)
    assert float(data["law_effort"].sel(law="rubs")[0]) == 0


def test_a_bar_lies_on_a_stop_as_deep_as_its_weight_presses_it():
    scene = bar({"kind": "stop", "lower": -1.0, "contact": {"stiffness": 1e5}}, **STATIC)
    result = fm.analyse(scene.changed({"freedoms": {"O": {"start": 0.0}}}))
    place = brentq(lambda angle: 1e5 * (-1 - angle) ** 1.5 - G / 2 * np.cos(angle), -1.1, -1.0)
    assert float(result.data["freedom_place"][0, 0]) == pytest.approx(place, abs=1e-9)
    text = str(fm.summary(result))
    assert "at rest" in text
    assert "static, 1 position " in text
    assert "closed" not in text


def test_a_journal_rests_in_its_bearing_where_the_pin_would_have_the_same_force():
    springs = {"s": {"between": ("ground.O", "piston.B"), "stiffness": 100.0, "length": 0.1}}
    scene = slider_crank(gravity=(0, -G), springs=springs).changed(STATIC)
    rattle = {"kind": "clearance", "joint": "B", "radial": 1e-6, "radius": 0.01, "contact": {"stiffness": 1e9}}
    data = fm.analyse(scene.changed({"joint_laws": {"rattle": rattle}})).data
    force = float(data["law_effort"][0, 0])
    pinned = fm.analyse(scene).data["joint_force"].sel(joint="B")[0].to_numpy()
    assert force == pytest.approx(np.hypot(*pinned), rel=1e-3)
    assert float(data["indentation"][0, 0]) == pytest.approx((force / 1e9) ** (2 / 3), rel=1e-6)


def test_a_drive_is_held_beside_a_freedom():
    drive = {"joint": "P0", "speed": 3.0}
    scene = bars(2, 1e-5).changed(STATIC | {"drive": drive, "analysis.position": 2.5})
    data = fm.analyse(scene).data
    assert float(data["theta"][0]) == 2.5
    assert float(data["freedom_place"][0, 0] + 2.5) == pytest.approx(-np.pi / 2 + 2 * np.pi, abs=1e-8)
    assert float(data["input_torque"][0]) == pytest.approx(1.5 * G * np.cos(2.5), rel=1e-9)  # both hang on the first


def test_a_linkage_that_drives_lead_has_the_forces_of_its_loads():
    changes = STATIC | {"drive": {"joint": "O", "speed": 60.0}, "analysis.position": 0.7}
    push = {"pull": {"at": "piston.B", "force": (-100.0, 0)}}
    data = fm.analyse(slider_crank(loads=push).changed(changes)).data
    crank, rod = MACHINE.a, MACHINE.rod
    way = -crank * np.sin(0.7) - crank**2 * np.sin(0.7) * np.cos(0.7) / np.sqrt(rod**2 - (crank * np.sin(0.7)) ** 2)
    assert float(data["input_torque"][0]) == pytest.approx(100 * way, rel=1e-9)


@pytest.mark.slow  # four equilibria of bending links
def test_a_hanging_strip_swings_as_its_modes_with_geometric_stiffness():
    strip = {"materials.stiff.modulus": 2e9, "mesh.elements": 4, "analysis.start": "rigid"} | STATIC
    scene = bent.bars(1).changed(strip)
    result = fm.analyse(scene.changed({"freedoms": {"P0": {}}, "effects": "auto"}))
    data = result.data
    assert float(data["freedom_place"][0, 0]) == pytest.approx(-np.pi / 2, abs=1e-8)
    hangs = {"links.b0.angle": -np.pi / 2, "effects": ("gravity", "geometric-stiffness")}
    modes = fm.modes(scene.changed(hangs)).data["frequency"].to_numpy()[0]
    np.testing.assert_allclose(data["rest_frequency"][:3], modes[:3], rtol=1e-3)
    assert "Small motions" in str(fm.summary(result))


@pytest.mark.slow
def test_two_bending_bars_on_a_spring_rest_where_drives_there_need_no_effort():
    changes = {"materials.stiff.modulus": 2e11, "mesh.elements": 2, "analysis.start": "rigid"} | STATIC
    scene = bent.bars(2).changed(changes | {"springs": {"t": {"joint": "P0", "stiffness": 40.0, "angle": 0.0}}})
    scene = scene.changed({"effects": "auto"})
    data = fm.analyse(scene.changed({"freedoms": {"P1": {}}})).data
    places = {str(name): float(data["freedom_place"].sel(freedom=name)[0]) for name in data["freedom"].to_numpy()}
    held = [{"joint": name, "speed": 1.0, "start": place} for name, place in places.items()]
    led = fm.analyse(scene.changed({"drive": held})).data
    assert abs(led["drive_effort"]).max() < 1e-9  # the spring has a moment of 20 N m
    np.testing.assert_allclose(led["strain"], data["strain"], atol=1e-6 * float(abs(data["strain"]).max()))
    assert places["P0"] + places["P1"] == pytest.approx(-np.pi / 2, abs=0.05)  # the second bar hangs at a bent end


def test_a_bar_on_a_soft_spring_vibrates_as_pinned_and_free_and_its_material_damps_what_bends():
    """Closed forms: ``w = 3.92660^2 sqrt(E I/(m L^4))`` decays by ``tau w^2/2``; the spring swings all of the bar."""
    modulus, lag, stiffness, mass = 2e9, 1e-3, 0.01, 7850 * 2e-4  # kg/m
    soft = {"materials.stiff.modulus": modulus, "mesh.elements": 8, "analysis.start": "rigid", "gravity": (0, 0)}
    spring = {"springs": {"s": {"joint": "P0", "stiffness": stiffness, "angle": 0.3}}, "damping.material": lag}
    freedom = {"freedoms": {"P0": {}}, "effects": ("coupling", "large-rotations")}
    data = fm.analyse(bent.bars(1).changed(STATIC | soft | spring | freedom)).data
    bending = 3.926602**2 * np.sqrt(modulus * 0.02 * 0.01**3 / 12 / mass)
    swings = np.sqrt(stiffness / (mass / 3))
    assert float(data["freedom_place"][0, 0]) == pytest.approx(0.3, abs=1e-10)
    np.testing.assert_allclose(data["rest_frequency"][:2], np.array([swings, bending]) / (2 * np.pi), rtol=2e-3)
    assert float(data["rest_decay"][1]) == pytest.approx(lag * bending**2 / 2, rel=5e-3)
    assert float(data["rest_decay"][0]) < 1e-4


def test_soft_bars_rest_where_they_hang_though_they_start_far_from_it():
    soft = {"materials.stiff.modulus": 2e9, "mesh.elements": 2, "analysis.start": "rigid"} | STATIC
    data = fm.analyse(bent.bars(2).changed(soft | {"freedoms": {"P1": {}}, "damping.ratio": 0.02})).data
    places = {str(name): float(data["freedom_place"].sel(freedom=name)[0]) for name in data["freedom"].to_numpy()}
    assert places == pytest.approx({"P0": -np.pi / 2, "P1": 0.0}, abs=1e-8)
    assert (data["rest_decay"] > 0).all()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"freedoms.O.start": "90 deg"}, "unstable: a small disturbance grows by a rate of 3.836 1/s"),
        ({"freedoms.O.effort": 50.0}, "no equilibrium of the freedom at joint O is found"),
        ({"gravity": (0, 0)}, "nothing holds the freedom at joint O"),
        ({"links.bar.rigid": {"mass": 0.0}, "loads": {"w": {"at": "bar.O", "moment": 1.0}}}, "moves no mass"),
    ],
)
def test_what_does_not_rest_is_an_error(changes, words):
    scene = bar(OPEN_STOP, freedoms={"O": {"start": "80 deg"}}, **STATIC).changed(changes)
    with pytest.raises(fm.SolverError, match=words):
        fm.analyse(scene)


def test_an_unstable_equilibrium_may_be_accepted():
    scene = bar(OPEN_STOP, freedoms={"O": {"start": "90 deg"}}, **STATIC)
    data = fm.analyse(scene.changed({"analysis.allow_unstable": True})).data
    np.testing.assert_allclose(sorted(data["rest_decay"]), np.array([-1, 1]) * np.sqrt(1.5 * G), rtol=1e-6)


def test_bending_links_with_joint_laws_alone_do_not_rest():
    laws = {"stop": OPEN_STOP | {"joint": "P0"}}
    with pytest.raises(fm.SceneError, match="or 'static' for an equilibrium of freedoms"):
        bent.bars(1).changed({"analysis.method": "static", "joint_laws": laws})
