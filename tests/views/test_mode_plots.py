"""Drawings of mode shapes, and the shapes themselves."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.views.model_plots import LARGEST, plot_mode_shapes, skeleton_at
from tests.common import DEMOS


@pytest.fixture(scope="module")
def found():
    return fm.modes(fm.load(DEMOS / "four_bar.toml").changed({"analysis.sub_intervals": 12}))


@pytest.fixture(scope="module")
def column():
    """Modes of a straight column on two pins, whose shapes are sines."""
    scene = fm.load(DEMOS / "pulsating_column.toml").changed({"loads": {}, "effects": (), "mesh.elements": 12})
    return fm.modes(scene.changed({"analysis.sub_intervals": 8, "analysis.modes": 3, "analysis.allow_coarse": True}))


def test_shapes_of_a_column_on_two_pins_are_sines(column):
    shape = column.data["shape"].isel(theta=0, member=0)
    across = np.abs(shape.sel(component="x").to_numpy())
    s = column.data["s"].to_numpy()
    for number, curve in enumerate(across[:2], 1):
        assert curve == pytest.approx(np.abs(np.sin(number * np.pi * s)), abs=5e-3)


def test_a_panel_shows_the_mode_at_the_nearest_position(found):
    figure = plot_mode_shapes(found, angle=np.radians(61) - 2 * np.pi)
    here = found.data.isel(theta=2)
    rest = skeleton_at(found, float(here["theta"]))
    assert "60\N{DEGREE SIGN}" in figure.get_suptitle()
    for axes, mode in zip(figure.axes, found.data["mode"].to_numpy()):
        frequency = float(here["frequency"].sel(mode=mode))
        assert float(axes.get_title("left").split()[2]) == pytest.approx(frequency, rel=5e-3)
        drawn = [line for part in axes.collections for line in getattr(part, "get_segments", list)() if len(line) > 2]
        expected = 1e3 * (rest.path + LARGEST * rest.extent * here["shape"].sel(mode=mode).to_numpy())
        assert np.array(drawn) == pytest.approx(expected)
        assert np.linalg.norm(expected - 1e3 * rest.path, axis=-1).max() == pytest.approx(1e3 * LARGEST * rest.extent)


def test_members_meet_at_their_joints_in_every_mode(found):
    shape = found.data["shape"]
    crank, coupler, follower = (shape.sel(member=name) for name in ("crank", "coupler", "follower"))
    assert crank.isel(s=-1).to_numpy() == pytest.approx(coupler.isel(s=0).to_numpy(), abs=1e-9)
    assert coupler.isel(s=-1).to_numpy() == pytest.approx(follower.isel(s=-1).to_numpy(), abs=1e-9)
