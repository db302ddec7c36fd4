"""Linkages without rough angles, or with wrong ones, and linkages of any size."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.machine.drawn_from_scene import bodies_of
from fenics_mech.machine.linkage import solve_motion, start_motion
from fenics_mech.machine.reach import reachable_range
from fenics_mech.machine.start_notices import assembly_notices
from tests.common import DEMOS

CASES = Path(__file__).parent / "scenes"

POWERS = {"area": 2, "inertia": 4, "fibre": 1, "width": 1, "height": 1, "diameter": 1, "thickness": 1}
THETA = np.linspace(0, 2 * np.pi, 25)


def without_angles(scene):
    """Give a scene of which no link states where it lies."""
    data = scene.model_dump()
    for link in data["links"].values():
        link |= {"angle": 0.0, "position": None}
    return fm.Scene.read(data)


def with_keys(scene, notice, choice):
    """Give a scene with the keys that a notice offers as its so many-th choice, as a user pastes them."""
    said = notice.split("at the start. Taken is ")[1].removesuffix(". Write the one that is meant").split("; or ")
    keys = {}
    for one in (said[0], said[choice]):  # of another than the taken one it says what differs
        for part in one.split(", [links."):
            name, stated = part.removeprefix("[links.").split("] ", 1)
            for key in stated.split(", position"):
                value = key.split(" = ")[1]
                keys[f"links.{name}.{'angle' if 'angle' in key else 'position'}"] = json.loads(value)
    return scene.changed(keys)


def triangle(base, rod, rocker):
    """Angles of rod and rocker, in degrees, that close the triangle over a base along x, law of cosines."""
    first = math.acos((base**2 + rod**2 - rocker**2) / (2 * base * rod))
    second = math.pi - math.acos((base**2 + rocker**2 - rod**2) / (2 * base * rocker))
    return np.degrees([first, second])


def test_a_four_bar_without_angles_is_assembled_and_both_ways_are_listed():
    scene = fm.load(CASES / "missing_angles.toml")
    rod, rocker = triangle(0.22 - 0.06, 0.25, 0.15)
    (notice,) = assembly_notices(scene)
    assert "rod and rocker" in notice
    assert "closes in 2 ways" in notice
    for sign in (1, -1):  # mirrored in the base; printed to four digits
        assert f'[links.rod] angle = "{sign * rod:.4g} deg", [links.rocker] angle = "{sign * rocker:.4g} deg"' in notice
    for choice, sign in ((0, 1), (1, -1)):
        chosen = with_keys(scene, notice, choice)
        assert not assembly_notices(chosen)
        angles = np.degrees(start_motion(chosen).angle[0])
        assert angles == pytest.approx([0, sign * rod, sign * rocker], abs=1e-9)


def test_a_run_without_angles_is_that_with_the_taken_ones_and_says_so():
    scene = fm.load(CASES / "missing_angles.toml").changed(
        {"analysis": {"sub_intervals": 60, "method": "quasi-static"}}
    )
    (notice,) = assembly_notices(scene)
    result = fm.analyse(scene)
    assert notice in result.warnings
    stated = fm.analyse(with_keys(scene, notice, 0))
    assert notice not in stated.warnings
    # Newton's method ends at rounding, from wherever it starts
    assert result.data["strain"].to_numpy() == pytest.approx(stated.data["strain"].to_numpy(), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("name", sorted(path.stem for path in DEMOS.glob("*.toml")))
def test_a_search_finds_the_assembly_of_demos(name):
    """The search finds the assembly that the demo states, among others."""
    scene = fm.load(DEMOS / f"{name}.toml")
    stated = bodies_of(scene)
    apart = (stated.search().q - stated.q)[:, : stated.machine.n]
    apart[:, 2::3] -= 2 * np.pi * np.round(apart[:, 2::3] / (2 * np.pi))
    assert np.abs(apart).max(axis=1).min() < 1e-9


@pytest.mark.parametrize("name", ["watt", "stephenson", "quick_return", "slider_crank"])
def test_each_listed_assembly_can_be_chosen(name):
    scene = without_angles(fm.load(DEMOS / f"{name}.toml"))
    notices = assembly_notices(scene)
    if name == "slider_crank":  # its rod lies near to 0 deg, its angle where none is stated
        assert not notices
        return
    (notice,) = notices
    for choice in range(notice.count("; or ") + 1):
        chosen = with_keys(scene, notice.split("; and ")[0], choice)
        assert not assembly_notices(chosen)


def test_wrong_rough_angles_are_searched_from_and_it_is_said():
    scene = fm.load(CASES / "missing_angles.toml")
    wrong = scene.changed({"links.rod.angle": "180 deg", "links.rocker.angle": "180 deg"})
    (notice,) = assembly_notices(wrong)
    assert "the rough angles lead to no assembly" in notice
    angles = np.abs(np.degrees(np.angle(np.exp(1j * start_motion(wrong).angle[0, 1:]))))
    assert angles == pytest.approx(triangle(0.16, 0.25, 0.15), abs=1e-9)


def test_stated_angles_cost_no_search(monkeypatch):
    def refuse(*arguments):
        pytest.fail("there was a search")

    monkeypatch.setattr("fenics_mech.machine.drawn_from_scene.assemblies", refuse)
    for name in ("four_bar", "watt", "jansen"):
        scene = fm.load(DEMOS / f"{name}.toml")
        assert not assembly_notices(scene)
        start_motion(scene)


def test_an_assembly_that_lets_the_drive_turn_is_preferred():
    """Of two dyads in a row one orientation of the first locks the second; the nearest to 0 deg may be that one."""
    scene = without_angles(fm.load(DEMOS / "stephenson.toml"))
    motion = solve_motion(scene, THETA)
    turned = motion.angle[-1] - motion.angle[0]
    assert turned == pytest.approx([2 * np.pi, *np.zeros(len(turned) - 1)], abs=1e-9)  # after a whole turn all are back


def test_what_cannot_close_names_the_joint_and_the_least_gap():
    scene = fm.load(CASES / "missing_angles.toml").changed({"ground.points.C": ("2.2 m", 0)})
    # crank, rod and rocker in line reach 0.06 + 0.25 + 0.15 m
    with pytest.raises(AssemblyError, match=r"joint C stays open by 1\.74 m at least"):
        solve_motion(scene, THETA)
    assert not assembly_notices(scene)  # the error says it


def test_links_that_close_elsewhere_are_told_where_the_drive_may_start():
    # crank 0.06, rod 0.25, rocker 0.15 m over 0.36 m: rod and rocker reach 0.4 m, and at 180 deg they need 0.42 m;
    # law of cosines: they reach up to arccos((0.06^2 + 0.36^2 - 0.4^2)/(2 0.06 0.36)) = 128.4 deg, and from 231.6 on
    scene = fm.load(CASES / "missing_angles.toml").changed({"ground.points.C": ("360 mm", 0), "drive.start": "180 deg"})
    with pytest.raises(
        AssemblyError, match=r"joint O at 180 deg.*stays open by 0\.02\d* m.*with O at 240 deg the links"
    ):
        solve_motion(scene, THETA)


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "quick_return", "watt", "stephenson"])
@pytest.mark.parametrize("size", [1e-8, 1e-4, 1e3, 1e6])
def test_links_of_any_size_move_alike(name, size):
    scene = fm.load(DEMOS / f"{name}.toml")
    big = scaled(scene, size)
    expected, found = solve_motion(scene, THETA), solve_motion(big, THETA)
    assert np.abs(found.angle - expected.angle).max() < 1e-9
    assert np.abs(found.position / size - expected.position).max() < 1e-9 * np.abs(expected.position).max()
    assert len(reachable_range(big).critical) == len(reachable_range(scene).critical)


def scaled(scene, size):
    """Give a scene of which all lengths of links are so many times as large."""
    data = scene.model_dump()
    for body in (data["ground"], *data["links"].values()):
        body["points"] = {name: (x * size, y * size) for name, (x, y) in body["points"].items()}
        if body.get("position"):
            body["position"] = tuple(size * x for x in body["position"])
        if body.get("rigid"):
            body["rigid"]["centre"] = tuple(size * x for x in body["rigid"]["centre"])
    for section in data["sections"].values():
        section |= {key: size**power * section[key] for key, power in POWERS.items() if key in section}
    for mass in data["masses"].values():
        mass |= {"mass": size**3 * mass["mass"], "inertia": size**5 * mass["inertia"]}
    data["drive"]["speed"] = scene.drives[0].speed / size
    return fm.Scene.read(data)


@pytest.mark.parametrize("size", [1e-8, 1e6])
def test_links_of_any_size_have_the_same_strains_at_the_same_speed_of_their_tips(size):
    """E eps ~ rho (w L)^2: a linkage of another size that turns slower in proportion has the same strains."""
    scene = fm.load(DEMOS / "four_bar.toml")
    scene = scene.changed({"effects": (), "analysis": {"method": "quasi-static", "sub_intervals": 24}})
    expected, found = (fm.analyse(one).data["strain"].to_numpy() for one in (scene, scaled(scene, size)))
    assert np.abs(found - expected).max() < 1e-9 * np.abs(expected).max()


def test_a_tiny_stroke_by_a_formula_is_to_be_periodic_too():
    with pytest.raises(SceneError, match="not periodic"):
        fm.Expression(formula="1e-10*theta")
    fm.Expression(formula="1e-10*sin(theta)**3")
    fm.Expression(formula="0")
