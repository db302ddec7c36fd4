"""Prefixes of units fit the numbers of a result, and one number has one rounding everywhere."""

import re
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech._console import text_of
from fenics_mech.recovery import Result
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.studies.compare import compare, curves_of_result
from fenics_mech.studies.design.trial import Trials
from fenics_mech.views import comparison, spread_views, study_views
from fenics_mech.views.frames import cycle, frames_at, peak_of
from fenics_mech.views.page.report import page
from fenics_mech.views.prefixes import fitted
from fenics_mech.views.reading import Reading, reading_of
from fenics_mech.views.summary import summary
from fenics_mech.views.tables import number
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


@pytest.mark.parametrize(("factor", "size", "unit"), [(1e3, 1e9, "GPa"), (1e-3, 1e3, "kPa")])
def test_frames_of_an_animation_have_the_unit_of_its_peak(result, factor, size, unit):
    """Their colours were in MPa while peak, colour bar and caption were in the unit that fits."""
    scaled = louder(result, factor)
    assert reading_of(scaled).units.label("stress") == unit
    frames = frames_at(scaled, scaled.data["theta"].to_numpy(), 1.0)
    assert np.abs(frames.sides).max() == pytest.approx(np.abs(scaled.data["stress"]).max() / size)
    assert peak_of(scaled).limit / 2 < np.abs(frames_at(scaled, cycle(scaled, 60), 1.0).sides).max()


def test_a_comparison_has_one_unit_for_both_results(result, tmp_path, monkeypatch):
    """The larger of both decides: that of the reference alone would need an exponent for the other."""
    sources = [curves_of_result(louder(result, factor), label) for factor, label in ((1.0, "one"), (1e3, "other"))]
    data, drawn = compare(sources), []
    text = text_of(comparison.comparison_table(sources, data, result.scene))
    assert "joint force (kN)" in text
    assert "input torque (N m)" in text
    largest = float(data["peak"].sel(quantity=[q for q in data["quantity"].to_numpy() if "joint force" in q]).max())
    assert f" {number(largest / 1e3)} " in text
    monkeypatch.setattr(comparison, "save", lambda figure, path: drawn.extend(figure.axes) or path)
    comparison.plot_comparison(sources, data, tmp_path, result.scene)
    forces = [axes for axes in drawn if axes.get_ylabel() == "joint force (kN)"]
    assert max(axes.get_lines()[1].get_ydata().max() for axes in forces) == pytest.approx(largest / 1e3, rel=1e-3)
    stated = text_of(comparison.comparison_table(sources, data, result.scene.changed(units=["N"])))
    assert "joint force (N)" in stated
    plt.close("all")


def test_numbers_of_studies_have_a_prefix_and_those_of_a_limit_its_unit():
    variables = {"speed": {"numbers": ["drive.speed"], "between": [20, 900]}}
    study = {"maximise": ["joint_force.max"], "variables": variables}
    scene = fm.load("demos/four_bar.toml").changed(study=study)
    start, best = (SimpleNamespace(numbers={"joint_force.max": force}) for force in (50.0, 38200.0))

    def told(scene):
        trials = Trials.of(scene)
        found = SimpleNamespace(problem=SimpleNamespace(first=start, trials=trials), best=best)
        return study_views.unit_of(found, "joint_force.max")

    assert told(scene).whole(38200.0) == "38.2 kN"
    assert told(scene).label("force") == "force (kN)"
    limited = scene.changed(study=study | {"limits": [{"of": "joint_force.max", "most": "9e4 N"}]})
    assert told(limited).whole(38200.0) == "38200 N"
    assert told(scene.changed(units=["N"])).unit == "N"
    explorer = SimpleNamespace(first=best, trials=Trials.of(scene))
    spread = SimpleNamespace(explorer=explorer, scattered=SimpleNamespace(design=explorer.trials.design))
    assert spread_views.unit_of(spread, "joint_force.max").unit == "kN"
