"""Sections: their rigidities against formulas of their own, and bad ones refused with their place."""

import sys

import numpy as np
import pytest

from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene

STEEL, ALUMINIUM = {"modulus": "210 GPa", "density": 7850}, {"modulus": "70 GPa", "density": 2700}
PLACES = np.linspace(0, 1, 5)


def beam(section, material="steel", **sections):
    """Make a scene of one bar of this section that turns about one end."""
    return Scene.read(
        {
            "materials": {"steel": STEEL, "aluminium": ALUMINIUM},
            "sections": {"it": section} | sections,
            "ground": {"points": {"O": (0, 0)}},
            "links": {
                "bar": {
                    "points": {"O": (0, 0), "A": (1, 0)},
                    "members": {"OA": {"ends": ("O", "A"), "section": "it", "material": material}},
                }
            },
            "joints": {"O": {"connect": ("ground.O", "bar.O")}},
            "drive": {"joint": "O", "speed": 1.0},
        }
    )


def rigidity(section, material="steel", **sections):
    return beam(section, material, **sections).rigidity("bar", PLACES)


def by_layers(breadth, low, high, layers=200_000):
    """Area, second moment about the centroid and the centroid of a section, by the midpoint rule over its height."""
    y = low + (np.arange(layers) + 0.5) * (high - low) / layers
    b = breadth(y) * (high - low) / layers
    centre = np.sum(b * y) / np.sum(b)
    return np.sum(b), np.sum(b * (y - centre) ** 2), centre


def chord(y, radius):
    return 2 * np.sqrt(np.clip(radius**2 - y**2, 0, None))


PLAIN = {  # section, breadth at height y (m), half height (m)
    "rectangle": (
        {"shape": "rectangle", "width": "30 mm", "height": "4 cm"},
        lambda y: np.full_like(y, 0.03),
        0.02,
    ),
    "round": ({"shape": "round", "diameter": "50 mm"}, lambda y: chord(y, 0.025), 0.025),
    "tube": (
        {"shape": "tube", "diameter": "5 cm", "thickness": "4 mm"},
        lambda y: chord(y, 0.025) - chord(y, 0.021),
        0.025,
    ),
    "I": (
        {"shape": "I", "height": "10 cm", "width": "60 mm", "flange": "8 mm", "web": "5 mm"},
        lambda y: np.where(np.abs(y) > 0.042, 0.06, 0.005),
        0.05,
    ),
}


@pytest.mark.parametrize("shape", PLAIN)
def test_plain_shapes_are_the_integrals_over_their_breadth(shape):
    section, breadth, half = PLAIN[shape]
    area, inertia, _ = by_layers(breadth, -half, half)
    found = rigidity(section)
    assert np.allclose(found.axial, 210e9 * area, rtol=2e-6)
    assert np.allclose(found.bending, 210e9 * inertia, rtol=2e-6)
    assert np.allclose(found.line_density, 7850 * area, rtol=2e-6)
    assert np.allclose(found.fibre, [half, -half], rtol=1e-14)
    assert np.array_equal(found.modulus, np.full((5, 2), 210e9))


def test_a_tube_without_a_hole_is_a_round():
    tube = rigidity({"shape": "tube", "diameter": 0.05, "thickness": 0.025})
    assert tube.bending == pytest.approx(rigidity({"shape": "round", "diameter": 0.05}).bending, rel=1e-14)


def test_a_laminate_is_its_transformed_section():
    # widths scaled by the moduli: a steel strip is three times as wide as one of aluminium
    plies = [{"thickness": "2 mm", "material": "steel"}, {"thickness": "5 mm", "material": "aluminium"}]
    found = rigidity({"shape": "laminate", "width": "20 mm", "plies": plies})
    area, inertia, centre = by_layers(lambda y: np.where(y < 0.002, 0.06, 0.02), 0, 0.007)
    assert np.allclose(found.axial, 70e9 * area, rtol=1e-6)
    assert np.allclose(found.bending, 70e9 * inertia, rtol=1e-6)
    assert np.allclose(found.line_density, 0.02 * (0.002 * 7850 + 0.005 * 2700), rtol=1e-14)
    assert np.allclose(found.fibre, [0.007 - centre, -centre], rtol=1e-6)
    assert np.array_equal(found.modulus[0], [70e9, 210e9])  # the last ply is on the normal's side


