"""Six machines of public dimensions: the factor that decides, and its mode, against short calculations by hand.

Each calculation is of statics, of rigid kinematics and of formulas of books, and uses nothing of the program. Where it
leaves something out, the tolerance says how much that is.
"""

from math import acos, cos, hypot, pi, sin, sqrt, tan
from pathlib import Path

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.safety import judge
from tests.common import DEMOS, analysed

HERE = Path(__file__).parent
INCH, LBF, PSI = 0.0254, 4.4482216, 6894.757


def answered(name):
    """Answer a machine without vibration, as the hand does."""
    path = HERE / f"{name}.toml"
    if path.exists():
        return analysed(fm.load(path))
    still = {"analysis.method": "quasi-static", "analysis.sub_intervals": 720, "effects": ()}
    return analysed(fm.load(DEMOS / "load_cases" / f"{name}.toml").changed(still))


def check_of(result, member, mode):
    return next(check for check in judge(result).checks[member] if check.mode == mode and check.decides)


def johnson(area, radius, length, strength, modulus=206e9):
    """Euler's or J. B. Johnson's load of a strut on pins (Shigley, 9th ed., eq. (4-42) and (4-48))."""
    slender = length / radius
    if slender >= sqrt(2 * pi**2 * modulus / strength):
        return pi**2 * modulus * area / slender**2
    return area * strength * (1 - strength * slender**2 / (4 * pi**2 * modulus))


def endurance(ultimate, a, b, area):
    """Surface times limit, and size factor of a bent bar (Shigley, 9th ed., section 6-9), in Pa and m^2."""
    size = 0.808 * sqrt(area) * 1e3
    return min(a * (ultimate / 1e6) ** b, 1.0) * 0.5 * ultimate, 1.24 * size**-0.107


def goodman(bending, axial, limit, size, ultimate):
    """Factor of safety of a cycle of stresses, with kb of bending and kc = 0.85 of axial stress (section 6-14)."""
    raised, plain = bending / size + axial / 0.85, bending + axial
    amplitude, mean = (raised.max(axis=0) - raised.min(axis=0)) / 2, (plain.max(axis=0) + plain.min(axis=0)) / 2
    return 1 / (amplitude / limit + np.clip(mean, 0, None) / ultimate).max()


class Engine:
    """A slider-crank of rigid links, whose rod is a beam on two pins under its own inertia."""

    crank, length, piston, area, density = 0.0625, 0.3, 1.6, 396e-6, 7850.0
    inertia, fibre = (24 * 30**3 - 18 * 18**3) / 12 * 1e-12, 0.015
    theta, s = np.linspace(0, 2 * pi, 1441)[:, None], np.linspace(0, 1, 41)

    def loads(self, speed, gas):
        """Axial force and bending moment, ``(angles, places)``; gas is the force on the piston."""
        r, long, w, th = self.crank, self.length, speed, self.theta
        phi = -np.arcsin(r * np.sin(th) / long)
        rate = -r * w * np.cos(th) / (long * np.cos(phi))
        spin = (r * w**2 * np.sin(th) + long * np.sin(phi) * rate**2) / (long * np.cos(phi))
        ax, ay = -r * w**2 * np.cos(th), -r * w**2 * np.sin(th)
        along = ax * np.cos(phi) + ay * np.sin(phi) - self.s * long * rate**2
        across = -ax * np.sin(phi) + ay * np.cos(phi) + self.s * long * spin
        line = -self.density * self.area
        first, last = line * across[:, :1], line * across[:, -1:]
        moment = long**2 * (first * self.s * (1 - self.s) / 2 + (last - first) * (self.s - self.s**3) / 6)
        of_piston = -self.piston * (along[:, -1:] * np.cos(phi) - across[:, -1:] * np.sin(phi)) + gas
        side = -long * (first / 2 + (last - first) / 3)
        end = (of_piston + side * np.sin(phi)) / np.cos(phi)
        mean = (along[:, -1:] + along) / 2
        return end + line * long * (1 - self.s) * mean, moment


GAS = (
    [0, 5, 20, 30, 45, 60, 90, 120, 150, 180, 355, 360],
    [0.95, 1, 0.794, 0.62, 0.413, 0.283, 0.157, 0.109, 0.089, 0, 0, 0.95],
)


