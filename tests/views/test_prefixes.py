"""Prefixes of units fit the numbers of a result, and one number has one rounding everywhere."""

import re

import numpy as np
import pytest

from fenics_mech.recovery import Result
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.views.page.report import page
from fenics_mech.views.prefixes import fitted
from fenics_mech.views.reading import Reading, reading_of
from fenics_mech.views.summary import summary
from fenics_mech.views.words import short

FORCES = "joint_force", "shaking_force", "shaking_moment", "input_torque"


def louder(result, factor):
    """The result with forces and stresses so many times as large; the seed has 50 N, 5 N m and 50 MPa."""
    names = {name: result.data[name] * factor for name in (*FORCES, "stress", "stress_quasi_static")}
    kept = {name: data.assign_attrs(result.data[name].attrs) for name, data in names.items()}
    return Result(result.data.assign(kept))


@pytest.mark.parametrize(
    ("factor", "force", "moment", "stress"),
    [
        (1.0, "N", "N m", "MPa"),
        (100.0, "N", "N m", "MPa"),
        (1e3, "kN", "N m", "GPa"),
        (1e5, "kN", "kN m", "GPa"),
        (1e-3, "mN", "mN m", "kPa"),
        (1e-5, "mN", "mN m", "Pa"),
        (0.0, "N", "N m", "MPa"),
    ],
)
def test_the_largest_number_has_at_most_four_digits_before_the_point(result, factor, force, moment, stress):
    reading = Reading(louder(result, factor))
    assert [reading.units.label(kind) for kind in ("force", "moment", "stress")] == [force, moment, stress]
    assert reading.force.max() < 1e4
    assert np.abs(reading.stress).max() < 1e4
    text = str(summary(louder(result, factor)))
    assert f"force, {force}" in text
    for line in text.splitlines():
        if line.startswith(("force,", "Peak stress")):
            assert not re.search(r"\de[+\N{MINUS SIGN}-]?\d|\d{5}", line)


def test_forces_of_millions_of_newtons(result):
    assert Reading(louder(result, 1e6)).units.label("force") == "MN"


def test_units_that_are_stated_have_no_other_prefix(result):
    large = louder(result, 1e4)
    assert reading_of(large, AnswerUnits.of(["N"])).units.label("force") == "N"
    assert reading_of(large, AnswerUnits.of(["N"])).units.label("stress") == "GPa"
    scene = result.scene.changed(units=["N", "MPa"])
    stated = Result(large.data.assign_attrs(scene=scene.model_dump_json()))
    assert reading_of(stated).units.label("force") == "N"
    assert "force, N " in str(summary(stated))
    assert "MPa" in str(summary(stated, details=True))


def test_summary_details_and_report_have_one_unit(result):
    large = louder(result, 1e3)
    largest = short(float(Reading(large).force.max()))
    assert f" {largest} " in str(summary(large))
    assert f"{largest}" in str(page(large))
    assert re.search(r"\d kN ", str(summary(large, details=True)))
    assert ">kN<" in str(page(large)) or "force, kN" in str(page(large))


def test_units_fit_numbers_of_tables_that_are_no_results():
    """As those of `refine`: kinds without prefixes, such as strains and frequencies, stay."""
    units = fitted({"force": 5e5, "stress": 30.0, "moment": 1e-3, "strain": 1e-9, "frequency": 1e9}, AnswerUnits())
    assert [units.label(kind) for kind in ("force", "stress", "moment")] == ["kN", "Pa", "mN m"]
    assert units.label("strain") == AnswerUnits().label("strain")
