"""Drag of the air by the square of the velocity: spinning arms in closed form, and a four-bar by its rigid motion."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene

LENGTH, WIDTH, HEIGHT, SPEED = 0.5, 0.02, 0.005, 20.0
DENSITY, COEFFICIENT = 1000.0, 1.2  # of water, so that the drag is large
DRAG = DENSITY * COEFFICIENT * WIDTH / 2
AIR = {"density": DENSITY, "coefficient": COEFFICIENT}
STIFF = {"modulus": 206e13, "density": 7850}
STRIP = {"shape": "rectangle", "width": WIDTH, "height": HEIGHT}


def arm(speed=SPEED, **rest):
    """An arm that spins about its end, so stiff that it does not bend by much."""
    data = {
        "materials": {"steel": STIFF},
        "sections": {"strip": STRIP},
        "ground": {"points": {"O": (0, 0)}},
        "links": {
            "arm": {
                "points": {"O": (0, 0), "B": (LENGTH, 0)},
                "members": {"beam": {"ends": ("O", "B"), "section": "strip", "material": "steel"}},
            }
        },
        "joints": {"O": {"connect": ("ground.O", "arm.O")}},
        "drive": {"joint": "O", "speed": speed},
        "damping": {"air": AIR},
        "mesh": {"elements": 4},
        "effects": ("coupling", "large-rotations"),
        "analysis": {"sub_intervals": 12, "stations": 5, "stability": False},
    }
    return Scene.read(data | rest)


def four_bar(modulus=206e12, **rest):
    """A crank, a coupler with places where the velocity across it changes its sign, and a follower."""
    lengths = {"crank": 0.1, "coupler": 0.28, "follower": 0.22}
    ends = {"crank": ("A", "B"), "coupler": ("B", "C"), "follower": ("C", "D")}
    angles = {"crank": "90 deg", "coupler": "20 deg", "follower": "-70 deg"}
    data = {
        "materials": {"steel": {"modulus": modulus, "density": 7850}},
        "sections": {"strip": STRIP},
        "ground": {"points": {"A": (0, 0), "D": (0.3, 0)}},
        "links": {
            name: {
                "points": {ends[name][0]: (0, 0), ends[name][1]: (lengths[name], 0)},
                "members": {"beam": {"ends": ends[name], "section": "strip", "material": "steel"}},
                "angle": angles[name],
            }
            for name in lengths
        },
        "joints": {
            "A": {"connect": ("ground.A", "crank.A")},
            "B": {"connect": ("crank.B", "coupler.B")},
            "C": {"connect": ("coupler.C", "follower.C")},
            "D": {"connect": ("follower.D", "ground.D")},
        },
        "drive": {"joint": "A", "speed": SPEED},
        "damping": {"air": AIR},
        "mesh": {"elements": 2},
        "effects": ("coupling",),
        "analysis": {"sub_intervals": 48, "stations": 3, "stability": False},
    }
    return Scene.read(data | rest)


def dissipated(scene):
    """Power that the air takes from rigid links (W), by Gauss quadrature over many short parts of each."""
    motion = solve_motion(scene, np.arange(48) * 2 * np.pi / 48)
    x, weights = np.polynomial.legendre.leggauss(4)
    parts = 200
    places = ((np.arange(parts)[:, None] + (1 + x) / 2) / parts).ravel()
    weights = np.tile(weights / 2 / parts, parts)
    power = np.zeros(48)
    for name, link in scene.links.items():
        start, end = (motion.of_point(name, point) for point in link.points.values())
        length = np.hypot(*(end[0] - start[0])[0])
        normal = (end[0] - start[0])[:, ::-1] * [-1, 1] / length
        ends = [np.sum(normal * v, axis=1) for v in (start[1], end[1])]
        speed = ends[0][:, None] * (1 - places) + ends[1][:, None] * places
        power += DRAG * length * np.abs(speed) ** 3 @ weights
    return power


@pytest.mark.parametrize(
    "rest",
    [
        {},
        {"effects": ()},
        {"effects": ("coupling", "large-rotations", "shear"), "materials": {"steel": STIFF | {"poisson": 0.3}}},
        {"analysis": {"method": "quasi-static", "sub_intervals": 12, "stations": 5}},
        {"analysis": {"method": "quasi-static", "sub_intervals": 12, "stations": 5, "solver": "poses"}},
        {"analysis": {"solver": "harmonic-balance", "sub_intervals": 12, "harmonics": 2, "stations": 5}},
    ],
)
def test_spinning_arm_carries_its_drag(rest):
    # dF = k (Omega x)^2 dx; the links' stiffness leaves deflections of 1e-6 of the length, across which exact drag acts
    data = analyse(arm(**rest)).data
    torque = DRAG * SPEED**2 * LENGTH**4 / 4
    assert data["input_torque"].to_numpy() == pytest.approx(torque, rel=5e-6)
    assert float(data["mean_power"].sel(cause="air drag")) == pytest.approx(-torque * SPEED, rel=5e-6)
    assert data.attrs["power_balance_error"] < 1e-5  # the quasi-static bow of the arm takes none
    x = data["s"].to_numpy() * LENGTH
    moment = -DRAG * SPEED**2 * (LENGTH**4 / 4 - x * LENGTH**3 / 3 + x**4 / 12)
    shear = DRAG * SPEED**2 * (LENGTH**3 - x**3) / 3
    assert data["moment"].to_numpy()[0, 0] == pytest.approx(moment, abs=1e-5 * torque)
    assert data["shear_force"].to_numpy()[0, 0] == pytest.approx(shear, abs=1e-5 * shear[0])


def test_width_is_that_of_the_members():
    wide = analyse(arm(damping={"air": AIR | {"width": 2 * WIDTH}})).data
    assert wide["input_torque"].to_numpy() == pytest.approx(DRAG * SPEED**2 * LENGTH**4 / 2, rel=1e-6)


@pytest.mark.parametrize("effects", [(), ("coupling",)])
def test_four_bar_needs_the_power_that_the_air_takes(effects):
    # links of 1000 times the stiffness of steel change their velocities by some 1e-6
    scene = four_bar(effects=effects)
    data = analyse(scene).data
    power = dissipated(scene).mean()
    assert float(data["mean_power"].sel(cause="drive")) == pytest.approx(power, rel=1e-5)
    assert float(data["mean_power"].sel(cause="air drag")) == pytest.approx(-power, rel=1e-5)
    assert data.attrs["power_balance_error"] < 1e-5


def test_vibration_in_cross_flow_is_damped_by_its_velocity():
    # growth -int rho C_D b Omega x phi^2 dx / (2 int m phi^2 dx) of the first mode, 0.4 % of critical damping
    air = {"density": 2.0, "coefficient": COEFFICIENT}
    steel = {"steel": {"modulus": 206e9, "density": 7850}}
    scene = arm(damping={"air": air}, materials=steel, analysis={"sub_intervals": 96, "stations": 5})
    root, x = 1.8751040687, np.linspace(0, 1, 2001)
    share = (np.cosh(root) + np.cos(root)) / (np.sinh(root) + np.sin(root))
    shape = np.cosh(root * x) - np.cos(root * x) - share * (np.sinh(root * x) - np.sin(root * x))
    mean = LENGTH * np.sum(x * shape**2) / np.sum(shape**2)
    growth = -air["density"] * COEFFICIENT * WIDTH * SPEED * mean / (2 * 7850 * WIDTH * HEIGHT)
    # 2e-6 by measure, of the mesh and the stretching of the arm; the sums above are good to 3e-4
    assert analyse(scene).data["growth_rate"].to_numpy()[:2] == pytest.approx([growth] * 2, rel=1e-3)


def test_drag_of_linear_vibration_is_told_by_the_theory():
    # links that vibrate as fast as they move: what is linear in their velocity lacks its square
    scene = four_bar(5e9, damping={"air": AIR, "ratio": 0.01})
    linear, exact = (analyse(scene.changed(effects=("coupling", *more))).data for more in ((), ("large-rotations",)))
    power, true = (float(data["mean_power"].sel(cause="air drag")) for data in (linear, exact))
    assert abs(power / true - 1) < 0.01
    told = float(linear["drive_effort_error"].sel(source="theory").max())
    assert told > np.abs(linear["input_torque"] - exact["input_torque"]).max() / 3


def test_only_what_is_known_is_answered():
    custom = {"strip": {"area": 1e-4, "inertia": 1e-10, "fibre": 0.0025}}
    for rest, message in (
        ({"sections": custom}, "has no width by which the air drags it"),
        ({"tolerance": 0.01}, "a tolerance is not available for the drag of the air"),
        ({"analysis": {"solver": "sub-intervals"}}, "effects: .* write solver = .poses. or .collocation."),
    ):
        with pytest.raises(SceneError, match=message):
            analyse(arm(**rest))