def test_the_rod_of_an_engine_tires_by_overspeed_and_buckles_most_at_low_speed():
    result, engine = answered("engine"), Engine()
    force, moment = engine.loads(3000 * pi / 30, 0.0)
    limit, size = endurance(540e6, 272.0, -0.995, engine.area)
    bending = moment * engine.fibre / engine.inertia
    factors = [goodman(side * bending, force / engine.area, limit, size, 540e6) for side in (1, -1)]
    member, check = judge(result).governing
    assert (member, check.mode, check.case) == ("rod", "fatigue", "overspeed")
    assert check.factor == pytest.approx(min(factors), rel=0.01)  # the mesh leaves 0.5 %
    gas = -21.29e3 * np.interp(np.degrees(engine.theta), *GAS)
    pushed = -engine.loads(800 * pi / 30, gas)[0].min()
    radius = sqrt(engine.inertia / engine.area)
    buckling = check_of(result, "rod", "buckling in plane")
    assert buckling.case == "full_throttle_low"
    assert buckling.factor == pytest.approx(johnson(engine.area, radius, 0.3, 320e6) / pushed, rel=5e-3)


def test_the_beam_of_a_pumping_unit_tips_sideways_first():
    """The moment is load times arm; 0.9 % is by the inertia of the horsehead at 10 rpm."""
    result = answered("pump_jack")
    width, flange, height, web = (x * INCH for x in (7.495, 0.57, 17.99, 0.355))
    across = (2 * flange * width**3 + (height - 2 * flange) * web**3) / 12
    torsion = (2 * width * flange**3 + (height - 2 * flange) * web**3) / 3
    modulus, long = 29e6 * PSI, 2 * 72 * INCH  # a free end doubles the length
    warping = modulus * across * (height - flange) ** 2 / 4 * (pi / long) ** 2
    borne = pi / long * sqrt(modulus * across * (modulus / 2.6 * torsion + warping))  # Timoshenko and Gere, 6.2
    moment = 13300 * LBF * 72 * INCH
    member, check = judge(result).governing
    assert (member, check.mode, check.case) == ("beam.front", "lateral torsion", "rated")
    assert check.factor == pytest.approx(borne / moment, rel=0.015)
    for case in result.cases.values():  # tables of cases are by the members of the result
        assert list(case.data["member"].to_numpy()) == list(result.data["member"].to_numpy())
    inertia = (width * height**3 - (width - web) * (height - 2 * flange) ** 3) / 12
    stress = check_of(result, "beam.front", "yield")
    assert stress.acting == pytest.approx(moment * height / 2 / inertia, rel=0.015)


def test_the_stroke_of_the_pumping_unit_is_that_of_its_name():
    """54 in, by the law of cosines at both dead centres; units are named by round strokes, and this one has 55.5 in."""
    a, c, i, p, k, r = 72.0, 64.0, 64.0, 74.5, 116.0 - 41.0, 24.0
    base = hypot(i, k)
    swing = [acos((c**2 + base**2 - reach**2) / (2 * c * base)) for reach in (p + r, p - r)]
    assert a * (swing[0] - swing[1]) == pytest.approx(54, rel=0.03)
    angle = answered("pump_jack").data["link_angle"].sel(link="beam").to_numpy()
    assert np.ptp(angle) == pytest.approx(swing[0] - swing[1], rel=1e-3)  # of 120 positions one is near a dead centre


def test_the_cylinder_of_an_excavator_has_its_published_force_and_its_rod_buckles_first():
    result = answered("excavator")
    push = 15.7e6 * pi / 4 * 0.04**2  # N: 157 bar on 40 mm
    assert push * 257 * 181 / (220 * 547) == pytest.approx(7626, rel=1e-3)  # as Patel and Prajapati have it
    effort = result.data["case_effort"].sel(drive="seal", case="breakout").item()
    assert effort == pytest.approx(push, rel=2e-3)  # the angles of the links are stated to 0.01 deg
    member, check = judge(result).governing
    assert (member, check.mode, check.case) == ("rod", "buckling in plane", "breakout")
    area = pi / 4 * 0.025**2
    borne = johnson(area, 0.025 / 4, 0.45 + 0.15, 355e6)  # from the pin of the barrel to that of the lever
    assert check.factor == pytest.approx(borne / push, rel=2e-3)
    exact = 2.4556**2 * 206e9 * area * (0.025 / 4) ** 2 / 0.45**2  # tan z = -z/3: a rigid barrel of a third of the rod
    assert pi**2 * 206e9 * area * (0.025 / 4) ** 2 / 0.6**2 == pytest.approx(0.92 * exact, rel=2e-3)  # and below it


