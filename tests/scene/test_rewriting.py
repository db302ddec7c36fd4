"""Scene files with other values: comments and units stay, and nothing but the values changes."""

import tomllib

import pytest

from fenics_mech.scene import load
from fenics_mech.scene.rewriting import rewritten, write_like
from tests.common import DEMOS

SEED = (DEMOS / "four_bar.toml").read_text()


@pytest.mark.parametrize(
    ("path", "value", "line"),
    [
        ("sections.strip.area", 0.5e-4, 'area = "0.5 cm^2"\n'),  # stated thrice in the file, in other units too
        ("materials.aluminium.modulus", 69.5e9, 'modulus = "69.5 GPa"\n'),
        ("links.crank.points.A.0", 0.127, 'points = { O = [0, 0], A = ["5 in", 0] }\n'),
        ("masses.B.mass", 0.03, 'B = { at = "follower.B", mass = "30 g" }\n'),
        ("damping.ratio", 0.0225, "ratio = 0.0225\n"),  # has no unit in the file
        ("links.crank.members.OA.section", "strip", 'members.OA = { ends = ["O", "A"], section = "strip", material'),
    ],
)
def test_a_value_is_exchanged_in_its_unit_and_the_rest_stays(path, value, line):
    found = rewritten(SEED, {path: value})
    assert line in found
    changed = [(a, b) for a, b in zip(SEED.splitlines(), found.splitlines(), strict=True) if a != b]
    assert len(changed) == 1


def test_what_the_file_does_not_state_is_added():
    found = rewritten(SEED, {"masses.A.inertia": 1e-5, "drive.speed": 30.0})
    assert tomllib.loads(found)["masses"]["A"] == {"at": "crank.A", "mass": "45.2 g", "inertia": 1e-5}
    assert 'speed = "30 rad/s"' in found


def test_a_file_that_has_changed_meanwhile_is_not_taken(tmp_path):
    (file := tmp_path / "seed.toml").write_text(SEED)
    scene = load(file).changed({"damping.ratio": 0.03})
    for text in (SEED.replace("32.3 rad/s", "132.3 rad/s"), "no TOML ["):
        file.write_text(text)
        assert load(write_like(file, {"damping.ratio": 0.03}, scene, tmp_path / "best.toml")) == scene


def test_the_name_and_the_files_of_measurements_are_those_of_the_scene(tmp_path):
    (tmp_path / "gauge.csv").write_text("angle_deg,strain\n0,1e-6\n90,2e-6\n")
    data = '[[measurements]]\nfile = "gauge.csv"\nmember = "coupler"\n'
    text = SEED.replace('name = "seed four-bar"\n', "") + data
    (file := tmp_path / "seed.toml").write_text(text)
    (tmp_path / "out").mkdir()
    scene = load(file).changed({"damping.ratio": 0.03})
    again = load(write_like(file, {"damping.ratio": 0.03}, scene, tmp_path / "out" / "best.toml"))
    assert (again.name, again.damping.ratio) == ("seed", 0.03)
    assert again.measurements[0].file.resolve() == tmp_path / "gauge.csv"
    assert again.model_copy(update={"measurements": ()}) == scene.model_copy(update={"measurements": ()})
