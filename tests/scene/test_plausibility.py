"""Numbers that can be computed with and are hardly meant: each mistake of a magnitude is named with its place.

The scenes of `demos` and `meshes`, and what is unusual but right, must raise no alarm.
"""

import math
import tomllib

import pytest

from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene, load
from fenics_mech.scene.plausibility import implausible
from tests.common import ROOT

SCENES = sorted([*(ROOT / "demos").glob("*.toml"), *(ROOT / "meshes").glob("*.toml")])
STRIP = {"shape": "rectangle", "width": "25.4 mm", "height": "1.6 mm"}


def with_changes(changes, name="four_bar"):
    """Give a demo with other values, by dotted path, as a user would write them."""
    data = tomllib.loads((ROOT / "demos" / f"{name}.toml").read_text())
    for path, value in changes.items():
        here = data
        *above, key = path.split(".")
        for part in above:
            here = here[int(part)] if isinstance(here, list) else here.setdefault(part, {})
        here[key] = value
    return Scene.read(data)


def press(**factor):
    return {"loads.press": {"at": "follower.B", "force": ["5 N", 0], "factor": factor}}


MISTAKES = {  # the place of the only warning, and what it says
    "density in g/cm^3": ({"materials.aluminium.density": 2.714}, "aluminium.density", "= 2714 kg/m^3 is likely"),
    "density in kg/mm^3": ({"materials.aluminium.density": 2.714e-6}, "aluminium.density", "= 2714 kg/m^3 is likely"),
    "modulus in GPa": ({"materials.aluminium.modulus": 71}, "aluminium.modulus", "71 GPa = 7.1e+10 Pa is likely"),
    "modulus in MPa": ({"materials.aluminium.modulus": 71e3}, "aluminium.modulus", "71000 MPa = 7.1e+10 Pa is likely"),
    "MPa for GPa": ({"materials.aluminium.modulus": "71 MPa"}, "aluminium.modulus", "speed of sound of 162 m/s"),
    "modulus in N/mm^2": ({"materials.aluminium.modulus": 210000}, "aluminium.modulus", "2.1e+11 Pa may be meant"),
    "drag relative to the links": ({"damping.relative": 1e4}, "damping.relative", "within 0.0001 s"),
    "load in kN for a moment": (
        {
            "loads.tap": {
                "at": "coupler@0.5",
                "force": [0, "10 kN"],
                "factor": {"kind": "pulse", "start": "100 deg", "end": "100.1 deg"},
            }
        },
        "loads.tap.force",
        "strain",
    ),
    "strength in MPa": ({"materials.aluminium.strength": 250}, "aluminium.strength", "250 MPa"),
    "width in mm": ({"sections.strip": STRIP | {"width": 12}}, "sections.strip.width", "12 mm = 0.012 m is likely"),
    "height in mm": ({"sections.strip": STRIP | {"height": 1.6}}, "sections.strip.height", "1.6 mm = 0.0016 m"),
    "no height": ({"sections.strip": STRIP | {"height": 1e-9}}, "sections.strip.height", "as good as nothing"),
    "fibre in mm": ({"sections.strip.fibre": 0.8}, "sections.strip.fibre", "1 to 10 times as far"),
    "a link in mm": ({"links.coupler.points.B": [279.4, 0]}, "links.coupler.points", "279.4 mm = 0.2794 m is likely"),
    "rad/s for rpm": ({"drive.speed": "600 rad/s"}, "drive.speed", "600 rpm = 62.83 rad/s may be meant"),
    "mass in g": ({"masses.A.mass": 45.2}, "masses.A.mass", "45.2 g = 0.0452 kg is likely"),
    "inertia in kg cm^2": ({"masses.A.inertia": 3}, "masses.A.inertia", "3 kg cm^2 = 0.0003"),
    "gravity in mm/s^2": ({"gravity": [0, -9810]}, "gravity", "9810 mm/s^2 = 9.81"),
    "rough angle in degrees": ({"links.coupler.angle": 110}, "links.coupler.angle", '"110 deg" is likely meant'),
    "drive start in degrees": ({"drive.start": 30}, "drive.start", '"30 deg" is likely meant'),
    "ratio in percent": ({"damping.ratio": 0.5}, "damping.ratio", '"0.5 %" may be meant'),
    "retardation time in ms": ({"damping.material": 0.1}, "damping.material", "0.1 ms = 0.0001 s is likely"),
    "drag of nonsense size": ({"damping.external": 1e4}, "damping.external", "within 0.0001 s"),
    "pulse the wrong way round": (
        press(kind="pulse", start="160 deg", end="100 deg"),
        "press.factor",
        "300 deg of the",
    ),
    "pulse in degrees": (press(kind="pulse", start="1 deg", end=160), "loads.press.factor.end", '"160 deg" is likely'),
    "pulse of two cycles": (press(kind="pulse", start=0, end="700 deg"), "press.factor.end", "340 deg of the cycle"),
    "wave of half a cycle": (
        press(kind="expression", formula="cos(1.5*theta)"),
        "loads.press.factor.formula",
        "jumps in every cycle",
    ),
    "impulse in degrees": ({"impulses.i": {"at": "B", "angle": 90}}, "impulses.i.angle", '"90 deg" is likely'),
    "load in kN": ({"loads.p": {"at": "coupler@0.5", "force": [0, 5e3]}}, "loads.p.force", "strains it by about 0.45"),
    "free length in mm": (
        {"springs.r": {"between": ["follower.B", "ground.O"], "stiffness": 40, "length": 200}},
        "springs.r.length",
        "200 mm = 0.2 m is likely",
    ),
    "tolerance in percent": ({"tolerance": 0.5}, "tolerance", '"0.5 %" may be meant'),
    "run-up in ms": ({"drive.run_up": 500}, "drive.run_up", "500 ms = 0.5 s is likely"),
}


