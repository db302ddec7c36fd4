"""A drive with a motor: against the rigid linkage's nonlinear equation, and the structure of Lagrange's equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import root

from fenics_mech import analyse, load
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS, response_of

SHAFT = {"stiffness": 60.0, "damping": 0.05, "inertia": 2e-3}
ACTING = {
    "loads": {"press": {"at": "follower.B", "force": (4.0, -3.0)}},
    "springs": {
        "hinge": {"joint": "C", "stiffness": 2.0, "angle": "100 deg"},
        "line": {"between": ("coupler.B", "ground.O"), "stiffness": 100.0, "length": 0.1},
    },
    "dampers": {"hinge": {"joint": "C", "damping": 0.02}},
}


def with_motor(motor, **rest):
    data = seed_four_bar(**{"effects": ("large-rotations",)} | rest).model_dump()
    data["drive"]["motor"] = motor
    return Scene.read(data)


def stiff(scale):
    return {"material": {"modulus": 71e9 * scale, "density": 2714}}


class Rigid:
    """The rigid linkage as a function of its crank's angle: J, the torque of loads and springs, and that of dampers."""

    def __init__(self, scene, count=256):
        psi = 2 * np.pi * np.arange(count) / count
        motion, speed = solve_motion(scene, psi), scene.drive.speed

        def rate(at):
            body, point = scene.point(at)
            return motion.of_point(body, point)[1] / speed

        inertia = np.zeros(count)
        for name, link in scene.links.items():
            (member,) = link.members.values()
            first, second = (rate(f"{name}.{end}") for end in member.ends)
            mass = (
                2714 * scene.sections[member.section].area * np.linalg.norm(np.diff(list(link.points.values()), axis=0))
            )
            # a bar has a sixth of its mass at each end and two thirds in the middle
            for share, v in ((1 / 6, first), (4 / 6, (first + second) / 2), (1 / 6, second)):
                inertia += share * mass * np.sum(v**2, axis=1)
        for mass in scene.masses.values():
            inertia += mass.mass * np.sum(rate(mass.at) ** 2, axis=1)
        turn = motion.omega[:, 2] / speed
        torque = rate("follower.B") @ [4.0, -3.0] - 2.0 * (motion.angle[:, 2] - np.radians(100)) * turn
        away = motion.of_point("follower", scene.point("follower.B")[1])[0]
        length = np.linalg.norm(away, axis=1)
        torque -= 100 * (length - 0.1) / length * np.sum(away * rate("follower.B"), axis=1)
        self.series = [np.fft.rfft(values)[:100] / count for values in (inertia, torque, 0.02 * turn**2)]

    def at(self, psi):
        """J, dJ/dpsi, torque, and torque over the rate of the crank by dampers."""
        n = np.arange(1, 100)
        wave = np.exp(1j * n * psi)
        j, torque, drag = (s[0].real + 2 * (s[1:] @ wave).real for s in self.series)
        return j, 2 * (1j * n * self.series[0][1:] @ wave).real, torque, drag

    def orbit(self, motor, speed, count):
        """Twist and rate of the crank of the steady motion, ``(2, count)``."""

        def rates(t, y):
            j, slope, torque, drag = self.at(y[0])
            shaft = -motor["stiffness"] * (y[0] - speed * t) - motor["damping"] * (y[1] - speed)
            return [y[1], (shaft + torque - drag * y[1] - slope * y[1] ** 2 / 2) / (j + motor["inertia"])]

        period = 2 * np.pi / speed

        def run(start, times):
            options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, "t_eval": times}
            y = solve_ivp(rates, (0, period), [start[0], speed + start[1]], **options).y
            return y - np.array([speed * times, 0 * times])

        found = root(lambda start: (run(start, np.array([period]))[:, 0] - [0, speed]) - start, [0.0, 0.0])
        assert found.success
        return run(found.x, period * np.arange(count) / count)


def test_crank_turns_as_that_of_the_rigid_linkage():
    scene = with_motor(
        SHAFT, materials=stiff(1e4), analysis={"sub_intervals": 120, "stability": False, "allow_coarse": True}, **ACTING
    )
    data = response_of(scene).data
    twist, rate = Rigid(scene).orbit(SHAFT, scene.drive.speed, 120)
    assert np.ptp(rate) > 0.3 * scene.drive.speed  # far from a small ripple
    # 120 steps, and links 1e4 times as stiff as aluminium
    assert np.abs(data["drive_twist"] - twist).max() < 2e-4 * np.abs(twist).max()
    assert np.abs(data["drive_rate"] - rate).max() < 2e-4 * np.ptp(rate)


