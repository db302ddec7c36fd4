"""What the points of a sweep have in common: effects, mesh and steps, chosen once for all or told where they change."""

import json

import pytest

from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.studies.one_equation import MOST_TIMES, OneEquation, union
from fenics_mech.studies.sweep import sweep
from fenics_mech.studies.sweep_axes import parse_axes, stated_data


def record(effects="coupling, vibration", error="", **numbers):
    return {"effects": effects, "error": error, "numbers": json.dumps(numbers) if numbers else ""}


def test_what_one_point_needs_is_taken_for_all():
    """Three elements of a mesh that nobody states are the usual ones; points that failed need nothing."""
    scene = seed_four_bar(effects="auto")
    records = [
        record(),
        record(elements=5),
        record("coupling, large-rotations, vibration"),
        record(error="SolverError"),
    ]
    one = OneEquation.of(scene, records)
    assert dict(one.numbers) == {"elements": 5}
    assert set(one.effects) == {"coupling", "large-rotations"}  # vibration acts by the method
    assert [one.lacks(known) for known in records] == [True, True, True, False]
    data = one.scene(stated_data(scene))
    assert data["mesh"] == {"elements": 5}
    assert data["effects"] == list(one.effects)
    whole = record("coupling, large-rotations, vibration", elements=5)
    assert not one.lacks(whole)
    assert OneEquation.of(scene, [whole, whole]) is None


def test_far_finer_meshes_of_few_points_stay_theirs():
    scene = seed_four_bar()
    assert OneEquation.of(scene, [record(), record(elements=int(3 * MOST_TIMES) + 1)]) is None
    assert OneEquation.of(seed_four_bar(mesh={"elements": 3}), [record(), record(elements=4)]) is None  # it is stated


def test_effects_that_others_hold_are_left_out():
    """Large rotations hold the stiffening by axial forces."""
    assert "geometric-stiffness" not in union({"coupling, geometric-stiffness", "coupling, large-rotations"})


def test_what_a_scene_states_by_itself_is_not_listed():
    """Loads and vibration act by what the scene states: a list that names them is refused where it does not."""
    assert union({"coupling, loads, vibration", "coupling, large-rotations, vibration"}) == (
        "coupling",
        "large-rotations",
    )
    one = OneEquation.of(
        seed_four_bar(effects="auto"), [record(), record("coupling, large-rotations, loads, vibration")]
    )
    assert not one.lacks(record("coupling, large-rotations, vibration"))


@pytest.mark.slow
def test_a_tolerance_has_one_equation_too(tmp_path):
    """Strains are exact at all points, and none may go without estimates."""
    scene = seed_four_bar(effects="auto", tolerance=0.01)
    found = sweep(scene, parse_axes(scene, ["drive.speed=40 rpm:200 rpm:2"]), tmp_path)
    assert set(found.data["effects"].to_numpy()) == {"coupling, large-rotations, rotary-inertia, vibration"}
    assert (found.data["error"] == "").all()
