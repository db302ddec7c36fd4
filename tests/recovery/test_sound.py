"""Radiated sound against closed forms, and levels against tables."""

import math

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import ResultError
from fenics_mech.recovery.sound import DENSITY, SPEED, _widths, a_weighting, radiated_power
from fenics_mech.views.figures import save
from fenics_mech.views.sound_plots import sound_figure


def test_a_compact_force_radiates_as_a_dipole():
    force = np.array([[[2.0, 1.0j]]])
    k = 0.7
    exact = k**2 * 5.0 / (24 * math.pi * DENSITY * SPEED)  # Howe (1998), equation (1.9.8)
    assert radiated_power(force, np.array([[0.3, -0.2]]), np.array([k]))[0] == pytest.approx(exact, rel=1e-12)


def test_a_long_strip_radiates_as_a_line_dipole():
    # in two dimensions: pressure rho c U (pi/2)(kb/2)^2 H1/2 of a strip of width b, power k f^2/(16 rho c) on a length
    length, k, count = 12.0, 4.0, 400
    x = (np.arange(count) + 0.5) * length / count
    places = np.stack([x, np.zeros(count)], axis=1)
    force = np.zeros((1, count, 2), dtype=complex)
    force[..., 1] = 3.0 * length / count  # 3 N/m
    exact = length * k * 3.0**2 / (16 * DENSITY * SPEED)
    found = radiated_power(force, places, np.array([k]))[0]
    assert found == pytest.approx(exact, rel=0.05)  # its ends are 1/(k length) = 2 % of it


def test_opposite_forces_close_together_radiate_less():
    places, force = np.array([[0.0, 0.0], [0.05, 0.0]]), np.zeros((1, 2, 2), dtype=complex)
    force[0, :, 1] = 1.0, -1.0
    alone = radiated_power(force[:, :1], places[:1], np.array([1.0]))[0]
    assert radiated_power(force, places, np.array([1.0]))[0] < 2e-3 * alone  # about (k d)^2/5


def test_a_weighting_is_that_of_the_standard():
    table = {31.5: -39.4, 63: -26.2, 125: -16.1, 250: -8.6, 500: -3.2, 1000: 0.0, 2000: 1.2, 4000: 1.0, 8000: -1.1}
    exact = 1000 * 10 ** (np.round(10 * np.log10(np.array([*table]) / 1000)) / 10)  # nominal bands
    np.testing.assert_allclose(a_weighting(exact), [*table.values()], atol=0.06)


def stiff(speed):
    changes = {"analysis.method": "quasi-static", "analysis.sub_intervals": 90, "effects": ()}
    return fm.load("demos/four_bar.toml").changed({"materials.aluminium.modulus": 1e16, "drive.speed": speed} | changes)


@pytest.mark.slow
def test_the_power_of_rigid_links_grows_with_the_sixth_power_of_the_speed(tmp_path):
    slow, fast = (fm.sound(fm.analyse(stiff(speed))) for speed in (5.0, 10.0))
    assert fast.attrs["power_level"] - slow.attrs["power_level"] == pytest.approx(60 * math.log10(2), abs=0.02)
    assert float(fast["sound_frequency"][3]) == pytest.approx(3 * 10 / (2 * math.pi))
    result = fm.analyse(stiff(5.0))
    near, far = (fm.sound(result, distance).attrs["weighted_level"] for distance in (1.0, 2.0))
    assert near - far == pytest.approx(20 * math.log10(2))
    members = [str(member) for member in result.data["member"].to_numpy()]
    half = {member: 0.5 * width for member, width in zip(members, (25.24e-3, 25.375e-3, 25.375e-3))}
    wide = fm.sound(result, widths=half).attrs["power_level"]
    assert slow.attrs["power_level"] - wide == pytest.approx(40 * math.log10(2), abs=0.02)  # force as width^2
    assert save(sound_figure(fast), tmp_path / "sound.png").exists()


OUTLINE = [[-8e-4, -0.0127], [8e-4, -0.0127], [8e-4, 0.0127], [-8e-4, 0.0127]]
LIKE_A_RECTANGLE = {
    "polygon": {"shape": "polygon", "outline": OUTLINE},
    "variable": {"shape": "variable", "area": 4.064e-5, "inertia": "8.67e-12", "fibre": 8e-4},
    "taper": {"shape": "taper", "from": "rectangle", "to": "rectangle"},
}


@pytest.mark.parametrize("shape", LIKE_A_RECTANGLE)
def test_every_section_has_a_width(shape):
    rectangle = {"sections.rectangle": {"shape": "rectangle", "width": 0.0254, "height": 1.6e-3}}
    scene = stiff(5.0).changed(rectangle | {"sections.like": LIKE_A_RECTANGLE[shape], "analysis.sub_intervals": 24})
    of_both = [
        fm.sound(fm.analyse(scene.changed({"links.coupler.members.AB.section": section}))).attrs["power_level"]
        for section in ("rectangle", "like")
    ]
    assert of_both[1] == pytest.approx(of_both[0], abs=1e-9)  # dB, by rounding; measured 1e-12


def test_the_width_of_a_taper_is_that_at_each_place():
    ends = {name: {"shape": "rectangle", "width": width, "height": 0.005} for name, width in (("a", 0.03), ("b", 0.01))}
    scene = fm.load("demos/four_bar.toml").changed({f"sections.{name}": end for name, end in ends.items()})
    scene = scene.changed({"sections.strip": {"shape": "taper", "from": "a", "to": "b"}})
    assert _widths(scene, ["coupler"], np.array([0.0, 0.25, 1.0]), {}) == pytest.approx(np.array([[0.03, 0.025, 0.01]]))


def test_sound_needs_a_cycle_in_equal_steps():
    with pytest.raises(ResultError, match="periodic motion"):
        fm.sound(fm.analyse(stiff(5.0).changed({"analysis.method": "static"})))
