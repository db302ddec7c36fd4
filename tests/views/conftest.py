"""A small result that the tests of views look at."""

import pytest

from fenics_mech.analysis import analyse
from fenics_mech.scene.factories import seed_four_bar


@pytest.fixture(scope="session")
def result():
    """Analyse the seed four-bar with 24 sub-intervals and 2 modes."""
    return analyse(seed_four_bar(analysis={"sub_intervals": 24, "modes": 2, "allow_coarse": True}))