def test_the_bush_of_a_press_has_the_least_factor():
    """Mean pressure F/(d t); the slope of the rod and the slide's inertia are 0.2 % of the force."""
    result = answered("press")
    member, check = judge(result).governing
    assert (member, check.mode, check.case) == ("rod", "pin and eye", "rated")
    assert "bush" in check.detail
    assert check.factor == pytest.approx(60e6 * 0.18 * 0.12 / 630e3, rel=5e-3)
    buckling = check_of(result, "rod", "buckling in plane")
    area = pi / 4 * 0.09**2
    assert buckling.factor == pytest.approx(johnson(area, 0.09 / 4, 0.6, 370e6) / 630e3, rel=5e-3)


def test_the_lowest_arm_of_a_scissor_lift_buckles_across_first():
    """The screw draws W/tan(t), as x = L cos t and h = L sin t; the arm bears its part along it, and half of W."""
    result, half, long = answered("scissor_lift"), 1000 * LBF, 46 * INCH
    tilt = acos(1.1602 / long)
    screw = half / tan(tilt)
    assert result.data["case_effort"].sel(drive="screw", case="lowered").item() == pytest.approx(screw, rel=1e-3)
    load = 1.5 * (screw * cos(tilt) + half / 2 * sin(tilt))
    member, check = judge(result).governing
    assert (check.mode, check.case) == ("buckling across", "test")
    assert member in ("up.lower", "down.lower")  # which have the same force
    borne = johnson(0.08 * 0.02, 0.02 / sqrt(12), long / 2, 355e6)
    assert check.factor == pytest.approx(borne / load, rel=2e-3)
    moment = 1.5 * half * long * cos(tilt) / 4  # at the pin in the middle of both arms
    stress = check_of(result, "down.upper", "yield").acting  # which has no axial force but the load's
    assert stress == pytest.approx(moment * 6 / (0.02 * 0.08**2) - 1.5 * half / 2 * sin(tilt) / 0.0016, rel=5e-3)


def test_the_sword_of_a_loom_tires_at_the_beat():
    """Cloth against the inertia of the slay, on 3 in of sword; its own 0.3 kg are 1 % of the slay's 30 kg."""
    result = answered("loom")
    w, theta = 180 * pi / 30, np.linspace(0, 2 * pi, 7201)
    crank, arm, pin, base = 3 * INCH, 12 * INCH, 24 * INCH, np.array([15.0, 24.0]) * INCH
    tip = base[:, None] + crank * np.array([np.cos(theta), np.sin(theta)])
    reach, bearing = np.hypot(*tip), np.arctan2(tip[1], tip[0])
    angle = bearing + np.arccos((pin**2 + reach**2 - arm**2) / (2 * pin * reach))
    spin = np.gradient(np.gradient(angle, theta), theta) * w**2
    degrees = np.degrees(theta)
    rise, fall = (np.clip((degrees - at + 4) / 8, 0, 1) for at in (170, 182))
    ramp = lambda x: x**3 * (10 - 15 * x + 6 * x**2)  # noqa: E731
    cloth = 4e3 * (ramp(rise) - ramp(fall))  # N, in x: the sword's normal is near to -x
    moment = 3 * INCH * (cloth * np.sin(angle) + 30 * 27 * INCH * spin)
    stress = moment / (0.012 * 0.04**2 / 6)
    limit, size = endurance(360e6, 57.7, -0.718, 0.012 * 0.04)
    inner = slice(10, -10)  # without the ends of the differences
    factor = min(goodman(side * stress[inner, None], 0.0, limit, size, 360e6) for side in (1, -1))
    member, check = judge(result).governing
    assert (check.mode, check.case) == ("fatigue", "weaving")
    assert member in ("sword.upper", "sword.lower")  # at the pin between them
    assert check.factor == pytest.approx(factor, rel=0.02)


@pytest.mark.parametrize("name", ["engine", "pump_jack", "excavator", "press", "scissor_lift", "loom"])
def test_a_minute_is_enough_to_see_whether_it_is_safe(name):
    said = str(fm.summary(answered(name)))
    machine, *rest = said.splitlines()
    assert "load cases" in machine
    assert rest[0].startswith("Safe in ")
    assert len(said.splitlines()) <= 31
    assert all(len(line) <= 80 for line in said.splitlines())
