"""Scenes as scripts for Exudyn: what stands in them, and that Exudyn agrees with them."""

import ast
import csv
import importlib.util
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from fenics_mech import analyse, load
from fenics_mech.cli import app
from fenics_mech.errors import SceneError
from fenics_mech.other_programs.beam_linkage import with_material_damping
from fenics_mech.other_programs.exudyn_script import exudyn_script
from fenics_mech.scene.meshing import with_elements
from tests.common import DEMOS

FINE = {"sub_intervals": 480, "stages": 3, "solver": "collocation", "reduction": "none", "stations": 3}


def assigned(text):
    """The plain numbers of a script, by name."""
    tables = [node for node in ast.parse(text).body if isinstance(node, ast.Assign)]
    found = {}
    for node in tables[:9]:
        found[node.targets[0].id] = ast.literal_eval(node.value)
    return found


def test_a_script_holds_the_machine_in_plain_numbers():
    found = assigned(exudyn_script(load(DEMOS / "slider_crank.toml")))
    crank, rod = found["BEAMS"]
    assert crank["ends"][1] == pytest.approx(rod["ends"][0])
    speed = np.hypot(*crank["velocities"][1])
    assert speed == pytest.approx(abs(found["SPEED"]) * np.hypot(*np.subtract(*crank["ends"])))
    assert found["PINS"] == [((0, -1), (1, 0))]
    assert found["SUPPORTS"] == [(0, 0)]
    assert [end for end, _ in found["GUIDES"]] == [(1, -1)]
    assert found["RETARDATION"] > 0


@pytest.mark.parametrize("name", ['""" or [] #', '"""; import os', "\\", 'ends with "', "{0}"])
def test_a_name_from_a_stranger_stays_a_text(name):
    scene = load(DEMOS / "slider_crank.toml").model_copy(update={"name": name})
    tree = ast.parse(exudyn_script(scene))
    names = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert names == {"csv", "math", "sys", "exudyn", "numpy"}
    assert ast.get_docstring(tree)


def test_what_a_script_has_no_words_for_is_refused(tmp_path):
    scene = load(DEMOS / "slider_crank.toml").changed(gravity=(0, -9.81))
    with pytest.raises(SceneError, match="gravity: other programs are given no gravity"):
        exudyn_script(scene)
    done = CliRunner().invoke(app, ["export", str(DEMOS / "quick_return.toml"), str(tmp_path / "no.py")])
    assert isinstance(done.exception, SceneError)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "stephenson"])
def test_exudyn_agrees_with_its_script(name, tmp_path):
    """To 0.1 % of each fibre's peak over the cycle; the four-bar is near a resonance."""
    if importlib.util.find_spec("exudyn") is None:
        pytest.skip("Exudyn is not installed")
    script, table = tmp_path / "model.py", tmp_path / "strain.csv"
    done = CliRunner().invoke(app, ["export", str(DEMOS / f"{name}.toml"), str(script)])
    assert done.exit_code == 0, done.output
    subprocess.run([sys.executable, script, table], check=True, timeout=600, capture_output=True)
    with table.open(newline="") as file:
        head, *rows = csv.reader(file)
    scene = with_material_damping(load(DEMOS / f"{name}.toml"))
    scene = scene.changed(effects=("coupling", "large-rotations"), tolerance=None, analysis=FINE)
    strain = analyse(with_elements(scene, 8)).data["strain"].sel(s=0.5)
    for label, theirs in zip(head[1:], np.array(rows, dtype=float)[:, 1:].T):
        member, fibre = label.rsplit(" ", 1)
        ours = strain.sel(member=member, fibre=fibre).to_numpy()[::4]
        assert np.abs(ours - theirs).max() < 2e-3 * np.abs(ours).max()
