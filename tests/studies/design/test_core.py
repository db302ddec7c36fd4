"""Variables, numbers of results, and trials of a study."""

import math

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.errors import ResultError, SceneError
from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.result_numbers import Quantity, total_mass
from fenics_mech.studies.design.trial import Trials, kept_folder
from fenics_mech.studies.worker_processes import Workers

SPEED = {"numbers": ["drive.speed"], "between": ["100 rpm", "500 rpm"]}
QUICK = {"analysis.method": "quasi-static", "analysis.sub_intervals": 36, "effects": ()}


def scene_of(variables, **study):
    scene = fm.load("demos/four_bar.toml").changed(QUICK)
    return scene.changed(study={"variables": variables, **study})


def test_several_numbers_follow_one_variable():
    tied = {"number": "sections.strip.inertia", "factor": 2.0, "power": 3}
    design = Design.of(scene_of({"h": {"numbers": ["sections.strip.fibre", tied], "between": ["0.5 mm", "2 mm"]}}))
    scene = design.at([1e-3])
    assert design.start == [0.8e-3]
    assert (scene.sections["strip"].fibre, scene.sections["strip"].inertia) == (1e-3, pytest.approx(2e-9))


def test_a_choice_takes_a_whole_part():
    choice = {"numbers": ["links.coupler.members.AB.section"], "choices": ["strip", "crank"]}
    design = Design.of(scene_of({"section": choice}))
    assert design.bounds == [(0.0, 1.0)]
    assert design.at([0.9]).links["coupler"].members["AB"].section == "crank"
    assert design.shown([1.0]) == {"section": "crank"}


BAD = [
    ({"numbers": ["drive.sped"], "between": [1, 2]}, "no such number. Did you mean drive.speed"),
    ({"numbers": ["drive.speed"], "between": ["500 rpm", "100 rpm"]}, "is not below the upper bound"),
    ({"numbers": ["drive.speed"], "between": [1, 2]}, "outside of its bounds"),
    ({"numbers": ["drive.speed"], "between": ["1 kg", "2 kg"]}, "wrong unit"),
    ({"numbers": ["name"], "between": [1, 2]}, "must be a string"),
    ({"numbers": ["drive.speed"], "between": [30, 30]}, "the range '[30.0, 30.0]' begins where it ends"),
    ({"numbers": ["drive.speed"], "between": ["100 rpm", 30]}, "one end of '[100 rpm, 30.0]' has a unit"),
    ({"numbers": ["drive.speed"]}, "either `between`"),
    ({"numbers": ["drive.speed"], "between": [1, 2], "bounds": 3}, "unknown key 'bounds'"),
    ({"numbers": ["links.coupler.members.AB.section"], "choices": ["strip", "beam"]}, "beam"),
]


@pytest.mark.parametrize(("variable", "said"), BAD, ids=[said for _, said in BAD])
def test_a_bad_variable_is_one_message_with_its_place(variable, said):
    with pytest.raises(SceneError, match=r"study\.variables\.x") as caught:
        Design.of(scene_of({"x": variable}))
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("strian.max", "Did you mean strain"),
        ("strain.maxx", "Did you mean strain.max"),
        ("strain[cupler].max", "Did you mean coupler"),
        ("mass[cupler]", "no such link"),
        ("mass.max", "It is one number: leave .max out"),
        ("strain[coupler][@2][+].max", "'@2' is no place from 0 to 1 along a member"),
        ("strain", "numbers. Write strain.max"),
        ("tracer_error[P].rms", "names no target"),
        ("a b", "cannot read"),
    ],
)
def test_an_unknown_number_ends_the_study_with_names_near_to_it(name, said):
    with pytest.raises(SceneError, match="study") as caught:
        Trials.of(scene_of({"speed": SPEED}, minimise=[name, "strain.max"])).run([[20.0]])
    assert said in str(caught.value)


def test_numbers_are_those_of_the_result():
    scene = scene_of({"speed": SPEED})
    data = fm.analyse(scene.changed({"analysis.sub_intervals": 180})).data
    names = [
        "strain[coupler][@0.5][+].range",
        "shaking_force.rms",
        "frequency[1].min",
        "torque.mean",
        "joint_force[A].max",
    ]
    result = fm.Result(data)
    found = {name: Quantity.read(name).of(result) for name in names if name.split("[")[0] != "frequency"}
    wave = result.strain_at("coupler", s=0.5)
    shaking = data["shaking_force"].transpose("theta", "component").to_numpy()
    beyond = 1e-3  # of what 180 positions show, as peaks are between them
    assert 1 <= found["strain[coupler][@0.5][+].range"] / np.ptp(wave) < 1 + beyond
    assert found["shaking_force.rms"] == pytest.approx(math.sqrt((shaking**2).sum(axis=1).mean()))
    assert Quantity.read("noise").of(result) == fm.sound(result).attrs["weighted_level"]
    assert found["torque.mean"] == pytest.approx(float(data["input_torque"].mean()))
    force = data["joint_force"].sel(joint="A").transpose("theta", "component").to_numpy()
    assert 1 <= found["joint_force[A].max"] / np.linalg.norm(force, axis=1).max() < 1 + beyond


