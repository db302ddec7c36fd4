"""What the README shows runs, and its scene file is one."""

import re
import tomllib

import numpy as np
import pytest

from fenics_mech import Result, analyse
from fenics_mech.scene.build import build
from tests.common import ROOT

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


def test_scotch_yoke_is_pushed_by_its_inertia_and_bent_by_the_pin_beside_its_axis():
    scene = build(tomllib.loads(blocks("toml")[1])).changed(analysis__method="quasi-static", analysis__sub_intervals=24)
    data = analyse(scene).data
    force = 7800 * 0.015 * 0.0085 * 0.25 * 0.05 * (2 * np.pi * 10) ** 2 * np.cos(data["theta"])
    assert data["joint_force"].sel(joint="A", component="x").to_numpy() == pytest.approx(force.to_numpy(), abs=1e-9)
    moment = force * 0.05 * np.sin(data["theta"])  # about the axis, by which the pin is off it
    strain = data["strain"].sel(member="yoke", s=1, fibre=["+", "-"])
    bending = (strain[:, 0] - strain[:, 1]) / 2
    assert np.abs(bending).to_numpy() == pytest.approx(
        np.abs(moment) * 0.0025 / (207e9 * 0.015 * 0.005**3 / 12), abs=1e-9
    )
