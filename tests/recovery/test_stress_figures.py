"""Range, mean and utilisation of stresses, rainflow counting by the standard's example, damage by closed forms."""

import re

import numpy as np
import pytest
from typer.testing import CliRunner

import fenics_mech as fm
from fenics_mech import MechanismError, ResultError, StressLife, fatigue, judge
from fenics_mech.cli import app
from fenics_mech.recovery.peaks import peak_of
from fenics_mech.recovery.stress_figures import stress_cycles
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.views.fatigue_table import fatigue_table
from fenics_mech.views.summary import summary
from tests.common import DEMOS, analysed, response_of
from tests.recovery.test_momentum import arm

CURVE = {"range": 40e6, "cycles": 2e6, "slope": 5.0}
STEEL = {"modulus": 206e9, "density": 7850.0}
TURNING = {"drive": {"joint": "O", "speed": 40.0}, "analysis": {"method": "quasi-static", "sub_intervals": 360}}


def turning_arm(**material):
    """An arm that turns under its weight: its moment is the cosine of its angle, its axial force has a mean."""
    return arm(materials={"steel": STEEL | material}, gravity=(0.0, -9.81), **TURNING)


def test_range_and_mean_of_a_turning_arm():
    data = response_of(turning_arm(strength=50e6)).data
    line, length, mass, height = 7850 * 1e-4, 0.5, 0.05, 0.005
    modulus = 0.02 * height**2 / 6
    moment = 9.81 * (line * length**2 / 2 + mass * length)
    pull = 40**2 * (line * length**2 / 2 + mass * length)
    weight = 9.81 * (line * length + mass)
    # stress of the upper fibre at the bearing: centrifugal force, less weight sin, and bending by weight cos
    swing = np.hypot(moment / modulus, weight / 1e-4)
    root = data.sel(member="arm", s=0.0, fibre="+")
    assert float(root["stress_range"]) == pytest.approx(2 * swing, rel=1e-3)
    assert float(root["stress_mean"]) == pytest.approx(pull / 1e-4, rel=1e-3)
    least, largest = pull / 1e-4 - swing, pull / 1e-4 + swing
    assert float(root["stress_ratio"]) == pytest.approx(least / largest, rel=5e-3)
    assert float(data["utilisation"].sel(member="arm")) == pytest.approx(largest / 50e6, rel=1e-3)


def test_a_free_end_has_no_stress_ratio():
    scene = arm(gravity=(0.0, -9.81), masses={}, **TURNING)
    ratio = response_of(scene).data["stress_ratio"].sel(member="arm", fibre="+")
    assert np.isfinite(ratio.sel(s=slice(0, 0.99))).all()
    assert np.isnan(ratio.sel(s=1.0))


def test_a_place_that_is_only_pressed_has_no_stress_ratio():
    """At the pins of the column the largest stress is rounding, and the ratio was 4e14."""
    scene = fm.load(DEMOS / "pulsating_column.toml").changed(analysis__stability=False, analysis__error_estimates=False)
    ratio = np.abs(fm.analyse(scene).data["stress_ratio"].to_numpy())
    assert np.isnan(ratio).any()
    assert np.nanmax(ratio) < 1e6


def test_summary_tells_the_utilisation_of_what_has_a_strength():
    scene = seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24})
    assert "utilisation" not in response_of(scene).data
    material = next(iter(scene.materials))
    result = analysed(scene.changed({f"materials.{material}.strength": "80 MPa"}))
    largest = np.abs(peak_of(result, "stress")[2]) / 80e6  # between the positions too
    assert result.data["utilisation"].to_numpy() == pytest.approx(largest)
    first = str(result.data["member"][int(largest.argmax())].item())
    assert f"strength of the material: {first}" in str(summary(result, details=True)).replace("\n", " ")
    check = next(check for check in judge(result).checks[first] if check.mode == "yield")
    assert check.factor == pytest.approx(1 / float(largest.max()), rel=1e-6)


def test_rainflow_of_the_standards_example():
    pytest.importorskip("rainflow")
    stress = np.array([-2.0, 1, -3, 5, -1, 3, -4, 4, -2])  # ASTM E1049, figure 6
    found = sorted(map(tuple, stress_cycles(stress, repeats=False)[:, ::2]))
    assert found == [(3, 0.5), (4, 0.5), (4, 1.0), (6, 0.5), (8, 0.5), (8, 0.5), (9, 0.5)]


def test_every_cycle_of_a_motion_that_goes_on_closes():
    pytest.importorskip("rainflow")
    theta = 2 * np.pi * np.arange(360) / 360
    ranges, mean, count = stress_cycles(7 + 10 * np.cos(theta + 1) + 3 * np.cos(9 * theta), repeats=True).T
    assert count.sum() == pytest.approx(9)
    assert ranges.max() == pytest.approx(np.ptp(7 + 10 * np.cos(theta + 1) + 3 * np.cos(9 * theta)))
    assert (mean > -3).all()


