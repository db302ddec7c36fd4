"""Harmonic balance against exact motions, and against collocation."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.response.periodic.harmonic_balance import solve_harmonic_balance
from fenics_mech.scene import load
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS, response_of
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


def test_impulses_are_refused():
    scene = seed_four_bar(
        impulses={"blow": {"at": "follower.B", "impulse": (0.01, 0.0), "angle": "40 deg"}},
        analysis={"solver": "harmonic-balance"},
    )
    with pytest.raises(SceneError, match="harmonics do not follow"):
        analyse(scene)


def strains(scene, count, **analysis):
    """Strains at 40 angles."""
    values = {f"analysis__{key}": value for key, value in analysis.items()}
    result = response_of(scene.changed(**values, analysis__sub_intervals=count, analysis__stability=False))
    return result.data["strain"].to_numpy()[:: count // 40]


def same(scene, stages, count, harmonics, angles):
    """Largest difference of the strains of both solvers, over the largest strain."""
    by_steps = strains(scene, count, solver="collocation", stages=stages)
    by_series = strains(scene, angles, solver="harmonic-balance", harmonics=harmonics)
    return np.abs(by_steps - by_series).max() / np.abs(by_steps).max()


@pytest.mark.slow
@pytest.mark.parametrize("effects", [("coupling",), ("coupling", "large-rotations")])
def test_seed_four_bar_by_collocation_and_by_harmonics(effects):
    """Two solvers that share the equation alone; measured 2e-8 and 3e-7."""
    scene = seed_four_bar(effects=effects, damping={"material": 1.339e-4})
    assert same(scene, stages=5, count=240, harmonics=85, angles=360) < 1e-6


def test_slider_crank_by_collocation_and_by_harmonics():
    scene = load(DEMOS / "slider_crank.toml").changed(effects=("coupling",))
    assert same(scene, stages=4, count=120, harmonics=25, angles=120) < 1e-6  # measured 4e-9


@pytest.mark.long
@pytest.mark.slow
def test_quick_return_by_collocation_and_by_harmonics():
    """The pin passes from element to element, and P'' jumps there: both converge as a power.

    Measured 5e-5, and 1e-6 with 340 harmonics.
    """
    scene = load(DEMOS / "quick_return.toml").changed(effects=("coupling",))
    assert same(scene, stages=5, count=240, harmonics=85, angles=360) < 2e-4


def test_what_a_load_does_between_the_sub_intervals_is_told():
    """The series does not see a pulse narrower than a sub-interval; the steps that tell its error are cut there."""
    pulse = {"kind": "pulse", "start": 1.0, "end": 1.01}
    scene = load(DEMOS / "slider_crank.toml").changed(
        effects=("coupling",),
        loads={"tap": {"at": "rod@0.5", "force": (-1.0, 0.6), "factor": pulse}},
        analysis={"sub_intervals": 80, "harmonics": 16, "allow_coarse": True},
    )
    series, steps = (analyse(scene.changed(analysis__solver=one)).data for one in ("harmonic-balance", "collocation"))
    error = np.abs(series["strain"] - steps["strain"]).max(["theta", "s", "fibre"]) / series["largest_strain"]
    told = series["relative_error"].drop_sel(source=["theory", "positions"]).sum()  # at the positions
    assert 0.01 < error.max() < told < 2 * error.max()
