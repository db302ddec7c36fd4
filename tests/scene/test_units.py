"""Quantities."""

import math

import pytest

from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.units import COMMON, EXAMPLES, in_unit, registry

BODY = {"mass": 1.0, "inertia": 0.01}
CART = {  # a cart with a pendulum, at rest or driven
    "ground": {"points": {"G": (0, 0)}},
    "links": {
        "cart": {"points": {"G": (0, 0), "P": (0, 0)}, "rigid": BODY},
        "bar": {"points": {"P": (0, 0)}, "rigid": BODY | {"centre": (0, -0.5)}},
    },
    "joints": {
        "slide": {"kind": "prismatic", "connect": ("ground.G", "cart.G")},
        "pin": {"connect": ("cart.P", "bar.P")},
    },
    "freedoms": {"slide": {}, "pin": {}},
    "analysis": {"method": "transient", "duration": 1.0},
}
SWING = {"joint": "pin", "law": {"kind": "harmonics", "sine": ["5 deg"]}, "period": 1.0}
PUSH = {"joint": "slide", "law": {"kind": "table", "values": [0, "1 mm", 0, 0, 0, 0]}, "period": 1.0}
BACK = {"kind": "rest-to-rest", "end": "5 mm", "out": (0.1, 0.3), "back": (0.5, 0.7)}
STOP = {"kind": "stop", "contact": {"stiffness": 1e5}}


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("4.25 in", "m", 0.10795),
        ("0.406 cm^2", "m**2", 4.06e-5),
        ("8.67e-4 cm^4", "m**4", 8.67e-12),
        ("90 deg", "rad", 1.5707963267948966),
        ("60 rpm", "rad/s", 6.283185307179586),
        ("2.5", "m", 2.5),
        (3, "kg", 3.0),
        ("2 %", "1", 0.02),
        ("0.02", "1", 0.02),
    ],
)
def test_conversion(text, unit, value):
    assert in_unit(unit)(text) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("value", ["3 kg", "", "4 furlong per", "1e400 m", float("nan"), True, None, [1]])
def test_refused(value):
    with pytest.raises(ValueError, match="m"):
        in_unit("m")(value)


@pytest.mark.parametrize(("text", "unit"), [("2 %", "m"), ("2 deg", "1"), ("2 m", "1"), ("3 m/mm", "Pa")])
def test_no_quantity_for_another(text, unit):
    with pytest.raises(ValueError, match="wrong unit"):
        in_unit(unit)(text)


@pytest.mark.parametrize(
    ("text", "unit", "why"),
    [
        ("1,5 mm", "m", "comma"),  # pint takes it for 15 mm
        ("7,850 kg/m^3", "kg/m**3", "comma"),
        ("1 500 g", "kg", "two numbers"),  # pint takes it for 500 g
        ("200 1/min", "rad/s", "turns or radians"),  # pint takes it for rad/min
        ("3 1/2 in", "m", "two numbers"),  # pint takes it for 1.5 in
        ("3 1 / 2 in", "m", "two numbers"),
        ("5 mm 2", "m", "two numbers"),  # pint takes it for 10 mm
        ("1.234.567 mm", "m", "two points"),  # pint takes it for 0.7 mm
        ("1..5 mm", "m", "two points"),
        ("1.5e-3.5 m", "m", "two points"),
        ("--5 deg", "rad", "two signs"),
        ("5 cps", "rad/s", "is a frequency"),  # pint takes it for 5 rad/s
        ("1·5 mm", "m", "raised point"),  # pint takes it for 5 mm
        ("\N{MINUS SIGN}9.81 m/s^2", "m/s**2", "MINUS SIGN.*minus of the keyboard"),  # pint takes it for 9.81
        ("\N{EN DASH}30 deg", "rad", "EN DASH.*minus of the keyboard"),
        ("9 \N{EN DASH} 4 mm", "m", "EN DASH"),  # pint takes it for 36 mm
        ('5"', "m", "QUOTATION MARK"),  # pint takes it for 5 m
        ("5\N{DOUBLE PRIME}", "m", "DOUBLE PRIME"),
        ("30\N{PRIME}", "rad", "PRIME"),  # pint takes it for 30 rad
        ("5 # g", "kg", "NUMBER SIGN"),  # pint takes it for 5 kg
        ("5 mm \N{PLUS-MINUS SIGN} 1", "m", "PLUS-MINUS SIGN"),
        ("4\N{DIVISION SIGN}5 g", "kg", "DIVISION SIGN"),  # pint takes it for 20 g
        ("< 5 mm", "m", "LESS-THAN SIGN"),
        ("5\u200b0 mm", "m", "ZERO WIDTH SPACE"),  # pint takes it for 0
    ],
)
def test_what_another_reader_would_misread_is_refused(text, unit, why):
    with pytest.raises(ValueError, match=why):
        in_unit(unit)(text)


