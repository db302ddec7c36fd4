"""What acts on links that move by the equation of poses: drag, air, loads that jump and impulses, in closed form."""

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import frequencies, march, tangents_at
from tests.common import DEMOS
from tests.effects import test_air_drag, test_drag
from tests.effects.test_impulses import INERTIA, MASS, E, J, L, blow, ringing, tip_normal, turning_beam

POSES = {"solver": "poses", "stability": False, "error_estimates": False, "allow_coarse": True}
EXACT = ("coupling", "large-rotations")


def by_poses(scene, **analysis):
    changes = {f"analysis.{key}": value for key, value in (POSES | analysis).items()}
    return fm.analyse(scene.changed({"analysis.method": "periodic", **changes})).data


# ---- drag ----
@pytest.mark.slow
def test_spinning_arm_needs_the_torque_of_its_drag_and_of_its_masses():
    """Torque c Omega J of all mass: the arm's, the tip's and its own inertia. The arm is stiff."""
    masses = {"B": {"at": "arm.B", "mass": 0.1, "inertia": 0.02}}
    steel = {"steel": {"modulus": 206e12, "density": 7850}}
    arm = test_drag.arm(damping={"external": 3.0}, masses=masses, materials=steel)
    data = by_poses(arm.changed(effects=EXACT))
    inertia = test_drag.LINE * test_drag.LENGTH**3 / 3 + 0.1 * test_drag.LENGTH**2 + 0.02
    assert data["input_torque"].to_numpy() == pytest.approx(3.0 * 20.0 * inertia, rel=3e-5)
    power = data["mean_power"].sel(cause="external drag").item()
    assert power == pytest.approx(-3.0 * 20.0**2 * inertia, rel=3e-5)
    assert data.attrs["power_balance_error"] < 1e-6
    x = data["s"].to_numpy() * test_drag.LENGTH  # the drag on what is beyond x, about x
    beyond = test_drag.LENGTH - x
    drag = 60.0 * (test_drag.LINE * (beyond**3 / 3 + x * beyond**2 / 2) + 0.1 * test_drag.LENGTH * beyond + 0.02)
    assert data["moment"].to_numpy()[0, 0] == pytest.approx(-drag, abs=3e-5 * drag[0])


def test_air_that_turns_with_the_link_drags_no_rigid_motion():
    data = by_poses(test_drag.arm(damping={"relative": 3.0}).changed(effects=EXACT))
    assert np.abs(data["input_torque"].to_numpy()).max() < 1e-6  # of 79 N m/s of external drag


@pytest.mark.parametrize(("damping", "speed"), [("external", 0.5), ("external", 1.6), ("relative", 1.6), ("both", 1.6)])
def test_whirl_of_a_rotor_grows_as_external_and_internal_damping_say(damping, speed):
    """Genta, Dynamics of Rotating Systems, chapter 4, as in `effects/test_drag.py`: the same equation."""
    spokes = 1e-4 / test_drag.RADIUS + 12 * 1e-8 / 12 / test_drag.RADIUS**3
    omega = math.sqrt(1.5 * 1e7 * spokes / test_drag.ROTOR_MASS)
    spin, rate = speed * omega, 0.02 * omega
    c, d = rate * (damping in ("external", "both")), rate * (damping in ("relative", "both"))
    stated = {"external": {"external": rate}, "relative": {"relative": rate}}
    stated["both"] = {"external": rate, "material": 0.02 / omega}
    roots = np.roots([1, 2j * spin + c + d, omega**2 - spin**2 + 1j * c * spin])
    rotor = test_drag.rotor(spin, stated[damping]).changed(effects=EXACT)
    data = by_poses(rotor, stability=True, allow_unstable=True)
    assert data["growth_rate"].to_numpy().max() == pytest.approx(roots.real.max(), abs=2e-5 * omega * 0.5)


