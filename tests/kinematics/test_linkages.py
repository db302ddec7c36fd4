"""Rigid motion of linkages against closed forms, circle intersections with complex numbers, and differences."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import load
from fenics_mech.scene.factories import four_bar, manipulator, quick_return, slider_crank
from tests.common import DEMOS

SECTION = {"area": 1e-4, "inertia": 1e-10, "fibre": 1e-3}
MATERIAL = {"modulus": 7e10, "density": 2700}
THETA = np.linspace(0, 2 * np.pi, 73)
SIXTH_ORDER = {-3: -1 / 60, -2: 3 / 20, -1: -3 / 4, 1: 3 / 4, 2: -3 / 20, 3: 1 / 60}


def slider(r, rod, **rest):
    given_ = {"sections": [SECTION] * 2, "material": MATERIAL, "speed": 10.0}
    return slider_crank(crank=r, rod=rod, **given_ | rest)


def shaper(**rest):
    given_ = {"crank": 0.08, "centres": 0.2, "rocker": 0.4, "coupler": 0.15, "guide": 0.39, "speed": 10.0}
    return quick_return(sections=[SECTION] * 3, material=MATERIAL, **given_ | rest)


def point(motion, link, place):
    """Position of a link's point as complex numbers."""
    x, y = motion.of_point(link, place)[0].T
    return x + 1j * y


def meet(p, q, from_p, from_q, side):
    """Where circles about p and q meet; side 1 is the left of the way from p to q."""
    apart = q - p
    cosine = (from_p**2 + np.abs(apart) ** 2 - from_q**2) / (2 * from_p * np.abs(apart))
    return p + from_p * apart / np.abs(apart) * (cosine + 1j * side * np.sqrt(1 - cosine**2))


def corner(p, q, over, place):
    """Third corner of a triangle that has p at its origin, q at `over` on its x axis, and the corner at `place`."""
    return p + (q - p) / over * complex(*place)


def assert_at(motion, scene, **expected):
    """Compare points, named link__point, with expected places relative to the linkage's size."""
    for name, place in expected.items():
        link, end = name.split("__")
        found = point(motion, link, scene.links[link].points[end])
        assert np.abs(found - place).max() < 1e-12 * max(1, np.abs(place).max()), name


# Closed forms


@pytest.mark.parametrize("branch", ["right", "left"])
@pytest.mark.parametrize("offset", [0.0, 0.07, -0.05])
def test_slider_crank_closed_form(offset, branch):
    # x_B = r cos + sqrt(l^2 - (e - r sin)^2), its first two derivatives by hand
    r, rod, speed, sign = 0.2, 0.5, 10.0, 1 if branch == "right" else -1
    motion = solve_motion(slider(r, rod, offset=offset, branch=branch, speed=speed), THETA)
    s, c = np.sin(THETA), np.cos(THETA)
    rise = offset - r * s
    root = np.sqrt(rod**2 - rise**2)
    root1 = rise * r * c / root
    root2 = (-((r * c) ** 2) - rise * r * s - root1**2) / root
    found = [z[:, 0] for z in motion.of_point("rod", (rod, 0))]
    assert np.abs(found[0] - (r * c + sign * root)).max() < 1e-12
    assert np.abs(found[1] - speed * (-r * s + sign * root1)).max() < 1e-12 * speed
    assert np.abs(found[2] - speed**2 * (-r * c + sign * root2)).max() < 1e-12 * speed**2
    assert np.abs(motion.of_point("rod", (rod, 0))[0][:, 1] - offset).max() < 1e-14


def test_inverted_slider_crank_closed_form():
    # rocker angle = arg(i d + r e^{i theta}); omega and alpha are the imaginary parts of its derivatives' ratios
    r, apart, speed = 0.08, 0.2, 10.0
    motion = solve_motion(shaper(), THETA)
    arm = 1j * apart + r * np.exp(1j * THETA)
    first = 1j * speed * r * np.exp(1j * THETA) / arm
    second = -(speed**2) * r * np.exp(1j * THETA) / arm
    assert np.abs(motion.angle[:, 1] - np.angle(arm)).max() < 1e-12
    assert np.abs(motion.omega[:, 1] - first.imag).max() < 1e-12 * speed
    assert np.abs(motion.alpha[:, 1] - (second - first**2).imag).max() < 1e-12 * speed**2