@pytest.mark.parametrize(("text", "unit", "value"), [("5 1/min", "1/s", 1 / 12), ("3 1/s", "rad/s", 3.0)])
def test_a_rate_without_a_unit_of_angle(text, unit, value):
    assert in_unit(unit)(text) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("30°", "rad", 0.5235987755982988),
        ("71·10⁹ N/m²", "Pa", 71e9),
        ("71\N{MULTIPLICATION SIGN}10^9 Pa", "Pa", 71e9),
        ("3 kg·cm²", "kg*m**2", 3e-4),
        ("9.81 m s⁻²", "m/s**2", 9.81),
        ("5\N{NO-BREAK SPACE}µm", "m", 5e-6),
        ("1/2 in", "m", 0.0127),
        ("2 N/(mm^2)", "Pa", 2e6),
        ("-2.5e-3 m", "m", -2.5e-3),
        ("5 kg 1/s^2", "N/m", 5.0),
        ("2 m - 3 mm", "m", 1.997),
    ],
)
def test_signs_of_quantities(text, unit, value):
    assert in_unit(unit)(text) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize("name", COMMON)
def test_common_units_are_as_pint_has_them(name):
    unit = "*".join([*(f"{symbol}**{2 * power}" for symbol, power in COMMON[name][1].items()), "s"])
    text = f" -7.3e-1 {name}^3/{name} s"
    assert in_unit(unit)(text) == pytest.approx(registry().Quantity(text).to(unit).magnitude, rel=1e-15)


@pytest.mark.parametrize(("unit", "text"), EXAMPLES.items())
def test_examples_are_read_as_by_pint(unit, text):
    assert in_unit(unit)(text) == pytest.approx(registry().Quantity(text).to(unit).magnitude, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "unit", "hint"),
    [
        ("12 lb", "N", "lb is a mass, and lbf a force"),
        ("12 lb/in", "N/m", "lb is a mass, and lbf a force"),
        ("3 lbf", "kg", "lbf is a force, and lb or lbm a mass"),
    ],
)
def test_pounds_of_the_other_kind_are_said(text, unit, hint):
    with pytest.raises(ValueError, match=hint):
        in_unit(unit)(text)


def test_pounds_of_mass_have_both_names():
    assert in_unit("kg")("2 lbm") == in_unit("kg")("2 lb") == pytest.approx(2 * 0.45359237)


OF_THE_OTHER_KIND = {  # place: what is stated there, in the right unit and in a wrong one
    "freedoms.pin.start": ("5 deg", "5 mm"),
    "freedoms.slide.start": ("5 mm", "5 deg"),
    "freedoms.pin.speed": ("5 rpm", "5 m/s"),
    "freedoms.slide.speed": ("5 mm/s", "5 rpm"),
    "freedoms.pin.effort": ("5 N m", "5 N"),
    "freedoms.slide.effort": ("5 kN", "5 N m"),
    "freedoms.slide.effort.speed": ("5 m/s", "5 rad/s"),
    "joint_laws.stop.lower": ("-5 deg", "-5 mm"),
    "joint_laws.cam.lift.end": ("5 mm", "5 deg"),
    "joint_laws.gas.effort": ("5 N", "5 N m"),
    "analysis.poincare.at": ("5 deg", "5 mm"),
    "drive.start": ("5 deg", "5 mm"),
    "drive.law.sine.0": ("5 deg", "5 mm"),
    "drive.law.values.1": ("1 mm", "1 deg"),
}


def stated(place, text):
    """Give the cart's data with a text at a place."""
    data = {key: dict(value) for key, value in CART.items()}
    table, name, *rest = place.split(".")
    if table == "freedoms":
        data["freedoms"] = CART["freedoms"] | {name: {rest[0]: text}}
        if rest[1:]:
            data["freedoms"][name] = {"effort": {"kind": "speed-controller", "proportional": 1.0, "speed": text}}
    elif table == "joint_laws":
        law = {
            "stop": STOP | {"joint": "pin", "lower": text},
            "cam": {"kind": "cam", "joint": "pin", "drives": "slide", "lift": BACK | {"end": text}, "stiffness": 1e5},
            "gas": {"kind": "joint-effort", "joint": "slide", "effort": text},
        }[name]
        data["joint_laws"] = {name: law}
    elif table == "analysis":
        data["analysis"]["poincare"] = {"joint": "pin", "at": text}
    else:
        law = {"sine": SWING["law"] | {"sine": [text]}, "values": PUSH["law"] | {"values": [0, text, 0, 0, 0, 0]}}
        at = "slide" if "values" in place else "pin"
        how = {"law": law[rest[0]], "period": 1.0} if rest else {"speed": 1.0, "start": text}
        data |= {"drive": {"joint": at} | how, "freedoms": {"pin" if at == "slide" else "slide": {}}}
        data["analysis"] = {"method": "transient", "cycles": 1}
    return data


