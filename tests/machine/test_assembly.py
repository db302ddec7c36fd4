"""Links of scenes put together on the core: branches, searches, refusals, and what the core may import."""

import re
import subprocess
import sys

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.machine.assembly import assemblies, led
from fenics_mech.machine.drawn_from_scene import _cycle, bodies_of
from fenics_mech.machine.from_scene import machine_of
from tests.cases.test_assembly import CASES, scaled, triangle, without_angles
from tests.common import DEMOS
from tests.kinematics.test_motion import piston, seed_four_bar, welded_arm

SCENES = [*DEMOS.glob("*.toml"), *DEMOS.glob("free_motion/*.toml"), *DEMOS.glob("joint_laws/*.toml")]
SCENES += [CASES / f"{name}.toml" for name in ("missing_angles", "sticking_block", "knuckle_press", "side_buckling")]
OF_TURNS = np.array([0.0, 0.0, 1.0])


def found_by_search(scene):
    bodies = bodies_of(scene)
    search = assemblies(bodies.machine, 0.0, np.tile(OF_TURNS, len(scene.links)))
    return bodies, search.q, bodies.angles + search.q[:, 2 : bodies.machine.n : 3]


def test_a_four_bar_without_angles_closes_in_the_two_ways_of_its_triangle():
    """The law of cosines; of both, which are as near, that one is taken whose links turn counter-clockwise."""
    scene = fm.load(CASES / "missing_angles.toml")
    bodies, _, found = found_by_search(scene)
    rod, rocker = np.radians(triangle(0.22 - 0.06, 0.25, 0.15))
    assert found == pytest.approx(np.array([[0, rod, rocker], [0, -rod, -rocker]]), abs=1e-9)
    assert bodies.q[2:9:3] + bodies.angles == pytest.approx(found[0], abs=1e-9)


@pytest.mark.parametrize(("name", "count"), [("watt", 4), ("stephenson", 4), ("slider_crank", 2)])
def test_the_search_counts_the_assemblies_of_dyads(name, count):
    """Each dyad closes in two ways, and Watt's and Stephenson's chains have two."""
    assert len(found_by_search(fm.load(DEMOS / f"{name}.toml"))[1]) == count


@pytest.mark.slow
def test_an_assembly_is_preferred_through_whose_cycle_the_drive_leads():
    """Of Jansen's legs without angles the nearest two lock, as those in link frames do."""
    scene = without_angles(fm.load(DEMOS / "jansen.toml")).changed({"drive.start": "30 deg"})
    bodies, found, _ = found_by_search(scene)
    assert led(bodies.machine, found[:3], _cycle(scene))[1].tolist() == [False, False, True]
    assert bodies.q == pytest.approx(found[2], abs=1e-9)


@pytest.mark.parametrize("size", [1e-8, 1e6])
@pytest.mark.parametrize("name", ["four_bar", "quick_return", "stephenson"])
def test_links_of_any_size_start_alike(name, size):
    scene = fm.load(DEMOS / f"{name}.toml")
    big, small = bodies_of(scaled(scene, size)).frames(), bodies_of(scene).frames()
    for link, (place, axes) in small.items():
        assert big[link][1] == pytest.approx(axes, abs=1e-9)
        assert big[link][0] / size == pytest.approx(place, abs=1e-9)


# Refusals


@pytest.mark.slow
def test_what_cannot_close_names_the_joint_and_the_least_gap():
    """Crank, rod and rocker in line reach 0.06 + 0.25 + 0.15 m."""
    scene = fm.load(CASES / "missing_angles.toml").changed({"ground.points.C": ("2.2 m", 0)})
    with pytest.raises(AssemblyError, match=r"with joint O at 0 deg.*: joint C stays open by 1\.74 m at least"):
        machine_of(scene)


@pytest.mark.slow
def test_links_that_close_elsewhere_are_told_where_the_drive_may_start():
    """By the law of cosines they reach up to 128.4 deg, and from 231.6 deg on: see tests/cases/test_assembly.py."""
    scene = fm.load(CASES / "missing_angles.toml").changed({"ground.points.C": ("360 mm", 0), "drive.start": "180 deg"})
    with pytest.raises(AssemblyError, match=r"joint O at 180 deg.*open by 0\.02\d* m.*with O at 240 deg the links"):
        machine_of(scene)


def test_a_rough_angle_that_misleads_is_refused_with_the_ways_to_assemble():
    scene = seed_four_bar(links__coupler__angle=-1.6, links__follower__angle=1.0)
    with pytest.raises(AssemblyError, match=r"far from its rough angle.*assembled with .*coupler at .*; or") as raised:
        machine_of(scene)
    ways = re.findall(r"coupler at (\S+) deg, follower at (\S+) deg", str(raised.value))
    for coupler, follower in ways:  # each can be stated
        stated = {"links.coupler.angle": f"{coupler} deg", "links.follower.angle": f"{follower} deg"}
        angles = np.degrees(bodies_of(scene.changed(stated)).turned[0, 2:])
        assert angles == pytest.approx([float(coupler), float(follower)], abs=1e-3)


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (
            lambda: piston().changed(links__piston__angle=np.radians(75.0)),
            "G holds link piston at 15 deg to the ground",
        ),
        (lambda: welded_arm().changed(links__arm__angle=np.radians(140.0)), "W holds link arm at -40 deg to link rock"),
    ],
)
def test_a_rough_angle_that_a_joint_contradicts_is_refused(scene, words):
    with pytest.raises(AssemblyError, match=f"joint {words}.*say"):
        machine_of(scene())


def test_effects_that_there_are_not_are_refused():
    with pytest.raises(SceneError, match="there is no effect 'couplings'"):
        fm.analyse(fm.load(DEMOS / "four_bar.toml").changed(effects=("couplings",)))


@pytest.mark.slow
def test_the_core_needs_no_other_equation():
    program = "import sys, fenics_mech.machine.from_scene, fenics_mech.solve, fenics_mech.estimate\nprint(*sys.modules)"
    made = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    rooms = {name.split(".")[1] for name in made.stdout.split() if name.startswith("fenics_mech.")}
    assert rooms.isdisjoint({"classical", "answers", "recovery", "planning", "safety", "studies", "views"})
    assert "machine" in rooms
