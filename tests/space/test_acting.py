"""Loads, springs, dampers and strokes in space: powers by closed forms of a rigid slider-crank that moves slowly.

Without inertia the drive's power is that of what acts: T w = dE/dt + dissipation - power of the loads.
"""

import numpy as np
import pytest

import fenics_mech as fm
from tests.space.machines import RSSP_N, RSSP_P, rssp, rssp_pin, rssp_stroke

SLOW = 1e-3  # rad/s
POSITIONS = 96


def slope(values):
    """Give the derivative of periodic values by theta, harmonic by harmonic."""
    waves = np.fft.rfft(values, axis=0)
    order = np.arange(len(waves)).reshape(-1, *(1,) * (np.ndim(values) - 1))
    return np.fft.irfft(1j * order * waves, n=len(values), axis=0)


THETA = 2 * np.pi * np.arange(POSITIONS) / POSITIONS
STROKE, PIN = rssp_stroke(THETA), rssp_pin(THETA)
SLIDER = RSSP_P + STROKE[:, None] * RSSP_N


def torque(speed=SLOW, guide="slider", **keys):
    made = rssp(guide, drive={"joint": "O", "speed": speed}, analysis={"positions": POSITIONS}, **keys)
    return np.asarray(fm.analyse(made).data["input_torque"][:, 0])


def off(found, exact):
    """Give the largest difference, over the largest value."""
    return np.abs(found - exact).max() / np.abs(exact).max()


def test_a_push_along_a_slider_is_held_by_the_crank():
    assert off(torque(loads={"push": {"joint": "P", "push": 30.0}}), -30.0 * slope(STROKE)) < 1e-6


def test_a_force_that_varies_over_the_cycle_is_held_by_the_crank():
    """The force keeps its direction; its factor is a harmonic of the drive's angle."""
    force = np.array([3.0, -5.0, 7.0])
    load = {"at": "slider.S", "force": tuple(force), "factor": {"kind": "harmonics", "mean": 1.0, "cosine": [0.5]}}
    assert off(torque(loads={"f": load}), -(1 + 0.5 * np.cos(THETA)) * (slope(SLIDER) @ force)) < 1e-6


def test_a_spring_between_two_points_stores_its_energy():
    """It is free of force as drawn where it states no length."""
    length = np.linalg.norm(PIN - RSSP_P, axis=-1)
    springs = {"s": {"between": ("ground.P", "crank.A"), "stiffness": 500.0}}
    assert off(torque(springs=springs), slope(500.0 * (length - length[0]) ** 2 / 2)) < 1e-6
    springs["s"]["length"] = 0.05
    assert off(torque(springs=springs), slope(500.0 * (length - 0.05) ** 2 / 2)) < 1e-6


@pytest.mark.parametrize("kind", ["point", "line", "hinge"])
def test_dampers_take_their_power(kind):
    """It is c v^2, of the drive at its speed; the line's rate is that of its length."""
    dampers = {
        "point": {"at": "slider.S", "damping": 2e3},
        "line": {"between": ("ground.P", "crank.A"), "damping": 2e3},
        "hinge": {"joint": "O", "damping": 300.0},
    }
    rates = {
        "point": 2e3 * slope(STROKE) ** 2,
        "line": 2e3 * slope(np.linalg.norm(PIN - RSSP_P, axis=-1)) ** 2,
        "hinge": 300.0 + 0 * THETA,
    }
    assert off(torque(dampers={"d": dampers[kind]}) / SLOW, rates[kind]) < 1e-6


def test_a_slider_that_may_turn_in_its_cylinder_is_held_and_told():
    """A body of revolution in a cylinder: its turn moves nothing, so that torques are those of the slider."""
    made = rssp("cylinder", drive={"joint": "O", "speed": 4.0}, analysis={"positions": POSITIONS})
    result = fm.analyse(made)
    assert sorted(result.data["held_link"].values) == ["rod", "slider"]
    exact = np.asarray(
        fm.analyse(rssp(drive={"joint": "O", "speed": 4.0}, analysis={"positions": POSITIONS})).data["input_torque"]
    )
    np.testing.assert_allclose(result.data["input_torque"], exact, atol=1e-9 * np.abs(exact).max())


def test_a_driven_stroke_turns_the_crank_back():
    """The same slider-crank, led at its slider by a part of its stroke: forces are those of the crank that leads."""
    angle = -0.9 * (1 - np.cos(THETA))  # of the crank; its dead centre is at 0.2 rad
    strokes = tuple(rssp_stroke(angle) - rssp_stroke(0.0))
    made = rssp(
        drive={"joint": "P", "law": {"kind": "table", "values": strokes}, "period": 2000.0},
        loads={"brake": {"joint": "O", "torque": 2.0}},
        analysis={"positions": POSITIONS},
    )
    data = fm.analyse(made).data
    np.testing.assert_allclose(data["joint_place"].sel(joint="A"), rssp_pin(angle), atol=1e-9)
    many = np.linspace(-1.9, 0.1, 20001)
    per_angle = np.interp(angle, many, np.gradient(rssp_stroke(many), many))
    np.testing.assert_allclose(data["input_torque"][:, 0], -2.0 / per_angle, rtol=1e-5)  # N
