"""Hard: the stiffness of a member in n elements has a condition number of order n^4: 1e10 at 300 elements.

Right: as many elements as leave four digits, and more are an error.
"""

import numpy as np
import pytest
from fenics_mech.response.setup import mechanism

from fenics_mech.errors import SceneError
from fenics_mech.scene.factories import seed_four_bar
from tests.common import scene_modes


def frequencies(scene):
    return scene_modes(scene, mechanism(scene)).frequency


def test_all_nodes_are_refused_before_digits_are_lost():
    with pytest.raises(SceneError, match="rounding"):
        seed_four_bar(mesh__elements=301)
    whole, least = (frequencies(seed_four_bar(mesh__elements=n, analysis__sub_intervals=4)) for n in (300, 150))
    assert np.abs(whole / least - 1).max() < 1e-4
