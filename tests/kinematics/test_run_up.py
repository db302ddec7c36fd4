"""Motion in time: run-ups against closed forms, high-order differences and the steady motion."""

from dataclasses import replace

import numpy as np
import pytest

from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.kinematics import run_up, solve_motion, solve_motion_in_time
from fenics_mech.scene import load
from fenics_mech.scene.factories import four_bar, manipulator, seed_four_bar
from tests.common import DEMOS

SPEED, RUN_UP = 32.3, 0.4
NAMES = ("position", "velocity", "acceleration", "angle", "omega", "alpha")
STRIP = {"area": 1e-4, "inertia": 1e-10, "fibre": 1e-3}
METAL = {"modulus": 7e10, "density": 2700}
# eighth-order central differences
WEIGHTS = {-4: 1 / 280, -3: -4 / 105, -2: 1 / 5, -1: -4 / 5, 1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
RAMP = {"kind": "expression", "formula": "0.5 * 32.3 / 0.4 * t**2"}
WAVERING = {
    "kind": "table",
    "times": [0.0, 0.1, 0.2, 0.3, 0.4],
    "angles": ["0 deg", "20 deg", "70 deg", "160 deg", "330 deg"],
}


def running(**rest):
    return seed_four_bar(drive__run_up=RUN_UP, **rest)


def two_arms():
    law = {"kind": "harmonics", "mean": 0.3, "sine": [0.4, 0.1]}
    other = {"kind": "expression", "formula": "1.2 + 0.5*cos(theta)**2"}
    sections, masses = [STRIP] * 2, [{"mass": 0.1}] * 2
    return manipulator(arms=(0.3, 0.2), sections=sections, material=METAL, laws=(law, other), period=0.7, masses=masses)


def largest_difference(one, other):
    """Largest difference of two motions, each quantity over its own largest value."""
    pairs = [(getattr(one, name), getattr(other, name)) for name in NAMES]
    return max(np.abs(a - b).max() / max(np.abs(b).max(), 1e-300) for a, b in pairs)


def test_angle_speed_and_acceleration_of_the_smooth_start():
    # speed = SPEED (10 x^3 - 15 x^4 + 6 x^5): at the middle half of it, with 30/16 of the mean acceleration
    drive = running().drive
    jet = drive.coordinate(np.array([0.0, RUN_UP / 2, RUN_UP, 3 * RUN_UP]))
    assert jet.value == pytest.approx(
        [0, SPEED * RUN_UP * (2.5 - 1.5 + 0.25) / 16, SPEED * RUN_UP / 2, 2.5 * SPEED * RUN_UP]
    )
    assert jet.first == pytest.approx([0, SPEED / 2, SPEED, SPEED])
    assert jet.second == pytest.approx([0, 30 / 16 * SPEED / RUN_UP, 0, 0])


@pytest.mark.parametrize("law", [None, RAMP, WAVERING], ids=["smooth", "ramp", "table"])
def test_rates_against_differences(law):
    scene = running(drive__run_up_law=law)
    h = 3e-5  # the drive turns by 1e-3 rad: truncation and rounding are both below 1e-10
    time = np.concatenate([np.linspace(0.013, 0.387, 23), np.linspace(0.413, 1.2, 11)])
    time = time[np.abs(time[:, None] - np.array(WAVERING["times"])).min(axis=1) > 5 * h]  # a spline's knots are rough
    motion = solve_motion_in_time(scene, time)
    near = {i: solve_motion_in_time(scene, time + i * h) for i in WEIGHTS}
    for value, rate in (("angle", "omega"), ("omega", "alpha"), ("position", "velocity"), ("velocity", "acceleration")):
        difference = sum(w * getattr(near[i], value) for i, w in WEIGHTS.items()) / h
        exact = getattr(motion, rate)
        assert np.abs(difference - exact).max() < 1e-9 * np.abs(exact).max()


def test_crank_follows_the_ramp():
    # constant acceleration: alpha = SPEED / RUN_UP, omega = alpha t, and two thirds of the speed times time at 2 RUN_UP
    motion = solve_motion_in_time(running(drive__run_up_law=RAMP), np.array([0.0, 0.3, 0.8]))
    assert motion.omega[:, 0] == pytest.approx([0, 0.75 * SPEED, SPEED], abs=1e-12)
    assert motion.alpha[:, 0] == pytest.approx([SPEED / RUN_UP, SPEED / RUN_UP, 0], abs=1e-9)
    assert motion.angle[:, 0] == pytest.approx([0, 0.5 * SPEED * 0.3**2 / RUN_UP, 1.5 * SPEED * RUN_UP], abs=1e-12)


def test_table_goes_through_its_points():
    jet = running(drive__run_up_law=WAVERING).drive.coordinate(np.array(WAVERING["times"]))
    assert np.degrees(jet.value) == pytest.approx([0, 20, 70, 160, 330])
    assert (jet.first[0], jet.second[0]) == pytest.approx((0, 0), abs=1e-9)
    assert (jet.first[-1], jet.second[-1]) == pytest.approx((SPEED, 0), abs=1e-9)


@pytest.mark.parametrize(
    "scene",
    [
        seed_four_bar(),
        seed_four_bar(drive__speed=-SPEED),
        load(DEMOS / "quick_return.toml").changed(drive__speed=-5.0),
        two_arms(),
    ],
    ids=["four_bar", "backwards", "quick_return", "periodic_laws"],
)
def test_without_run_up_it_is_the_motion_at_constant_rate(scene):
    time = np.linspace(0, 5.3, 997)
    found, expected = solve_motion_in_time(scene, time), solve_motion(scene, scene.cycle_rate * time)
    assert largest_difference(found, expected) < 1e-11  # the longer way of angles of 27 turns loses two digits
    assert np.array_equal(found.time, time)


def test_two_drives_follow_one_coordinate():
    # a geared five-bar is two cranks at a ratio of 2 and two rods: the second crank's angle is start + 2 theta
    scene = seed_four_bar(drive__run_up=RUN_UP)
    data = scene.model_dump()
    data["links"]["second"] = data["links"]["crank"] | {"points": {"C": (0, 0), "D": (0.05, 0)}, "angle": 0.4}
    data["links"]["second"]["members"] = {"CD": {**data["links"]["crank"]["members"]["OA"], "ends": ("C", "D")}}
    data["joints"]["C"]["connect"] = ("ground.C", "second.C")
    data["joints"]["D"] = {"connect": ("second.D", "follower.C")}
    data["drive"] = [data["drive"], {"joint": "C", "speed": 2 * SPEED, "start": 0.4}]
    both = type(scene).model_validate(data)
    time = np.linspace(0, 1.1, 301)
    motion = solve_motion_in_time(both, time)
    second = motion.links.index("second")
    assert np.allclose(motion.angle[:, second], 0.4 + 2 * motion.theta, rtol=0, atol=1e-11)
    assert np.allclose(motion.alpha[:, second], 2 * motion.alpha[:, 0], rtol=0, atol=1e-9)
    assert largest_difference(motion.held(), solve_motion(both, motion.theta).held()) < 1e-11
    data["drive"] = [{**data["drive"][0], "run_up": None}, {**data["drive"][1], "run_up": 1.0}]
    with pytest.raises(SceneError, match="run-up is that of the first drive"):
        type(scene).model_validate(data)


def test_run_up_goes_over_into_the_steady_motion():
    scene, h = running(), 1e-5 * RUN_UP
    time = RUN_UP + np.array([-h, 0, h])
    motion = solve_motion_in_time(scene, time)
    steady = solve_motion(scene, SPEED * (time - RUN_UP / 2))
    # before the end the acceleration lacks 30 (h/T)^2 of SPEED/T, and the speed 10 (h/T)^3
    assert largest_difference(motion, steady) < 1e-8
    assert largest_difference(motion.part(slice(1, 3)), steady.part(slice(1, 3))) < 1e-12
    start = solve_motion_in_time(scene, np.array([0.0, h]))
    assert np.abs(start.omega[0]).max() == np.abs(start.alpha[0]).max() == 0
    assert np.abs(start.alpha[1]).max() < 1e-8 * np.abs(motion.alpha).max()


def test_following_every_turn_gives_the_same_as_one_cycle_again_and_again(monkeypatch):
    # the way of a linkage whose links come back after several cycles only
    time = np.linspace(0, 1.7, 400)
    cycle = solve_motion_in_time(running(), time)
    monkeypatch.setattr(run_up, "RUN_UP", replace(run_up.RUN_UP, same=-1.0))
    assert largest_difference(cycle, solve_motion_in_time(running(), time)) < 1e-11


def test_part_of_a_turn_does_not_need_a_whole_one():
    # a double rocker locks at some angle, and a run-up that ends before it is solved
    lengths = {"crank": 2.0, "coupler": 1.2, "follower": 1.2, "ground": 1.9}
    scene = four_bar(**lengths, sections=[STRIP] * 3, material=METAL, speed=1.0).changed(drive__run_up=0.4)
    assert np.isfinite(solve_motion_in_time(scene, np.linspace(0, 0.8, 9)).angle).all()
    with pytest.raises(AssemblyError, match="cannot turn beyond"):
        solve_motion_in_time(scene, np.linspace(0, 3, 9))


def test_many_times_at_once():
    time = np.linspace(0, 20, 100_000)
    motion = solve_motion_in_time(running(), time)
    few = slice(None, None, 9973)
    assert largest_difference(motion.part(few), solve_motion_in_time(running(), time[few])) < 1e-12


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"run_up": -1.0}, "greater than 0"),
        ({"run_up": "3 m"}, "wrong unit"),
        ({"run_up_law": RAMP}, "needs its duration"),
        ({"run_up": 0.5, "run_up_law": RAMP}, "ends with 40.375 rad/s, and the drive goes on with 32.3"),
        ({"run_up": 0.5, "run_up_law": WAVERING}, "table ends at 0.4 s, and the run-up at 0.5 s"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "1 + 0.5 * 32.3 / 0.4 * t**2"}}, "start with an angle of 0"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "log(t)"}}, "not finite"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "1/0"}}, "not finite"),
        ({"run_up": 0.4, "run_up_law": {**RAMP, "formula": "theta"}}, "may not stand in a formula"),
        ({"run_up": 0.4, "run_up_law": {**WAVERING, "times": [0, 0.2, 0.1, 0.3, 0.4]}}, "times must increase"),
        ({"run_up": 0.4, "run_up_law": {**WAVERING, "times": [0, 0.4]}}, "the same number of both"),
        ({"speed": None, "law": {"kind": "harmonics", "sine": [0.3]}, "period": 1.0, "run_up": 0.4}, "has none"),
    ],
)
def test_bad_run_ups_are_refused(values, words):
    with pytest.raises(SceneError, match=words):
        seed_four_bar(**{f"drive__{key}": value for key, value in values.items()})


