"""Demos of motion show the numbers of their comments, which closed forms and other programs give."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid
from scipy.special import ellipk

import fenics_mech as fm
from tests.common import DEMOS
from tests.response.rigid_programs import SliderCrank

G = 9.81


def moved(name, **changes):
    """Time, angle or stroke and rate of the one freedom of a demo, and its result."""
    scene = fm.load(DEMOS / f"{name}.toml").changed({"analysis.error_estimates": False, **changes})
    data = fm.analyse(scene).data
    place, rate = (data[f"freedom_{what}"].to_numpy()[:, 0] for what in ("place", "rate"))
    return data["time"].to_numpy(), place, rate, data


def crossing(time, values):
    """Times at which a curve falls through 0."""
    k = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0))
    return time[k] - values[k] * (time[k + 1] - time[k]) / (values[k + 1] - values[k])


def test_pendulum_has_the_period_of_its_comment():
    time, place, _, _ = moved("free_motion/pendulum")
    period = 4 * ellipk(0.5) * np.sqrt(2 / (3 * G))
    assert period == pytest.approx(1.933, abs=5e-4)
    assert np.diff(crossing(time, place + np.pi / 2)) == pytest.approx(period, abs=1e-4)
    assert 2 * np.pi * np.sqrt(2 / (3 * G)) == pytest.approx(1.638, abs=5e-4)


@pytest.mark.long
@pytest.mark.slow  # 150 periods of a chaotic motion
def test_driven_pendulum_is_chaotic_as_its_comment_says():
    scene = fm.load(DEMOS / "free_motion/driven_pendulum.toml")
    result = fm.analyse(scene)
    exponents, natural = result.data["lyapunov_exponent"].to_numpy(), np.sqrt(G)
    assert exponents.sum() == pytest.approx(-natural / 2, rel=1e-5)  # q = 2
    # of the natural frequency, by a Runge-Kutta rule of order 4 with the variational equation over 1450 periods
    assert exponents[0] / natural == pytest.approx(0.112, abs=0.04)
    assert "CHAOTIC" in str(fm.summary(result))
    assert result.data.sizes["section_point"] == 150


def test_door_shuts_when_and_as_fast_as_its_comment_says():
    time, place, rate, data = moved("free_motion/door_closer")
    inertia, damping, stiffness, rest = 30 * 0.45**2 + 2.025, 45.0, 20.0, np.radians(-40)
    slow, fast = np.sort(-np.roots([inertia, damping, stiffness]))
    away = np.pi / 2 - rest

    def angle(t):
        return rest + away * (fast * np.exp(-slow * t) - slow * np.exp(-fast * t)) / (fast - slow)

    times = np.linspace(0, 5, 500_001)
    shut = times[np.argmax(angle(times) <= 0)]
    speed = away * slow * fast * (np.exp(-slow * shut) - np.exp(-fast * shut)) / (fast - slow)
    assert (shut, speed) == (pytest.approx(2.627, abs=5e-4), pytest.approx(0.34, abs=5e-4))
    before = time < shut
    np.testing.assert_allclose(place[before], angle(time[before]), atol=1e-6)
    k = int(before.sum()) - 1
    assert -rate[k] == pytest.approx(speed, abs=0.01)  # at the last position before
    assert place[k + 1 :].min() > -5e-3
    assert place[k + 1 :].max() < 0.1 * np.pi / 2
    assert data.attrs["contacts_closed"] >= 1


@pytest.mark.long
@pytest.mark.slow  # each blow takes some short steps
def test_hammer_rebounds_and_hits_as_its_comment_says():
    mass, speed, contact = (
        50.0,
        np.sqrt(2 * G),
        fm.load(DEMOS / "free_motion/drop_hammer.toml").joint_laws["anvil"].contact,
    )
    c = 2.082498  # of the exact restitution 0.4, by c (1 + e) = ln[(1 + c)/(1 - c e)]
    assert c * 1.4 == pytest.approx(np.log((1 + c) / (1 - 0.4 * c)), rel=1e-6)

    def rates(_, y):
        return [y[1], G - contact.stiffness / mass * max(y[0], 0.0) ** 1.5 * max(1 + c * y[1] / speed, 0.0)]

    blow = solve_ivp(rates, (0, 2e-3), [0.0, speed], rtol=1e-10, atol=1e-13, max_step=1e-6)
    force = contact.stiffness * np.maximum(blow.y[0], 0) ** 1.5 * np.maximum(1 + c * blow.y[1] / speed, 0)
    time, place, _, data = moved("free_motion/drop_hammer")
    assert float(data["largest_law_effort"][0]) == pytest.approx(force.max(), rel=2e-3)
    fall = np.sqrt(2 / G)
    between = (time > fall) & (time < fall * 1.8)
    assert place[between].max() == pytest.approx(0.4**2, abs=2e-3)
    assert force.max() == pytest.approx(2.3e6, rel=2e-3)


def test_fan_has_the_speed_and_the_start_of_its_comment():
    time, _, rate, _ = moved("free_motion/motor_start")
    inertia, torque, no_load, drag = 0.064, 6.0, 100 * np.pi, 2.154e-5
    up, down = np.sort(np.roots([-drag, -torque / no_load, torque]))[::-1]

    def speed(t):  # of the Riccati equation J w' = -drag (w - up)(w - down)
        decay = np.exp(-drag * (up - down) * t / inertia)
        return up * (1 - decay) / (1 - up / down * decay)

    np.testing.assert_allclose(rate, speed(time), rtol=1e-5, atol=1e-4)
    share = 0.05 / (1 - 0.95 * up / down)
    late = -inertia / (drag * (up - down)) * np.log(share)
    assert (up, late) == (pytest.approx(246.0, abs=0.5), pytest.approx(6.86, abs=0.005))


def test_wiper_needs_the_torque_of_its_comment():
    data = fm.analyse(fm.load(DEMOS / "free_motion/wiper.toml")).data
    theta, torque = data["theta"].to_numpy(), data["input_torque"].to_numpy()
    pin = 0.04 * np.stack([np.cos(theta), np.sin(theta)], axis=1) - [0.18, 0]  # of the crank, seen from the wiper's pin
    size = np.hypot(*pin.T)
    wiper = np.unwrap(np.arctan2(pin[:, 1], pin[:, 0])) - np.arccos((size**2 + 0.07**2 - 0.18**2) / (2 * size * 0.07))
    ratio = np.gradient(np.append(wiper[-1:], np.append(wiper, wiper[:1])), theta[1])[1:-1]
    omega = 1.5 * np.pi
    rubbing = 6 * np.tanh(ratio * omega / 0.05) * ratio
    inertia = torque - rubbing
    assert np.abs(inertia).max() < 0.21  # N m: the links' own inertia is small at 45 rpm
    assert torque.max() == pytest.approx(3.99, abs=0.005)
    assert (6 * np.abs(ratio)).max() == pytest.approx(torque.max(), rel=0.06)


@pytest.mark.slow  # three strokes
def test_press_slows_its_flywheel_as_an_independent_program_finds():
    time, place, rate, data = moved("free_motion/press_with_flywheel")
    press = SliderCrank()
    press.a, press.rod, press.rod_mass, press.rod_inertia, press.slider_mass = 0.05, 0.3, 15.0, 0.12, 60.0
    press.crank_inertia = 500.02
    synchronous = 62 * 2 * np.pi / 60

    def effort(angle, omega):
        (ram, way, _), _ = press.slider(angle)
        slip = 1 - omega / synchronous
        motor = 1500 * 2 * slip * 0.2 / (slip**2 + 0.04)
        return motor - 120e3 * (1 + np.tanh((ram - 0.338) / 1e-3)) / 2 * (1 + np.tanh(way * omega / 0.02)) / 2 * way

    expected = press.course(effort, [0.0, 2 * np.pi], time, tolerance=1e-10)
    np.testing.assert_allclose(place, expected[0], rtol=1e-4, atol=1e-4)
    last = time > 2
    fluctuation = np.ptp(rate[last]) / rate[last].mean()
    assert np.ptp(expected[1][last]) / expected[1][last].mean() == pytest.approx(fluctuation, rel=1e-3)
    assert fluctuation == pytest.approx(0.055, abs=5e-4)
    assert data.attrs["power_balance_error"] < 1e-6


@pytest.mark.long
@pytest.mark.slow  # it lifts off and bounces
def test_valve_lifts_off_above_the_speed_of_its_comment():
    mass, preload, spring, lift = 0.12, 150.0, 3e4, 9e-3
    leaves = np.sqrt((preload + spring * lift) / (mass * lift / 2))
    assert leaves * 30 / np.pi == pytest.approx(8421, abs=1)
    _, _, _, data = moved("joint_laws/valve_train")
    assert float(data["indentation"].min()) < -1e-5
    _, _, _, slower = moved("joint_laws/valve_train", **{"drive.speed": 0.97 * leaves})
    assert float(slower["indentation"].min()) > 0


@pytest.mark.long
@pytest.mark.slow  # twelve links over 4 s
def test_legs_walk_with_the_mean_speed_of_their_comment():
    _, place, rate, data = moved("free_motion/walking_legs")
    # over a late turn kinetic and potential energy come back: the mean effort over the angle is 0
    turn = place > place[-1] - 2 * np.pi
    mean = trapezoid(rate[turn], place[turn]) / np.ptp(place[turn])
    assert 6 / (6 / 10 + 0.2) == 7.5
    assert mean == pytest.approx(7.5, rel=1e-3)
    assert np.ptp(rate[turn]) > 0.5
    assert data.attrs["power_balance_error"] < 1e-6


@pytest.mark.long
@pytest.mark.slow  # a bending arm over a cycle
def test_gripper_swings_on_as_its_comment_says():
    scene = fm.load(DEMOS / "free_motion/pick_and_place.toml").changed({"analysis.error_estimates": False})
    data = fm.analyse(scene).data
    length, bar = 0.4, 2700 * 0.03 * 0.006 * 0.4
    stiffness = 3 * 70e9 * 0.03 * 0.006**3 / 12 / length**3
    omega = np.sqrt(stiffness / (0.3 + 33 / 140 * bar))  # Rayleigh's share of the bar
    mass, way, duration = 0.3 + 11 / 40 * bar, np.pi / 2, 0.2  # that the bar's own inertia bends it like

    def rates(t, y):
        alpha = way * 2 * np.pi / duration**2 * np.sin(2 * np.pi * t / duration) * (t < duration)
        return [y[1], -(omega**2) * y[0] - mass / (0.3 + 33 / 140 * bar) * length * alpha]

    after = solve_ivp(rates, (0, 0.48), [0.0, 0.0], rtol=1e-9, atol=1e-12, max_step=1e-3)
    expected = np.hypot(after.y[0, -1], after.y[1, -1] / omega)
    time, bend = data["time"].to_numpy(), data["deflection"].sel(member="arm").to_numpy()[:, -1]
    dwell = (time > 0.26) & (time < 0.54)
    swing = np.linalg.norm(bend[dwell], axis=-1).max()
    assert swing == pytest.approx(expected, rel=0.05)
    assert swing == pytest.approx(16.9e-3, abs=2e-4)
    residual = data["residual_vibration"].sel(member="arm")
    assert float(residual.sel(dwell="after out")) == pytest.approx(expected, rel=0.05)
    assert "after back" in residual["dwell"]
