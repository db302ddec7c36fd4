"""Sums and products over many positions against plain ones of NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_mech._arrays import each, summed

FEW = settings(max_examples=40, deadline=None)


@FEW
@given(st.integers(0, 10**6), st.integers(1, 9), st.booleans())
def test_entries_are_summed_by_their_places(seed, size, complex_numbers):
    chance = np.random.default_rng(seed)
    values = chance.standard_normal((2, 3, 12)) + 1j * complex_numbers * chance.standard_normal((2, 3, 12))
    values, place = values if complex_numbers else values.real, chance.integers(0, size, 12)
    expected = np.zeros((2, 3, size), values.dtype)
    np.add.at(expected, (slice(None), slice(None), place), values)
    assert summed(values, place, size) == pytest.approx(expected)


def test_products_of_elements_are_those_of_each_angle():
    chance = np.random.default_rng(0)
    matrices, vectors = chance.standard_normal((5, 2, 6)), chance.standard_normal((7, 5, 6))
    assert each(matrices, vectors) == pytest.approx(np.einsum("eij,tej->tei", matrices, vectors))