def test_damage_of_one_swing_is_that_of_its_range():
    pytest.importorskip("rainflow")
    result = response_of(turning_arm(fatigue=CURVE))
    found = fatigue(result)
    ranges = result.data["stress_range"].transpose("member", "s", "fibre")
    expected = (ranges / 40e6) ** 5 / 2e6
    damage = found["damage"].transpose("member", "s", "fibre")
    assert damage.to_numpy() == pytest.approx(expected.to_numpy(), rel=1e-6)
    worst = float(expected.max())
    assert float(found["life_cycles"][0]) == pytest.approx(1 / worst)
    assert float(found["life_hours"][0]) == pytest.approx(2 * np.pi / 40 / worst / 3600)


def test_damage_of_a_motion_in_time_counts_no_return_to_its_start():
    pytest.importorskip("rainflow")
    once = {"method": "transient", "cycles": 1, "sub_intervals": 96}
    whole = response_of(turning_arm(fatigue=CURVE).changed(effects=(), analysis=once))
    result = fm.Result(whole.data.isel(theta=slice(0, 25)))  # a quarter of a turn, which ends elsewhere
    stress = result.data["stress"].sel(member="arm", s=0.0, fibre="+").to_numpy()
    ranges, _, count = stress_cycles(stress, repeats=False).T
    damage, quarter = count @ (ranges / 40e6) ** 5 / 2e6, np.pi / 2 / 40
    found = fatigue(result)
    assert float(found["damage"].sel(member="arm", s=0.0, fibre="+")) == pytest.approx(damage, rel=1e-12)
    assert float(found["life_hours"][0]) == pytest.approx(quarter / float(found["damage"].max()) / 3600)


CORED = {  # a stiff core 6 mm high between soft skins of 1 mm, as plies and as parts
    "laminate": {
        "shape": "laminate",
        "width": 0.02,
        "plies": [{"thickness": t, "material": name} for t, name in ((1e-3, "skin"), (6e-3, "core"), (1e-3, "skin"))],
    },
    "polygon": {
        "shape": "polygon",
        "parts": [
            {"outline": [(low, -0.01), (high, -0.01), (high, 0.01), (low, 0.01)], "material": name}
            for low, high, name in ((-4e-3, -3e-3, "skin"), (-3e-3, 3e-3, "core"), (3e-3, 4e-3, "skin"))
        ],
    },
}


@pytest.mark.parametrize("shape", CORED)
def test_the_stress_of_inner_materials_counts(shape):
    """Under its core's largest moment the core has 207/70 of the skins' modulus at 3/4 of their distance."""
    pytest.importorskip("rainflow")
    core = {"modulus": 207e9, "density": 7850.0, "strength": 20e6, "fatigue": CURVE}
    skin = {"modulus": 70e9, "density": 2700.0, "strength": 20e6}
    beam = {"ends": ("O", "B"), "section": "strip"}
    links = {"arm": {"points": {"O": (0, 0), "B": (0.5, 0)}, "members": {"beam": beam}}}
    materials = {"core": core, "skin": skin}
    scene = arm(materials=materials, sections={"strip": CORED[shape]}, links=links, gravity=(0, -9.81), **TURNING)
    result = response_of(scene.changed({"drive.speed": 0.01}))  # its weight alone, and hardly any axial force
    line, stiffness = 0.02 * (7850 * 6e-3 + 2700 * 2e-3), 0.02 * (207e9 * 6**3 + 70e9 * (8**3 - 6**3)) * 1e-9 / 12
    moment = 9.81 * (line * 0.5**2 / 2 + 0.05 * 0.5)
    skins, inside = (modulus * moment / stiffness * y for modulus, y in ((70e9, 4e-3), (207e9, 3e-3)))
    assert float(result.data["stress"].max()) == pytest.approx(skins, rel=2e-3)  # with the weight along the arm
    assert float(result.data["utilisation"][0]) == pytest.approx(inside / 20e6, rel=2e-3)
    found = fatigue(result)
    assert found["damage"].sel(s=0.0).to_numpy() == pytest.approx((2 * inside / 40e6) ** 5 / 2e6, rel=0.02)
    assert found["stress_range"].sel(s=0.0).to_numpy() == pytest.approx(2 * inside, rel=2e-3)
    assert np.abs(found["stress_mean"].sel(s=0.0)).max() < 5e-3 * inside
    table = fatigue_table(result, found).renderables[1]
    assert float(next(iter(table.columns[2].cells))) == pytest.approx(2 * inside / 1e6, rel=2e-3)
    weak = scene.changed({"materials.core.strength": 0.9 * inside, "drive.speed": 0.01})
    (warning,) = [text for text in fm.analyse(weak).warnings if "strength" in text]
    assert "the strength of core" in warning
    assert "of the way from fibre - to +" in warning


def test_limit_and_mean_stress_count():
    curve = StressLife(**CURVE)
    assert StressLife(**CURVE | {"limit": 50e6}).damage(49e6, 0) == 0
    goodman = StressLife(**CURVE | {"ultimate": 400e6})
    assert goodman.damage(30e6, 100e6) == pytest.approx(float(curve.damage(40e6, 0)))  # 30/(1 - 1/4) MPa
    assert goodman.damage(30e6, -100e6) == pytest.approx(float(curve.damage(30e6, 0)))
    assert np.isinf(goodman.damage(30e6, 400e6))


