"""What the analyses of a study have in common: made once, and the same result to the last bit."""

import gc
import weakref

import numpy as np
import pytest
from fenics_mech.mechanism.modal_forces import ModalForces
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.setup import CommonParts

from fenics_mech import load
from fenics_mech.analysis import analyse, solved
from fenics_mech.beams.mesh import mesh_depends_on
from fenics_mech.kinematics import Linkage
from fenics_mech.kinematics.linkage import Path
from fenics_mech.mechanism import beam_links
from fenics_mech.planning.cycle_steps import Steps
from fenics_mech.response import setup
from tests.common import DEMOS

COARSE = {"analysis.sub_intervals": 36, "analysis.allow_coarse": True, "analysis.allow_ringing": True}
SPRING = {"between": ("ground.O", "follower.B"), "stiffness": 50.0}
CASES = {  # demo, what is stated, what changes
    "truncated": ("four_bar", {}, {"drive.speed": (20, 30, -25)}),
    "coupling": ("four_bar", {"effects": ["coupling"]}, {"drive.speed": (20, 30), "damping.ratio": (0.02, 0.05)}),
    "large rotations": ("four_bar", {"effects": ["coupling", "large-rotations"]}, {"drive.speed": (20, 30)}),
    "longer steps": (
        "four_bar",
        {"effects": ["coupling", "large-rotations"], "analysis.error_estimates": False},
        {"analysis.sub_intervals": (240, 60)},
    ),
    "axial forces": ("four_bar", {"effects": ["coupling", "geometric-stiffness"]}, {"drive.speed": (20, 30)}),
    "springs": (
        "four_bar",
        {"effects": ["coupling"], "springs.s": SPRING},
        {"springs.s.stiffness": (50, 80), "drive.speed": (20, 30)},
    ),
    "sizes": ("four_bar", {}, {"sections.strip.inertia": (8.67e-12, 8e-12), "links.coupler.points.B.0": (0.27, 0.28)}),
    "quasi-static": ("quick_return", {"analysis.method": "quasi-static"}, {"drive.speed": (5, 8), "gravity.1": (0, 9)}),
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_a_result_does_not_depend_on_what_it_has_in_common_with_others(case):
    demo, stated, changes = CASES[case]
    scene = load(DEMOS / f"{demo}.toml").changed({"effects": [], **COARSE, **stated})
    common = CommonParts()
    for path, values in changes.items():
        for value in values:
            changed = scene.changed({path: value})
            assert analyse(changed, common=common).data.identical(analyse(changed).data), (path, value)


def test_points_of_steps_stand_at_the_same_angles_at_all_speeds(seed):
    """Else what is made once at these angles would be another by rounding, and so would the result."""
    scene, places = seed.changed(analysis__sub_intervals=60), np.array([0.155, 0.5, 0.645])
    angles = [Steps.of(scene.changed(drive__speed=speed)).angles(places) for speed in np.linspace(20.0, 40.0, 14)]
    assert all(np.array_equal(one, angles[0]) for one in angles[1:])
    backwards = Steps.of(scene.changed(drive__speed=-23.0)).angles(places)
    assert np.array_equal(backwards, -angles[0])


def test_links_and_points_in_another_order_are_numbered_anew(seed):
    """Mappings are equal in any order, and links, members and nodes are numbered by it."""
    crank = seed.links["crank"]
    for changed in (
        dict(reversed(seed.links.items())),
        seed.links | {"crank": crank.model_copy(update={"points": dict(reversed(crank.points.items()))})},
    ):
        turned = seed.model_copy(update={"links": changed})
        assert beam_links.links_depend_on(turned) != beam_links.links_depend_on(seed)
        assert mesh_depends_on(turned) != mesh_depends_on(seed)
        assert not Linkage(seed).moves_as(turned)


def counted(monkeypatch, calls, module, name):
    """Count the calls of a function."""
    function = getattr(module, name)

    def counting(*arguments, **options):
        calls[name] = calls.get(name, 0) + 1
        return function(*arguments, **options)

    monkeypatch.setattr(module, name, counting)


def test_positions_are_shared_by_scenes_whose_links_move_alike(seed):
    here = Linkage(seed)
    two = seed.changed(links__crank__points__A__0=0.11)
    assert not here.moves_as(two)
    assert not here.moves_as(seed.changed(links__coupler__angle=1.3))
    assert not here.moves_as(seed.changed(drive__start=0.1))
    assert here.moves_as(seed.changed({"drive.speed": -20, "materials.material.density": 7850, "mesh.elements": 5}))
    assert beam_links.links_depend_on(seed) == beam_links.links_depend_on(seed.changed(drive__start=0.1))


def test_a_motion_that_is_changed_forgets_its_positions(seed):
    motion = setup.mechanism(seed.changed(COARSE)).motion
    assert motion.path is not None
    assert motion.held().path is None
    assert motion.part(slice(0, 3)).path is None
    assert motion.part(slice(None)) is motion


def test_rates_of_positions_scale_with_the_rate(seed):
    theta = seed.drive_angles(24)
    one, two = (Linkage(seed).path(theta).motion(rate) for rate in (1.0, -3.0))
    assert two.omega == pytest.approx(-3 * one.omega, rel=1e-15)
    assert two.alpha == pytest.approx(9 * one.alpha, rel=1e-15)
    assert np.array_equal(two.angle, one.angle)


def test_what_an_analysis_made_ends_with_it(seed):
    """Objects that held each other would keep their arrays until Python looks for such cycles."""
    scene = seed.changed({"effects": ["coupling"], "damping.ratio": 0.02, **COARSE})
    kinds = {Flow, Path, ModalForces}
    gc.collect()
    before = {id(thing) for thing in gc.get_objects() if type(thing) in kinds}
    found = solved(scene)
    made = [thing for thing in gc.get_objects() if type(thing) in kinds and id(thing) not in before]
    assert {type(thing) for thing in made} == kinds
    left = [weakref.ref(thing) for thing in made]
    gc.disable()
    try:
        del found, made
        assert not any(thing() for thing in left)
    finally:
        gc.enable()