def test_a_laminate_of_one_material_is_a_rectangle():
    plies = [{"thickness": t, "material": "steel"} for t in (0.001, 0.002, 0.0005)]
    found = rigidity({"shape": "laminate", "width": 0.02, "plies": plies})
    solid = rigidity({"shape": "rectangle", "width": 0.02, "height": 0.0035})
    for name in ("axial", "bending", "line_density", "modulus", "fibre"):
        assert np.allclose(getattr(found, name), getattr(solid, name), rtol=1e-13)


def square(low, high):
    return [[low, low], [high, low], [high, high], [low, high]]


def test_polygons_are_their_formulas():
    pytest.importorskip("sectionproperties")
    triangle = rigidity({"shape": "polygon", "outline": [[0, 0], ["6 mm", 0], [0, "4 mm"]]})  # apex at +y
    assert np.allclose(triangle.axial, 210e9 * 12e-6, rtol=1e-12)
    assert np.allclose(triangle.bending, 210e9 * 4e-3 * 6e-3**3 / 36, rtol=1e-12)
    assert np.allclose(triangle.fibre, [4e-3, -2e-3], rtol=1e-12)
    hollow = rigidity({"shape": "polygon", "outline": square(-2, 2), "holes": [square(-1, 1)]})
    assert np.allclose(hollow.bending, 210e9 * (4**4 - 2**4) / 12, rtol=1e-12)
    assert np.allclose(hollow.line_density, 7850 * 12, rtol=1e-12)


def test_a_polygon_of_two_materials_is_the_laminate():
    pytest.importorskip("sectionproperties")
    low = {"outline": [[0, 0], [2e-3, 0], [2e-3, 2e-2], [0, 2e-2]], "material": "steel"}
    high = {"outline": [[2e-3, 0], [7e-3, 0], [7e-3, 2e-2], [2e-3, 2e-2]], "material": "aluminium"}
    found = rigidity({"shape": "polygon", "parts": [low, high]})
    plies = [{"thickness": 2e-3, "material": "steel"}, {"thickness": 5e-3, "material": "aluminium"}]
    same = rigidity({"shape": "laminate", "width": 2e-2, "plies": plies})
    for name in ("axial", "bending", "line_density", "modulus", "fibre", "neutral", "mass_centre"):
        assert np.allclose(getattr(found, name), getattr(same, name), rtol=1e-10)


@pytest.mark.parametrize("axis", ["neutral", "middle", "origin"])
def test_where_the_axis_of_a_member_passes_its_section(axis):
    pytest.importorskip("sectionproperties")
    low = {"outline": [[0, 0], [2e-3, 0], [2e-3, 2e-2], [0, 2e-2]], "material": "steel"}
    high = {"outline": [[2e-3, 0], [7e-3, 0], [7e-3, 2e-2], [2e-3, 2e-2]], "material": "aluminium"}
    found = rigidity({"shape": "polygon", "parts": [low, high], "axis": axis})
    neutral, centre = (
        (1e-3 * 2 * by[0] + 4.5e-3 * 5 * by[1]) / (2 * by[0] + 5 * by[1]) for by in ((3, 1), (7850, 2700))
    )
    place = {"neutral": neutral, "middle": 3.5e-3, "origin": 0.0}[axis]
    assert np.allclose(found.neutral, neutral - place, rtol=1e-9, atol=1e-15)
    assert np.allclose(found.mass_centre, centre - place, rtol=1e-9, atol=1e-15)
    if axis != "origin":
        plies = [{"thickness": 2e-3, "material": "steel"}, {"thickness": 5e-3, "material": "aluminium"}]
        same = rigidity({"shape": "laminate", "width": 2e-2, "plies": plies, "axis": axis})
        assert np.allclose(found.mass_centre, same.mass_centre, rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("axis", ["neutral", "middle"])
def test_a_symmetric_laminate_has_no_offset(axis):
    thirds = [{"thickness": t, "material": m} for t, m in ((7e-4, "steel"), (1.1e-3, "aluminium"), (7e-4, "steel"))]
    found = rigidity({"shape": "laminate", "width": 0.03, "plies": thirds, "axis": axis})
    assert not found.neutral.any()
    assert not found.mass_centre.any()  # exactly: it takes the path of all symmetric sections


def test_without_the_extra_a_polygon_says_how_to_get_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "sectionproperties", None)
    monkeypatch.setitem(sys.modules, "sectionproperties.pre", None)
    with pytest.raises(SceneError, match=r"sections\.it: .*pip install 'fenics_mech\[sections\]'"):
        beam({"shape": "polygon", "outline": square(0, 1)})


