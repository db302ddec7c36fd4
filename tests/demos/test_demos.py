"""Every demo is analysed, and a number of its answer is compared with one that can be had by hand."""

import numpy as np
import pytest
from scipy.integrate import simpson

from fenics_mech.machine.linkage import solve_motion

ALUMINIUM = {"e": 71e9, "rho": 2714.0}


def pinned_frequency(ei, line_density, length):
    """First bending frequency (Hz) of a beam on two pins, (pi/L)^2 sqrt(EI/rho A)."""
    return np.pi / 2 / length**2 * np.sqrt(ei / line_density)


def strip(width, height, e, rho):
    """EI and rho A of a rectangle."""
    return e * width * height**3 / 12, rho * width * height


def mid_moment(place, line_density, theta, rate, h=1e-3):
    """Bending moment in the middle of a bar on pins, loaded by its own inertia alone: rho A L^2 (a_1 + a_2)/16.

    `place` gives the ends of the bar as complex numbers at drive angles; a_1 and a_2 are their accelerations across it,
    by fourth-order differences.
    """
    steps = {-2: -1 / 12, -1: 4 / 3, 0: -5 / 2, 1: 4 / 3, 2: -1 / 12}
    acceleration = rate**2 / h**2 * sum(w * np.array(place(theta + i * h)) for i, w in steps.items())
    first, second = place(theta)
    length = np.abs(second - first)
    across = (acceleration * np.conj((second - first) / length)).imag
    return line_density * length**2 * across.sum(axis=0) / 16


def meet(p, q, from_p, from_q):
    """Where circles about p and q meet, left of the way from p to q."""
    apart = q - p
    cosine = (from_p**2 + np.abs(apart) ** 2 - from_q**2) / (2 * from_p * np.abs(apart))
    return p + from_p * apart / np.abs(apart) * (cosine + 1j * np.sqrt(1 - cosine**2))


def assert_moment(data, member, place, line_density, rate):
    found = data["moment"].sel(member=member, s=0.5).to_numpy()
    expected = mid_moment(place, line_density, data["theta"].to_numpy(), rate)
    assert np.abs(found - expected).max() < 1e-6 * np.abs(expected).max()


def test_slider_crank_rod_bends_as_a_beam_on_pins(analysed):
    ei, line_density = strip(0.025, 0.003, **ALUMINIUM)
    lowest = analysed("slider_crank")["frequency"].min("mode").to_numpy()
    assert lowest == pytest.approx(
        pinned_frequency(ei, line_density, 0.3), rel=2e-3
    )  # the crank is stiff, the slider heavy

    def ends(theta):
        pin = 0.06 * np.exp(1j * theta)
        return pin, pin.real + np.sqrt(0.09 - (0.01 - pin.imag) ** 2) + 0.01j

    assert_moment(analysed("slider_crank", "quasi-static"), "rod", ends, line_density, 60.0)
    # slower than a fifth of that frequency, the rod follows: its vibration adds a few per cent
    periodic, static = (
        np.abs(analysed("slider_crank", m)["moment"].sel(member="rod")).max() for m in ("periodic", "quasi-static")
    )
    assert 1.0 < periodic / static < 1 / (1 - (9.55 / 77.3) ** 2) + 0.02


def test_quick_return_rocker_vibrates_as_an_overhanging_beam(analysed):
    # with the crank upright the pin is 0.28 m from the pivot; Rayleigh's quotient of ram, coupler and rocker with the
    # deflection under a tip force, which is c^2 L/(3 EI) at the tip
    ei, line_density = strip(0.02, 0.006, 206e9, 7850.0)
    a, c = 0.28, 0.12
    x, y = np.linspace(0, a, 4001), np.linspace(0, c, 4001)
    between = -c * x * (a**2 - x**2) / (6 * a)
    beyond = c * a * y / 3 + y**2 * (3 * c - y) / 6
    tip = beyond[-1]
    assert tip == pytest.approx(c**2 * (a + c) / 3)
    mass = 0.4 + 7850 * 0.016 * 0.003 * 0.15
    own = line_density * (simpson(between**2, x=x) + simpson(beyond**2, x=y)) / tip**2
    rayleigh = np.sqrt(ei / tip / (mass + own)) / (2 * np.pi)
    data = analysed("quick_return")
    upright = int(np.abs(data["theta"].to_numpy() - np.pi / 2).argmin())
    found = float(data["frequency"].isel(theta=upright).min())
    assert 0.99 * rayleigh < found < rayleigh  # Rayleigh's quotient is an upper bound; the crank gives way a little