def test_fatigue_needs_a_curve_and_more_than_one_position():
    with pytest.raises(ResultError, match="no material states `fatigue`"):
        fatigue(response_of(turning_arm()))
    static = arm(
        materials={"steel": STEEL | {"fatigue": CURVE}}, drive=(), gravity=(0, -9.81), analysis={"method": "static"},
        joints={"O": {"kind": "weld", "connect": ("ground.O", "arm.O")}},
    )  # fmt: skip
    with pytest.raises(ResultError, match="single position"):
        fatigue(response_of(static))


def test_library_that_is_not_there_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "rainflow", None)
    with pytest.raises(MechanismError, match=r"pip install 'fenics_mech\[fatigue\]'"):
        stress_cycles(np.array([0.0, 1.0, 0.0]), repeats=True)


def test_command_prints_how_long_members_last(tmp_path):
    pytest.importorskip("rainflow")
    response_of(turning_arm(fatigue=CURVE)).save(tmp_path / "result.nc")
    words = ["fatigue", str(tmp_path / "result.nc"), "-o", str(tmp_path / "out")]
    done = CliRunner().invoke(app, words, env={"COLUMNS": "80"})
    assert done.exit_code == 0, done.output
    assert "Damage by fatigue" in done.output
    assert len((tmp_path / "out" / "fatigue.csv").read_text().splitlines()) == 1 + 2 * 21


def test_shear_stress_of_shapes_against_their_limits():
    """Of a rectangle 3/2 and of a round 4/3 of the mean; a tube without a hole is a round, one of foil has twice it.

    An I whose web is as wide as its flanges is a rectangle. Its moments over all breadths come to the inertia.
    """
    rectangle = fm.RectangleSection(width=0.02, height=0.01)
    solid = fm.RoundSection(diameter=0.01)
    shapes = (rectangle, 3 / 2), (solid, 4 / 3), (fm.TubeSection(diameter=0.01, thickness=1e-7), 2.0)
    for section, over_mean in shapes:
        found = section.moment_over_breadth(np.array([0.0, section.fibre])) * section.area / section.inertia
        assert found == pytest.approx([over_mean, 0.0], abs=1e-4)
    y = np.linspace(-0.005, 0.005, 11)
    whole = fm.TubeSection(diameter=0.01, thickness=0.005)
    assert whole.moment_over_breadth(y) == pytest.approx(solid.moment_over_breadth(y))
    broad = fm.ISection(height=0.01, width=0.02, flange=0.002, web=0.02)
    assert broad.moment_over_breadth(y) == pytest.approx(rectangle.moment_over_breadth(y))
    beam = fm.ISection(height=0.02, width=0.01, flange=0.002, web=0.001)
    points, weights = np.polynomial.legendre.leggauss(20)
    parts = (0.0, 0.008, 0.001), (0.008, 0.01, 0.01)  # of half the height: web and flange, with their breadths
    moments = [
        breadth * (high - low) / 2 * weights @ beam.moment_over_breadth((low + high) / 2 + (high - low) / 2 * points)
        for low, high, breadth in parts
    ]
    assert 2 * sum(moments) == pytest.approx(beam.inertia)
    assert fm.CustomSection(area=1e-4, inertia=1e-9, fibre=0.005).moment_over_breadth(y) is None


def test_von_mises_is_that_of_the_fibres_or_of_the_middle():
    """A massless arm with a weight at its end: bending at the bearing, and at the tip pure shear, sqrt(3) tau."""
    result = response_of(turning_arm())
    shear, mises = (result.derived(name).sel(member="arm") for name in ("shear_stress", "von_mises"))
    force = result.data["shear_force"].sel(member="arm").transpose(*shear.dims)
    assert shear.to_numpy() == pytest.approx(1.5 / 1e-4 * force.to_numpy())
    root, fibres = mises.sel(s=0.0), abs(result.data["stress"].sel(member="arm", s=0.0)).max("fibre")
    assert float(root.max()) == pytest.approx(float(fibres.max()))
    axial = result.data["axial_force"].sel(member="arm", s=1.0) / 1e-4
    k = int(abs(shear.sel(s=1.0)).to_numpy().argmax())
    at_tip = np.sqrt(float(axial[k]) ** 2 + 3 * float(shear.sel(s=1.0)[k]) ** 2)
    assert float(mises.sel(s=1.0)[k]) == pytest.approx(at_tip, rel=1e-6)


def test_positioning_errors_and_shear_are_told_in_details():
    scene = turning_arm().changed(points={"T": {"at": "arm.B"}})
    result = response_of(scene)
    error = result.derived("positioning_error").sel(point="T")
    tip = np.linalg.norm(result.data["deflection"].sel(member="arm", s=1.0).transpose("theta", "component"), axis=-1)
    assert error.to_numpy() == pytest.approx(tip)
    text = " ".join(str(summary(analysed(scene), details=True)).split())
    assert f"(mm): T {1e3 * tip.max():.4g}." in text
    assert re.search(r"Largest von Mises stress \S+ MPa in arm; shear stress \S+ MPa in arm\.", text)
