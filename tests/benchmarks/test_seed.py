"""Time of the seed scene against the hand-coded NumPy model: `make bench`. Never run as a test."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene.factories import seed_four_bar
from tests.validation.reference.nine_element import NineElementModel
from tests.validation.reference.periodic_motion import periodic_response
from tests.validation.reference.strain import link_strain

STATIONS = {"mid-span": 3, "21 stations": 21}


@pytest.mark.benchmark(group="seed scene, 360 sub-intervals, 27 dofs, 5 modes")
@pytest.mark.parametrize("stations", STATIONS)
def test_analyse(benchmark, stations):
    scene = seed_four_bar(analysis__stations=STATIONS[stations])
    assert len(benchmark(analyse, scene).data["theta"]) == 360


@pytest.mark.benchmark(group="seed scene, 360 sub-intervals, 27 dofs, 5 modes")
@pytest.mark.parametrize("stations", STATIONS)
def test_by_hand(benchmark, stations):
    def work():
        model = NineElementModel()
        response = periodic_response(model, 360, modes=5)
        places = [0.5] if stations == "mid-span" else np.linspace(0, 1, 21)
        return [
            link_strain(model, response.theta, response.displacement, response.acceleration, s).total for s in places
        ]

    assert len(benchmark(work)[0]) == 360
