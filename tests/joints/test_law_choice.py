"""Estimates of friction and clearance before a run against runs with and without them."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.answers.solved_by_poses import AtRest
from fenics_mech.errors import SolverError
from fenics_mech.planning.law_choice import choose_laws
from tests.joints.test_bending import RUBS, slider_crank

LED = {"freedoms": {}, "drive": {"joint": "O", "speed": 20.0}, "analysis.cycles": 1, "effects": "auto"}
GUIDE = RUBS | {"joint": "G"}
LOOSE = {"kind": "clearance", "joint": "A", "radial": 1e-5, "radius": 0.01, "contact": {"stiffness": 1e9}}


def sizes(**changes):
    scene, choices = choose_laws(slider_crank(True, modulus=2.1e11, **(LED | changes)))
    return scene, {choice.effect.name: choice for choice in choices}


def test_friction_is_estimated_as_its_share_of_the_torque():
    _, found = sizes(joint_laws={"guide": GUIDE})
    led = {"freedoms": {}, "drive": {"joint": "O", "speed": 20.0}, "analysis.method": "quasi-static"}
    led |= {"analysis.start": "rigid", "analysis.duration": None, "analysis.sub_intervals": 48}
    torques = [
        fm.analyse(slider_crank(False, joint_laws=laws, **led)).data["input_torque"].to_numpy()
        for laws in ({}, {"guide": GUIDE})
    ]
    share = np.abs(torques[1] - torques[0]).max() / np.abs(torques[0]).max()
    # friction of 0.2 raises the force that it is a share of, by a part that the estimate leaves out
    assert found["joint_laws.guide"].size == pytest.approx(share, rel=0.1)
    assert found["joint_laws.guide"].acts


def test_clearance_is_estimated_against_the_deflection():
    scene, found = sizes(joint_laws={"loose": LOOSE})
    tight = fm.analyse(
        scene.changed(
            {
                "joint_laws": {},
                "effects": (),
                "analysis": {"method": "quasi-static", "sub_intervals": 48},
            }
        )
    ).data
    largest = float(np.linalg.norm(tight["deflection"], axis=-1).max())
    assert found["joint_laws.loose"].size == pytest.approx(LOOSE["radial"] / largest, rel=1e-6)
    assert list(scene.joint_laws) == ["loose"]


def test_laws_that_are_too_small_to_count_are_left_out():
    little = {
        "guide": GUIDE | {"coefficient": 1e-4},
        "loose": LOOSE | {"radial": 1e-12},
        "crank": RUBS | {"joint": "O", "radius": 0.01},
    }
    scene, found = sizes(joint_laws=little)
    assert {name: choice.acts for name, choice in found.items()} == {
        "joint_laws.guide": False,
        "joint_laws.loose": False,
        "joint_laws.crank": True,
    }
    assert list(scene.joint_laws) == ["crank"]


@pytest.mark.parametrize("changes", [{"effects": ("coupling",)}, {"drive": [], "freedoms": {"O": {"start": 1.0}}}])
def test_what_is_listed_or_has_no_cycle_is_not_estimated(changes):
    scene, found = sizes(joint_laws={"guide": GUIDE}, **changes)
    assert not found
    assert list(scene.joint_laws) == ["guide"]


def test_laws_that_cannot_be_estimated_say_so():
    """Without laws the scene has no answer, so that nothing tells their sizes: all are kept."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(AtRest, "of", _refused)
        scene, found = sizes(joint_laws={"guide": GUIDE})
    (choice,) = found.values()
    assert (choice.size, choice.acts) == (None, True)
    assert choice.effect.meaning.endswith("not estimated, as without laws of joints the scene has no answer")
    assert list(scene.joint_laws) == ["guide"]


def _refused(scene):
    raise SolverError("a member buckles")