# ---- air ----
def test_spinning_arm_carries_its_drag_in_the_air():
    """Of each piece it is dF = k (Omega x)^2 dx, inside elements too."""
    T = test_air_drag
    data = by_poses(T.arm().changed(effects=EXACT))
    torque = T.DRAG * T.SPEED**2 * T.LENGTH**4 / 4
    assert data["input_torque"].to_numpy() == pytest.approx(torque, rel=1e-6)
    assert data["mean_power"].sel(cause="air drag").item() == pytest.approx(-torque * T.SPEED, rel=1e-6)
    x = data["s"].to_numpy() * T.LENGTH
    moment = -T.DRAG * T.SPEED**2 * (T.LENGTH**4 / 4 - x * T.LENGTH**3 / 3 + x**4 / 12)
    shear = T.DRAG * T.SPEED**2 * (T.LENGTH**3 - x**3) / 3
    assert data["moment"].to_numpy()[0, 0] == pytest.approx(moment, abs=1e-5 * torque)
    assert data["shear_force"].to_numpy()[0, 0] == pytest.approx(shear, abs=1e-5 * shear[0])


@pytest.mark.slow
@pytest.mark.parametrize("elements", [1, 2])
def test_four_bar_needs_the_power_that_the_air_takes(elements):
    """By quadrature along stiff links, whose velocity across changes its side inside an element."""
    scene = test_air_drag.four_bar(mesh={"elements": elements})
    data, power = by_poses(scene), test_air_drag.dissipated(scene).mean()
    assert data["mean_power"].sel(cause="drive").item() == pytest.approx(power, rel=1e-5)
    assert data["mean_power"].sel(cause="air drag").item() == pytest.approx(-power, rel=1e-5)


@pytest.mark.slow
def test_springs_and_dampers_on_the_ground_are_supports():
    """The frame carries all: what shakes it is minus the rate of the links' momentum, whatever the springs do."""
    parts = {
        "springs": {
            "line": {"between": ["ground.G", "rod.A"], "stiffness": 300.0},
            "wound": {"joint": "O", "stiffness": 1e-9},
        },
        "dampers": {"line": {"between": ["rod.A", "ground.G"], "damping": 2.0}},
    }
    scene = fm.load(DEMOS / "slider_crank.toml").changed({"effects": EXACT, **parts})
    with pytest.raises(SceneError, match="without end"):
        by_poses(scene, sub_intervals=24)
    del parts["springs"]["wound"]
    scene, bare = (fm.load(DEMOS / "slider_crank.toml").changed({"effects": EXACT, **some}) for some in (parts, {}))
    data, alone = (by_poses(one, sub_intervals=24) for one in (scene, bare))
    supports = data["support"].to_numpy().tolist()
    assert supports[-2:] == ["spring line", "damper line"]
    whole = data["support_force"].sum("support")
    np.testing.assert_allclose(whole, data["shaking_force"], atol=1e-12)
    # links bend by 1e-4 of their length more or less, and their momentum changes with that
    largest = float(np.abs(data["support_force"]).max())
    np.testing.assert_allclose(data["shaking_force"], alone["shaking_force"], atol=2e-3 * largest)
    pull, way = data["spring_force"].sel(spring="line"), data["point_position_bent"].sel(point="rod.A")
    ground = np.array(scene.ground.points["G"])
    along = (way.to_numpy() - ground) / np.linalg.norm(way.to_numpy() - ground, axis=1)[:, None]
    held = data["support_force"].sel(support="spring line").to_numpy()
    np.testing.assert_allclose(held, pull.to_numpy()[:, None] * along, atol=1e-9 * float(np.abs(pull).max()))


# ---- jumps and impulses ----
SPIN = 10.0  # rad/s


def rate_of_tip():
    """Rate of a tip mass on a massless cantilever that spins: it carries m W^2 L (Timoshenko, beam-columns)."""
    tension = MASS * SPIN**2 * L
    root = math.sqrt(tension / (E * INERTIA))
    stiffness = tension * root / (root * L - math.tanh(root * L))
    return math.sqrt(stiffness / MASS - SPIN**2)