def test_quick_return_moment_is_largest_at_the_pin(analysed):
    data = analysed("quick_return", "quasi-static")
    place = np.abs(0.2j + 0.08 * np.exp(1j * data["theta"].to_numpy())) / 0.4
    moment = np.abs(data["moment"].sel(member="rocker").to_numpy())
    loaded = moment.max(axis=1) > 0.2 * moment.max()
    assert np.abs(data["s"].to_numpy()[moment.argmax(axis=1)] - place)[loaded].max() < 0.05  # a station


def test_watt_bar_bends_by_its_own_inertia(analysed):
    def ends(theta):
        a = 0.08 * np.exp(1j * theta)
        b = meet(a, 0.25, 0.22, 0.2)
        p, q = a + (b - a) / 0.22 * (0.13 + 0.11j), 0.25 + (b - 0.25) / 0.2 * (0.19 - 0.12j)
        return p, meet(p, q, 0.24, 0.2)

    _, line_density = strip(0.02, 0.002, **ALUMINIUM)
    assert_moment(analysed("watt", "quasi-static"), "left", ends, line_density, 8 * np.pi)


def test_stephenson_output_bends_by_its_own_inertia(analysed):
    def ends(theta):
        a = 0.08 * np.exp(1j * theta)
        p = a + (meet(a, 0.25, 0.22, 0.2) - a) / 0.22 * (0.15 + 0.12j)
        return np.full_like(p, 0.42 + 0.04j), meet(p, 0.42 + 0.04j, 0.3, 0.24)

    _, line_density = strip(0.02, 0.002, **ALUMINIUM)
    assert_moment(analysed("stephenson", "quasi-static"), "output", ends, line_density, 8 * np.pi)


def test_counterweight_loads_the_rocker_at_its_pivot(analysed, scene_of):
    # statics of the overhang: (m l^2 + J + rho A l^3/3) alpha; at its end the counterweight's J alpha
    data = analysed("counterweighted_rocker", "quasi-static")
    alpha = solve_motion(scene_of("counterweighted_rocker"), data["theta"].to_numpy()).alpha[:, 2]
    _, line_density = strip(0.025, 0.004, **ALUMINIUM)
    expected = (0.4 * 0.12**2 + 1.2e-4 + line_density * 0.12**3 / 3) * alpha
    moment = data["moment"]
    assert moment.sel(member="rocker.WC", s=1).to_numpy() == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())
    assert moment.sel(member="rocker.WC", s=0).to_numpy() == pytest.approx(1.2e-4 * alpha, abs=1e-9)
    assert np.abs(moment.sel(member="rocker.BE", s=1)).max() < 1e-9


def test_manipulator_needs_the_torque_of_the_textbook(analysed):
    # two-link arm in a level plane: Spong, Hutchinson and Vidyasagar, Robot Modeling and Control, 2006, section 7.3
    data = analysed("manipulator", "quasi-static")
    t, rate, degree = data["theta"].to_numpy(), np.pi, np.pi / 180
    q1d = rate * degree * (30 * np.sin(t) + 10 * np.cos(2 * t))
    q1dd = rate**2 * degree * (30 * np.cos(t) - 20 * np.sin(2 * t))
    q2 = 0.9 - 0.375 * np.cos(t) - 0.125 * np.cos(3 * t) + 0.2 * np.sin(t)
    q2d = rate * (0.375 * np.sin(t) + 0.375 * np.sin(3 * t) + 0.2 * np.cos(t))
    q2dd = rate**2 * (0.375 * np.cos(t) + 1.125 * np.cos(3 * t) - 0.2 * np.sin(t))
    l1, l2 = 0.5, 0.4
    m1, m2 = 2714 * 0.04 * 0.006 * l1, 2714 * 0.03 * 0.004 * l2
    about_joint1 = m1 * l1**2 / 3 + 0.25 * l1**2 + 1e-4 + (m2 + 0.1) * l1**2
    about_joint2 = m2 * l2**2 / 3 + 0.1 * l2**2 + 0.5e-4
    first_moment = (m2 / 2 + 0.1) * l2
    couple, twist = l1 * first_moment * np.cos(q2), l1 * first_moment * np.sin(q2)
    torque = (about_joint1 + about_joint2 + 2 * couple) * q1dd + (about_joint2 + couple) * q2dd
    torque -= twist * (2 * q1d * q2d + q2d**2)
    found = data["input_torque"].to_numpy()
    assert np.abs(found - torque).max() < 1e-9 * np.abs(torque).max()
    assert data["moment"].sel(member="upper_arm", s=0).to_numpy() == pytest.approx(-found, abs=1e-9)


