"""Quantities."""

import pytest

from fenics_mech.scene.units import COMMON, EXAMPLES, in_unit, registry


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