def test_stiff_shaft_is_an_ideal_drive():
    analysis = {"sub_intervals": 60, "stability": False, "allow_coarse": True}
    ideal = response_of(seed_four_bar(effects=("coupling", "large-rotations"), analysis=analysis)).data["strain"]
    errors = []
    for stiffness in (1e5, 1e6):
        motor = {"stiffness": stiffness, "damping": 2e-4 * stiffness, "inertia": 1e-3}
        scene = with_motor(motor, effects=("coupling", "large-rotations"), analysis=analysis)
        strain = response_of(scene).data["strain"]
        errors.append(float(np.abs(strain - ideal).max() / np.abs(ideal).max()))
    assert errors[0] < 0.02
    assert errors[1] == pytest.approx(errors[0] / 10, rel=0.1)  # the twist goes with 1/stiffness


def test_mirrored_linkage_twists_the_other_way():
    scene = with_motor(SHAFT, analysis={"sub_intervals": 36, "stability": False, "allow_coarse": True})
    data = scene.model_dump()
    data["drive"]["speed"] *= -1
    for link in data["links"].values():
        link["angle"] *= -1
    plain, other = response_of(scene).data, response_of(Scene.read(data)).data
    for name in ("drive_twist", "drive_rate", "input_torque", "strain_bending"):
        assert np.abs(plain[name] + other[name].to_numpy()).max() < 1e-8 * np.abs(plain[name]).max(), name


def test_shaft_and_rotor_balance_the_torque_of_the_crank():
    # the torque on the crank is found from the links' forces on the undeformed shape: equal as the links get stiff
    scene = with_motor(
        SHAFT, materials=stiff(1e4), analysis={"sub_intervals": 240, "stability": False, "allow_coarse": True}
    )
    data = analyse(scene).data
    ripple = np.fft.rfft(data["drive_rate"].to_numpy())
    change = np.fft.irfft(1j * np.arange(len(ripple)) * scene.drive.speed * ripple, 240)
    twist, rate = data["drive_twist"], data["drive_rate"] - scene.drive.speed
    shaft = -60.0 * twist - 0.05 * rate - 2e-3 * change
    assert (
        np.abs(data["input_torque"] - shaft).max() < 2e-3 * np.abs(shaft).max()
    )  # measured 1e-3: order 2 of the steps


@pytest.mark.parametrize("motor", [SHAFT | {"stiffness": 0.05}, SHAFT | {"stiffness": 3}])
def test_of_a_shaft_that_is_too_soft_for_the_load_the_share_that_it_carries_is_told(motor):
    loads = {"press": {"at": "follower.B", "force": (40.0, -40.0)}}
    scene = with_motor(motor, loads=loads, analysis={"sub_intervals": 24, "stability": False, "allow_coarse": True})
    with pytest.raises(SolverError, match=r"There are answers up to 0\.\d+ of the load"):
        analyse(scene)


@pytest.mark.slow
def test_motor_works_with_large_rotations_and_tells_stability():
    scene = with_motor(SHAFT, effects=("large-rotations",), analysis={"sub_intervals": 60, "allow_coarse": True})
    data = analyse(scene).data
    assert np.isfinite(data["strain"]).all()
    assert np.abs(data["multiplier"].to_numpy()).max() < 1


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"analysis__method": "quasi-static"}, "periodic response"),
        ({"analysis__solver": "sub-intervals"}, "collocation"),
        (
            {"drive__speed": None, "drive__law": {"kind": "harmonics", "sine": [1.0]}, "drive__period": 1.0},
            "constant speed",
        ),
        (
            {"joints__O__connect": ("crank.O", "coupler.A"), "joints__A__connect": ("ground.O", "crank.A")},
            "pin of the ground",
        ),
    ],
)
def test_motors_that_are_refused(changes, words):
    scene = with_motor(SHAFT)
    with pytest.raises(SceneError, match=words):
        scene.changed(**changes)


def test_the_motion_under_a_motor_without_inertia_does_not_depend_on_the_mesh_of_the_crank():
    """Solved for from the equation, the acceleration was 4 % off with four elements, and refused with eight."""
    scene = load(DEMOS / "slider_crank.toml").changed(
        effects=("coupling", "large-rotations"),
        drive__motor={"stiffness": 40.0, "damping": 0.02},
        analysis={"sub_intervals": 90, "stability": False, "allow_coarse": True},
    )
    coarse, fine = (response_of(scene.changed(mesh__elements=count)).data for count in (3, 8))
    efforts, forces = (np.abs(coarse[name] - fine[name]).max() for name in ("drive_effort", "joint_force"))
    assert efforts < 1e-4 * np.abs(fine["drive_effort"]).max()
    assert forces < 2e-4 * np.abs(fine["joint_force"]).max()
