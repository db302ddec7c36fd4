"""Quantities with units: a number is SI, a string has a unit, the answer is always a float in SI.

Common units are read here, all others by pint.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import BeforeValidator, PlainValidator, ValidatorFunctionWrapHandler, WithJsonSchema, WrapValidator

from fenics_mech.errors import shortened
from fenics_mech.scene.unit_spellings import meant, spelled

if TYPE_CHECKING:
    import pint


LARGEST = 1e30  # in SI: products of several of them must not overflow
LONGEST = 100  # characters
MOST_POWERS = 5  # pint computes them with whole numbers of any length
POWER = re.compile(r"\*\*|\^|[⁰¹²³⁴⁵⁶⁷⁸⁹]+")
SMALL_POWER = re.compile(r"(\*\*|\^)\s*[-+]?\d\b(?!\s*(\*\*|\^|\.\d))|[⁰¹²³⁴⁵⁶⁷⁸⁹](?![⁰¹²³⁴⁵⁶⁷⁸⁹.])")

POUND = re.compile(r"\b(lbs?|lbm|pounds?)\b")
POUND_FORCE = re.compile(r"\b(lbf|kips?|pounds?_force)\b")
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE | re.ASCII)
COMMA = re.compile(r"\d,\d")
NUMBER_AND_UNIT = re.compile(r"([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?+)\s*([^\d\s.*+-].*)")  # a number and its unit
MISREAD = (  # what pint would read as something else, and what to write
    (COMMA, "a comma. Write a decimal point"),  # 1,5 as 15
    # 1 500 as 500, 3 1/2 as 3 halves and 5 mm 2 as 10 mm, but for the likes of 5 1/s
    (re.compile(r"[\w%°]\s+(?!1\s*/\s*[^\W\d])[\d.]"), "two numbers. Write one, without a space in it"),
    (re.compile(r"\.\d*\.|\d[eE][-+]?\d+\."), "a number with two points. Write one decimal point"),  # 1.234.567 as 0.7
    (
        re.compile(r"\d[·⋅](?!10[\^*⁻⁰¹²³⁴⁵⁶⁷⁸⁹])\d"),
        "a raised point. Write a decimal point, or * for a product",
    ),  # 1·5 as 5
    (re.compile(r"[-+]\s*[-+]"), "two signs. Write one"),  # --5 as 5
    (re.compile(r"\bgr\b"), "'gr', which is a grain to some and a gram to others. Write g or grain"),
)
FREQUENCIES = "hertz", "counts_per_second", "becquerel", "baud"  # to pint all are 1/s, as rad/s is
SIGNS = frozenset(".+-*/^()_%°·⋅⁻\N{MULTIPLICATION SIGN}")  # of quantities, beside letters, digits and spaces
FACTOR = re.compile(r"(\s*[*/]\s*|\s+)([A-Za-z%]+|1)(?:(?:\^|\*\*)(-?\d))?", re.ASCII)
COMMON = {  # in SI, which pint takes half a second of every start to say
    "m": (1.0, {"m": 1}),
    "cm": (1e-2, {"m": 1}),
    "mm": (1e-3, {"m": 1}),
    "in": (0.0254, {"m": 1}),
    "kg": (1.0, {"kg": 1}),
    "g": (1e-3, {"kg": 1}),
    "s": (1.0, {"s": 1}),
    "ms": (1e-3, {"s": 1}),
    "rad": (1.0, {"rad": 1}),
    "deg": (math.pi / 180, {"rad": 1}),
    "rpm": (math.pi / 30, {"rad": 1, "s": -1}),
    "Hz": (1.0, {"Hz": 1}),
    "kHz": (1e3, {"Hz": 1}),
    "N": (1.0, {"kg": 1, "m": 1, "s": -2}),
    "kN": (1e3, {"kg": 1, "m": 1, "s": -2}),
    "Pa": (1.0, {"kg": 1, "m": -1, "s": -2}),
    "MPa": (1e6, {"kg": 1, "m": -1, "s": -2}),
    "GPa": (1e9, {"kg": 1, "m": -1, "s": -2}),
    "%": (1e-2, {}),
    "1": (1.0, {}),
}

EXAMPLES = {
    "1": "2 %",
    "m": "4.25 in",
    "m**2": "0.406 cm^2",
    "m**3": "20 mm^3",
    "m**4": "8.67e-4 cm^4",
    "kg": "45.2 g",
    "kg/m**3": "2714 kg/m^3",
    "Pa": "71 GPa",
    "rad": "71 deg",
    "rad/s": "300 rpm",
    "m/s": "2 m/s",
    "s": "20 ms",
    "1/s": "5 /s",
    "Hz": "2 kHz",
    "kg*m**2": "3 kg cm^2",
    "N": "12 N",
    "N*m": "2 N m",
    "N/m": "5 N/m",
    "N*m/rad": "2 N m/rad",
    "N*s/m": "5 N s/m",
    "N*m*s/rad": "0.1 N m s/rad",
    "m/s**2": "-9.81 m/s^2",
    "N*s": "0.2 N s",
    "N*m*s": "0.01 N m s",
    "Pa*m/s": "1.5 MPa m/s",
}


@cache
def registry() -> pint.UnitRegistry:
    """Give the unit registry, made once."""
    import pint  # noqa: PLC0415  (slow to import, and few scenes need it)

    found: pint.UnitRegistry = pint.UnitRegistry(cache_folder=None)
    found.define("@alias pound = lbm")
    found.define("Msi = 1e6 * psi")  # as moduli of fibres are stated
    return found


def _in_common_units(text: str) -> tuple[float, Counter[str]] | None:
    """Read a number and its units as a float in SI and the powers of the SI units; None where it has any other."""
    text, powers = text.strip(), Counter[str]()
    if (number := NUMBER.match(text)) is None or len(text) > LONGEST:
        return None
    value, rest = float(number[0]), text[number.end() :].strip()
    rest = rest if rest[:1] in ("", "*", "/") else f" {rest}"
    while rest:
        factor = FACTOR.match(rest)
        if factor is None or factor[2] not in COMMON:
            return None
        power = int(factor[3] or 1) * (-1 if "/" in factor[1] else 1)
        size, units = COMMON[factor[2]]
        value *= size**power
        powers.update({symbol: times * power for symbol, times in units.items()})
        rest = rest[factor.end() :]
    return value, powers


@cache
def _in_common(text: str, unit: str) -> float | None:
    """Convert the text of a quantity in common units, or of a number alone, to a float in `unit`; None for others."""
    common, wanted = _in_common_units(text), _in_common_units(f"1 {unit}")
    if common and wanted and (common[1] == wanted[1] or NUMBER.fullmatch(text.strip())):
        return common[0]
    return None


@cache
def _parse(text: str, unit: str) -> float:
    """Convert the text of a quantity to a float in `unit`, or say what is likely meant."""
    if len(text) > LONGEST:
        return _by_pint(text, unit)
    plain = spelled(text)
    try:
        return _read(plain, unit)
    except ValueError as error:
        said = str(error).replace(repr(plain), repr(text))
        likely = meant(text, lambda other: _read(other, unit))
        raise ValueError(f"{said}. Did you mean {likely!r}?" if likely else said) from error


def _read(text: str, unit: str) -> float:
    """Convert the text of a quantity in usual spelling to a float in `unit`."""
    common = _in_common(text, unit)
    return _by_pint(text, unit) if common is None else common


def _by_pint(text: str, unit: str) -> float:
    """Convert the text of any quantity to a float in `unit`, or say what is wrong with it."""
    plain = "a number" if unit == "1" else f"a number in SI ({unit.replace('**', '^')})"
    example = f"write {plain} or a string such as {EXAMPLES[unit]!r}"
    if len(text) > LONGEST:
        raise ValueError(f"cannot read {shortened(text)} as a quantity: it has {len(text)} characters; {example}")
    powers = list(POWER.finditer(text))
    if len(powers) > MOST_POWERS or any(not SMALL_POWER.match(text, power.start()) for power in powers):
        raise ValueError(f"cannot read {text!r} as a quantity: an exponent is one digit, as in m^2; {example}")
    if not any(map(str.isdigit, text)):  # as "auto"
        raise ValueError(f"cannot read {text!r} as a quantity; {example}")
    if (why := _misread_by_pint(text)) is not None:
        raise ValueError(f"cannot read {text!r} as a quantity: {why}; {example}")
    import pint  # noqa: PLC0415

    quantity: Any
    try:
        quantity = registry().Quantity(text)
    except Exception as error:  # pint raises its parser's own errors of many types
        raise ValueError(f"cannot read {text!r} as a quantity; {example}") from error
    if unit == "rad/s" and any(name in str(quantity.units) for name in FREQUENCIES):
        raise ValueError(f"{text!r} is a frequency, and 1 Hz is 2 pi rad/s; write rpm or rad/s")
    if unit == "rad/s" and str(quantity.units) == "1 / minute":  # to pint 1/min is rad/min, and turns may be meant
        raise ValueError(f"{text!r} does not say whether it counts turns or radians; write rpm or rad/s")
    bare = str(quantity.units) == "dimensionless"
    if (unit == "Hz" and "hertz" not in str(quantity.units) and not bare) or (unit == "1" and not quantity.unitless):
        raise ValueError(f"{text!r} has the wrong unit; {example}")
    try:
        return float(quantity.magnitude if bare else quantity.to(unit).magnitude)
    except OverflowError:  # of whole numbers of any length
        return math.inf
    except (pint.DimensionalityError, pint.OffsetUnitCalculusError) as error:
        raise ValueError(f"{text!r} has the wrong unit{_of_pounds(text, unit)}; {example}") from error


def _misread_by_pint(text: str) -> str | None:
    """Say what pint would read as something else: it takes signs that it does not know for products."""
    for pattern, what in MISREAD:
        if pattern.search(text):
            return f"it has {what}"
    sign = next((sign for sign in text if not (sign.isalnum() or sign.isspace() or sign in SIGNS)), None)
    if sign is None:
        return None
    minus = sign == "\N{MINUS SIGN}" or unicodedata.category(sign) == "Pd"  # as word processors write it
    called = f"the sign {sign!r} ({unicodedata.name(sign, 'without a name')})"
    return f"it has {called}. Write the minus of the keyboard, '-'" if minus else f"it has {called}"


def _of_pounds(text: str, unit: str) -> str:
    """Say that pounds are masses, and that pounds of force are not, where the other is expected."""
    if ("N" in unit or unit == "Pa") and POUND.search(text):
        return ": lb is a mass, and lbf a force"
    return ": lbf is a force, and lb or lbm a mass" if "kg" in unit and POUND_FORCE.search(text) else ""


def in_unit(unit: str) -> Callable[[Any], Any]:
    """Give the validator that turns a number or a string into a finite float in `unit`."""

    def convert(value: Any) -> Any:
        number = _parse(value, unit) if isinstance(value, str) else value
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise ValueError(
                f"expected a number or a string with a unit such as {EXAMPLES[unit]!r}, found {shortened(value)}"
            )
        if not abs(number) <= LARGEST:
            raise ValueError(f"expected a finite number, at most {LARGEST:g} in SI, found {shortened(value)}")
        return float(number)

    return convert


def unit_written(texts: Sequence[str], values: Sequence[float]) -> tuple[str, float] | None:
    """Give the unit in which numbers are written and how much of SI it is; None where they have none."""
    for match, end in zip(map(NUMBER_AND_UNIT.fullmatch, texts), values):
        if match and float(match[1]):
            return match[2], end / float(match[1])
    return None


def _quantity(unit: str) -> Any:
    return Annotated[float, BeforeValidator(in_unit(unit)), _schema(unit)]


class OfTurning(float):
    """A quantity that was written in a unit of joints that turn, such as 5 deg or 2 N m."""


class OfSliding(float):
    """A quantity that was written in a unit of joints that slide, such as 5 mm or 2 N."""


def _either(turning: str, sliding: str, named: str) -> Any:
    """Give the type of a quantity in one of two units: what is of one only is an `OfTurning` or an `OfSliding`."""

    def read(value: Any) -> Any:
        if not isinstance(value, str):
            return value if isinstance(value, OfTurning | OfSliding) else in_unit(turning)(value)
        found = {}
        for kind, unit, other in ((OfTurning, turning, sliding), (OfSliding, sliding, turning)):
            if _in_common(value, other) is not None and _in_common(value, unit) is None:
                continue  # pint, which is slow to load, would say no more
            try:
                found[kind] = in_unit(unit)(value)
            except ValueError:
                if kind is OfSliding and not found:
                    raise
        if len(found) == 2:
            return found[OfTurning]
        return next(kind(number) for kind, number in found.items())

    return Annotated[float, PlainValidator(read), _schema(named)]


def _angle() -> Any:
    """Give the type of an angle: an `OfTurning` where its unit is written, so that none is thought forgotten."""

    def read(value: Any, checked: ValidatorFunctionWrapHandler) -> Any:
        number = checked(in_unit("rad")(value))
        written = isinstance(value, str) and NUMBER.fullmatch(value.strip()) is None
        return OfTurning(number) if written or isinstance(value, OfTurning) else number

    return Annotated[float, WrapValidator(read), _schema("rad")]


def _schema(named: str) -> WithJsonSchema:
    either = [{"type": "number"}, {"type": "string"}]
    return WithJsonSchema({"anyOf": either, "description": f"{named}, or a string with a unit"})


Share = _quantity("1")
Length = _quantity("m")
Area = _quantity("m**2")
SectionModulus = _quantity("m**3")
SecondMoment = _quantity("m**4")
Mass = _quantity("kg")
Density = _quantity("kg/m**3")
Modulus = _quantity("Pa")
Angle = _angle()
AngularSpeed = _quantity("rad/s")
Time = _quantity("s")
Rate = _quantity("1/s")
Inertia = _quantity("kg*m**2")
Force = _quantity("N")
Torque = _quantity("N*m")
SpringRate = _quantity("N/m")
TorsionalRate = _quantity("N*m/rad")
Viscosity = _quantity("N*s/m")
TorsionalDamping = _quantity("N*m*s/rad")
LineForce = _quantity("N/m")
Speed = _quantity("m/s")
Acceleration = _quantity("m/s**2")
Momentum = _quantity("N*s")
AngularMomentum = _quantity("N*m*s")
PressureTimesSpeed = _quantity("Pa*m/s")
AngleOrLength = _either("rad", "m", "rad or m")
RateOfJoint = _either("rad/s", "m/s", "rad/s or m/s")
TorqueOrForce = _either("N*m", "N", "N m or N")
