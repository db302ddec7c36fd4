"""What the program reads back of its own files: points, trials, plans and results that someone else has changed."""

import json
import os

import numpy as np
import pytest
import xarray as xr

from fenics_mech import Result, load, sweep
from fenics_mech._files import csv_text
from fenics_mech.errors import ResultError
from fenics_mech.studies import kept_points
from fenics_mech.studies.design.trial import Trials
from tests.common import DEMOS, analysed

QUASI_STATIC = {"analysis.method": "quasi-static", "analysis.sub_intervals": 12, "analysis.error_estimates": False}
SPEEDS = {"drive.speed": ["100 rpm", "200 rpm"]}
STUDY = {"variables": {"speed": {"numbers": ["drive.speed"], "between": [5, 50]}}, "minimise": ["strain.max"]}


def machine(**changes):
    return load(DEMOS / "four_bar.toml").changed(QUASI_STATIC | changes)


def changed(path, change):
    """Change what a JSON file holds."""
    record = json.loads(path.read_text())
    change(record)
    path.write_text(json.dumps(record))


def pipe(path):
    path.unlink()
    os.mkfifo(path)


def device(path):
    path.unlink()
    path.symlink_to("/dev/zero")


def folder(path):
    path.unlink()
    path.mkdir()


POINTS = {
    "a pipe": pipe,
    "a device": device,
    "a huge file": lambda path: os.truncate(path, 10**12),
    "deep": lambda path: path.write_text("[" * 100_000),
    "deep inside": lambda path: path.write_text('{"values": ' + "[" * 5000),
    "not UTF-8": lambda path: path.write_bytes(b"\xff\xfe{}"),
    "a list": lambda path: path.write_text("[]"),
    "a text for a number": lambda path: changed(path, lambda r: r["values"].update(peak_strain=["large"] * 3)),
    "a number for a text": lambda path: changed(path, lambda r: r.update(message=1)),
    "a text for seconds": lambda path: changed(path, lambda r: r.update(seconds="1")),
    "a strain of 7": lambda path: changed(path, lambda r: r["values"].update(peak_strain=[7.0, 0.1, 0.1])),
    "an infinite stress": lambda path: changed(path, lambda r: r["values"].update(peak_stress=[1e400, 1.0, 1.0])),
    "a negative force": lambda path: changed(path, lambda r: r["values"].update(peak_joint_force=[-1.0] * 4)),
    "too few members": lambda path: changed(path, lambda r: r["values"].update(peak_strain=[1e-4])),
    "rows of two lengths": lambda path: changed(
        path, lambda r: r["values"].update(strain_harmonic=[[1.0], [1.0, 2.0]])
    ),
    "another variable": lambda path: changed(path, lambda r: r["values"].update(secret=[1.0])),
    "another key": lambda path: changed(path, lambda r: r.update(labels={"member": ["=HYPERLINK(1)"]})),
    "a formula for an error": lambda path: changed(path, lambda r: r.update(error="=HYPERLINK(1)")),
    "a long message": lambda path: changed(path, lambda r: r.update(message="x" * 10**6)),
}


@pytest.mark.parametrize("damage", POINTS)
def test_what_is_no_point_of_a_sweep_is_computed_anew(damage, tmp_path):
    whole = sweep(machine(), SPEEDS, tmp_path)
    first = sorted((tmp_path / "points").glob("*.json"))[0]
    POINTS[damage](first)
    again = sweep(machine(), SPEEDS, tmp_path)
    xr.testing.assert_equal(again.data, whole.data)
    assert first.is_file()
    assert not first.is_symlink()


def test_a_point_that_is_whole_is_believed(tmp_path):
    """The folder is the user's own: SECURITY.md says so."""
    sweep(machine(), SPEEDS, tmp_path)
    for path in (tmp_path / "points").glob("*.json"):
        changed(path, lambda r: r["values"].update(peak_strain=[0.125] * 3))
    assert (sweep(machine(), SPEEDS, tmp_path).data["peak_strain"] == 0.125).all()


@pytest.mark.parametrize(
    "damage",
    [
        pipe,
        lambda path: path.write_text("[" * 100_000),
        lambda path: changed(path, lambda plan: plan["values"].update({"drive.speed": ["fast"]})),
        lambda path: changed(path, lambda plan: plan["values"].update({"drive.speed": []})),
        lambda path: changed(path, lambda plan: plan["values"].update({"drive.speed": 1})),
        lambda path: changed(path, lambda plan: plan.update(gauge=1)),
    ],
)
def test_what_is_no_plan_of_a_sweep_is_one_message(damage, tmp_path):
    sweep(machine(), SPEEDS, tmp_path)
    damage(tmp_path / "sweep.json")
    with pytest.raises(ResultError, match="cannot be used for a sweep: it"):
        sweep(machine(), SPEEDS, tmp_path)


