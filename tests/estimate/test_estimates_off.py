"""Analyses whose errors are not estimated: the same answer, less work, and nobody is told a wrong certainty."""

from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from fenics_mech import analyse, summary
from fenics_mech.errors import SceneError
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.studies.follow import follow
from tests.common import too_coarse

OFF = {"analysis.error_estimates": False}


def seed(effects=("coupling",), **analysis):
    return seed_four_bar(effects=effects).changed({f"analysis.{name}": value for name, value in analysis.items()})


@pytest.mark.parametrize("method", ["periodic", "quasi-static", "static", "transient"])
def test_the_answer_is_the_same(method, monkeypatch):
    scene = seed(method=method, sub_intervals=90, cycles=1, allow_coarse=True)
    whole = analyse(scene).data
    for module in ("by_poses", "in_time_by_poses"):
        monkeypatch.setattr(f"fenics_mech.answers.{module}.estimated", None)  # is not called
    data = analyse(scene.changed(OFF)).data
    for name in data.variables:
        if data[name].dtype.kind == "f":
            np.testing.assert_array_equal(data[name], whole[name], err_msg=name)
    assert "error_estimate" in whole.attrs
    assert not [name for name in [*data, *data.attrs] if name.endswith(("strain_error", "error_estimate"))]


def test_the_summary_says_that_nothing_is_estimated():
    console = Console(width=200, file=StringIO())
    console.print(summary(analyse(seed(sub_intervals=90).changed(OFF)), details=True))
    text = console.file.getvalue()
    assert "none, as analysis.error_estimates = false" in text


def test_a_coarse_answer_is_told_only_where_it_is_estimated():
    coarse = seed(sub_intervals=12, solver="collocation", stages=1)
    assert "sub_intervals" in too_coarse(coarse)
    assert not too_coarse(coarse.changed(OFF))


def test_a_tolerance_needs_estimates():
    with pytest.raises(SceneError, match="switched off"):
        seed_four_bar().changed({"tolerance": 1e-2, **OFF})


def test_a_branch_is_followed_without_estimates():
    scene = seed(("coupling", "large-rotations"), sub_intervals=60, allow_coarse=True).changed(OFF)
    branch = follow(scene, "drive.speed", (20.0, 22.0), points=4)
    assert np.isfinite(branch.data["peak_strain"]).all()
