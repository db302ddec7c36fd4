"""Members that are pressed by more than they carry across the plane of motion."""

import math
from pathlib import Path

import numpy as np
import pytest

from fenics_mech import judge, load
from fenics_mech.safety import buckled_sideways
from fenics_mech.safety.side_buckling import pressed_sideways
from fenics_mech.scene import Scene
from fenics_mech.scene.sections import Stock
from fenics_mech.views.judgements import judgements, verdict
from tests.common import DEMOS, ROOT, analysed

SCENE = load(Path(__file__).parent / "scenes" / "side_buckling.toml")
E, LENGTH = 207e9, 0.4
EULER = math.pi**2 * E * 0.12 * 0.003**3 / 12 / LENGTH**2  # of a strip 3 mm wide and 120 mm high, pinned: 3449 N
STRIP = {"shape": "rectangle", "width": 0.003, "height": 0.12}


def strut(force, method="static", section=STRIP, links=None, effects=("large-rotations",), **analysis):
    """Give a link that a drive holds at its start, pressed by a force at its free end."""
    given = {
        "name": "strut",
        "effects": effects,
        "materials": {"m": {"modulus": E, "density": 7850.0}},
        "sections": {"s": section, "thin": {**STRIP, "width": 0.002}},
        "ground": {"points": {"O": (0, 0)}},
        "links": links
        or {
            "bar": {
                "points": {"O": (0, 0), "A": (LENGTH, 0)},
                "members": {"OA": {"ends": ("O", "A"), "section": "s", "material": "m"}},
            }
        },
        "joints": {"O": {"connect": ("ground.O", "bar.O")}},
        "loads": {"F": {"at": "bar.A", "force": (-force, 0.0)}},
        "drive": {"joint": "O", "speed": 1.0},
        "mesh": {"elements": 2},
        "analysis": {"method": method, **analysis},
    }
    return Scene.read(given)


def said(scene):
    judged = judgements(analysed(scene))
    return verdict(judged), " ".join(one.text for one in judged)


@pytest.mark.long
@pytest.mark.slow
def test_strips_on_edge_are_not_called_inside_the_theory():
    """24 kN against 3.4 kN with pinned ends and 13.8 kN with clamped ends."""
    (level, usable), text = said(SCENE)
    assert level == "bad"
    assert usable.startswith("Do not use these numbers: sideways buckling of upper, lower")
    assert "inside the theory" not in usable
    assert "Member upper is pressed by up to 23900 N" in text
    assert f"buckles at {3450} N with pinned ends and {13800} N with clamped ends" in text


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(("force", "level", "words"), [("8 kN", "warn", "is possible"), ("2.8 kN", "good", "inside")])
def test_strips_are_told_from_their_lower_load_on(force, level, words):
    found, usable = said(SCENE.changed(loads__coining__force=(0, force)))[0]
    assert found == level
    assert words in usable


def test_free_end_buckles_at_a_quarter():
    """A driven strip whose tip is free, in statics: pi^2 EI/(4 L^2)."""
    for force, buckled in ((0.24 * EULER, False), (0.26 * EULER, True)):
        (level, usable), text = said(strut(force))
        assert ("sideways buckling of bar" in usable) == buckled
        assert level == ("bad" if buckled else "good")
        assert ("as one end is free" in text) == buckled


@pytest.mark.parametrize("method", ["static", "quasi-static", "periodic", "transient"])
def test_every_method_tells_it(method):
    options = {"quasi-static": {"sub_intervals": 12}, "static": {}}.get(method, {"sub_intervals": 24})
    scene = strut(0.3 * EULER, method, effects=(), **options).model_dump()
    scene["loads"]["F"] |= {"follows": True}
    scene["damping"] = {"ratio": 0.05} if method == "periodic" else {"material": 1e-3}
    if method == "transient":
        scene["analysis"] |= {"cycles": 1}
    assert "sideways buckling of bar" in said(Scene.read(scene))[0][1]


def test_length_is_that_between_joints():
    """Two members in line without a joint between them buckle as one; the weaker one tells the lower load."""
    members = {
        "OB": {"ends": ("O", "B"), "section": "s", "material": "m"},
        "BA": {"ends": ("B", "A"), "section": "thin", "material": "m"},
    }
    points = {"O": (0, 0), "B": (0.1, 0), "A": (LENGTH, 0)}
    data = analysed(strut(0.26 * EULER, links={"bar": {"points": points, "members": members}}))
    found = {one.member: one for one in buckled_sideways(data.scene, data.data)}
    assert found["bar.OB"].pinned == pytest.approx(EULER / 4)
    assert found["bar.BA"].pinned == pytest.approx(EULER / 4 * (2 / 3) ** 3)


