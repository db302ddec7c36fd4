"""The largest strain between the points of a sweep: against an oscillator's curve in closed form."""

import json
import math

import numpy as np
import pytest

from fenics_mech.studies.kept_points import TEXTS
from fenics_mech.studies.sweep_peaks import MOST, largest_between, vertex

NOTHING = dict.fromkeys(TEXTS, "")
DAMPING = 0.05


def oscillator(ratio):
    """Magnification ``1/|1 - r^2 + 2 i z r|``, and half of it for a second member."""
    most = 1 / math.hypot(1 - ratio**2, 2 * DAMPING * ratio)
    values = {"peak_strain": [most, most / 2], "peak_stress": [7 * most, most]}
    return NOTHING | {"values": values}


def test_a_parabola_has_its_top_where_three_points_say():
    x = np.array([1.0, 2.0, 4.0])
    assert vertex(x, 5 - (x - 2.3) ** 2) == pytest.approx(2.3, abs=1e-12)
    assert math.isnan(vertex(x, x**2))


def test_the_top_of_a_resonance_is_found_between_the_points():
    """It is at ``sqrt(1 - 2 z^2)``, ``1/(2 z sqrt(1 - z^2))`` high: Den Hartog, section 2.8. The points miss 11 %."""
    values, asked = np.linspace(0.5, 1.5, 20), []

    def analysed(value):
        asked.append(value)
        return oscillator(value)

    records = [oscillator(value) for value in values]
    found = json.loads(largest_between(values, records, analysed, ["rod", "crank"]))
    top = 1 / (2 * DAMPING * math.sqrt(1 - DAMPING**2))
    assert max(record["values"]["peak_strain"][0] for record in records) < 0.95 * top
    assert found["member"] == "rod"
    assert found["strain"] == pytest.approx(top, rel=0.01)
    assert found["stress"] == pytest.approx(7 * top, rel=0.01)
    assert found["value"] == pytest.approx(math.sqrt(1 - 2 * DAMPING**2), abs=0.01)
    assert len(asked) <= MOST


def test_at_the_ends_and_beside_unstable_points_nothing_is_sought():
    def none(value):
        pytest.fail(f"{value} is not to be analysed")

    values = np.linspace(0.5, 0.9, 5)
    rising = [oscillator(value) for value in values]
    assert largest_between(values, rising, none, ["rod", "crank"]) == ""
    values = np.linspace(0.5, 1.5, 5)
    loose = [oscillator(value) for value in values]
    loose[3] |= {"unstable": "it grows"}
    assert largest_between(values, loose, none, ["rod", "crank"]) == ""
    assert largest_between(values[:1], [NOTHING | {"error": "SolverError"}], none, ["rod"]) == ""
