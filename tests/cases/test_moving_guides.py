"""Guides on links that bend, which the equation of poses moves with them."""

from pathlib import Path

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.views.judgements import judgements, verdict
from tests.cases.elastica import crank_in_guide
from tests.common import DEMOS, analysed

SCENES = Path(__file__).parent / "scenes"
GUIDE = load(SCENES / "moving_guide.toml")


def exactly(scene):
    """Give the force of the pin, and its displacement."""
    crank, arm = scene.links["crank"], scene.links["arm"]
    length, section, modulus = crank.points["A"][0], scene.sections["s"], scene.materials["pom"].modulus
    pivot, reach = np.array(scene.ground.points["C"]), abs(arm.points["T"][0])
    bent = length, modulus * section.inertia, modulus * section.area
    return crank_in_guide(bent, scene.drives[0].start, pivot, scene.loads["F"].force[1], reach)


def found(result):
    force = np.linalg.norm(result.data["joint_force"].sel(joint="A").isel(theta=0))
    return force, result.data["deflection"].sel(member="crank").isel(theta=0, s=-1).to_numpy()


def test_guide_that_hardly_turns_is_not_warned_of():
    level, said = verdict(judgements(analysed(GUIDE.changed(loads__F__force=(0.0, -2.0)))))
    assert "inside the theory" in said
    assert level == "good"


def test_guide_on_ground_leaves_nothing_out():
    assert "joints_share" not in analysed(load(DEMOS / "slider_crank.toml")).data.attrs


def test_guide_force_and_deflection_are_those_of_the_elastica():
    """25.740 N, and 5.092 mm at the pin."""
    force, right = exactly(GUIDE)
    assert force == pytest.approx(25.740, abs=1e-3)
    assert np.linalg.norm(right) == pytest.approx(5.0922e-3, rel=1e-4)
    by_poses = found(analysed(GUIDE))
    assert by_poses[0] == pytest.approx(force, rel=1e-3)  # 10 elements
    assert np.linalg.norm(by_poses[1] - right) < 1e-3 * np.linalg.norm(right)