FORMULAS = {"area": "2e-4*(1 - s/2)", "inertia": "1e-9*(1 - s/2)**3", "fibre": "0.01*exp(-s)"}


def test_formulas_of_the_place():
    found = rigidity({"shape": "variable"} | FORMULAS)
    assert np.allclose(found.axial, 210e9 * 2e-4 * (1 - PLACES / 2), rtol=1e-14)
    assert np.allclose(found.bending, 210e9 * 1e-9 * (1 - PLACES / 2) ** 3, rtol=1e-14)
    assert np.allclose(found.line_density, 7850 * 2e-4 * (1 - PLACES / 2), rtol=1e-14)
    assert np.allclose(found.fibre, 0.01 * np.exp(-PLACES)[:, None] * [1, -1], rtol=1e-14)


def test_tables_and_single_values():
    table = {"area": ["3 cm^2", "2 cm^2", "1 cm^2", "1 cm^2"], "inertia": "2 cm^4", "fibre": 0.01}
    scene = beam({"shape": "variable"} | table)
    at_values = scene.rigidity("bar", np.linspace(0, 1, 4))
    assert np.allclose(at_values.axial, 210e9 * 1e-4 * np.array([3, 2, 1, 1]), rtol=1e-14)
    assert np.allclose(at_values.bending, 210e9 * 2e-8, rtol=1e-14)
    everywhere = scene.rigidity("bar", np.linspace(0, 1, 301))
    assert np.all(np.diff(everywhere.axial) <= 0)  # monotone, as the table is
    assert np.allclose(rigidity({"shape": "variable"} | table | {"area": [1, 3]}).axial, 210e9 * (1 + 2 * PLACES))


@pytest.mark.parametrize("shape", PLAIN)
def test_a_taper_has_the_dimensions_between(shape):
    section = PLAIN[shape][0]
    first = beam(section).sections["it"].model_dump(exclude={"shape"}, exclude_none=True)
    half = {"shape": shape} | {key: value / 2 for key, value in first.items()}
    middle = {"shape": shape} | {key: 0.75 * value for key, value in first.items()}
    found = rigidity({"shape": "taper", "from": "a", "to": "b"}, a=section, b=half)
    for i, same in ((0, section), (2, middle), (4, half)):
        expected = rigidity(same)
        for name in ("axial", "bending", "line_density", "fibre"):
            assert np.allclose(getattr(found, name)[i], getattr(expected, name)[i], rtol=1e-13)