@pytest.mark.parametrize(
    ("time", "words"),
    [
        ([-0.1, 0.2], "before it"),
        ([0.2, 0.1], "ascend"),
        ([0.0, np.nan], "finite"),
        ([[0.0]], "finite"),
        ([], "finite"),
    ],
)
def test_bad_times_are_refused(time, words):
    with pytest.raises(SceneError, match=words):
        solve_motion_in_time(seed_four_bar(), np.array(time))


def test_structure_at_rest_stays_there():
    # nothing drives a triangle of three bars
    ends = {"a": ((0, 0), (1, 0)), "b": ((0, 0), (1, 0))}
    data = seed_four_bar().model_dump()
    data["links"] = {
        name: data["links"]["crank"] | {"points": {"P": p, "Q": q}, "angle": angle}
        for (name, (p, q)), angle in zip(ends.items(), (1.0, 2.1))
    }
    for link in data["links"].values():
        link["members"] = {"PQ": {**next(iter(link["members"].values())), "ends": ("P", "Q")}}
    data["ground"] = {"points": {"O": (0, 0), "C": (1.0, 0)}}
    data["joints"] = {
        "O": {"connect": ("ground.O", "a.P")},
        "C": {"connect": ("ground.C", "b.P")},
        "B": {"connect": ("a.Q", "b.Q")},
    }
    data |= {"drive": (), "masses": {}, "measurements": (), "analysis": {"method": "static"}}
    motion = solve_motion_in_time(type(seed_four_bar()).model_validate(data), np.array([0.0, 2.0]))
    assert np.array_equal(motion.angle[0], motion.angle[1])
    assert motion.time[1] == 2.0
    assert not motion.omega.any()
