"""Drive torques and equilibria of turning rigid linkages in space, by energy and by closed forms."""

import numpy as np
import pytest
from scipy.optimize import brentq

import fenics_mech as fm
from tests.space.machines import (
    ORIGIN,
    RSSR_A,
    RSSR_Q,
    Y,
    Z,
    body,
    place,
    rigid_rssr_links,
    rssr,
    rssr_ball,
    rssr_output,
    scene,
    slim,
)

G = 9.81


def rate(values, theta_rate):
    """Give the rate of periodic values at even positions ``(positions, ...)``, harmonic by harmonic."""
    waves = np.fft.rfft(values, axis=0)
    order = np.arange(len(waves)).reshape(-1, *(1,) * (np.ndim(values) - 1))
    return np.fft.irfft(1j * theta_rate * order * waves, n=len(values), axis=0)


def energy_of_rod(mass, a, b, speed):
    """Kinetic and potential energy of a thin rod between two moving places (J)."""
    va, vb = rate(a, speed), rate(b, speed)
    kinetic = mass / 6 * np.sum(va * va + va * vb + vb * vb, axis=-1)
    return kinetic + mass * G * (a + b)[:, 2] / 2


@pytest.mark.parametrize("method", ["periodic", "quasi-static"])
def test_the_drive_of_an_rssr_gives_the_change_of_energy(method):
    """By places of the closed form alone: power = d/dt of the energy of three thin rods, a disc and a mass."""
    speed, masses, disc, bob = 12.0, (0.7, 1.1, 0.9), 3e-3, 0.4
    links = rigid_rssr_links(masses)
    B = rssr_ball(0.0)
    made = slim(RSSR_Q, B, masses[2])
    links["rocker"]["rigid"] = made | {"inertia": place(np.array(made["inertia"]) + disc * np.array([0.5, 1, 0.5]))}
    scene_ = rssr(
        links,
        gravity=(0, 0, -G),
        masses={"bob": {"at": "coupler.B", "mass": bob}},
        drive={"joint": "O", "speed": speed},
        analysis={"method": method, "positions": 128},
    )
    data = fm.analyse(scene_).data
    theta = np.asarray(data["theta"])
    A, B = 0.1 * np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1), rssr_ball(theta)
    turning, falling = rate(rssr_output(theta), speed), np.sum(rate(B, speed) ** 2, axis=-1)
    energy = (
        energy_of_rod(masses[0], 0 * A, A, speed)
        + energy_of_rod(masses[1], A, B, speed)
        + energy_of_rod(masses[2], RSSR_Q + 0 * B, B, speed)
        + disc * turning**2 / 2
        + bob * (falling / 2 + G * B[:, 2])
    )
    power = rate(energy, speed)
    found = np.asarray(data["input_torque"][:, 0]) * speed
    np.testing.assert_allclose(found, power, atol=1e-8 * np.abs(power).max())
    assert np.abs(power).max() > 1  # W


