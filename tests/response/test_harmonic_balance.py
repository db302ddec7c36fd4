"""Harmonic balance of link frames against exact motions."""

import numpy as np
import pytest

from fenics_mech.errors import SolverError
from fenics_mech.response.periodic.harmonic_balance import solve_harmonic_balance
from tests.response.synthetic import PERIOD, Duffing, Manufactured, oscillators, places, plain

START = np.zeros(1)


@pytest.mark.parametrize(("harmonics", "largest"), [(8, 1e-4), (12, 1e-7), (20, 1e-11)])
def test_converges_faster_than_any_power_and_tells_its_error(harmonics, largest):
    """The coefficients of exp(sin) are Bessel functions: with 20 harmonics 1e-20, below rounding."""
    case, time = Manufactured(), places(START, 128)
    series = solve_harmonic_balance(plain(case.matrices(time)), harmonics, PERIOD, {})
    exact = case.motion(time)
    q, rate = series.at(2 * np.pi * time / PERIOD)
    error = np.abs(q - exact[0]).max() / np.abs(exact[0]).max()
    assert error < largest
    assert np.abs(rate - exact[1]).max() < 100 * largest
    assert series.error < 100 * largest
    if harmonics < 20:
        assert error / 3 < series.error < 3 * error  # both weigh the coordinates alike up to a factor


def test_resonance_of_a_damped_mode():
    """At resonance the amplitude is ``f/(2 zeta omega^2)``; the series is exact, GMRES stops at 1e-12."""
    omega, zeta, time = 5 * 2 * np.pi / PERIOD, 1e-3, places(START, 64)
    matrices = oscillators(time, np.array([omega]), np.array([2 * zeta * omega]), 7 * np.cos(omega * time)[:, None])
    series = solve_harmonic_balance(plain(matrices), 6, PERIOD, {})
    assert series.coefficients[10, 0] == pytest.approx(7 / (2 * zeta * omega**2), rel=1e-8)  # a sine of harmonic 5
    assert np.abs(np.delete(series.coefficients, 10)).max() < 1e-10


def test_nonlinear_motion():
    """The motion has one harmonic and its cubic force three, all of them kept."""
    time = places(START, 32)
    duffing = Duffing(time)
    series = solve_harmonic_balance(duffing, 5, PERIOD, {}, duffing.tension)
    expected = np.zeros((11, 1))
    expected[1] = duffing.amplitude
    assert series.coefficients == pytest.approx(expected, abs=1e-10)


def test_too_few_harmonics_are_refused():
    equation = plain(Manufactured().matrices(places(START, 128)))
    with pytest.raises(SolverError, match="4 harmonics are too few: the error is about"):
        solve_harmonic_balance(equation, 4, PERIOD, {})
    with pytest.raises(SolverError, match="40 harmonics need more than 160 sub_intervals"):
        solve_harmonic_balance(equation, 40, PERIOD, {})


def test_solver_that_does_not_converge_raises_with_its_reason():
    equation = plain(Manufactured().matrices(places(START, 128)))
    with pytest.raises(SolverError, match="DIVERGED_MAX_IT"):
        solve_harmonic_balance(equation, 12, PERIOD, {"periodic_ksp_max_it": 2})
