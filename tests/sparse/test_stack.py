"""Sparse matrices at many positions against dense ones of NumPy."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_mech._arrays import each, summed
from fenics_mech._sparse import Pattern, SingularError, Stack

FEW = settings(max_examples=40, deadline=None)


def some(seed, size, count=3, filled=0.3):
    """Matrices that need no exchange of rows, at random places."""
    chance = np.random.default_rng(seed)
    rows, columns = np.nonzero(chance.random((size, size)) < filled)
    pattern = Pattern.of(size, rows, columns)
    values = chance.standard_normal((count, len(pattern.rows)))
    values[:, pattern.diagonal] += 2 * size
    return Stack(pattern, values)


@FEW
@given(st.integers(0, 10**6), st.integers(1, 30))
def test_products_and_answers_are_those_of_dense_matrices(seed, size):
    stack = some(seed, size)
    vectors = np.random.default_rng(seed + 1).standard_normal((3, 2, size))
    expected = np.einsum("tij,tmj->tmi", stack.full, vectors)
    assert stack.times(vectors) == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    assert stack.solve(expected) == pytest.approx(vectors, abs=1e-11)
    assert stack.times(vectors[:, 0]) == pytest.approx(expected[:, 0], abs=1e-12 * np.abs(expected).max())
    assert stack.at(1).toarray() == pytest.approx(stack.dense(1))


@FEW
@given(st.integers(0, 10**6))
def test_sums_of_different_patterns(seed):
    one, other = some(seed, 9), some(seed + 1, 9)
    assert (one + other).full == pytest.approx(one.full + other.full)
    assert one.transposed.full == pytest.approx(one.full.transpose(0, 2, 1))
    vectors = np.random.default_rng(seed).standard_normal((3, 40, 9))  # so many that freed memory is taken again
    assert one.transposed.times(vectors) == pytest.approx(vectors @ one.full)


@FEW
@given(st.integers(0, 10**6), st.integers(1, 9), st.booleans())
def test_entries_are_summed_by_their_places(seed, size, complex_numbers):
    chance = np.random.default_rng(seed)
    values = chance.standard_normal((2, 3, 12)) + 1j * complex_numbers * chance.standard_normal((2, 3, 12))
    values, place = values if complex_numbers else values.real, chance.integers(0, size, 12)
    expected = np.zeros((2, 3, size), values.dtype)
    np.add.at(expected, (slice(None), slice(None), place), values)
    assert summed(values, place, size) == pytest.approx(expected)


@pytest.mark.parametrize("place", [[0, 1, 3], [-1, 0, 1], [0, 1]])
def test_places_that_are_none_are_refused(place):
    with pytest.raises(ValueError, match="cannot be summed"):
        summed(np.ones((4, 3)), np.array(place), 3)


def test_products_of_elements_are_those_of_each_angle():
    chance = np.random.default_rng(0)
    matrices, vectors = chance.standard_normal((5, 2, 6)), chance.standard_normal((7, 5, 6))
    assert each(matrices, vectors) == pytest.approx(np.einsum("eij,tej->tei", matrices, vectors))


@FEW
@given(st.integers(0, 10**6))
def test_signs_of_pivots_are_those_of_eigenvalues(seed):
    """Sylvester's law of inertia."""
    one = some(seed, 12)
    symmetric = one + one.transposed
    symmetric.values[:, symmetric.pattern.diagonal[:5]] *= -1
    negative = (np.linalg.eigvalsh(symmetric.full) < 0).sum(axis=1)
    assert ((symmetric.factors.pivots < 0).sum(axis=1) == negative).all()


def test_a_singular_matrix_is_named():
    stack = some(0, 3)
    stack.values[1] = 0.0
    with pytest.raises(SingularError, match="position 1") as found:
        stack.solve(np.ones((len(stack.values), 3)))
    assert found.value.position == 1


def test_factors_of_a_chain_have_no_more_nonzeros():
    """A tridiagonal matrix, and one of blocks as elements join them: minimum degree fills nothing."""
    size = 60
    at = np.arange(size - 1)
    assert Pattern.of(size, at, at + 1).elimination.blocks == 3 * size - 2
    nodes = 3 * np.arange(19)[:, None] + np.arange(6)
    rows, columns = np.broadcast_arrays(nodes[:, :, None], nodes[:, None])
    chain = Pattern.of(60, rows.ravel(), columns.ravel())
    assert chain.elimination.blocks == len(chain.rows)
