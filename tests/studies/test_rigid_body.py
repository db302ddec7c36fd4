"""The rigid-body curve beside a result, against the strains that appendix G of the dissertation prints."""

from __future__ import annotations

import csv
from importlib import resources

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.studies.rigid_body import rigid_body_strains

DEMO = fm.load("demos/four_bar.toml").changed(analysis__sub_intervals=24)


def _printed(column: str) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the first 24 rows, and a unit of the last digit of each: numbers are cut to the print's width."""
    text = resources.files("fenics_mech.reference").joinpath("mecqbar_appendix_g.csv").read_text(encoding="utf-8")
    cells = [row[column] for row in csv.DictReader(text.splitlines())][:24]
    return np.array(cells, float), np.array([10.0 ** -len(cell.partition(".")[2]) for cell in cells])


@pytest.mark.parametrize("effects", ["auto", ("large-rotations", "coupling"), ()])
def test_the_curve_is_that_of_appendix_g(effects):
    scene = DEMO.changed(effects=effects)
    above, below = rigid_body_strains(scene), rigid_body_strains(scene, fibre="-")
    for (theta, strain, _), part in (  # the dissertation counts the follower's fibres from its other side
        (above["crank"], "eps1"),
        (above["coupler"], "eps2"),
        (below["follower"], "eps3"),
    ):
        np.testing.assert_allclose(theta, 2 * np.pi * np.arange(24) / 24, rtol=1e-12)
        printed, digit = _printed(part)
        assert np.all(np.abs(strain - printed) < digit)


def test_a_tolerance_of_the_scene_is_not_met_twice():
    with_tolerance = rigid_body_strains(DEMO.changed(tolerance=1e-3))
    np.testing.assert_array_equal(with_tolerance["coupler"][1], rigid_body_strains(DEMO)["coupler"][1])
