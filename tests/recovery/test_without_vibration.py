"""The curve without vibration in a result, against the strains that appendix G of the dissertation prints."""

from __future__ import annotations

import csv
from importlib import resources

import numpy as np
import pytest

import fenics_mech as fm
from tests.common import DEMOS, analysed

QUICK = {"sub_intervals": 24, "allow_coarse": True, "error_estimates": False, "stability": False, "allow_ringing": True}
DEMO = fm.load(DEMOS / "four_bar.toml").changed({f"analysis.{key}": value for key, value in QUICK.items()})


def _printed(column: str) -> tuple[np.ndarray, np.ndarray]:
    """Numbers of the first 24 rows, and a unit of the last digit of each: numbers are cut to the print's width."""
    text = resources.files("tests.validation.reference").joinpath("mecqbar_appendix_g.csv").read_text(encoding="utf-8")
    cells = [row[column] for row in csv.DictReader(text.splitlines())][:24]
    return np.array(cells, float), np.array([10.0 ** -len(cell.partition(".")[2]) for cell in cells])


@pytest.mark.parametrize("effects", [("large-rotations", "coupling"), ()])
def test_the_curve_is_that_of_appendix_g(effects):
    data = analysed(DEMO.changed(effects=effects)).data
    np.testing.assert_allclose(data["theta"], 2 * np.pi * np.arange(24) / 24, rtol=1e-12)
    strain = data["strain_quasi_static"].sel(s=0.5)
    for member, fibre, part in (  # the dissertation counts the follower's fibres from its other side
        ("crank", "+", "eps1"),
        ("coupler", "+", "eps2"),
        ("follower", "-", "eps3"),
    ):
        printed, digit = _printed(part)
        assert np.all(np.abs(strain.sel(member=member, fibre=fibre).to_numpy() - printed) < digit)
