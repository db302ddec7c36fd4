"""Rotations of the plane: the same numbers give the same bits."""

import numpy as np

from fenics_mech.geometry import PLANE


def test_an_angle_has_the_same_bits_wherever_its_matrix_lies_in_memory():
    """NumPy rounds functions of strided arrays in another way where the result lies right behind its argument."""
    angles = np.random.default_rng(1).uniform(-3, 3, 241)
    matrices = PLANE.turn(angles[:, None])
    found = set()
    for size in range(200, 400):  # of what else takes memory, so that copies come to lie at all places
        others = [np.empty(size + k) for k in range(40)]
        found.add(PLANE.vector(matrices.copy()).tobytes())
        del others
    assert len(found) == 1
    np.testing.assert_allclose(PLANE.vector(matrices)[:, 0], angles, rtol=1e-15)