TRIALS = {
    "a pipe": pipe,
    "a folder": folder,
    "deep": lambda path: path.write_text("[" * 100_000),
    "a text for a number": lambda path: changed(path, lambda r: r["numbers"].update({"strain.max": "large"})),
    "a strain of 7": lambda path: changed(path, lambda r: r["numbers"].update({"strain.max": 7.0})),
    "no number": lambda path: changed(path, lambda r: r["numbers"].update({"strain.max": 1e400})),
    "another number": lambda path: changed(path, lambda r: r["numbers"].update({"mass": 1.0})),
    "other values": lambda path: changed(path, lambda r: r.update(values=[11.0])),
    "a formula for an error": lambda path: changed(path, lambda r: r.update(error="=HYPERLINK(1)")),
}


@pytest.mark.parametrize("damage", [one for one in TRIALS if one != "a folder"])
def test_what_is_no_trial_is_run_anew(damage, tmp_path):
    trials = Trials.of(machine(study=STUDY), folder=tmp_path)
    (whole,) = trials.run([[10.0]])
    (path,) = tmp_path.glob("*.json")
    TRIALS[damage](path)
    (again,) = trials.run([[10.0]])
    assert again.numbers == whole.numbers
    assert again.numbers["strain.max"] < 1
    assert path.is_file()


def test_a_folder_in_the_place_of_a_trial_is_one_message(tmp_path):
    trials = Trials.of(machine(study=STUDY), folder=tmp_path)
    trials.run([[10.0]])
    (path,) = tmp_path.glob("*.json")
    folder(path)
    with pytest.raises(ResultError, match="cannot be written"):
        trials.run([[10.0]])


def test_what_would_not_be_read_is_no_answer_of_a_point(tmp_path, monkeypatch):
    monkeypatch.setitem(kept_points.MOST, "peak_strain", 1e-6)
    found = sweep(machine(), SPEEDS, tmp_path).data
    assert (found["error"] == "SolverError").all()
    assert "no answer that can be kept: peak_strain has values from" in str(found["message"].values[0])


def labelled(name, change):
    return lambda data: data.assign_coords({name: change([str(label) for label in data[name].values])})


STRANGE = {
    "a formula": (labelled("member", lambda names: ["=HYPERLINK(1)", *names[1:]]), "is no 'member' of its scene"),
    "another joint": (labelled("joint", lambda names: ["Z", *names[1:]]), "'Z' is no 'joint' of its scene"),
    "one member twice": (
        labelled("member", lambda names: [names[0]] * len(names)),
        "two labels of 'member' are the sam",
    ),
    "another fibre": (labelled("fibre", lambda names: ["+", "=1+1"]), "'=1.1' is no 'fibre' of its scene"),
    "numbers for members": (lambda data: data.assign_coords(member=[1, 2, 3]), "labels of member are texts"),
    "no number in strains": (lambda data: data.assign(strain=data["strain"] * np.nan), "strain has no number everywhe"),
    "a number for effects": (lambda data: data.assign_attrs(effects=1), "its attribute effects is no text"),
    "other effects": (lambda data: data.assign_attrs(effects='["x"]'), "its attribute effects is none that"),
    "deep warnings": (lambda data: data.assign_attrs(warnings="[" * 50_000), "its attribute warnings is none that"),
    "a text for a number": (lambda data: data.assign_attrs(dofs="many"), "its attribute dofs is no number"),
    "a path for a name": (lambda data: data.rename(strain="../strain"), "is no name of a variable"),
    "no scene": (lambda data: data.assign_attrs(scene="{}"), "of its scene"),
}


@pytest.mark.parametrize("damage", STRANGE)
def test_a_result_of_what_its_scene_does_not_have_is_refused(damage, tmp_path):
    change, message = STRANGE[damage]
    whole = analysed(machine())
    assert Result.load(whole.save(tmp_path / "whole.nc")).data.equals(whole.data)
    with pytest.raises(ResultError, match=message):
        Result.load(Result(change(whole.data)).save(tmp_path / "result.nc"))


@pytest.mark.parametrize(
    ("cell", "written"),
    [
        ("=HYPERLINK(1)", "'=HYPERLINK(1)"),
        ("+1+1", "'+1+1"),
        ("-1+cmd", "'-1+cmd"),
        ("@SUM(1)", "'@SUM(1)"),
        ("\tx", "'\tx"),
        ("coupler", "coupler"),
        ("+", "+"),
        ("-", "-"),
        (-1.5, "-1.5"),
        ("-1.5e-3", "-1.5e-3"),
    ],
)
def test_texts_in_tables_are_no_formulas_and_numbers_stay(cell, written):
    assert csv_text([[cell, 1]]) == f"{written},1\n"