def spinning(sense=1, steps=120, **rest):
    drive = {"joint": "O", "speed": sense * SPIN}
    analysis = {"sub_intervals": steps} | POSES
    return turning_beam(drive=drive, damping={}, mesh={"elements": 4}, effects=EXACT, analysis=analysis, **rest)


@pytest.mark.parametrize(("sense", "degrees"), [(1, 73.3), (-1, 90.0), (1, 0.0)])
def test_oscillator_struck_once_a_turn(sense, degrees):
    """120 steps damp it by 1e-3 a turn, which 240 do by 4e-5; it moves by 1e-6 of the beam's length."""
    angle, size = math.radians(degrees), J / 100
    data = fm.analyse(spinning(sense, impulses={"hammer": blow(angle, size)})).data
    since = np.mod((data["theta"].to_numpy() - angle) / sense / SPIN + 1e-12, 2 * np.pi / SPIN)
    exact = ringing(since, 2 * np.pi / SPIN, rate_of_tip(), 0.0, size / MASS)
    assert np.allclose(tip_normal(data), exact, rtol=0, atol=2e-4 * np.abs(exact).max())


def test_oscillator_under_a_load_that_jumps():
    """The integral of blows, of which each rings."""
    on, off, force = 1.0, 2.5, 1e-6
    factor = {"kind": "table", "angles": [on, on, off, off], "values": [0.0, 1.0, 1.0, 0.0]}
    load = {"push": {"at": "beam.B", "force": [0.0, force], "follows": True, "factor": factor}}
    blows, period = np.linspace(on, off, 2001), 2 * np.pi / SPIN
    errors = []
    for steps in (10, 20):
        data = fm.analyse(spinning(steps=steps, loads=load)).data
        since = np.mod((data["theta"].to_numpy()[:, None] - blows) / SPIN, period)
        exact = trapezoid(ringing(since, period, rate_of_tip(), 0.0, force / MASS), blows / SPIN, axis=1)
        errors.append(np.abs(tip_normal(data) - exact).max() / np.abs(exact).max())
    assert errors[1] < 2e-3
    assert errors[0] > 16 * errors[1]  # order 4 and more: steps end at the jumps


def test_a_load_over_the_state_of_a_joint_damps_and_pulls_back():
    """M = -k place - c rate on a bar at a pin: a damped oscillator, J x'' + c x' + k x = 0, without weight."""
    load = {
        "at": "bar.O",
        "moment": -1.0,
        "factor": {"kind": "formula", "joint": "O", "formula": "5 * place + 0.3 * rate"},
    }
    scene = fm.load(DEMOS / "free_motion" / "pendulum.toml").changed({"gravity": [0.0, 0.0], "loads": {"motor": load}})
    machine = machine_of(scene).machine
    rates, _ = frequencies(*tangents_at(machine, np.zeros(machine.size), np.zeros(machine.size)), 1)
    inertia = 0.083333333 + 0.5**2
    roots = np.roots([inertia, 0.3, 5.0])
    assert rates[0].real == pytest.approx(roots[0].real, rel=1e-9)
    assert abs(rates[0].imag) == pytest.approx(abs(roots[0].imag), rel=1e-9)
    spin = np.array([0.0, 0.5, 1.0, 0.0, 0.0])  # of the bar's centre, and no impulse of the pin
    course = march(machine, spin, 0.5, h=2e-3)
    turned = np.array([np.arctan2(motion.R[1][1, 0], motion.R[1][0, 0]) for motion in course.motion])
    exact = np.exp(roots[0].real * course.t) * np.sin(abs(roots[0].imag) * course.t) / abs(roots[0].imag)
    np.testing.assert_allclose(turned, exact, atol=1e-8)


