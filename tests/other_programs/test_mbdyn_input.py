"""Scenes as input files of MBDyn: what stands in them, and that MBDyn agrees with them."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from typer.testing import CliRunner

from fenics_mech import analyse, load
from fenics_mech.cli import app
from fenics_mech.errors import SceneError
from fenics_mech.other_programs.beam_linkage import beam_linkage, exported_linkage, with_material_damping
from fenics_mech.other_programs.mbdyn_input import ANGLES, ELEMENTS, mbdyn_input
from fenics_mech.scene.meshing import with_elements
from tests.common import DEMOS
from tests.other_programs.test_exudyn_script import FINE


def lines_of(text, kind):
    """The items of one kind, each as a list of its words."""
    return [re.split(r"[:,;]\s*", line.strip()) for line in text.splitlines() if line.strip().startswith(f"{kind}:")]


def middle_strain(table, linkage):
    """Strains at mid-span over the last cycle, ``(angles, beams, 2)``, from forces and moments of the elements."""
    found, half = [], ELEMENTS // 2
    near, far = 1 - 3**-0.5, 1 + 3**-0.5
    decay = 1 + 2j * np.pi * np.fft.fftfreq(ANGLES, linkage.period / ANGLES) * linkage.retardation
    for number, beam in enumerate(linkage.beams):
        before, after = (table[table[:, 0] == 100 * (number + 1) + half + one][-ANGLES - 1 : -1] for one in (0, 1))
        inner, outer = before[:, 7:] + after[:, 1:7], before[:, 1:7] + after[:, 7:]
        force = (far**2 * inner - near**2 * outer) / (far**2 - near**2) / 2  # the even polynomial through the four
        elastic = np.fft.ifft(np.fft.fft(force, axis=0) / decay[:, None], axis=0).real
        found.append(elastic[:, :1] / beam.axial - elastic[:, 5:] / beam.bending * beam.fibres)
    return np.stack(found, axis=1)


def test_the_file_holds_the_machine():
    scene = load(DEMOS / "slider_crank.toml")
    linkage, text = exported_linkage(scene), mbdyn_input(scene)
    nodes, bodies, beams, joints = (lines_of(text, kind) for kind in ("structural", "body", "beam3", "joint"))
    stated = dict(re.findall(r"    (structural nodes|rigid bodies|beams|joints): (\d+);", text))
    assert [int(number) for number in stated.values()] == [len(nodes), len(bodies), len(beams), len(joints)]
    masses = sum(float(line[3]) for line in bodies)
    theirs = sum(beam.line_density * beam.length for beam in linkage.beams) + sum(mass for _, mass in linkage.masses)
    assert masses == pytest.approx(theirs, rel=1e-12)
    assert [line[2] for line in joints] == ["clamp", "revolute hinge", "axial rotation", "total pin joint"]
    assert float(joints[2][-2]) == linkage.speed


@pytest.mark.parametrize("name", ['"; end: data;', "# /* ", "${PATH}", "{0} é"])
def test_a_name_from_a_stranger_stays_a_comment(name):
    scene = load(DEMOS / "slider_crank.toml")
    named = mbdyn_input(scene.model_copy(update={"name": name})).splitlines()
    assert named[0].startswith("# ")
    assert named[1:] == mbdyn_input(scene).splitlines()[1:]


def test_what_a_file_has_no_words_for_is_refused(tmp_path):
    scene = load(DEMOS / "slider_crank.toml")
    with pytest.raises(SceneError, match="gravity: other programs are given no gravity"):
        mbdyn_input(scene.changed(gravity=(0, -9.81)))
    with pytest.raises(SceneError, match="damping: without damping"):
        mbdyn_input(scene.changed(damping={}))
    with pytest.raises(SceneError, match="damping: with so little damping MBDyn would need"):
        mbdyn_input(scene.changed(damping={"ratio": 1e-4}))
    done = CliRunner().invoke(app, ["export", str(DEMOS / "quick_return.toml"), str(tmp_path / "no.mbd")])
    assert isinstance(done.exception, SceneError)
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "stephenson"])
def test_mbdyn_agrees_with_its_file(name, tmp_path):
    """To 1 % of each fibre's peak over the cycle; the four-bar is near a resonance."""
    if shutil.which("mbdyn") is None:
        pytest.skip("MBDyn is not installed")
    model = tmp_path / "model.mbd"
    done = CliRunner().invoke(app, ["export", str(DEMOS / f"{name}.toml"), str(model)])
    assert done.exit_code == 0, done.output
    command = ["mbdyn", "-s", "-f", model, "-o", tmp_path / "model"]
    subprocess.run(command, check=True, timeout=1800, capture_output=True)
    scene = with_material_damping(load(DEMOS / f"{name}.toml"))
    theirs = middle_strain(np.loadtxt(tmp_path / "model.act"), beam_linkage(scene))
    scene = scene.changed(effects=("coupling", "large-rotations"), tolerance=None, analysis=FINE)
    strain = analyse(with_elements(scene, 8)).data["strain"].sel(s=0.5)
    ours = strain.transpose("theta", "member", "fibre").to_numpy()[::4]
    assert np.all(np.abs(ours - theirs).max(axis=0) < 1e-2 * np.abs(ours).max(axis=0))
