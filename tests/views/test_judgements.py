"""Whether numbers may be used: every warning has a size, and what it says depends on that size."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from fenics_mech.cli import app
from fenics_mech.recovery import Result
from fenics_mech.views.judgements import error, judgements, stability, theory, verdict
from fenics_mech.views.summary import summary
from fenics_mech.views.words import sentence, share, short


def changed(result, acting=(), attributes=None, **values):
    """The result with other effects, sizes per member, relative errors by source, and attributes."""
    data, listed = result.data, json.loads(result.data.attrs["effects"])
    for effect in listed:
        effect["acts"] = effect["name"] in acting
    data = data.assign_attrs(effects=json.dumps(listed), **(attributes or {}))
    sources = values.pop("sources", None)
    if sources is not None:
        data = data.drop_dims("source").assign_coords(source=list(sources))
        data = data.assign({name: ("source", list(sources.values())) for name in PREFIXED})
    return Result(data.assign({name: (data[name].dims, np.full(data[name].shape, v)) for name, v in values.items()}))


PREFIXED = [f"{prefix}relative_error" for prefix in ("", "deflection_", "joint_force_", "drive_effort_")]
STRAIGHT = {"bow": 0.001, "euler_ratio": 0.01, "rotation": 0.01}


@pytest.mark.parametrize(
    ("acting", "sizes", "level", "said"),
    [
        ((), {}, "good", "Linear theory holds to 5 % of a buckling load"),
        ((), {"euler_ratio": 0.104}, "warn", "may be off by about 10 %"),
        (("geometric-stiffness",), {"euler_ratio": 0.104}, "good", "10.4 % of its buckling load"),
        ((), {"euler_ratio": 0.3}, "bad", "the strains are wrong"),
        ((), {"bow": 0.03}, "bad", "bows by up to 3 % of its length"),
        (("large-rotations",), {"rotation": 0.9, "bow": 0.4, "euler_ratio": 2}, "good", "holds to 1.3 rad"),
        (("large-rotations",), {"rotation": 1.4}, "bad", "the strains are wrong"),
    ],
)
def test_theory_by_the_size_of_deflections_and_axial_forces(result, acting, sizes, level, said):
    judged = theory(changed(result, acting, sources={"mesh": 0.01}, **STRAIGHT | sizes))
    assert judged.level == level
    assert said in judged.text


@pytest.mark.parametrize(("left_out", "level"), [(0.005, "good"), (0.054, "warn"), (0.3, "bad"), (np.inf, "bad")])
def test_theory_by_the_estimate_of_what_it_leaves_out(result, left_out, level):
    judged = theory(changed(result, sources={"mesh": 0.01, "theory": left_out}, **STRAIGHT))
    assert judged.level == level
    if level == "warn":
        assert "leaves out 5.4 % of the strain" in judged.text
        assert "effects = 'auto'" in judged.text


@pytest.mark.parametrize(("left_out", "said"), [(0.4, "leaves out 40 % of"), (1.0, "leaves out 100 % or more of")])
def test_large_estimates_of_the_theory_say_that_they_are_rough(result, left_out, said):
    judged = theory(changed(result, sources={"mesh": 0.01, "theory": left_out}, **STRAIGHT))
    assert said in judged.text
    assert "Estimates that large are rough" in judged.text


def test_errors_of_all_and_more_are_told_as_that(result):
    sources = {"mesh": 0.1, "theory": 1.0}
    total = {f"{prefix}error_estimate": 1.1 for prefix in ("", "deflection_", "joint_force_", "drive_effort_")}
    judged = error(changed(result, sources=sources, attributes=total))
    assert judged.title == "error 100 % or more"
    assert "100 % or more by linear theory" in judged.text


def test_quantities_that_a_tolerance_does_not_name_are_told_where_they_are_worse(result):
    errors = {"error_estimate": 0.005, "deflection_error_estimate": 0.02, "joint_force_error_estimate": 0.003}
    changes = {"sources": {"mesh": 0.005}, "attributes": errors | {"drive_effort_error_estimate": 0.001}}
    of_strain = changed(Result(result.data.assign_attrs(scene=scene_with(result, 0.01))), **changes)
    assert "The tolerance does not name what has larger errors: deflection 2 %." in error(of_strain).text
    of_both = scene_with(result, {"strain": 0.01, "deflection": 0.03})
    assert "does not name" not in error(changed(Result(result.data.assign_attrs(scene=of_both)), **changes)).text


def scene_with(result, tolerance):
    """The scene of a result as it keeps it, with a tolerance."""
    return result.scene.changed(tolerance=tolerance).model_dump_json()


def with_multiplier(result, size):
    places = {"multiplier": [[size, 0.0]]}
    data = result.data.assign_attrs(stability_limit=500.0).assign(
        multiplier=(("disturbance", "part"), places["multiplier"])
    )
    for name, value in {"growth_rate": -1.0, "multiplier_frequency": 50.0, "multiplier_mode": 1}.items():
        data[name] = ("disturbance", [value])
    return Result(data.assign(multiplier_link=("disturbance", ["coupler"])))


@pytest.mark.parametrize(("size", "level", "title"), [
    (0.25, "good", "stable"), (1.0, "warn", "at the limit of stability"), (1.2, "bad", "unstable"),
])  # fmt: skip
def test_stability_by_the_largest_multiplier(result, size, level, title):
    judged = stability(with_multiplier(result, size))
    assert (judged.level, judged.title) == (level, title)
    assert f"{100 * size:.0f} % is left after one cycle (50 Hz in the axes of link coupler" in judged.text


def test_stability_that_was_not_examined_is_a_note(result):
    assert stability(result).level == "note"
    assert verdict([stability(result)]) == ("note", "The computation is accurate: stability not examined.")


@pytest.mark.parametrize(
    ("total", "coarse", "level", "said"),
    [
        (0.0002, 0, "good", "Less than 0.1 % of a member"),
        (0.022, 0, "good", "2 % by the mesh, which more elements lowers"),
        (0.08, 0, "warn", "At most 8 %"),
        (0.08, 1, "bad", "Too large: do not use these numbers."),
    ],
)
def test_errors_by_their_size(result, total, coarse, level, said):
    sources = {"mesh": 0.9 * total, "time": 0.1 * total}
    shares = {f"{prefix}error_estimate": total for prefix in ("", "deflection_", "joint_force_", "drive_effort_")}
    data = changed(result, sources=sources, attributes={"too_coarse": coarse, **shares}).data
    many = data.drop_vars(["strain", "joint_force"]).assign(
        {name: data[name] * 0 for name in ("strain", "joint_force")}  # whose peaks are no longer in doubt
    )
    many.attrs.pop("not_estimated", None)  # poses tell what the theory leaves out with few positions too
    judged = error(Result(many))
    assert judged.level == level
    assert said in judged.text


@pytest.mark.parametrize(
    ("values", "lacking", "said"),
    [
        ({}, "", "by effects left out, which a tolerance below 1 % lowers."),
        ({"damping.ratio": 0.0}, "", "by effects left out, which effects = ['shear'] lowers."),  # takes no tolerance
        ({}, "Give `poisson`", "by effects left out, as shear lacks data. Give `poisson`."),
    ],
)
def test_what_lowers_an_error_is_what_the_scene_lacks(result, values, lacking, said):
    listed = [{"name": "shear", "size": 0.3, "acts": False, "lacking": lacking}]
    scene = result.scene.changed(values).model_dump_json()
    found = changed(result, sources={"time": 0.0, "effects": 0.3}, attributes={"error_estimate": 0.3, "scene": scene})
    assert said in error(Result(found.data.assign_attrs(effects=json.dumps(listed)))).text


def test_no_tolerance_takes_the_vibration_that_a_quasi_static_method_leaves_out(result):
    one = {"lacking": "", "acts": False}
    listed = [
        {"name": "vibration", "size": 3.0, **one},
        {"name": "geometric-stiffness", "size": 5.0, **one},  # large-rotations holds it
        {"name": "shear", "size": 0.3, **one, "lacking": "Give `poisson`"},
        {"name": "large-rotations", "size": 9.0, **one, "acts": True},
    ]
    found = changed(result, sources={"time": 0.0, "effects": 0.3}, attributes={"error_estimate": 0.3})
    text = error(Result(found.data.assign_attrs(effects=json.dumps(listed)))).text
    assert "by effects left out, which analysis.method = 'periodic' lowers." in text


def test_the_worst_reason_is_told_first_and_the_summary_says_the_same(result):
    judged = judgements(result)
    levels = ["bad", "warn", "good", "note"]
    assert [levels.index(j.level) for j in judged] == sorted(levels.index(j.level) for j in judged)
    for details in (False, True):
        text = " ".join(str(summary(result, details)).split())
        assert theory(result).text in text
        assert stability(result).text in text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0, "0"),
        (9.9999, "10.0"),
        (-0.0304, "\N{MINUS SIGN}0.0304"),
        (123456, "123000"),
        (1.5e-5, "1.50e\N{MINUS SIGN}05"),
        (2e6, "2.00e+06"),
        (float("nan"), "\N{EN DASH}"),
        (0.00012345, "0.000123"),
    ],
)
def test_numbers_have_three_digits(value, text):
    assert short(value) == text


def test_words():
    assert share(1e-5) == "less than 0.1 %"
    assert share(0.0217) == "2.2 %"
    assert sentence("the axis of Q") == "The axis of Q"


def test_the_sound_of_a_motion_that_is_not_to_be_used_says_so(result, tmp_path, monkeypatch):
    file = str(result.save(tmp_path / "result.nc"))
    level, said = verdict(judgements(result))
    assert level == "bad"
    assert f"Of the motion itself: {said}" in CliRunner().invoke(app, ["sound", file]).output
    monkeypatch.setattr("fenics_mech.views.judgements.verdict", lambda judged: ("good", said))
    assert said not in CliRunner().invoke(app, ["sound", file]).output
