"""The demos of joint laws show the numbers that their comments state."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech._console import text_of
from fenics_mech.machine.reach import reachable_range
from fenics_mech.views.tables import scene_overview
from tests.common import DEMOS
from tests.joints import clearance_program as program


@pytest.mark.long
@pytest.mark.slow  # stick and slip of three periods
def test_block_on_a_belt_has_the_period_of_its_comment():
    data = fm.analyse(fm.load(DEMOS / "joint_laws" / "belt_friction.toml")).data
    place, time = data["freedom_place"][:, 0].to_numpy(), data["time"].to_numpy()
    peaks = time[np.flatnonzero((place[1:-1] > place[:-2]) & (place[1:-1] >= place[2:])) + 1]
    period = np.ptp(peaks) / (len(peaks) - 1)
    drop, spring, belt, omega = 0.981, 100.0, 0.2, 10.0
    slip = (2 * np.pi - 2 * np.arctan(drop * omega / (spring * belt))) / omega
    assert slip + 2 * drop / (spring * belt) == pytest.approx(0.635, abs=5e-4)
    assert period == pytest.approx(0.635, rel=0.012)
    assert len(peaks) >= 3


@pytest.mark.long
@pytest.mark.slow  # 28 contacts
def test_rattling_slider_crank_has_the_peak_of_its_comment():
    scene = fm.load(DEMOS / "joint_laws" / "rattling_slider_crank.toml")
    assert scene.joint_laws["rattle"].contact.stiffness == pytest.approx(program.STIFFNESS, rel=1e-3)
    result = fm.analyse(scene)
    data = result.data
    assert "Contacts between these are shorter" in str(fm.summary(result))  # at positions 30 kN are seen
    other = program.ClearanceSliderCrank()
    other.course(data["time"].to_numpy()[[0, -1]])
    assert float(data["largest_law_effort"][0]) == pytest.approx(45.87e3, rel=1e-3)
    assert other.peak == pytest.approx(45.87e3, rel=1e-3)
    assert data.attrs["contacts_closed"] == other.contacts == 28


def test_the_check_of_a_scene_names_its_joint_laws():
    scene = fm.load(DEMOS / "joint_laws" / "rattling_slider_crank.toml")
    text = text_of(scene_overview(scene, reachable_range(scene)))
    assert "joint law rattle: clearance at joint B" in text
    assert "The drive turns through the whole cycle." in text