def test_mass_is_that_of_strips_and_bearings():
    scene = fm.load("demos/four_bar.toml")
    lengths = 1.07e-4 * 4.25 + 0.406e-4 * (11 + 10.65)  # area times inch
    assert total_mass(scene) == pytest.approx(2714 * 0.0254 * lengths + 0.0452 + 0.03755, rel=1e-12)


def test_a_trial_without_the_multipliers_that_are_asked_for_is_a_value():
    few = {"analysis.method": "periodic", "analysis.sub_intervals": 12, "analysis.stages": 1, "effects": ("coupling",)}
    scene = scene_of({"speed": SPEED}, maximise=["stability.margin"]).changed(few)
    (trial,) = Trials.of(scene).run([[5.0]])
    assert "all vibrations are too fast for these sub_intervals" in trial.message
    many = scene.changed({"analysis.sub_intervals": 60, "analysis.stages": 3})
    (trial,) = Trials.of(many, ["growth_rate[77].max"]).run([[30.0]])
    assert "multipliers: those that its sub_intervals can follow" in trial.message
    with pytest.raises(SceneError, match="stability was not judged"):
        Trials.of(scene_of({"speed": SPEED}), ["stability.margin"]).run([[30.0]])


def test_a_failed_trial_is_a_value(tmp_path):
    ground = {"numbers": ["ground.points.C.0"], "between": ["9 in", "30 in"]}
    trials = Trials.of(scene_of({"ground": ground}, minimise=["strain.max"]), folder=tmp_path)
    good, bad = trials.run([[0.254], [0.7]])
    assert not good.failed
    assert bad.error == "AssemblyError"
    assert math.isnan(bad.numbers["strain.max"])
    assert trials.run([[0.254], [0.7]]) == [good, bad]  # their seconds too: read from the folder


def test_processes_give_the_same_as_one(tmp_path):
    scene = scene_of({"speed": SPEED}, minimise=["strain.max"])
    points = [[20.0], [30.0]]
    alone = [trial.numbers for trial in Trials.of(scene).run(points)]
    with Workers(2) as workers:
        shared = Trials.of(scene, folder=tmp_path, workers=workers).run(points)
    assert [trial.numbers for trial in shared] == alone


def test_a_tracer_is_as_far_from_its_target_as_that_is_moved():
    scene = scene_of({"speed": SPEED}).changed({"analysis.sub_intervals": 180, "materials.aluminium.modulus": 1e16})
    radius = 4.25 * 0.0254
    angles = np.linspace(0, 5, 7)
    circle = [(1.1 * radius * math.cos(a), 1.1 * radius * math.sin(a)) for a in angles]
    targets = {
        "P": {"point": "crank.A", "path": circle, "angles": list(angles)},
        "Q": {"point": "crank.A", "path": circle},
    }
    trials = Trials.of(scene.changed({"study.targets": targets}), ["tracer_error[P].rms", "tracer_error[Q].max"])
    (trial,) = trials.run([trials.design.start])
    assert trial.numbers["tracer_error[P].rms"] == pytest.approx(0.1 * radius, rel=1e-5)
    assert trial.numbers["tracer_error[Q].max"] == pytest.approx(0.1 * radius, rel=2e-3)  # a polygon of 180 corners


def test_a_folder_has_one_study_at_a_time_and_none_that_is_empty(tmp_path):
    folder = tmp_path / "of" / "mine" / "out"
    busy = pytest.raises(ResultError, match="another study works in this folder")
    with kept_folder(folder), busy, kept_folder(folder):
        pytest.fail("two studies work in one folder")
    assert not list(tmp_path.iterdir())
    with kept_folder(folder) as kept:  # it is free again
        (kept / "trial.json").write_text("{}")
    assert folder.exists()


def test_a_folder_that_cannot_be_read_is_refused_as_others_in_it_are_not_seen(tmp_path, monkeypatch):
    def refuse(folder):
        raise PermissionError(13, "Permission denied", str(folder))

    monkeypatch.setattr("fenics_mech.studies.design.trial.os.scandir", refuse)  # as the superuser reads all
    with (
        pytest.raises(ResultError, match="out: cannot be used for trials: Permission denied"),
        kept_folder(tmp_path / "out"),
    ):
        pytest.fail("a study works in it")


@pytest.mark.parametrize(
    "text", ["", "[1]", '{"numbers": 3', '{"numbers": {}, "error": "", "message": "", "seconds": 0}']
)
def test_a_trial_whose_file_was_spoilt_is_run_again(text, tmp_path):
    trials = Trials.of(scene_of({"speed": SPEED}, minimise=["mass"]), folder=tmp_path)
    before = trials.run([[20.0]])[0].numbers
    (file,) = tmp_path.iterdir()
    file.write_text(text.replace('"seconds": 0', '"seconds": 0, "again": false'))
    assert trials.run([[20.0]])[0].numbers == before