def test_quick_return_has_its_time_ratio():
    # the rocker turns back where it touches the crank circle: at arcsin(r/d) below the horizontal, on either side
    back = -np.arcsin(0.08 / 0.2)
    motion = solve_motion(shaper(), np.array([back, np.pi - back]))
    assert np.abs(motion.omega[:, 1]).max() < 1e-13
    assert (np.pi - 2 * back) / (np.pi + 2 * back) == pytest.approx(1.7099, abs=1e-4)  # 227.16 deg to 132.84 deg


# Circle intersections


def test_watt_six_bar_against_circle_intersections():
    scene = load(DEMOS / "watt.toml")
    motion = solve_motion(scene, THETA)
    a, c = 0.08 * np.exp(1j * THETA), 0.25
    b = meet(a, c, 0.22, 0.2, 1)
    p, q = corner(a, b, 0.22, (0.13, 0.11)), corner(c, b, 0.2, (0.19, -0.12))
    assert_at(motion, scene, coupler__B=b, coupler__P=p, rocker__Q=q, left__R=meet(p, q, 0.24, 0.2, 1))


def test_stephenson_six_bar_against_circle_intersections():
    scene = load(DEMOS / "stephenson.toml")
    motion = solve_motion(scene, THETA)
    a = 0.08 * np.exp(1j * THETA)
    b = meet(a, 0.25, 0.22, 0.2, 1)
    p = corner(a, b, 0.22, (0.15, 0.12))
    assert_at(motion, scene, rocker__B=b, coupler__P=p, output__R=meet(p, 0.42 + 0.04j, 0.3, 0.24, 1))


def test_jansen_legs_against_circle_intersections():
    # six loops; lengths in Jansen's units
    scene = load(DEMOS / "jansen.toml")
    motion = solve_motion(scene, THETA)
    unit, pin = 0.005, 15 * np.exp(1j * THETA)
    for name, side in (("left", 1), ("right", -1)):
        pivot = -side * 38 - 7.8j
        top = meet(pin, pivot, 50, 41.5, -side)
        knee = meet(pin, pivot, 61.9, 39.3, side)
        outer = meet(pivot, top, 40.1, 55.8, side)
        shin = meet(outer, knee, 39.4, 36.7, -side)
        foot = meet(knee, shin, 49, 65.7, side)
        for link, end, place in (("upper", "Q", outer), ("lower", "R", shin), ("lower", "foot", foot)):
            found = point(motion, f"{name}_{link}", scene.links[f"{name}_{link}"].points[end])
            assert np.abs(found - unit * place).max() < 5e-7, (name, end)  # corners are given to 0.1 micrometre
    # the same to rounding with the corners as given
    for name, side in (("left", 1), ("right", -1)):
        pins = {key: scene.links[f"{name}_{key}"].points for key in ("upper", "lower")}
        pivot, crank = -side * 0.19 - 0.039j, 0.075 * np.exp(1j * THETA)
        top, knee = meet(crank, pivot, 0.25, 0.2075, -side), meet(crank, pivot, 0.3095, 0.1965, side)
        outer = corner(pivot, top, 0.2075, pins["upper"]["Q"])
        shin = meet(outer, knee, 0.197, 0.1835, -side)
        foot = corner(knee, shin, 0.1835, pins["lower"]["foot"])
        assert_at(motion, scene, **{f"{name}_upper__Q": outer, f"{name}_lower__R": shin, f"{name}_lower__foot": foot})


# Derivatives


@pytest.mark.parametrize(
    "demo", sorted({path.stem for path in DEMOS.glob("*.toml")} - {"pulsating_column"})
)  # it stands
def test_velocity_and_acceleration_are_derivatives(demo):
    scene, h = load(DEMOS / f"{demo}.toml"), 2e-3
    theta = np.linspace(0, 6, 13)
    motions = {i: solve_motion(scene, theta + i * h) for i in SIXTH_ORDER}
    motion = solve_motion(scene, theta)
    pairs = (("angle", "omega"), ("omega", "alpha"), ("position", "velocity"), ("velocity", "acceleration"))
    for value, derivative in pairs:
        found = scene.cycle_rate / h * sum(w * getattr(motions[i], value) for i, w in SIXTH_ORDER.items())
        exact = getattr(motion, derivative)
        assert np.abs(found - exact).max() < 1e-9 * np.abs(exact).max(), derivative