@pytest.mark.parametrize("path", SCENES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_scenes_of_the_project_raise_no_alarm(path):
    assert implausible(load(path)) == ()


@pytest.mark.parametrize("mistake", MISTAKES)
def test_wrong_magnitudes_are_named_with_their_place(mistake):
    changes, place, what = MISTAKES[mistake]
    (warning,) = implausible(with_changes(changes))
    found, _, said = warning.partition(": ")
    assert found.endswith(place)
    assert what in said


def test_a_section_higher_than_long_is_told_by_its_own_height():
    beam = {"shape": "I", "height": "400 mm", "width": "12 mm", "flange": "2 mm", "web": "1.5 mm"}
    (warning,) = implausible(with_changes({"sections.strip": beam}))
    assert warning.startswith("sections.strip.height: the section is 0.4 m high, and member ")
    assert "it is no beam" in warning


def test_laws_in_degrees_or_milliseconds():
    law = {"kind": "harmonics", "mean": 40, "cosine": [-30]}
    (warning,) = implausible(with_changes({"drive.0.law": law}, "manipulator"))
    assert warning.startswith("drive.0.law: the law swings by 60 rad about 40 rad")
    fast = implausible(with_changes({"drive.0.period": "2 ms", "drive.1.period": "2 ms"}, "manipulator"))
    assert [warning.split(":")[0] for warning in fast] == ["drive.0.law", "drive.1.law"]


@pytest.mark.parametrize(
    "changes",
    [
        press(kind="pulse", start="350 deg", end="10 deg"),  # across drive angle 0
        press(kind="pulse", start="350 deg", end="370 deg"),
        press(kind="expression", formula="1 + cos(2*theta)"),
        press(kind="expression", formula="theta"),  # a ramp
        {"links.coupler.angle": "-290 deg"},
        {"drive.speed": "1000 rpm"},
        {"damping.ratio": "15 %"},
        {"sections.strip": STRIP | {"height": "0.1 mm"}},  # a foil
        {"materials.aluminium": {"modulus": "1 TPa", "density": "3500 kg/m^3"}},  # diamond
    ],
)
def test_what_is_unusual_and_right_raises_no_alarm(changes):
    assert implausible(with_changes(changes)) == ()


def test_a_ratio_of_percent_is_refused_with_advice():
    with pytest.raises(SceneError, match=r'damping.ratio: must be less than 1.*found 1: write "1 %"'):
        with_changes({"damping.ratio": 1})


@pytest.mark.parametrize(
    ("ratio", "message"),
    [
        ([0.02, 2], r'ratio\.1: must be less than 1.*found 2: write "2 %"'),
        ([0.02, -0.1], r"ratio\.1: must be greater than or equal to 0, found -0\.1"),
        ([], r"ratio: must have at least 1 entries and has 0"),
        ({"first": 0.02}, r"ratio: expected a number .* found \{'first': 0\.02\}$"),
    ],
)
def test_what_is_wrong_in_a_list_of_ratios_is_named(ratio, message):
    with pytest.raises(SceneError, match=r"damping\." + message):
        with_changes({"damping.ratio": ratio})


@pytest.mark.parametrize("changes", [{"height": 1e-200}, {"width": 1e-300}, {"height": 1e30, "width": 1e30}])
def test_numbers_at_the_edge_are_told_as_well(changes):
    assert implausible(with_changes({"sections.strip": STRIP | changes}))


def spinning(speed, height="2 mm", offset=0.0):
    """A steel strip of 0.3 m that turns about its end, or beside its line, and nothing else."""
    members = {"BA": {"ends": ("B", "A"), "section": "it", "material": "steel"}}
    points = {"B": (0, offset), "A": (0.3, offset)}
    if offset:
        members["OB"] = {"ends": ("O", "B"), "section": "arm", "material": "steel"}
        points["O"] = (0, 0)
    pivot = "O" if offset else "B"
    return Scene.read(
        {
            "materials": {"steel": {"modulus": 210e9, "density": 7850}},
            "sections": {
                "it": {"shape": "rectangle", "width": "20 mm", "height": height},
                "arm": {"shape": "rectangle", "width": "20 mm", "height": "20 mm"},
            },
            "ground": {"points": {"O": (0, 0)}},
            "links": {"strip": {"points": points, "members": members}},
            "joints": {"O": {"connect": ("ground.O", f"strip.{pivot}")}},
            "drive": {"joint": "O", "speed": speed},
        }
    )


def test_acceleration_along_a_member_bends_nothing():
    """A radial strip at 290 rad/s: 0.3 m of 290^2 would strain it by 0.03 across, and draws it by 1.4e-4 along."""
    assert implausible(spinning(290.0)) == ()


def test_acceleration_across_a_member_of_the_driven_link_is_seen():
    """290^2 at 0.1 m beside the line: 7850 8410 0.3^2 0.75/(210e9 0.002) = 0.0106."""
    (warning,) = implausible(spinning(290.0, offset=0.1))
    assert "accelerates links by about 8.41e+03 m/s^2, which strains member strip.BA by about 0.011" in warning


@pytest.mark.parametrize(
    ("rpm", "crank", "rod", "material"),
    [
        (6000, "45 mm", ("150 mm", "22 mm"), {"modulus": "210 GPa", "density": 7850}),  # of a car
        (18000, "20 mm", ("110 mm", "18 mm"), {"modulus": "110 GPa", "density": 4430}),  # of a race car, titanium
        (11000, "16 mm", ("75 mm", "7 mm"), {"modulus": "71 GPa", "density": 2780}),  # of a model's engine
        (12000, "23 mm", ("95 mm", "14 mm"), {"modulus": "210 GPa", "density": 7850}),  # of a motorcycle
    ],
)
def test_connecting_rods_of_engines_raise_no_alarm(rpm, crank, rod, material):
    changes = {
        "materials.aluminium": material,
        "links.crank.points.A": [crank, 0],
        "links.rod.points.B": [rod[0], 0],
        "sections.strip": {"shape": "rectangle", "width": "15 mm", "height": rod[1]},
        "sections.bar": {"shape": "rectangle", "width": "30 mm", "height": "15 mm"},
        "ground.points.G": [0, 0],
        "drive.speed": f"{rpm} rpm",
    }
    assert implausible(with_changes(changes, "slider_crank")) == ()


@pytest.mark.parametrize("speed", ["300 rad/s", 1500, "1450 rad/s"])
def test_a_nominal_speed_in_rad_s_is_asked_about(speed):
    """A small machine bears it; a motor has 300 or 1450 rpm, and hardly such a number of rad/s."""
    number = float(str(speed).split()[0])
    (warning,) = implausible(spinning(speed, height="20 mm"))
    told = f"{number * 30 / math.pi:.0f} rpm"
    begin = f"drive.speed: {number:.6g} rad/s are {told}: {number:.6g} rpm = "
    if number * 0.3 < 340:
        assert warning.startswith(begin)
        assert warning.endswith(f"may be meant. If not, write '{told}'")
        assert implausible(spinning(told, height="20 mm")) == ()
    else:
        assert f"m/s: {number:.6g} rpm" in warning
