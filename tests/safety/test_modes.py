"""Members that fail by one mode alone are named by it, with the factor of a calculation by hand."""

import math

import numpy as np
import pytest

from fenics_mech import Result, SceneError, judge
from fenics_mech.safety import resonance
from fenics_mech.safety.critical_speeds import Nearest
from fenics_mech.studies.design.result_numbers import Quantity
from fenics_mech.views.key_figures import key_figures
from fenics_mech.views.page.report import page
from fenics_mech.views.safety_words import safety_sentences
from tests.common import analysed
from tests.safety.machines import E, G, along, middle, rectangle, rod

GOOD = {"yield": 355e6, "ultimate": 500e6}
TURN = {"sub_intervals": 24}
SWING = {"factor": {"kind": "harmonics", "cosine": [1.0]}}
LIMIT = 4.51 * 500**-0.265 * 250e6  # ka Se', Su = 500 MPa, machined
SMALL = {"diameter": 6e-3, "eye": 30e-3, "thickness": 10e-3}


def size(width, height):
    return 1.24 * (0.808 * math.sqrt(width * height) * 1e3) ** -0.107


def lateral(width, height):
    """pi/L sqrt(E Iy G J) of a thin blade, J = h b^3/3 (1 - 0.63 b/h)."""
    return math.pi * math.sqrt(E * height * width**3 / 12 * G * height * width**3 / 3 * (1 - 0.63 * width / height))


def johnson(area, radius, strength):
    return area * strength * (1 - strength / radius**2 / (4 * math.pi**2 * E))


