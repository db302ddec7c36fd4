"""Each notebook of the documents runs from top to bottom, and shows scene, result and plots."""

import os
import re

import pytest

from tests.common import ROOT
from tests.documents import DOCS

NOTEBOOKS = DOCS / "notebooks"


@pytest.fixture
def run(monkeypatch):
    """Give what runs a notebook, and says what its cells show, by kind."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))

    def shown(name):
        notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
        assert not any(cell.get("outputs") for cell in notebook.cells), "a notebook is kept without outputs"
        place = {"metadata": {"path": str(NOTEBOOKS)}}
        nbclient.NotebookClient(notebook, timeout=300, resources=place).execute()  # raises where a cell does
        outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
        found = {kind: [output.get("data", {}).get(kind, "") for output in outputs] for kind in KINDS}
        found["printed"] = [output.get("text", "") for output in outputs]
        return {kind: [one for one in texts if one] for kind, texts in found.items()}

    return shown


KINDS = "text/html", "text/plain", "image/png"


def test_every_notebook_is_run_by_a_test():
    assert {path.stem for path in NOTEBOOKS.glob("*.ipynb")} == {"four_bar", "coupler_curve", "which_speed"}


@pytest.mark.slow
def test_a_coupler_curve_of_a_linkage_stated_in_python(run):
    shown = run("coupler_curve")
    assert "Peak stress" in shown["text/html"][0]
    assert len(shown["image/png"]) == 3  # model, path and shaking force
    printed = "".join(shown["printed"])
    assert re.search(r"P is up to 4\d µm off its path", printed)
    assert "coupler_curve.html" in printed
    assert re.search(r"crank\s+11\.0\n", shown["text/plain"][-1])  # MPa


@pytest.mark.slow
def test_speeds_to_avoid(run):
    shown = run("which_speed")
    assert shown["printed"] == ["36 speeds, 0 without an answer\n"]
    assert len(shown["image/png"]) == 2
    shares = [float(line.split()[1]) for line in shown["text/plain"][-1].splitlines()[1:6]]
    assert sum(shares) == pytest.approx(1, abs=0.05)
    assert shares[:3] == sorted(shares[:3], reverse=True)


@pytest.mark.slow
def test_notebook_shows_scene_result_and_plots(run):
    shown = run("four_bar")
    scene, result = shown["text/html"]
    assert "seed four-bar" in scene
    assert "transmission angle at joint B" in scene
    assert "Peak stress 53.0 MPa in crank" in result
    assert "The computation is accurate" in result
    assert len(shown["image/png"]) == 2
    assert "".join(shown["printed"]).split("\n")[0] == "35.9 N"
