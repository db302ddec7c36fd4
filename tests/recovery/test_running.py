"""Speeds and electrical powers of freedoms against closed forms."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

import fenics_mech as fm
from fenics_mech.views.page.report import report

STALL, IDLE, INERTIA, BRAKE = 3.0, 100.0, 0.02, 1.0  # N m, rad/s, kg m^2, N m


def spun_up(**changes) -> fm.Scene:
    """Give a rotor that a direct-current motor spins up from rest against a constant brake."""
    scene = fm.Scene(
        name="spin-up",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"rotor": fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(inertia=INERTIA))},
        joints={"O": fm.Revolute(connect=("ground.O", "rotor.O"))},
        freedoms={"O": fm.Freedom(effort=fm.DirectCurrentMotor(stall_torque=STALL, no_load_speed=IDLE))},
        joint_laws={"brake": fm.JointEffort(joint="O", effort=fm.FormulaEffort(formula=f"-{BRAKE}"))},
        analysis=fm.Analysis(method="transient", duration=2.0, sub_intervals=400, time_tolerance=1e-8),
    )
    return scene.changed(changes)


def test_electrical_power_is_that_of_the_shaft_and_of_the_heat_in_the_rotor(tmp_path):
    result = fm.analyse(spun_up())
    data, time = result.data, result.data["time"].to_numpy()
    steady, lag = IDLE * (1 - BRAKE / STALL), INERTIA * IDLE / STALL
    rate = steady * (1 - np.exp(-time / lag))  # of J w' = Ts (1 - w/w0) - brake
    np.testing.assert_allclose(data["freedom_rate"].sel(freedom="O"), rate, atol=1e-5)
    torque = STALL * (1 - rate / IDLE)
    np.testing.assert_allclose(data["electrical_power"].sel(motor_at="O"), torque * IDLE, rtol=1e-6)
    heat = STALL * (1 - rate / IDLE) ** 2 * IDLE  # of the armature: the square of the current
    of_shaft = torque * data["freedom_rate"].sel(freedom="O").to_numpy()
    power = data["electrical_power"].sel(motor_at="O").to_numpy() - of_shaft
    np.testing.assert_allclose(power, heat, rtol=1e-6)
    # energies: what the motor takes is stored, braked and heat
    turned = float(data["freedom_place"].sel(freedom="O")[-1])
    taken = IDLE * (INERTIA * rate[-1] + BRAKE * time[-1])  # integral of the torque, by the momentum
    heated = taken - INERTIA * rate[-1] ** 2 / 2 - BRAKE * turned
    assert float(trapezoid(power, time)) == pytest.approx(heated, rel=1e-3)  # trapezoidal rule of 400 steps
    powers = dict(zip(data["cause"].to_numpy(), data["mean_power"].to_numpy()))
    assert powers["efforts"] == pytest.approx(-BRAKE * turned / 2.0, rel=1e-9)
    assert sum(powers.values()) == pytest.approx(0, abs=1e-8 * powers["freedom"])
    told = f"Motor at O: takes {taken / time[-1]:.4g} W"
    assert told in str(fm.summary(result))
    assert told in report(result, tmp_path / "report.html").read_text()


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_speed_over_the_last_turn_is_its_mean_and_range(way):
    # a torque of the angle alone: w^2/2 J = E + T (1 - cos), so that the range of the rate is known
    given = {"freedoms.O.effort": {"kind": "formula", "formula": "0.5 * sin(theta)"}, "freedoms.O.speed": way * 10.0}
    data = fm.analyse(spun_up(**given, **{"joint_laws": {}})).data
    fastest = np.sqrt(100 + 2 * 0.5 / INERTIA * 2)
    angle = np.linspace(0, 2 * np.pi, 2001)
    mean = 2 * np.pi / trapezoid(1 / np.sqrt(100 + 2 * 0.5 / INERTIA * (1 - np.cos(angle))), angle)
    assert float(data["last_turn_rate"].sel(freedom="O")) == pytest.approx(way * mean, rel=1e-4)
    assert float(data["last_turn_fluctuation"].sel(freedom="O")) == pytest.approx((fastest - 10) / mean, rel=2e-3)
    assert "electrical_power" not in data


def test_what_has_not_come_round_has_no_last_turn():
    assert "last_turn_rate" not in fm.analyse(spun_up(**{"analysis.duration": 0.05})).data