def test_sections_survive_json_and_changes():
    plies = [{"thickness": "2 mm", "material": "steel"}]
    scene = beam({"shape": "laminate", "width": "2 cm", "plies": plies}, other={"shape": "round", "diameter": 1})
    assert type(scene).model_validate_json(scene.model_dump_json()) == scene
    for varying in ({"shape": "variable"} | FORMULAS, {"shape": "taper", "from": "end", "to": "end"}):
        other = beam(varying, end={"shape": "round", "diameter": 1})
        assert type(other).model_validate_json(other.model_dump_json()) == other
        assert other.changed(name="other").sections == other.sections
    wider = scene.changed(sections__it__width="4 cm")
    assert wider.rigidity("bar", PLACES).axial == pytest.approx(2 * scene.rigidity("bar", PLACES).axial)


BAD = {
    "unknown shape": ({"shape": "Z"}, "sections.it", "known are custom, rectangle"),
    "wall": ({"shape": "tube", "diameter": 1, "thickness": 0.6}, "sections.it", "thickness <= 0.5 m"),
    "flanges": ({"shape": "I", "height": 1, "width": 1, "flange": 0.6, "web": 0.1}, "sections.it", "flange <= 0.5 m"),
    "web": ({"shape": "I", "height": 1, "width": 1, "flange": 0.1, "web": 2}, "sections.it", "at most as wide"),
    "negative": ({"shape": "round", "diameter": -1}, "sections.it.diameter", "greater than 0"),
    "unit": ({"shape": "round", "diameter": "1 kg"}, "sections.it.diameter", "wrong unit"),
    "no plies": ({"shape": "laminate", "width": 1, "plies": []}, "sections.it.plies", "at least 1"),
    "ply": (
        {"shape": "laminate", "width": 1, "plies": [{"thickness": 1, "material": "tin"}]},
        "sections.it.plies.0.material",
        "no material 'tin'",
    ),
    "negative somewhere": (
        {"shape": "variable"} | FORMULAS | {"area": "1 - 2*s"},
        "sections.it.area",
        "positive everywhere along the member, and is 0 at s = 0.5",
    ),
    "not finite": ({"shape": "variable"} | FORMULAS | {"fibre": "1/s"}, "sections.it.fibre", "is inf at s = 0"),
    "no formula": ({"shape": "variable"} | FORMULAS | {"inertia": "1 - x"}, "sections.it.inertia", "known are + - * /"),
    "unit of a table": ({"shape": "variable"} | FORMULAS | {"area": ["1 m", 1]}, "sections.it.area", "wrong unit"),
    "short table": ({"shape": "variable"} | FORMULAS | {"area": [1]}, "sections.it.area", "at least two"),
    "taper to nothing": ({"shape": "taper", "from": "it", "to": "x"}, "sections.it.to", "no section 'x'"),
    "taper of itself": ({"shape": "taper", "from": "it", "to": "it"}, "sections.it", "no two sections of one shape"),
    "taper without an end": ({"shape": "taper", "from": "it"}, "sections.it.to", "missing"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_sections_are_refused_with_their_place(case):
    section, place, message = BAD[case]
    with pytest.raises(SceneError) as caught:
        beam(section)
    assert str(caught.value).startswith(f"{place}: ")
    assert message in str(caught.value)


BAD_POLYGONS = {
    "crossed": ({"outline": [[0, 0], [1, 1], [1, 0], [0, 1]]}, "Self-intersection"),
    "hole outside": ({"outline": square(0, 1), "holes": [square(2, 3)]}, "make no polygon"),
    "nothing": ({}, "either an outline"),
    "overlap": (
        {"parts": [{"outline": square(0, 2), "material": "steel"}, {"outline": square(1, 3), "material": "steel"}]},
        "part 1 lies over",
    ),
}


@pytest.mark.parametrize("case", BAD_POLYGONS)
def test_bad_polygons_are_refused(case):
    pytest.importorskip("sectionproperties")
    section, message = BAD_POLYGONS[case]
    with pytest.raises(SceneError, match=message):
        beam({"shape": "polygon"} | section)


def test_a_section_of_one_material_needs_the_members():
    with pytest.raises(SceneError, match=r"links\.bar\.members\.OA\.material: .*needs a material"):
        beam({"shape": "round", "diameter": 1}, material=None)