@pytest.mark.parametrize("place", OF_THE_OTHER_KIND)
def test_a_joint_has_its_own_units(place):
    right, wrong = OF_THE_OTHER_KIND[place]
    scene = Scene.read(stated(place, right))
    assert Scene.read(scene.model_dump()) == scene
    with pytest.raises(SceneError, match=rf"{place}: joint .* and the unit is one of joints that (turn|slide)"):
        Scene.read(stated(place, wrong))


def test_a_drive_with_a_law_has_no_start():
    data = stated("drive.law.sine.0", "5 deg")
    data["drive"]["start"] = 0.3
    with pytest.raises(SceneError, match=r"drive\.start: the start is that of a drive at constant speed"):
        Scene.read(data)


@pytest.mark.parametrize(
    ("unit", "text", "value"),
    [
        ("Pa", "210000 N/mm2", 210e9),
        ("Pa", "210000 N/mm^2", 210e9),
        ("Pa", "21000 kgf/mm2", 21000 * 9.80665e6),
        ("Pa", "2 kp/cm2", 2 * 9.80665e4),
        ("Pa", "30 Msi", 30e6 * 6894.757293168361),
        ("kg/m**3", "7850 kg/m3", 7850),
        ("kg/m**3", "7.85 g/cm3", 7850),
        ("kg/m**3", "7850 kg m-3", 7850),
        ("kg/m**3", "1e-3 kg/m3", 1e-3),
        ("m**4", "8.67e-4 cm4", 8.67e-12),
        ("m**2", "2 in2", 2 * 0.0254**2),
        ("rad/s", "300 RPM", 10 * math.pi),
        ("rad/s", "300 rev/min", 10 * math.pi),
        ("rad/s", "300 rad/sec", 300),
        ("N*m", "5 Nm", 5),
        ("N*m", "5 kNm", 5e3),
        ("N*m", "5 N-mm", 5e-3),
        ("N*m/rad", "5 Nm/rad", 5),
        ("N*s/m", "5 Ns/m", 5),
        ("kg*m**2", "3 kg-m^2", 3),
        ("kg*m**2", "3e-4 kg m2", 3e-4),
        ("m/s**2", "-9.81 m/s2", -9.81),
        ("1/s", "5 s-1", 5),
        ("m", "2e-3 m", 2e-3),
        ("m", "2 in", 0.0508),
        ("N", "2 lbf", 2 * 4.4482216152605),
    ],
)
def test_units_are_read_as_engineers_write_them(unit, text, value):
    """An inch is 0.0254 m, a pound of force 4.4482216152605 N, a kilopond 9.80665 N, by definition."""
    assert in_unit(unit)(text) == pytest.approx(value, rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "text", "likely"),
    [
        ("Pa", "210 Gpa", "210 GPa"),
        ("Pa", "250 mpa", "250 MPa"),
        ("Pa", "2e5 N/MM2", "2e5 N/mm^2"),
        ("kg", "2 Kg", "2 kg"),
        ("kg", "2 kgs", "2 kg"),
        ("kg", "200 gr", "200 g"),
        ("kg/m**3", "7850 KG/M3", "7850 kg/m^3"),
        ("N", "2 KN", "2 kN"),
        ("N", "100 lbs", "100 lbf"),
        ("N*m", "5 in-lb", "5 in lbf"),
        ("m", '2"', "2 in"),
        ("m", "12 MM", "12 mm"),
        ("rad", "5 Deg", "5 deg"),
        ("rad/s", "300 Rpm", "300 rpm"),
        ("Hz", "2 khz", "2 kHz"),
        ("kg*m**2", "3 kgm2", "3 kg m^2"),
        ("s", "5 MS", "5 ms"),
        ("kg/m**3", "7850 kg/cbm", "7850 kg/m^3"),
        ("kg/m**3", "7.85 g/ccm", "7.85 g/cm^3"),
        ("m**2", "40 sqmm", "40 mm^2"),
        ("rad/s", "1 rev/s", "1 turn/s"),
        ("rad/s", "1 Rev/sec", "1 turn/sec"),
        ("rad/s", "5 RPS", "5 turn/s"),
        ("rad/s", "20 u/min", "20 turn/min"),
        ("rad/s", "300 UPM", "300 rpm"),
        ("rad", "2 revs", "2 turn"),
        ("Pa", "207 gpa", "207 GPa"),
    ],
)
def test_a_unit_that_is_not_read_is_answered_with_what_is_meant(unit, text, likely):
    with pytest.raises(ValueError, match="Did you mean") as told:
        in_unit(unit)(text)
    assert str(told.value).endswith(f"Did you mean {likely!r}?")
    assert repr(text) in str(told.value)
    assert math.isfinite(in_unit(unit)(likely))


@pytest.mark.parametrize(("unit", "text"), [("Pa", "5 furlongs"), ("rad/s", "300 1/min"), ("m", "auto")])
def test_nothing_is_suggested_where_nothing_is_near(unit, text):
    with pytest.raises(ValueError, match=r"quantity|unit|count") as told:
        in_unit(unit)(text)
    assert "Did you mean" not in str(told.value)