# Random linkages


@given(
    r=st.floats(0.05, 1.0),
    slack=st.floats(0.05, 3.0),
    offset=st.floats(-0.9, 0.9),
    guide=st.floats(-3.1, 3.1),
    branch=st.sampled_from(["right", "left"]),
    backwards=st.booleans(),
)
def test_random_slider_cranks(r, slack, offset, guide, branch, backwards):
    rod = r + abs(offset) + slack  # Grashof: the crank turns fully
    assume(slack > 0.05 * rod)
    theta = -THETA if backwards else THETA
    scene = slider(r, rod, offset=offset, guide_angle=guide, branch=branch, speed=-10.0 if backwards else 10.0)
    motion = solve_motion(scene, theta)
    pin = r * np.exp(1j * (theta - guide))  # in the guide's axes
    root = np.sqrt(rod**2 - (offset - pin.imag) ** 2)
    expected = pin.real + (root if branch == "right" else -root) + 1j * offset
    assert np.abs(point(motion, "rod", (rod, 0)) - expected * np.exp(1j * guide)).max() < 1e-11 * rod


@given(
    lengths=st.lists(st.floats(0.1, 2.0), min_size=2, max_size=5),
    seed=st.integers(0, 2**32 - 1),
)
@settings(max_examples=20)
def test_random_open_chains(lengths, seed):
    # the tip is a sum of turning arms, its velocity and acceleration the sum of their derivatives
    rng, period = np.random.default_rng(seed), 2.0
    mean, cosine, sine = rng.normal(size=(3, len(lengths)))
    laws = [{"kind": "harmonics", "mean": m, "cosine": [0.0, a], "sine": [b]} for m, a, b in zip(mean, cosine, sine)]
    scene = manipulator(
        arms=lengths,
        sections=[SECTION] * len(lengths),
        material=MATERIAL,
        laws=laws,
        period=period,
        masses=[{}] * len(lengths),
    )
    motion = solve_motion(scene, THETA)
    rate, t = 2 * np.pi / period, THETA[:, None]
    angle = np.cumsum(mean + cosine * np.cos(2 * t) + sine * np.sin(t), axis=1)
    omega = rate * np.cumsum(-2 * cosine * np.sin(2 * t) + sine * np.cos(t), axis=1)
    alpha = rate**2 * np.cumsum(-4 * cosine * np.cos(2 * t) - sine * np.sin(t), axis=1)
    arms = np.array(lengths) * np.exp(1j * angle)
    tip = [z[:, 0] + 1j * z[:, 1] for z in motion.of_point(f"arm{len(lengths)}", (lengths[-1], 0))]
    for found, expected in zip(tip, (arms, 1j * omega * arms, (1j * alpha - omega**2) * arms)):
        total = expected.sum(axis=1)
        assert np.abs(found - total).max() < 1e-11 * (1 + np.abs(expected).max())


def test_factories_make_the_demos():
    # the same dimensions give the same motion as the scene files
    four = four_bar(
        crank="4.25 in",
        coupler="11 in",
        follower="10.65 in",
        ground="10 in",
        sections=[SECTION] * 3,
        material=MATERIAL,
        speed=32.3,
    )
    crank = slider(0.06, 0.3, offset=0.01, speed=60.0)
    for demo, made in (("four_bar", four), ("slider_crank", crank), ("quick_return", shaper(speed="120 rpm"))):
        stated, found = (solve_motion(scene, THETA) for scene in (load(DEMOS / f"{demo}.toml"), made))
        assert np.allclose(stated.angle, found.angle, rtol=0, atol=1e-12)
        assert np.allclose(stated.acceleration, found.acceleration, rtol=0, atol=1e-11 * np.abs(stated.alpha).max())
