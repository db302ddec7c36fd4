"""The periodic response by sub-intervals, and the collocation that it is measured against."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import splu

from tests.validation.reference import (
    CollocationResponse,
    NineElementModel,
    gauss_legendre_periodic,
    link_strain,
    periodic_response,
    quasi_static_response,
)
from tests.validation.reference import gauss_legendre as collocation
from tests.validation.reference import periodic_motion as sub_intervals

STEPS = 1536


@pytest.fixture(scope="module")
def model() -> NineElementModel:
    return NineElementModel()


@pytest.fixture(scope="module")
def reference(model: NineElementModel) -> CollocationResponse:
    return gauss_legendre_periodic(model, STEPS)


def errors(model: NineElementModel, reference: CollocationResponse, intervals: int, **options: object) -> np.ndarray:
    """Mid-span strain error of coupler and follower relative to the peak, shape ``(2,)``."""
    found = periodic_response(model, intervals, **options)  # type: ignore[arg-type]
    strain = link_strain(model, found.theta, found.displacement, found.acceleration).total[:, 1:]
    wanted = link_strain(model, reference.theta, reference.displacement, reference.acceleration).total[:, 1:]
    return np.abs(strain - wanted[:: STEPS // intervals]).max(axis=0) / np.abs(wanted).max(axis=0)


def spectral_rate(values: np.ndarray, omega1: float) -> np.ndarray:
    """Take the derivative in time of values over one cycle, by Fourier series."""
    harmonics = 1j * omega1 * np.arange(len(values) // 2 + 1)[:, None]
    return np.fft.irfft(harmonics * np.fft.rfft(values, axis=0), n=len(values), axis=0)


def relative(found: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(found - wanted).max() / np.abs(wanted).max())


@pytest.mark.slow
def test_collocation_converges_at_sixth_order(model: NineElementModel, reference: CollocationResponse) -> None:
    answers = [gauss_legendre_periodic(model, n).displacement for n in (384, 768)]
    coarse, fine = (relative(q, reference.displacement[:: STEPS // len(q)]) for q in answers)
    assert np.log2(coarse / fine) > 5.5
    assert fine < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize("coupling", [False, True])
def test_collocation_solves_the_equation(model: NineElementModel, coupling: bool) -> None:
    # q'' comes from the equation of motion, so agreement of the series' derivatives is fulfilment of the equation.
    found, omega1 = gauss_legendre_periodic(model, STEPS, coupling=coupling), model.parameters.omega1
    assert relative(spectral_rate(found.displacement, omega1), found.velocity) < 1e-5
    second = np.linalg.solve(*_static_weighted(model, found, spectral_rate(found.velocity, omega1)))
    assert relative(second, np.linalg.solve(*_static_weighted(model, found, found.second_derivative))) < 1e-5


def _static_weighted(
    model: NineElementModel, found: CollocationResponse, rate: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """K and M q'', whose quotient weighs accelerations by the deflection they make."""
    mass, stiffness = model.mass_stiffness(found.theta)
    return stiffness, mass @ rate[..., None]


def test_coupling_terms_change_the_answer(model: NineElementModel, reference: CollocationResponse) -> None:
    full = gauss_legendre_periodic(model, 384, coupling=True)
    assert relative(full.displacement, reference.displacement[::4]) > 0.01
    theta = np.array([0.3, 2.0])
    without, equation = (collocation._equation(model, theta, 0.02, flag) for flag in (False, True))
    terms = model.coupling(theta)
    np.testing.assert_allclose(equation.damping - without.damping, 2 * (terms.Md + terms.Mv), atol=1e-8)
    added = terms.Mdd + 2 * terms.Mdv + terms.Ma
    np.testing.assert_allclose(equation.stiffness - without.stiffness, added, atol=1e-6)
    assert np.abs(added).max() > 5.0


@pytest.mark.parametrize("load", ["constant", "linear"])
@pytest.mark.parametrize("modes", [3, 5])
def test_physical_join_approaches_the_reference(
    model: NineElementModel, reference: CollocationResponse, modes: int, load: str
) -> None:
    coarse, fine = (errors(model, reference, n, modes=modes, load=load).max() for n in (24, 192))
    # What stays is the share of the modes left out in the turning of those kept, 1 % with so few modes.
    assert fine < 0.02
    assert coarse > 5 * fine


def test_physical_join_with_all_modes_approaches_the_reference(
    model: NineElementModel, reference: CollocationResponse
) -> None:
    assert errors(model, reference, 768).max() < 0.1
    assert errors(model, reference, 1536).max() < 0.03


@pytest.mark.parametrize("modes", [3, 5])
def test_physical_join_passes_below_the_projected(
    model: NineElementModel, reference: CollocationResponse, modes: int
) -> None:
    projected, physical = (errors(model, reference, 384, modes=modes, join=join) for join in ("projected", "physical"))
    assert np.all(physical < 0.6 * projected)
    assert physical.max() < 0.007


def test_modal_join_does_not_approach_the_reference(model: NineElementModel, reference: CollocationResponse) -> None:
    for intervals in (192, 384, 768):
        assert np.all(errors(model, reference, intervals, modes=5, join="modal") > 0.9)


@pytest.mark.parametrize("join", ["projected", "physical", "modal"])
@pytest.mark.parametrize("modes", [5, 27])
def test_condensation_solves_the_block_cyclic_system(model: NineElementModel, join: str, modes: int) -> None:
    count = 48
    data = sub_intervals._intervals(model, count, modes, "linear")
    joins, kicks = sub_intervals._joins(data, join, 0.02)  # type: ignore[arg-type]
    whole = sub_intervals._oscillators(data, 0.02, data.step)
    start = sub_intervals._closed_cycle(joins, kicks, whole)
    blocks: list[list[sparse.spmatrix | None]] = [[None] * count for _ in range(count)]
    right = np.empty((count, 2 * modes))
    for k in range(count):
        end = np.zeros((modes, 2, modes, 2))
        end[np.arange(modes), :, np.arange(modes), :] = whole.matrix[k]
        step = np.kron(joins[k], np.eye(2)) - np.kron(kicks[k], [[0, 0], [1, 0]])
        after = (k + 1) % count
        blocks[after][after] = sparse.identity(2 * modes)
        blocks[after][k] = sparse.csr_matrix(-step @ end.reshape(2 * modes, -1))
        right[after] = step @ whole.forced[k].ravel()
    expected = splu(sparse.bmat(blocks, format="csc")).solve(right.ravel()).reshape(start.shape)
    for part in (0, 1):
        assert relative(start[..., part], expected[..., part]) < 1e-9


def test_oscillators_are_exact() -> None:
    # Against the series of the matrix exponential of the state with its linear load.
    from scipy.linalg import expm

    omega, zeta, step, time = 50.0, 0.1, 0.04, 0.03
    one = np.ones((1, 1))
    data = sub_intervals._Intervals(one[0], step, one, one, omega * one, 3.0 * one, 5.0 * one, 7.0 * one, one, one)
    found = sub_intervals._oscillators(data, zeta, time)
    slope = (7.0 - 3.0) / step
    system = np.array([[0, 1, 0, 0], [-(omega**2), -2 * zeta * omega, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
    exact = expm(system * time)
    np.testing.assert_allclose(found.matrix[0, 0], exact[:2, :2], rtol=1e-12)
    np.testing.assert_allclose(found.forced[0, 0], exact[:2, 2:] @ [3.0, slope], rtol=1e-11)


def test_slow_crank_gives_the_quasi_static_answer() -> None:
    from tests.validation.reference import FourBarParameters

    model = NineElementModel(FourBarParameters(omega1=0.5))
    found = periodic_response(model, 96, modes=5, damping=0.5)
    static = quasi_static_response(model, found.theta)
    assert relative(found.displacement, static.displacement) < 0.02


@pytest.mark.parametrize(
    "options", [{"damping": 1.0}, {"damping": -0.1}, {"modes": 0}, {"modes": 28}, {"join": "?"}, {"load": "?"}]
)
def test_bad_options_are_errors(model: NineElementModel, options: dict[str, object]) -> None:
    with pytest.raises(ValueError, match=r"got|unknown"):
        periodic_response(model, 12, **options)  # type: ignore[arg-type]


def test_no_sub_interval_is_an_error(model: NineElementModel) -> None:
    with pytest.raises(ValueError, match="at least one sub-interval"):
        periodic_response(model, 0)