@pytest.mark.parametrize(
    ("section", "inertia"),
    [
        ({"shape": "rectangle", "width": 0.003, "height": 0.12}, 0.12 * 0.003**3 / 12),
        ({"shape": "round", "diameter": 0.02}, math.pi * 0.02**4 / 64),
        ({"shape": "tube", "diameter": 0.02, "thickness": 0.002}, math.pi * (0.02**4 - 0.016**4) / 64),
        (
            {"shape": "I", "height": 0.03, "width": 0.02, "flange": 0.003, "web": 0.002},
            (2 * 0.003 * 0.02**3 + 0.024 * 0.002**3) / 12,
        ),
        ({"shape": "polygon", "outline": ((0, 0), (0.03, 0), (0.03, 0.004), (0, 0.004))}, 0.03 * 0.004**3 / 12),
        ({"shape": "polygon", "outline": ((0, -0.005), (0, 0.005), (0.006, 0))}, 2 * 0.006 * 0.005**3 / 12),
        ({"shape": "laminate", "width": 0.004, "plies": ({"thickness": 0.02, "material": "m"},)}, 0.02 * 0.004**3 / 12),
        ({"shape": "custom", "area": 1e-4, "inertia": 1e-9, "fibre": 1e-2}, None),
    ],
)
def test_stiffness_across_the_plane(section, inertia):
    """Closed forms; a section that is given by its numbers alone does not say it."""
    scene = strut(1.0, section=section)
    stock = Stock(scene.materials["m"], scene.materials, scene.sections)
    found = scene.sections["s"].bending_across(np.array([0.0, 1.0]), stock)
    if inertia is None:
        assert found is None
        return
    assert found == pytest.approx(np.full(2, E * inertia), rel=1e-12)


def test_taper_across_the_plane_is_that_of_its_dimensions():
    scene = strut(1.0)
    given = scene.model_dump()
    given["sections"] |= {"end": {**STRIP, "width": 0.006}, "s": {"shape": "taper", "from": "thin", "to": "end"}}
    scene = Scene.read(given)
    found = scene.sections["s"].bending_across(
        np.array([0.0, 0.5, 1.0]), Stock(scene.materials["m"], scene.materials, scene.sections)
    )
    assert found == pytest.approx(E * 0.12 * np.array([0.002, 0.004, 0.006]) ** 3 / 12, rel=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("path", ["docs/tutorial/press.toml", "demos/four_bar.toml", "demos/watt.toml"])
def test_demos_do_not_buckle_sideways(path):
    result = analysed(load(ROOT / path))
    assert buckled_sideways(result.scene, result.data) == []


@pytest.mark.slow
def test_column_of_the_demo_is_stiffer_across_the_plane():
    result = analysed(load(DEMOS / "pulsating_column.toml"))
    assert buckled_sideways(result.scene, result.data) == []


@pytest.mark.parametrize("share", [0.3, 0.94, 1.0 - 1e-6, 1.01])
def test_factor_of_safety_is_that_of_the_judgement(share):
    """The closed form of a cantilever is a quarter of the pinned load; from 1 on both call it buckled."""
    result = analysed(strut(share * EULER / 4))
    check = next(check for check in judge(result).checks["bar"] if check.mode == "buckling across")
    assert check.factor == pytest.approx(1 / share, rel=1e-3)
    assert bool([one for one in judgements(result) if "sideways" in one.title]) == (share > 1)


def test_stated_ends_across_the_plane_are_taken():
    scene = SCENE.changed({"links.upper.members.CK.across": "clamped", "links.lower.members.KB.across": "pinned"})
    data = analysed(SCENE.changed(tolerance=None, analysis={"method": "static"})).data
    found = {
        one.member: one for one in pressed_sideways(scene, data.assign(axial_force=-1.0 + 0 * data["axial_force"]))
    }
    assert found["upper"].pinned == found["upper"].clamped == pytest.approx(4 * EULER)
    assert found["lower"].pinned == found["lower"].clamped == pytest.approx(EULER)