def test_jansen_legs_are_mirror_images_half_a_turn_apart(analysed):
    # the right leg at 180 deg - theta is the left leg at theta, seen in a mirror; its accelerations are the same
    data = analysed("jansen", "quasi-static")
    moment = data["moment"].to_numpy()
    members = list(data["member"].to_numpy())
    count = len(moment)
    opposite = (count // 2 - np.arange(count)) % count
    for name in (m.removeprefix("left_") for m in members if m.startswith("left_")):
        left, right = (moment[:, members.index(f"{side}_{name}")] for side in ("left", "right"))
        assert np.abs(left + right[opposite]).max() < 1e-7 * np.abs(moment).max(), name
    left, right = (moment[:, members.index(f"{side}_k")] for side in ("left", "right"))
    assert np.abs(left + right).max() > 0.5 * np.abs(left).max()  # it is not so at the same time


def test_jansen_longest_rods_vibrate_first(analysed):
    ei, line_density = strip(0.02, 0.003, **ALUMINIUM)
    frequency = np.sort(analysed("jansen")["frequency"].to_numpy(), axis=1)[:, :2]
    assert np.abs(frequency / pinned_frequency(ei, line_density, 0.3095) - 1).max() < 0.01  # the two rods k


def test_composite_coupler_has_the_stiffness_of_its_plies(analysed, scene_of):
    # EI = sum of E (t^3/12 + t z^2) width about the strip's middle
    plies = [(140e9, 0.5e-3, -0.75e-3), (9e9, 1e-3, 0.0), (140e9, 0.5e-3, 0.75e-3)]
    ei = 0.025 * sum(e * (t**3 / 12 + t * z**2) for e, t, z in plies)
    line_density = 0.025 * 2e-3 * 1600
    data = analysed("composite_four_bar", "quasi-static")
    coupler = data.sel(member="coupler", s=0.5)
    moment = coupler["moment"].to_numpy()
    assert coupler["strain_bending"].sel(fibre="+").to_numpy() == pytest.approx(-1e-3 / ei * moment, rel=1e-9)
    lowest = analysed("composite_four_bar")["frequency"].min(("theta", "mode"))
    assert lowest == pytest.approx(pinned_frequency(ei, line_density, 0.28), rel=0.05)

    def ends(theta):
        a = 0.09 * np.exp(1j * theta)
        return a, meet(a, 0.3, 0.28, 0.26)

    assert_moment(data, "coupler", ends, line_density, scene_of("composite_four_bar").drive.speed)


def test_pulsating_column_is_softened_by_its_load(analysed):
    # w^2 = w_1^2 (1 - P/P_E): Bolotin, The Dynamic Stability of Elastic Systems (1964), section 1
    ei, line_density = strip(0.02, 0.002, 206e9, 7850.0)
    data = analysed("pulsating_column")
    load = 32.5 * (1 + np.cos(data["theta"].to_numpy()))
    softened = pinned_frequency(ei, line_density, 0.5) * np.sqrt(1 - load / (np.pi**2 * ei / 0.5**2))
    # four elements make the Euler load 8e-4 too large, (1/4)^4 of the 0.22 of one
    assert data["frequency"].sel(mode=1).to_numpy() == pytest.approx(softened, rel=1e-3)
    assert data["axial_force"].sel(s=0.5).to_numpy()[:, 0] == pytest.approx(-load, abs=1e-4 * 65)  # and inertia
