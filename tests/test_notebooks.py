"""Each notebook of the documents runs from top to bottom, and shows scene, result and plots."""

import os
from pathlib import Path

import pytest

from tests.common import ROOT
from tests.documents import DOCS

NOTEBOOKS = sorted((DOCS / "notebooks").glob("*.ipynb"))


@pytest.fixture(params=NOTEBOOKS, ids=lambda path: path.stem)
def shown(request, monkeypatch):
    """What the cells of a notebook show, by kind."""
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    pytest.importorskip("ipykernel")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]))
    notebook = nbformat.read(request.param, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells), "a notebook is kept without outputs"
    place = {"metadata": {"path": str(Path(request.param).parent)}}
    nbclient.NotebookClient(notebook, timeout=300, resources=place).execute()  # raises where a cell does
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    shown = {"html": [], "png": [], "printed": []}
    for output in outputs:
        shown["html"].append(output.get("data", {}).get("text/html", ""))
        shown["png"].append(output.get("data", {}).get("image/png", ""))
        shown["printed"].append(output.get("text", ""))
    return {kind: [one for one in found if one] for kind, found in shown.items()}


@pytest.mark.slow
def test_notebook_shows_scene_result_and_plots(shown):
    scene, result = shown["html"]
    assert "seed four-bar" in scene
    assert "transmission angle at joint B" in scene
    assert "Peak stress 52.9 MPa in crank" in result
    assert "The numbers can be used" in result
    assert len(shown["png"]) == 2
    assert "".join(shown["printed"]).split("\n")[0] == "35.9 N"
