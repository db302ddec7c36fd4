"""What the page draws of section forces, loads and weights, against formulas and the result."""

import math

import numpy as np
import pytest

from fenics_mech.scene import parse
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views.page.curves import kinds_of, member_mass, payload
from fenics_mech.views.page.report import page
from fenics_mech.views.reading import SECTION_FORCES, Reading
from tests.common import response_of
from tests.views.test_outlines import FOUR_BAR
from tests.views.test_page import unpacked


@pytest.fixture(scope="module")
def loaded():
    """The seed with gravity, a load that keeps its direction, and one along the follower."""
    loads = {"push": {"at": "coupler.B", "force": (30.0, -40.0)}, "wind": {"member": "follower", "line": (20.0, 0.0)}}
    analysis = {"method": "quasi-static", "sub_intervals": 24}
    return response_of(seed_four_bar(analysis=analysis, gravity=(0.0, -9.81), loads=loads))


def test_section_forces_are_packed_as_the_result_has_them(result):
    data, reading = payload(Reading(result)), Reading(result)
    assert list(data["sections"]) == list(SECTION_FORCES)
    assert data["sections"]["moment"] == ["bending moment", "N m"]
    order = np.argsort(np.mod(np.round(reading.theta, 12), 2 * np.pi), kind="stable")
    for name in SECTION_FORCES:
        expected = reading.section_force(name)[order].reshape(len(order), -1)
        assert unpacked(data["arrays"][name]) == pytest.approx(expected, abs=1e-4 * np.abs(expected).max())
    assert 'id="sections"' in page(result)


def test_a_taper_weighs_as_its_trapezoid():
    """Width b, height from h0 to h1: m = rho b L (h0 + h1)/2, centre at (h0 + 2 h1)/(3 (h0 + h1)) of the length."""
    mass, s = member_mass(parse(FOUR_BAR), "coupler")
    assert mass == pytest.approx(7850 * 0.008 * 0.32 * (0.02 + 0.01) / 2, rel=1e-12)  # linear: the rule is exact
    assert s == pytest.approx((0.02 + 2 * 0.01) / (3 * 0.03), rel=1e-4)  # of 200 pieces, by the rule of trapezia


def test_weights_and_loads_are_where_and_as_large_as_the_scene_says(loaded):
    data, reading = payload(Reading(loaded)), Reading(loaded)
    acts, scene = data["acts"], loaded.scene
    assert acts["down"] == [0, -1]
    masses = [member_mass(scene, name)[0] for name in scene.members()] + [one.mass for one in scene.masses.values()]
    said = [float(text.removesuffix(" N")) for text in acts["weights"]]
    assert said == pytest.approx([9.81 * mass for mass in masses], rel=5e-3)  # three digits are told
    assert max(acts["weight_sizes"]) == 1
    places = unpacked(data["arrays"]["weights"]).reshape(len(data["axis"]), -1, 2)
    crank, length = places[:, 0], reading.lengths[0]
    assert np.hypot(*crank.T) == pytest.approx(length / 2, rel=1e-3)  # about O, uniform
    angle = np.radians(data["axis"])
    assert np.arctan2(*crank.T[::-1]) % (2 * math.pi) == pytest.approx(angle, abs=2e-3)
    arrows = unpacked(data["arrays"]["loads"]).reshape(len(angle), -1, 2, 2)
    assert acts["loads"][0] == "push"
    assert acts["loads"].count("wind") == 1
    assert arrows[:, 0, 1] == pytest.approx(np.tile([0.6, -0.8], (len(angle), 1)), abs=1e-3)
    assert arrows[:, 1:, 1] == pytest.approx(np.tile([1.0, 0.0], (len(angle), arrows.shape[1] - 1, 1)), abs=1e-3)
    assert kinds_of(reading) == ["loads", "weight"]


def test_without_loads_and_gravity_there_is_nothing_to_switch_on(result):
    assert payload(Reading(result))["acts"] == {}
    assert 'id="acting"' not in page(result)
