"""The hand-coded finite elements: matrices, frequencies and the quasi-static limit."""

from __future__ import annotations

import numpy as np
import pytest

from tests.validation.reference import FourBarParameters, NineElementModel, link_strain, mecqbar, quasi_static_response
from tests.validation.reference.nine_element import element_gyroscopic, element_mass, element_stiffness
from tests.validation.reference.strain import _inertia_before

# Hz, computed once with another program and printed to 1 mHz
FREQUENCIES = {
    0.0: [43.303, 48.744, 62.157, 194.597, 208.326, 475.912],
    np.pi / 2: [46.651, 50.171, 81.399, 192.463, 206.778, 476.599],
}


def shapes(x: np.ndarray, h: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows of [N] (4.4) at points `x`, shape ``(6, points)`` each."""
    zero, r = np.zeros_like(x), x / h
    u = np.array([1 - r, zero, zero, r, zero, zero])
    w = np.array([zero, 1 - 3 * r**2 + 2 * r**3, x * (1 - r) ** 2, zero, 3 * r**2 - 2 * r**3, -(h - x) * r**2])
    return u, w


def test_typed_matrices_are_the_integrals_of_the_shape_functions() -> None:
    h, density = 0.3, 1.7
    points, weights = np.polynomial.legendre.leggauss(6)
    u, w = shapes(h / 2 * (points + 1), h)
    weights = density * h / 2 * weights
    np.testing.assert_allclose(element_mass(density, h), (u * weights) @ u.T + (w * weights) @ w.T, atol=1e-15)
    np.testing.assert_allclose(element_gyroscopic(density, h), (w * weights) @ u.T - (u * weights) @ w.T, atol=1e-15)


def test_stiffness_gives_no_force_in_rigid_motion() -> None:
    h = 0.3
    stiffness = element_stiffness(7e10, 4e-5, 9e-12, h)
    rigid = np.array([[1, 0, 0, 1, 0, 0], [0, 1, 0, 0, 1, 0], [0, 0, 1, 0, h, 1]]).T
    assert np.abs(stiffness @ rigid).max() < 1e-13 * np.abs(stiffness).max()
    np.testing.assert_array_equal(stiffness, stiffness.T)
    assert np.linalg.matrix_rank(stiffness / np.sqrt(np.outer(np.diag(stiffness), np.diag(stiffness)))) == 3


def test_inertia_integrals_against_quadrature() -> None:
    h, xi = 0.3, 0.37
    points, weights = np.polynomial.legendre.leggauss(6)
    x, weights = xi * h / 2 * (points + 1), xi * h / 2 * weights
    u, w = shapes(x, h)
    axial, moment = _inertia_before(np.eye(6), xi, h)
    np.testing.assert_allclose(axial, u @ weights, atol=1e-16)
    np.testing.assert_allclose(moment, w @ (weights * (xi * h - x)), atol=1e-17)


def test_dofs() -> None:
    model = NineElementModel()
    assert model.size == len(set(model.dof_labels)) == 27
    assert model.dof_labels.count(("A", "X")) == 1
    assert ("crank", 0.333333333333, "w") in model.dof_labels
    assert ("crank", 0.0, "phi") not in model.dof_labels
    assert ("follower", 0.0, "phi") in model.dof_labels


@pytest.mark.parametrize("theta", FREQUENCIES)
def test_frequencies(theta: float) -> None:
    found = NineElementModel().frequencies(theta)[0, :6]
    np.testing.assert_allclose(found, FREQUENCIES[theta], atol=0.5e-3, rtol=0)


def test_transformation_derivatives_against_differences() -> None:
    model, step = NineElementModel(), 1e-5
    theta = np.array([0.3, 2.0, 5.5])
    time = 2 * step / model.parameters.omega1
    before, here, after = (model.transformations(theta + d) for d in (-step, 0.0, step))
    for b, t, a in zip(before, here, after, strict=True):
        np.testing.assert_allclose(t.rate, (a.value - b.value) / time, atol=1e-6 * 32.3)
        np.testing.assert_allclose(t.second, (a.rate - b.rate) / time, atol=1e-6 * 32.3**2)


def test_full_equation_keeps_the_hamiltonian_structure() -> None:
    # L = q'M q'/2 + q'B q - q K q/2 gives M q'' + (M' + B - B^T) q' + (K + B') q with K symmetric.
    model, step = NineElementModel(), 1e-5
    theta = np.array([0.3, 2.0, 5.5])
    time = 2 * step / model.parameters.omega1
    (before, _), (after, _) = model.mass_stiffness(theta - step), model.mass_stiffness(theta + step)
    skew = model.coupling(theta).damping - (after - before) / time
    assert np.abs(skew + skew.swapaxes(1, 2)).max() < 1e-7 * np.abs(skew).max()
    ahead, behind = model.coupling(theta + step).damping, model.coupling(theta - step).damping
    rate = ((ahead - ahead.swapaxes(1, 2)) - (behind - behind.swapaxes(1, 2))) / (2 * time)
    stiffness = model.coupling(theta).stiffness
    assert np.abs(stiffness - stiffness.swapaxes(1, 2) - rate).max() < 1e-7 * np.abs(stiffness).max()


@pytest.mark.parametrize(
    ("area", "mass_A", "mass_B"),
    [((0.0, 4e-5, 0.0), 0.0, 0.0), ((0.0, 0.0, 0.0), 0.04, 0.0), ((0.0, 0.0, 0.0), 0.0, 0.03)],
)
def test_translation_in_the_fixed_frame_has_no_coupling(
    area: tuple[float, float, float], mass_A: float, mass_B: float
) -> None:
    # A coupler or point mass that only translates knows nothing of the turning frames: its inertia is M q'' alone.
    model = NineElementModel(FourBarParameters(area=area, mass_A=mass_A, mass_B=mass_B), elements=1)
    coupling, theta = model.coupling([0.3, 2.0, 5.5]), [0.3, 2.0, 5.5]
    mass, _ = model.mass_stiffness(theta)
    for axis in "XY":
        move = np.array([float(label[-1] == axis) for label in model.dof_labels])
        inertia = np.abs(mass @ move).max()
        assert inertia > 1e-3
        assert np.abs(coupling.damping @ move).max() < 1e-12 * 32.3 * inertia
        assert np.abs(coupling.stiffness @ move).max() < 1e-11 * 32.3**2 * inertia


@pytest.mark.parametrize("elements", [1, 2, 3, 16])
def test_quasi_static_strain_is_that_of_mecqbar(elements: int) -> None:
    model, theta = NineElementModel(elements=elements), 2 * np.pi * np.arange(24) / 24 + 0.01
    strain = link_strain(model, theta, quasi_static_response(model, theta).displacement)
    expected = mecqbar(theta)
    for link in range(3):
        sign = -1 if link == 2 else 1  # MECQBAR's follower fibre is the one to the right of the axis C-B
        peak = np.abs(expected[f"eps{link + 1}"]).max()
        axial, bending = expected[f"eps{link + 1}_axial"], expected[f"eps{link + 1}_bending"]
        np.testing.assert_allclose(strain.axial[:, link], axial, atol=1e-10 * peak, rtol=0)
        np.testing.assert_allclose(sign * strain.bending[:, link], bending, atol=1e-10 * peak, rtol=0)
        total = strain.axial[:, link] + sign * strain.bending[:, link]
        np.testing.assert_allclose(total, expected[f"eps{link + 1}"], atol=1e-10 * peak, rtol=0)
