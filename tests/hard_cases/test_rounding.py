"""Hard: the stiffness of a member in n elements has a condition number of order n^4, 1e16 at 10,000 elements.

Right: eight digits of the first six frequencies, of static and of periodic strains, from 1 to 10,000 elements a link.
The reference is the same at 1000 elements, where the cubic elements themselves are good to 1e-12.
"""

import numpy as np
import pytest

from fenics_mech.errors import SceneError
from fenics_mech.response.setup import mechanism
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of, scene_modes

FINE = 10_000
REDUCED = {"analysis__reduction": "craig-bampton", "analysis__cutoff": "2 kHz"}


def reduced(elements, **changes):
    return seed_four_bar(mesh__elements=elements, analysis__sub_intervals=60, **REDUCED, **changes)


def frequencies(scene):
    return scene_modes(scene, mechanism(scene)).frequency


@pytest.mark.slow
def test_first_six_frequencies():
    coarse, fine = (frequencies(reduced(n, analysis__modes=6)) for n in (1000, FINE))
    assert np.abs(fine / coarse - 1).max() < 1e-8
    assert np.abs(frequencies(reduced(32, analysis__modes=6)) / coarse - 1).max() > 1e-7  # there the mesh is at work


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [
        {"analysis__method": "static", "gravity": (0, -9.81)},
        {"effects": ("coupling",), "analysis__allow_coarse": True, "analysis__stability": False},
    ],
    ids=["static", "periodic"],
)
def test_strains(changes):
    coarse, fine = (response_of(reduced(n, **changes)).data for n in (1000, FINE))
    for name in ("strain", "joint_force", "deflection"):
        assert np.abs(fine[name] - coarse[name]).max() < 1e-8 * np.abs(coarse[name]).max()


def test_all_nodes_are_refused_before_digits_are_lost():
    with pytest.raises(SceneError, match="rounding"):
        seed_four_bar(mesh__elements=301)
    whole, least = (frequencies(seed_four_bar(mesh__elements=n, analysis__sub_intervals=4)) for n in (300, 150))
    assert np.abs(whole / least - 1).max() < 1e-4
