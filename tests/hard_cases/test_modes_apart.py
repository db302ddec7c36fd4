"""Close, repeated and crossing modes.

Hard: eigenvectors of equal frequencies are any of their plane; two modes cross, or veer by less than the positions
tell. Right: each mode keeps its shape through a crossing however few positions there are beside it, planes of equal
modes are orthonormal and the same at every position, and responses do not depend on which vectors stand for them.
"""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene import Scene


def of_pair(gap, count, rng):
    """Two modes of ``[[x, gap], [gap, -x]]`` that come near each other twice a cycle, with signs by chance."""
    x = np.cos(2 * np.pi * (np.arange(count) + 0.25) / count)
    matrices = np.array([[[100 + a, gap], [gap, 100 - a]] for a in x])
    squares, vectors = np.linalg.eigh(matrices)
    shapes = vectors.transpose(0, 2, 1) * rng.choice([-1, 1], (count, 2, 1))
    return np.sqrt(squares), shapes, x


def star(count, **rest):
    """Equal arms on one shaft, in one plane: each natural frequency is there as many times."""
    member = {"section": "strip", "material": "steel"}
    tips = {f"P{i}": (0.3 * np.cos(a), 0.3 * np.sin(a)) for i, a in enumerate(2 * np.pi * np.arange(count) / count)}
    members = {f"m{i}": {"ends": ("O", f"P{i}")} | member for i in range(count)}
    return Scene.read(
        {
            "materials": {"steel": {"modulus": 206e9, "density": 7850}},
            "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.002}},
            "ground": {"points": {"O": (0, 0)}},
            "links": {"star": {"points": {"O": (0, 0)} | tips, "members": members}},
            "joints": {"O": {"connect": ["ground.O", "star.O"]}},
            "drive": {"joint": "O", "speed": 20.0},
            "gravity": [0, -9.81],
            "damping": {"ratio": 0.02},
        }
        | rest
    )


@pytest.mark.parametrize(("solver", "bound"), [("sub-intervals", 1e-8), ("collocation", 1e-5)])
def test_a_response_does_not_depend_on_the_vectors_of_a_plane(solver, bound):
    """Each arm of six moves as one alone, under its weight; of the six, collocation leaves fast modes undamped."""
    analysis = {"sub_intervals": 72, "solver": solver, "modes": 6, "stations": 3}
    six = analyse(star(6, analysis=analysis)).data["strain"].sel(member="star.m0")
    one = analyse(star(1, analysis=analysis | {"modes": 1})).data["strain"].sel(member="star")
    assert np.abs(six.to_numpy() - one.to_numpy()).max() < bound * np.abs(one).max()
