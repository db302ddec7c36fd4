"""The periodic solver against an independent integrator, and its options."""

import re

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SolverError
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of
from tests.validation.reference.gauss_legendre import gauss_legendre_periodic
from tests.validation.reference.nine_element import NineElementModel
from tests.validation.reference.strain import link_strain

STEPS = 1536


@pytest.fixture(scope="module")
def exact():
    """Mid-span strains of (5.1) with 2 % modal damping by Gauss-Legendre collocation, good to 1e-6 of their peak."""
    model = NineElementModel()
    answer = gauss_legendre_periodic(model, STEPS)
    return link_strain(model, answer.theta, answer.displacement, answer.acceleration).total


def errors(exact, count, **analysis):
    """Largest errors over the cycle, relative to the peak, of coupler and follower."""
    result = response_of(seed_four_bar(analysis={"sub_intervals": count, "allow_coarse": True} | analysis))
    found = np.stack([result.strain_at(link) for link in ("crank", "coupler", "follower")], axis=1)
    expected = exact[:: STEPS // count]
    return (np.abs(found - expected).max(axis=0) / np.abs(expected).max(axis=0))[1:]


def test_physical_join_converges_to_the_independent_answer(exact):
    assert np.all(errors(exact, 48, modes=3) < 0.015)
    assert np.all(errors(exact, 384, modes=3) < 0.0065)
    assert np.all(errors(exact, 768, modes=8) < 0.003)


@pytest.mark.long
def test_all_modes_converge_slowly(exact):
    found = [errors(exact, n, modes="all", allow_ringing=True).max() for n in (384, 768, 1536)]
    assert found[0] > 1.5 * found[1] > 2 * found[2]
    assert found[2] < 0.03


def test_projected_join_keeps_an_error_of_one_percent(exact):
    projected, physical = (errors(exact, 768, join=join) for join in ("projected", "physical"))
    assert np.all((projected > 0.008) & (projected < 0.013))
    assert np.all(physical < 0.6 * projected)


def test_modal_join_does_not_converge(exact):
    coarse, fine = (errors(exact, n, join="modal") for n in (192, 768))
    assert np.all(coarse > 0.9)
    assert np.all(fine > 0.9)


def test_static_correction_matters(exact):
    with_it, without = (errors(exact, 768, modes=3, static_correction=on) for on in (True, False))
    assert without.max() > 3 * with_it.max()


@pytest.mark.parametrize(("modes", "count", "mode"), [(8, 96, 6), (8, 48, 6), ("all", 360, 18)])
def test_modes_that_ring_at_the_joins_are_refused(exact, modes, count, mode):
    with pytest.raises(SolverError, match=rf"mode {mode} .* is too fast .* add 'coupling'"):
        analyse(seed_four_bar(analysis={"sub_intervals": count, "modes": modes, "allow_coarse": True}))
    if count != 360:  # and rightly so
        assert errors(exact, count, modes=modes, allow_ringing=True).max() > 0.2


@pytest.mark.slow
def test_what_a_refusal_of_ringing_advises_rings_no_more():
    analysis = {"sub_intervals": 96, "modes": 8, "allow_coarse": True}
    with pytest.raises(SolverError) as refused:
        analyse(seed_four_bar(analysis=analysis))
    modes, count = map(int, re.search(r"Keep (\d+) modes, or take at least (\d+) sub", str(refused.value)).groups())
    for change in ({"solver": "collocation"}, {"modes": modes}, {"sub_intervals": count}):
        analyse(seed_four_bar(analysis=analysis | change))
    stated = {"sub_intervals": 48, "modes": "all"}
    many = seed_four_bar(drive__speed=1.0, analysis=stated)
    with pytest.raises(SolverError, match=r"(?=.*set vibrating)(?=.*allow_coarse)(?!.*[Tt]ake at least)(?!.*[Kk]eep)"):
        analyse(many)


def test_iterative_solver_by_options_gives_the_same(exact):
    options = {"periodic_ksp_type": "gmres", "periodic_pc_type": "ilu", "periodic_ksp_rtol": 1e-12}
    direct = analyse(seed_four_bar(analysis={"sub_intervals": 96}))
    iterative = analyse(seed_four_bar(analysis={"sub_intervals": 96}, petsc=options))
    assert np.allclose(direct.data["strain"], iterative.data["strain"], rtol=0, atol=1e-11)


def test_solver_that_does_not_converge_raises_with_its_reason():
    options = {"periodic_ksp_type": "gmres", "periodic_pc_type": "none", "periodic_ksp_max_it": 3}
    with pytest.raises(SolverError, match="DIVERGED_MAX_IT"):
        analyse(seed_four_bar(analysis={"sub_intervals": 96}, petsc=options))


def test_slow_drive_is_quasi_static():
    fast, slow = (
        analyse(seed_four_bar(drive__speed=2.0, analysis={"sub_intervals": 720, "modes": 3, "allow_coarse": True} | a))
        for a in ({}, {"method": "quasi-static"})
    )
    peak = float(np.abs(slow.data["strain"]).max())
    assert np.abs(fast.data["strain"] - slow.data["strain"]).max() < 5e-3 * peak  # (2/272)^2 times order^2


def test_strain_grows_with_the_square_of_a_slow_speed():
    peaks = [
        float(np.abs(analyse(seed_four_bar(drive__speed=w, analysis={"method": "quasi-static"})).data["strain"]).max())
        for w in (10.0, 20.0)
    ]
    assert peaks[1] == pytest.approx(4 * peaks[0], rel=1e-9)