CASES = {
    "yield": (rod(rectangle(0.01, 0.01), [along(30e3)], material=GOOD), "yield", 355 / 300, "height"),
    "allowed stress": (
        rod(rectangle(0.01, 0.01), [along(25e3)], material={"strength": 200e6}), "yield", 0.8, "height",
    ),
    "buckling in plane": (
        rod(rectangle(0.03, 0.01), [along(-3e3)], material=GOOD),
        "buckling in plane", math.pi**2 * E * 0.03 * 0.01**3 / 12 / 3e3, "height",
    ),
    "buckling across": (
        rod(rectangle(0.01, 0.03), [along(-3e3)], material=GOOD),
        "buckling across", math.pi**2 * E * 0.03 * 0.01**3 / 12 / 3e3, "width",
    ),
    "clamped across": (
        rod(rectangle(0.01, 0.03), [along(-10e3)], material=GOOD, member={"across": "clamped"}),
        "buckling across", 4 * math.pi**2 * E * 0.03 * 0.01**3 / 12 / 10e3, "width",
    ),
    "stocky strut": (
        rod(
            rectangle(0.031, 0.03), [along(-60e3)], material={"yield": 235e6, "ultimate": 360e6},
            member={"across": "clamped"},
        ),
        "buckling in plane", johnson(0.031 * 0.03, 0.03 / math.sqrt(12), 235e6) / 60e3, "height",
    ),
    "lateral torsion": (
        rod(rectangle(0.002, 0.06), [middle(80.0)], material=GOOD),
        "lateral torsion", lateral(0.002, 0.06) / 20, "width",
    ),
    "fatigue": (
        rod(rectangle(0.02, 0.02), [middle(800.0, **SWING)], material=GOOD | {"yield": 450e6}, **TURN),
        "fatigue", LIMIT * size(0.02, 0.02) / 150e6, "height",
    ),
    "notch": (
        rod(
            rectangle(0.02, 0.02), [middle(500.0, **SWING)], material=GOOD,
            member={"notches": [{"at": 0.5, "kf": 2.0}]}, **TURN,
        ),
        "fatigue", LIMIT * size(0.02, 0.02) / (2 * 93.75e6), "height",
    ),
    "pin in shear": (
        rod(rectangle(0.02, 0.02), [along(10e3)], material=GOOD, pin=SMALL),
        "pin and eye", 2 * math.pi * 0.006**2 / 4 * 355e6 / math.sqrt(3) / 10e3, "diameter",
    ),
    "bush": (
        rod(rectangle(0.02, 0.02), [along(1e3)], material=GOOD, pin=SMALL | {"bush": 20e6}),
        "pin and eye", 20e6 * 6e-3 * 10e-3 / 1e3, "thickness",
    ),
    "bush by its speed": (  # p v = F/(d t) d w/2, at 0.01 rad/s
        rod(rectangle(0.02, 0.02), [along(1e3)], material=GOOD, pin=SMALL | {"bush_pv": 800.0}, **TURN),
        "pin and eye", 800.0 * 2 * 10e-3 / (1e3 * 0.01), "thickness",
    ),
    "deflection": (
        rod(rectangle(0.02, 0.02), [middle(400.0)], material=GOOD, design={"deflection": "L/500"}),
        "deflection", 2e-3 / (400 / (48 * E * 0.02**4 / 12)), "height",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_member_is_named_by_the_mode_by_which_alone_it_fails(name):
    """Closed forms; the rod swings by 1e-3 in a turn, and the fit of J is off by up to 1e-3."""
    scene, mode, by_hand, _ = CASES[name]
    verdict = judge(analysed(scene))
    member, check = verdict.governing
    assert (member, check.mode, verdict.safe) == ("rod", mode, False)
    assert check.factor == pytest.approx(by_hand, rel=3e-3)
    others = [other for other in verdict.checks["rod"] if other.decides and other.mode != mode]
    assert all(other.share > 1 for other in others)


@pytest.mark.parametrize("name", CASES)
def test_the_cure_is_enough_and_not_much_more(name):
    """The machine with the dimension is analysed again; dimensions are rounded up at the third digit."""
    scene, mode, _, key = CASES[name]
    result = analysed(scene)
    cure = judge(result).cure
    assert cure.key == key
    assert cure.place in " ".join(safety_sentences(result, scene.answer_units)[1])
    again = judge(analysed(scene.changed({cure.place: cure.needed})))
    check = next(check for check in again.checks["rod"] if check.mode == mode)
    assert 0.999 <= check.share < 1.04


def test_sentences_name_member_mode_and_dimension():
    result = analysed(CASES["buckling across"][0])
    level, said = safety_sentences(result, result.scene.answer_units)
    assert level == "bad"
    assert said[0] == (
        "Not safe: member 'rod' buckles across the plane of motion at 0.58 of its wanted factor (1.73 of 3)."
    )
    assert said[1] == "For these loads make it 12.1 mm thick, now 10 mm (sections.s.width)."


def test_other_modes_by_which_it_fails_are_named():
    result = analysed(rod(rectangle(0.01, 0.011), [along(-2.5e3)], material=GOOD))
    said = safety_sentences(result, result.scene.answer_units)[1]
    assert said[2] == "It fails by buckling in plane too."


def test_eye_in_fatigue():
    """Goodman with both halves of the load, Kt of a close pin with d/w = 1/2 raised by 35 % for clearance."""
    pin = {"diameter": 0.02, "eye": 0.04, "thickness": 0.005}
    check = _check(rod(rectangle(0.02, 0.02), [along(4e3)], material=GOOD, pin=pin, **TURN), "pin and eye")
    assert check.detail == "eye in fatigue, A"
    half = 1.35 * 2.507 * 2e3 / (0.02 * 0.005)
    assert check.factor == pytest.approx(1 / (half / (0.85 * LIMIT) + half / 500e6), rel=2e-3)


def test_mean_stress_lowers_what_is_endured_in_tension_and_not_in_compression():
    loads = [middle(400.0, **SWING)]
    section = rectangle(0.02, 0.02)
    used = {}
    for force in (-20e3, 0.0, 20e3):
        used[force] = 1 / _check(rod(section, [*loads, along(force)], material=GOOD, **TURN), "fatigue").factor
    assert used[20e3] - used[0.0] == pytest.approx(50e6 / 500e6, rel=0.03)  # the tension also stiffens the rod
    assert used[-20e3] == pytest.approx(used[0.0], rel=1e-6)


@pytest.mark.parametrize(("surface", "a", "b"), [("ground", 1.58, -0.085), ("hot-rolled", 57.7, -0.718)])
def test_surfaces(surface, a, b):
    material = GOOD | {"surface": surface}
    check = _check(rod(rectangle(0.02, 0.02), [middle(800.0, **SWING)], material=material, **TURN), "fatigue")
    assert check.factor == pytest.approx(a * 500**b * 250e6 * size(0.02, 0.02) / 150e6, rel=3e-3)


def test_axial_load_has_its_own_factor_and_no_size():
    loads = [("block.B", (20e3, 0.0), SWING)]
    check = _check(rod(rectangle(0.02, 0.02), loads, material=GOOD, **TURN), "fatigue")
    assert check.factor == pytest.approx(0.85 * LIMIT / 50e6, rel=3e-3)


def test_stress_life_curves_are_counted_by_rainflow():
    """Two equal cycles a turn, of 150 MPa: both count, with N = cycles (S/range)^5."""
    pytest.importorskip("rainflow")
    factor = {"factor": {"kind": "harmonics", "cosine": [0.0, 1.0]}}  # twice a turn
    curve = {"range": 200e6, "cycles": 2e6, "slope": 5.0}
    scene = rod(
        rectangle(0.02, 0.02), [middle(400.0, **factor)], material={"yield": 355e6, "fatigue": curve},
        design={"cycles": 1e6}, **TURN,
    )  # fmt: skip
    swing = 2 * 75e6
    by_hand = (2e6 / (2 * 1e6)) ** (1 / 5) * 200e6 / swing
    assert _check(scene, "fatigue").factor == pytest.approx(by_hand, rel=3e-3)


def test_grades_that_are_assumed_do_not_decide_and_are_told():
    result = analysed(rod(rectangle(0.01, 0.01), [along(30e3)]).changed(effects=("large-rotations",)))
    verdict = judge(result)
    check = next(check for check in verdict.checks["rod"] if check.mode == "yield")
    assert (check.factor, check.decides) == (pytest.approx(235 / 300, rel=1e-3), False)
    assert verdict.safe
    level, said = safety_sentences(result, result.scene.answer_units)
    assert level == "warn"
    assert said[0].startswith("Safe, as far as the scene tells: ")
    assert said[1].endswith("state materials.steel.yield.")
    assert "steel yields as steel S235" in verdict.assumed


def test_materials_of_no_known_kind_are_not_judged():
    scene = rod(rectangle(0.01, 0.01), [along(30e3)], material={"modulus": 3e9, "density": 1400.0})
    assert _check(scene, "yield").missing == "state materials.steel.yield"


def test_a_flat_strip_is_bent_about_its_weak_axis_and_cannot_tip():
    assert math.isinf(_check(rod(rectangle(0.06, 0.002), [middle(1.0)], material=GOOD), "lateral torsion").factor)


def test_numbers_of_a_rectangle_are_taken_as_one():
    numbers = {"area": 3e-4, "inertia": 0.01 * 0.03**3 / 12, "fibre": 0.015}
    check = _check(rod(numbers, [along(-3e3)], material=GOOD), "buckling across")
    assert check.factor == pytest.approx(CASES["buckling across"][2], rel=1e-6)
    assert "section s is the rectangle of its numbers" in check.assumed


def test_resonance_decides_where_the_answer_has_no_vibration(monkeypatch):
    found = Nearest(0.04, "harmonic 3 meets mode 1", "rod")
    monkeypatch.setattr(resonance, "resonance_margin", lambda _: found)
    scene = rod(rectangle(0.011, 0.012), [along(1.0)], material=GOOD)
    assert judge(analysed(scene)).governing[1].mode != "resonance"
    verdict = judge(Result.with_scene(still := scene.changed(analysis__method="quasi-static"), analysed(still).data))
    assert verdict.governing[1].mode == "resonance"
    assert verdict.governing[1].share == pytest.approx(0.4)


def _check(scene, mode):
    return next(check for check in judge(analysed(scene)).checks["rod"] if check.mode == mode)


def test_wanted_factors_are_those_of_the_scene():
    scene = CASES["buckling across"][0].changed({"design.safety": {"buckling": 1.5}})
    assert np.isclose(_check(scene, "buckling across").wanted, 1.5)
    assert judge(analysed(scene)).safe


def test_studies_know_the_least_factor_and_that_of_a_member_and_a_mode():
    result = analysed(CASES["buckling across"][0])
    least = CASES["buckling across"][2] / 3
    for name in ("safety.min", "safety[rod].min", "safety[rod][buckling across].min"):
        assert Quantity.read(name).of(result) == pytest.approx(least, rel=1e-3)
    assert Quantity.read("safety[pin and eye].min").of(result) > 1  # which rests on an assumed pin
    with pytest.raises(SceneError, match="there is no 'crank'"):
        Quantity.read("safety[crank].min").of(result)
    with pytest.raises(SceneError, match="nothing moves in a static answer"):
        Quantity.read("safety[resonance].min").of(result)


def test_figures_for_other_programs():
    found = key_figures(analysed(CASES["buckling across"][0]))["safety"]
    assert (found["safe"], found["member"], found["mode"], found["level"]) == (False, "rod", "buckling across", "bad")
    assert found["cure"] == {"place": "sections.s.width", "now": 0.01, "needed": pytest.approx(0.0121)}
    assert found["members"]["rod"]["buckling across"]["decides"]
    assert not found["members"]["rod"]["pin and eye"]["decides"]


def test_page_hatches_what_rests_on_an_assumption():
    html = page(analysed(CASES["buckling across"][0]))
    assert 'class="t bad" data-mode="buckling across"' in html
    assert 'assumed" data-mode="pin and eye"' in html
    assert "make it 12.1 mm thick, now 10 mm" in html


@pytest.mark.parametrize(("design", "safe"), [({}, True), ({"safety": {"yield": 1.5}}, False)])
def test_an_allowed_stress_has_its_factor_in_it_unless_more_is_wanted(design, safe):
    """180 of 200 MPa: 1.11 of 1."""
    scene = rod(rectangle(0.01, 0.01), [along(18e3)], material={"strength": 200e6}, design=design)
    assert _check(scene, "yield").factor == pytest.approx(10 / 9, rel=1e-3)
    assert judge(analysed(scene)).safe is safe
