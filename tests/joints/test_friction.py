"""Dry friction against closed forms: stick and slip on a belt, a slider, a pendulum, a led pin."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.joints.dry_friction import held_at, line
from tests.joints.scenes import G, bar, block

RUBS = {"kind": "friction", "coefficient": 0.2}


@pytest.mark.long
@pytest.mark.slow  # stick and slip over several periods
@pytest.mark.parametrize(("sharp", "limit"), [(1e-3, 0.012), (1e-4, 0.004)])
def test_period_of_a_block_on_a_belt_in_closed_form(sharp, limit):
    # friction falls from 0.3 to 0.2 at once in the closed form: the error falls with the root of Stribeck's speed
    spring, belt, drop = 100.0, 0.2, 0.1 * G
    omega = np.sqrt(spring)
    slip = (2 * np.pi - 2 * np.arctan(drop * omega / (spring * belt))) / omega
    period = slip + 2 * drop / (spring * belt)
    highest = 0.2 * G / spring + np.hypot(drop / spring, belt / omega)
    law = RUBS | {"static": 0.3, "stribeck": sharp, "belt_speed": belt, "width": sharp / 20}
    moving = {"freedoms": {"G": {"speed": belt}}, "analysis.duration": 3.2, "analysis.sub_intervals": 1600}
    moving["analysis.time_tolerance"] = 1e-7  # rates that stick are told by 1e-5 m/s
    data = fm.analyse(block(law, **moving)).data
    time, place, rate = data["time"].to_numpy(), data["freedom_place"][:, 0].to_numpy(), data["freedom_rate"][:, 0]
    peaks = np.flatnonzero((place[1:-1] > place[:-2]) & (place[1:-1] >= place[2:])) + 1
    found = time[peaks][1:]  # the first is of the start
    assert len(found) >= 4
    assert np.ptp(found) / (len(found) - 1) == pytest.approx(period, rel=limit)
    assert place[time > 1].max() == pytest.approx(highest, rel=limit)
    sticks = np.abs(rate.to_numpy()[time > 1] - belt) < sharp / 10
    assert sticks.mean() == pytest.approx(1 - slip / period, abs=0.03)


@pytest.mark.slow  # three changes of sense
def test_slider_with_friction_stops_as_its_piecewise_closed_form():
    # each half of a swing ends by 2 mu m g/k nearer to the middle, until the spring cannot move the block any more
    spring, shift = 100.0, 0.2 * G / 100
    half = np.pi / np.sqrt(spring)
    scene = block(
        RUBS | {"width": 1e-5},
        **{"freedoms": {"G": {"start": 0.15}}, "springs.s.length": 1.0, "analysis.duration": 5 * half},
    ).changed({"analysis.sub_intervals": 200, "analysis.time_tolerance": 1e-7})
    data = fm.analyse(scene).data
    place, time = data["freedom_place"][:, 0].to_numpy(), data["time"].to_numpy()
    expected, start, sign = np.empty_like(time), 0.15, 1.0
    for k in range(5):
        inside = (time >= k * half - 1e-12) & (time <= (k + 1) * half + 1e-12)
        expected[inside] = sign * shift + (start - sign * shift) * np.cos(np.sqrt(spring) * (time[inside] - k * half))
        start, sign = -(start - 2 * sign * shift), -sign
        if abs(start) <= shift:
            expected[time > (k + 1) * half] = start
            break
    np.testing.assert_allclose(place, expected, atol=2e-5)  # the width of 1e-5 m/s lets it creep
    power = dict(zip(data["cause"].to_numpy(), data["mean_power"].to_numpy()))
    lost = spring / 2 * (0.15**2 - place[-1] ** 2)
    assert -power["friction"] * time[-1] == pytest.approx(lost, rel=1e-6)


def test_swing_of_a_pendulum_with_dry_friction_decays_linearly():
    # a pin that carries m g takes 2 mu r/(L/2) off each half of a small swing; the swing of 0.02 rad is off by 1e-4
    mu, radius = 0.2, 5e-3
    law = RUBS | {"radius": radius, "width": 1e-7}
    omega = np.sqrt(1.5 * G)
    scene = bar(law, **{"freedoms": {"O": {"start": -np.pi / 2 + 0.02}}, "analysis.duration": 5 * np.pi / omega})
    data = fm.analyse(scene.changed({"analysis.sub_intervals": 500})).data
    swing = data["freedom_place"][:, 0].to_numpy() + np.pi / 2
    peaks = np.abs(swing[::100])  # at the ends of its halves
    np.testing.assert_allclose(peaks, 0.02 - 4 * mu * radius * np.arange(6) / 1.0, atol=1e-5)


def test_friction_of_a_led_pin_adds_to_its_torque():
    speed, law = 6.0, RUBS | {"radius": 0.01}
    scene = bar(law, drive={"joint": "O", "speed": speed}, analysis={"method": "periodic", "sub_intervals": 36})
    data = fm.analyse(scene).data
    theta = data["theta"].to_numpy()
    force = np.stack([-(speed**2) / 2 * np.cos(theta), G - speed**2 / 2 * np.sin(theta)], axis=-1)
    np.testing.assert_allclose(data["joint_force"][:, 0], force, atol=1e-9)
    rubbing = 0.2 * 0.01 * np.linalg.norm(force, axis=-1)
    np.testing.assert_allclose(data["input_torque"], G / 2 * np.cos(theta) + rubbing, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(data["law_effort"][:, 0], -rubbing, rtol=1e-9)
    power = dict(zip(data["cause"].to_numpy(), data["mean_power"].to_numpy()))
    assert power["friction"] == pytest.approx(-speed * rubbing.mean(), rel=1e-9)
    assert data.attrs["power_balance_error"] < 1e-12


def test_viscous_share_acts_beside_the_dry_one():
    law = {"kind": "friction", "coefficient": 0.0, "viscous": 2.0}
    data = fm.analyse(block(law, spring=None, freedoms={"G": {"speed": 1.0}})).data
    np.testing.assert_allclose(data["freedom_rate"][:, 0], np.exp(-2 * data["time"].to_numpy()), atol=1e-6)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (RUBS, "law.radius: the friction of a pin needs the radius"),
        (RUBS | {"radius": "5 mm", "coefficient": -0.1}, "coefficient"),
        (RUBS | {"radius": "5 mm", "static": 0.1, "stribeck": 0.01}, "static coefficient 0.1 is less"),
        (RUBS | {"radius": "5 mm", "static": 0.3}, "go together"),
        (RUBS | {"radius": "5 mm", "width": 0}, "width"),
        (RUBS | {"radius": "5 mm", "belt_speed": 1.0}, "no belt"),
        (RUBS | {"radius": "5 mm", "joint": "X"}, "no joint 'X'"),
    ],
)
def test_friction_that_cannot_be_is_refused(law, message):
    with pytest.raises(fm.SceneError, match=message):
        bar(law)


def test_a_slider_has_no_radius_and_a_joint_one_friction():
    with pytest.raises(fm.SceneError, match="without a radius"):
        block(RUBS | {"radius": "5 mm"})
    with pytest.raises(fm.SceneError, match=r"has a friction already, joint_laws\.law"):
        block(RUBS).changed({"joint_laws.other": RUBS | {"joint": "G"}})


def test_a_tangent_of_friction_touches_its_law():
    at = np.array([-2.0, 0.0, 0.3])
    np.testing.assert_allclose(line(at, at), np.tanh(at))
    np.testing.assert_allclose((line(at, at + 1e-6) - line(at, at)) / 1e-6, 1 / np.cosh(at) ** 2, rtol=1e-6)


@pytest.mark.parametrize("needed", [0.5, -0.999, 0.999999])
@pytest.mark.parametrize("before", [0.0, 3e7, -3e7, 0.5])
def test_friction_that_is_predicted_comes_to_what_a_body_at_rest_needs(needed, before):
    """As above, by the share of the limit that a step predicts; the forces that a share is of are off by 1e-4."""
    rate = -1e5 / 1e8
    held, speed = np.array([before]), np.array([-1e5])
    for step in range(8):
        at = np.tanh(held)
        slope = 1 - at**2
        speed = (rate + needed - at + slope * held) / (1e-8 + slope)
        held = held_at(line(held, speed) * (1 + (1e-4 if step < 3 else 0.0)), speed)
    assert np.tanh(held).item() == pytest.approx(needed + rate if abs(needed + rate) < 1 else -1, abs=1e-6)