# ---- a motor's shaft ----
def test_a_soft_shaft_lets_a_stiff_crank_swing_as_its_weight_and_the_rotor_ask():
    """(J + I) u'' + c u' + k u = - m g d cos(Omega t + u), u being the twist: the arm is 1e3 times as stiff as steel.

    Accelerations of stiff links are of order 2 in the steps: the torque misses 6.5e-4 with 60, and 1.6e-4 with 120.
    """
    mass, length, speed, k, c, rotor, g = 2.0, 0.3, 8.0, 40.0, 0.3, 0.15, 9.81
    section = {"shape": "rectangle", "width": 0.02, "height": 0.02}
    scene = fm.Scene.read(
        {
            "name": "arm on a soft shaft",
            "materials": {"stiff": {"modulus": 2e14, "density": mass / length / 4e-4}},
            "sections": {"bar": section},
            "ground": {"points": {"O": (0, 0)}},
            "links": {
                "arm": {
                    "points": {"O": (0, 0), "A": (length, 0)},
                    "members": {"OA": {"ends": ("O", "A"), "section": "bar", "material": "stiff"}},
                }
            },
            "joints": {"O": {"connect": ("ground.O", "arm.O")}},
            "drive": {"joint": "O", "speed": speed, "motor": {"stiffness": k, "damping": c, "inertia": rotor}},
            "gravity": (0, -g),
            "effects": EXACT,
            "analysis": {"method": "periodic", "sub_intervals": 120, **POSES},
        }
    )
    data = fm.analyse(scene).data
    t, arm = data["time"].to_numpy(), mass * length**2 / 3
    rates = 1j * np.fft.fftfreq(120, 1 / 120) * speed
    twist = np.zeros(120)
    for _ in range(100):
        weight = -mass * g * length / 2 * np.cos(speed * t + twist)
        twist = np.fft.ifft(np.fft.fft(weight) / ((arm + rotor) * rates**2 + c * rates + k)).real
    rate, change = (np.fft.ifft(rates**order * np.fft.fft(twist)).real for order in (1, 2))
    largest = np.abs(twist).max()
    assert largest > 0.1
    assert np.abs(data["drive_twist"].to_numpy() - twist).max() < 2e-5 * largest
    assert data["drive_rate"].to_numpy() == pytest.approx(speed + rate, rel=2e-5)
    shaft = -(k * twist + c * rate)
    for name, known in (("input_torque", shaft - rotor * change), ("support_moment", -shaft[:, None])):
        assert np.abs(data[name].to_numpy() - known).max() < 3e-4 * np.abs(known).max(), name
    assert np.abs(data["deflection"].to_numpy()).max() < 1e-6  # beside the crank, which the twist moves by 40 mm
    assert data.attrs["power_balance_error"] < 1e-3


@pytest.mark.long
def test_a_tolerance_is_met_for_strains_of_a_finer_answer():
    """Twice as many elements, steps and stations of poses are the reference: their errors are 1/16 and less."""
    tolerance = 0.002
    scene = fm.load(DEMOS / "four_bar.toml").changed({"effects": EXACT, "analysis.solver": "poses"})
    found = fm.analyse(scene.changed(tolerance=tolerance))
    told = float(found.data["relative_error"].sum())
    finer = found.scene.changed(
        {
            "tolerance": None,
            "mesh.elements": 2 * found.scene.mesh.elements,
            "analysis.sub_intervals": 2 * found.scene.analysis.sub_intervals,
            "analysis.stations": 2 * found.scene.analysis.stations - 1,
            "analysis.stability": False,
            "analysis.error_estimates": False,
        }
    )
    there = fm.analyse(finer).data["strain"][::2]  # peaks between positions are those of the curve
    there, here = (np.abs(x).max(("theta", "s", "fibre")) for x in (there, found.data["strain"]))
    assert told <= tolerance
    assert float((np.abs(here - there) / there).max()) <= tolerance
    assert "met by poses in" in found.data.attrs["chosen"]
