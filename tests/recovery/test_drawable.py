"""What a result holds so that it can be drawn by itself: places, and the answer without vibration."""

import numpy as np
import pytest

from fenics_mech import Result, analyse, load
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS, analysed

ANALYSIS = {"sub_intervals": 48, "stability": False, "allow_coarse": True}
SEED = seed_four_bar(effects=("coupling", "large-rotations"), analysis=ANALYSIS)


@pytest.fixture(scope="module")
def data():
    return analysed(SEED).data


def test_ends_of_the_four_bars_members_close_its_loop(data):
    """Lengths of 4.25, 11 and 10.65 inches; the crank's end is at its drive angle."""
    at = data["position"].transpose("theta", "member", "end", "component")
    crank, coupler, follower = (at.sel(member=name).to_numpy() for name in ("crank", "coupler", "follower"))
    theta = data["theta"].to_numpy()
    assert crank[:, 1] == pytest.approx(0.0254 * 4.25 * np.stack([np.cos(theta), np.sin(theta)], axis=1), abs=1e-12)
    assert coupler[:, 0] == pytest.approx(crank[:, 1])
    assert follower[:, 0] == pytest.approx(np.tile([0.254, 0.0], (48, 1)), abs=1e-12)
    assert follower[:, 1] == pytest.approx(coupler[:, 1])
    for member, inches in ((coupler, 11), (follower, 10.65)):
        assert np.linalg.norm(member[:, 1] - member[:, 0], axis=1) == pytest.approx(0.0254 * inches)


def test_links_frames_give_the_members_ends(data):
    scene, angle = SEED, data["link_angle"].sel(link="coupler").to_numpy()
    x, y = scene.links["coupler"].points["B"]
    arm = np.stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y], axis=1)
    end = data["link_position"].sel(link="coupler").to_numpy() + arm
    assert end == pytest.approx(data["position"].sel(member="coupler", end="second").to_numpy())


def test_without_vibration_it_is_the_rigid_bodys_answer(data):
    """Whatever effects act: the strains of the quasi-static analysis of the same scene without effects."""
    still = analyse(SEED.changed(effects=(), analysis__method="quasi-static")).data
    for name in ("strain", "stress"):
        found = data[f"{name}_quasi_static"].transpose(*still[name].dims).to_numpy()
        assert found == pytest.approx(still[name].to_numpy(), rel=1e-9, abs=1e-9 * float(abs(still[name]).max()))
    assert float(abs(data["strain"] - data["strain_quasi_static"]).max()) > 0.1 * float(abs(still["strain"]).max())
    assert "strain_quasi_static" not in still  # which is its strain


def test_pins_that_travel_load_their_members_without_vibration_too():
    scene = load(DEMOS / "quick_return.toml").changed(
        analysis__sub_intervals=48, analysis__allow_coarse=True, analysis__solver="collocation"
    )
    found = analyse(scene).data["stress_quasi_static"]
    still = analyse(scene.changed(effects=(), analysis__method="quasi-static")).data["stress"]
    assert found.transpose(*still.dims).to_numpy() == pytest.approx(
        still.to_numpy(), abs=1e-6 * float(abs(still).max())
    )


def test_they_are_saved_with_their_units(data, tmp_path):
    loaded = Result.load(Result(data).save(tmp_path / "result.nc")).data
    for name, unit in {
        "position": "m",
        "link_angle": "rad",
        "strain_quasi_static": "1",
        "stress_quasi_static": "Pa",
    }.items():
        assert loaded[name].attrs["units"] == unit
        assert loaded[name].equals(data[name])