def test_forces_on_a_rigid_coupler_are_its_inertia():
    """Newton and Euler on a rod with a disc between both joints.

    The universal joint keeps the direction c across Z and the rod, so that the rod's spin follows from places alone.
    """
    speed, mass, disc = 12.0, 1.1, 4e-3
    links, B0 = rigid_rssr_links((0.7, mass, 0.9)), rssr_ball(0.0)
    e0, across = (B0 - RSSR_A) / np.linalg.norm(B0 - RSSR_A), mass * 0.4**2 / 12 + disc / 2
    tensor = across * (np.eye(3) - np.outer(e0, e0)) + disc * np.outer(e0, e0)
    links["coupler"]["rigid"] |= {
        "inertia": place(np.diag(tensor)),
        "products": (-tensor[0, 1], -tensor[0, 2], -tensor[1, 2]),
    }
    made = rssr(links, gravity=(0, 0, -G), drive={"joint": "O", "speed": speed}, analysis={"positions": 128})
    data = fm.analyse(made).data
    theta = np.asarray(data["theta"])
    A, B = 0.1 * np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1), rssr_ball(theta)
    centre = (A + B) / 2
    at_A, at_B = (np.asarray(data["joint_force"].sel(joint=j)) for j in "AB")
    inertia = mass * (rate(rate(centre, speed), speed) + [0, 0, G])
    np.testing.assert_allclose(at_A - at_B, inertia, atol=1e-8 * np.abs(inertia).max())
    e = (B - A) / 0.4
    c = np.cross(Z, e) / np.linalg.norm(np.cross(Z, e), axis=-1, keepdims=True)
    spin = np.sum(rate(c, speed) * np.cross(e, c), axis=-1, keepdims=True)
    momentum = across * np.cross(e, rate(e, speed)) + disc * spin * e
    moment_A = np.asarray(data["joint_moment"].sel(joint="A"))
    moments = moment_A + np.cross(A - centre, at_A) - np.cross(B - centre, at_B)
    torque = rate(momentum, speed)
    np.testing.assert_allclose(moments, torque, atol=1e-8 * np.abs(torque).max())
    assert float(np.abs(data["joint_moment"].sel(joint="B")).max()) < 1e-12  # of a ball
    # a universal joint holds the turn about the normal of its cross alone
    size = np.abs(moment_A).max()
    assert size > 0.01
    assert np.abs(moment_A @ np.array(Z)).max() < 1e-9 * size
    assert np.abs(np.sum(moment_A * c, axis=-1)).max() < 1e-9 * size


def governor(speed, stiffness=2.0):
    """An arm on a turning shaft, hinged across it, with a spring that is free as drawn, and a heavy end."""
    arm, out, mass, drawn = 0.2, 0.03, 0.8, np.radians(20)
    hinge = np.array([out, 0, 0])
    ball = hinge + arm * np.array([np.sin(drawn), 0, -np.cos(drawn)])
    made = scene(
        {
            "shaft": body({"O": ORIGIN, "H": hinge}, 1.0, (1e-3, 1e-3, 1e-3), ORIGIN),
            "arm": body({"H": hinge, "B": ball}, mass, (0, 0, 0), ball),
            "flag": body({"B": ball}, 0.0, (0, 0, 0), ball),
        },
        {
            "O": {"connect": ("ground.O", "shaft.O"), "axis": Z},
            "H": {"connect": ("shaft.H", "arm.H"), "axis": Y},
            "B": {"connect": ("arm.B", "flag.B"), "kind": "weld"},
        },
        ground={"points": {"O": ORIGIN}},
        gravity=(0, 0, -G),
        springs={"H": {"joint": "H", "stiffness": stiffness}},
        dampers={"H": {"joint": "H", "damping": 0.05}},
        drive={"joint": "O", "speed": speed},
        analysis={"positions": 60},
    )

    def left(angle):
        turning = mass * speed**2 * (out + arm * np.sin(angle)) * arm * np.cos(angle)
        return turning - mass * G * arm * np.sin(angle) - stiffness * (angle - drawn)

    return made, brentq(left, 0, np.pi / 2), hinge, arm


@pytest.mark.parametrize("speed", [4.0, -9.0, 15.0])
def test_a_governor_swings_out_to_its_closed_form(speed):
    made, angle, hinge, arm = governor(speed)
    data = fm.analyse(made).data
    theta = np.asarray(data["theta"])
    B = np.asarray(data["joint_place"].sel(joint="B"))
    radius = hinge[0] + arm * np.sin(angle)
    exact = np.stack([radius * np.cos(theta), radius * np.sin(theta), -arm * np.cos(angle) + 0 * theta], axis=-1)
    np.testing.assert_allclose(B, exact, atol=1e-7)  # of 0.2 m: the tolerance of Newton's method
    centripetal = 0.8 * speed**2 * radius * arm
    assert float(np.abs(data["input_torque"]).max()) < 1e-5 * centripetal  # it turns evenly without a drive
    assert float(np.abs(data["multiplier"]).max()) < 1
