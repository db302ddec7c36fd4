"""A scene that is written and read again is the same scene."""

from pathlib import Path

import pytest

import fenics_mech as fm
from fenics_mech.scene.files import load, parse
from fenics_mech.scene.writing import scene_text, write_scene
from tests.common import DEMOS

OTHERS = "plugin", "space"  # folders of scenes that need a package, or are in space
SCENES = sorted(path.relative_to(DEMOS) for path in DEMOS.rglob("*.toml") if path.parent.name not in OTHERS)


@pytest.mark.parametrize("name", SCENES, ids=str)
def test_what_is_written_is_read_as_the_same_scene(name):
    scene = load(DEMOS / name)
    assert parse(scene_text(scene)) == scene


def test_defaults_are_left_out_and_comments_stand_first(tmp_path):
    text = write_scene(load(DEMOS / "four_bar.toml"), tmp_path / "copy.toml", "made\nby a test").read_text()
    assert text.startswith("# made\n# by a test\nname = ")
    assert "allow_coarse" not in text
    assert "petsc" not in text


def test_measurements_are_found_from_the_folder_of_the_file(tmp_path):
    scene = load(DEMOS / "four_bar.toml").changed(measurements=[{"file": "gauge.csv", "member": "coupler"}])
    (tmp_path / "below").mkdir()
    again = load(write_scene(scene, tmp_path / "below" / "copy.toml"))
    assert again.measurements[0].file.resolve() == Path("gauge.csv").resolve()


def test_a_file_that_cannot_be_written_is_said(tmp_path):
    with pytest.raises(fm.ResultError, match="cannot be written"):
        write_scene(load(DEMOS / "four_bar.toml"), tmp_path / "no" / "copy.toml")
