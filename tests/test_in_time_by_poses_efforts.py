"""Efforts and laws of joints by the equation of poses, against equations of rigid bodies that scipy integrates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fenics_mech as fm
from fenics_mech.scene.freedoms import effort_of, with_slopes
from tests.test_in_time_by_poses import LENGTH, MASS, at, bars

TURNS = MASS * LENGTH**2 / 3  # inertia of a bar about its end (kg m^2)
INERTIA = 3e-3
MOTORS = {
    "dc-motor": ({"stall_torque": 0.05, "no_load_speed": 10.0}, lambda t, x, v: 0.05 * (1 - v / 10)),
    "induction-motor": (
        {"breakdown_torque": 0.05, "breakdown_slip": 0.2, "synchronous_speed": -10.0},
        lambda t, x, v: -0.05 * 2 * (1 + v / 10) * 0.2 / ((1 + v / 10) ** 2 + 0.2**2),
    ),
    "speed-controller": (
        {"speed": 4.0, "proportional": 0.02, "integral": 0.05},
        lambda t, x, v: 0.02 * (4 - v) + 0.05 * (4 * t - x),
    ),
    "formula": ({"formula": "0.03 * cos(theta) - 0.01 * omega + 0.02 * t"}, None),
}


def moved(effort, mass, t):
    """Integrate the motion of one coordinate from rest."""
    return solve_ivp(lambda t, y: (y[1], effort(t, *y) / mass), (0, t[-1]), [0, 0], t_eval=t, rtol=1e-9, atol=1e-12).y


@pytest.mark.parametrize("kind", MOTORS)
def test_a_bar_that_a_motor_turns_goes_as_a_rigid_one(kind):
    """It bends by 1e-4 rad, as its angle at the pin does. What it takes is the effort less that of its rotor."""
    stated, law = MOTORS[kind]
    law = law or (lambda t, x, v: 0.03 * np.cos(x) - 0.01 * v + 0.02 * t)
    freedom = {"start": 0.0, "effort": {"kind": kind, **stated}, "inertia": INERTIA}
    changes = {"freedoms": {"J0": freedom}, "analysis.start": "static", "analysis.time_tolerance": 1e-3}
    data = fm.analyse(bars(elements=1, **changes)).data
    t = data["time"].to_numpy()
    place, rate = moved(law, TURNS + INERTIA, t)
    np.testing.assert_allclose(at(data, "freedom_place", freedom="J0"), place, atol=1e-3)
    np.testing.assert_allclose(at(data, "freedom_rate", freedom="J0"), rate, atol=3e-3)
    effort = law(t, place, rate)
    net = effort * TURNS / (TURNS + INERTIA)
    np.testing.assert_allclose(at(data, "drive_effort", drive="J0"), net, atol=1e-2 * np.abs(net).max())
    np.testing.assert_allclose(at(data, "support_moment", support="J0"), -effort, atol=2e-3 * np.abs(effort).max())
    given = float(data["mean_power"].sel(cause="freedom")) * t[-1]
    assert given == pytest.approx(TURNS * rate[-1] ** 2 / 2, rel=3e-3)
    assert data.attrs["power_balance_error"] < 1e-5
    if kind in ("dc-motor", "induction-motor"):
        np.testing.assert_allclose(
            at(data, "electrical_power", motor_at="J0"), effort * (10 if kind[0] == "d" else -10), rtol=5e-3
        )


@pytest.mark.parametrize("kind", MOTORS)
def test_slopes_of_efforts_are_those_of_differences(kind):
    """Central differences by h = 1e-4 have h^2/6 of the third derivative, at most 1e-8 here."""
    effort = fm.Freedom(effort={"kind": kind, **MOTORS[kind][0]}).effort
    t, place, rate, h = np.array([0.3, 0.7]), np.array([0.2, -1.0]), np.array([2.0, -4.0]), 1e-4
    value = lambda x, v: effort_of(effort, t, (x, v), 0.1)  # noqa: E731
    found = with_slopes(effort, t, (place, rate), 0.1)
    by_place, by_rate = (
        (value(place + x, rate + v) - value(place - x, rate - v)) / (2 * h) for x, v in ((h, 0.0), (0.0, h))
    )
    np.testing.assert_allclose(found, [value(place, rate), by_place, by_rate], atol=1e-8)


def test_a_force_in_a_guide_moves_a_bar_by_its_place_and_rate():
    effort = {"kind": "formula", "formula": "0.5 - 3 * theta - 0.05 * omega**2 + 0.1 * sin(20 * t)"}
    changes = {"freedoms": {"J0": {"start": 0.0, "effort": effort}}, "analysis.time_tolerance": 1e-3}
    data = fm.analyse(bars(1, 1, "prismatic", **changes)).data
    t = data["time"].to_numpy()
    force = lambda t, x, v: 0.5 - 3 * x - 0.05 * v**2 + 0.1 * np.sin(20 * t)  # noqa: E731
    place, rate = moved(force, MASS, t)
    np.testing.assert_allclose(at(data, "freedom_place", freedom="J0"), place, atol=2e-6)
    np.testing.assert_allclose(at(data, "drive_effort", drive="J0"), force(t, place, rate), atol=1e-5)
    along = data["joint_force"].sel(joint="J0", component="x")
    np.testing.assert_allclose(along, force(t, place, rate), atol=1e-3)


def test_an_effort_at_a_joint_is_told_with_what_it_takes():
    law = {"kind": "joint-effort", "joint": "J0", "effort": {"kind": "formula", "formula": "0.03 - 0.01 * omega"}}
    changes = {"joint_laws": {"brake": law}, "analysis.start": "static", "analysis.time_tolerance": 1e-3}
    data = fm.analyse(bars(elements=1, **changes)).data
    t = data["time"].to_numpy()
    effort = lambda t, x, v: 0.03 - 0.01 * v  # noqa: E731
    place, rate = moved(effort, TURNS, t)
    np.testing.assert_allclose(at(data, "freedom_place", freedom="J0"), place, atol=1e-3)
    np.testing.assert_allclose(at(data, "law_effort", law="brake"), effort(t, place, rate), atol=1e-4)
    np.testing.assert_allclose(
        at(data, "support_moment", support="joint law brake"), -effort(t, place, rate), atol=1e-4
    )
    given = float(data["mean_power"].sel(cause="efforts")) * t[-1]
    assert given == pytest.approx(TURNS * rate[-1] ** 2 / 2, rel=3e-3)
    assert data["law_effort"].attrs["units"] == "N m"
    assert data.attrs["power_balance_error"] < 1e-5


def test_bars_with_a_bushing_between_them_swing_along_their_guides():
    """Two equal masses with a spring and a damper: M x'' = k (y - x) + c (y' - x') and the opposite."""
    k, c, speed = 20.0, 0.05, 0.02
    law = {"kind": "bushing", "joint": "B", "stiffness": (k, 50.0), "damping": (c, 0.0)}
    scene = bars(2, 1).model_dump()
    joints = {
        "J0": {"kind": "prismatic", "connect": ("ground.O", "bar0.O")},
        "J1": {"kind": "prismatic", "connect": ("ground.P", "bar1.A")},
        "B": {"connect": ("bar0.A", "bar1.O")},
    }
    freedoms = {"J0": {"start": 0.0, "speed": speed}, "J1": {"start": 0.0, "speed": 0.0}}
    stated = {"ground": {"points": {"O": (0, 0), "P": (2 * LENGTH, 0)}}, "joints": joints, "freedoms": freedoms}
    scene = fm.Scene(**{**scene, **stated, "joint_laws": {"soft": law}})
    data = fm.analyse(scene.changed({"analysis.time_tolerance": 1e-4})).data
    t = data["time"].to_numpy()

    def rates(t, y):
        pull = k * (y[1] - y[0]) + c * (y[3] - y[2])
        return y[2], y[3], pull / MASS, -pull / MASS

    known = solve_ivp(rates, (0, t[-1]), [0, 0, speed, 0], t_eval=t, rtol=1e-9, atol=1e-12).y
    for name, place in zip(("J0", "J1"), known):
        np.testing.assert_allclose(at(data, "freedom_place", freedom=name), place, atol=1e-6)
    pull = np.abs(k * (known[1] - known[0]) + c * (known[3] - known[2]))
    np.testing.assert_allclose(at(data, "law_effort", law="soft"), pull, atol=2e-3 * pull.max())
    held = float(data["mean_power"].sel(cause="bushings")) * t[-1]
    v, w = known[2:, -1]
    assert held == pytest.approx(MASS * (v**2 + w**2 - speed**2) / 2, rel=1e-3)
    force = np.abs(at(data, "joint_force", joint="B", component="x"))
    np.testing.assert_allclose(force, pull, atol=2e-3 * pull.max())
