"""What the README shows runs, and its scene file is one."""

import re
import tomllib
from pathlib import Path

import numpy as np

from fenics_mech import Result
from fenics_mech.scene.build import build

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text()


def blocks(language):
    return re.findall(rf"```{language}\n(.*?)```", README, flags=re.DOTALL)


def test_python_block_runs(tmp_path, monkeypatch):
    (tmp_path / "demos").symlink_to(ROOT / "demos")
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(blocks("python")[0], names)
    saved = Result.load(tmp_path / "result.nc")
    assert saved.scene.analysis.modes == 8
    assert np.array_equal(saved.data["strain"], names["result"].data["strain"])


def test_scene_block_together_with_the_demo_is_a_scene(demo_text):
    demo, shown = tomllib.loads(demo_text), tomllib.loads(blocks("toml")[0])
    for table, content in shown.items():
        demo[table] = demo.get(table, {}) | content if isinstance(content, dict) else content
    scene = build(demo)
    assert scene.loads["press"].force == (5.0, 0.0)
    assert scene.petsc == {"periodic_ksp_type": "gmres"}
    assert scene.measurements[0].member == "coupler"
