"""Harmonic balance of the residual: Galerkin's conditions of Duffing's oscillator, and the steps of `periodic`."""

import numpy as np
import pytest
from scipy.optimize import root

from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.scene import load
from fenics_mech.solve import damp_modes, periodic, rigid_cycle
from fenics_mech.solve.harmonic_balance import balanced
from tests.common import DEMOS
from tests.machine.builders import seed
from tests.response.forced import ORDERS, lack
from tests.solve.test_continuation import CUBIC, DAMPING, FORCE, oscillator


def test_a_cubic_oscillator_has_the_coefficients_of_galerkin():
    """Harmonics 1, 3 ... 9 by an own program; the even ones are 0 by symmetry."""
    rate = 0.8
    machine, period = oscillator(rate)
    found = balanced(machine, period, 9, 64)[0].coefficients[1:, 0].reshape(-1, 2)
    start = np.append(np.eye(1, len(ORDERS))[0] * 0.3, np.zeros(len(ORDERS)))
    expected = root(lambda x: lack(x, rate, DAMPING, CUBIC, FORCE), start, tol=1e-13).x.reshape(2, -1)
    assert np.abs(found[ORDERS - 1].T - expected).max() < 1e-11
    assert np.abs(found[1::2]).max() < 1e-12


def test_it_goes_to_the_motion_of_the_steps_as_harmonics_are_added():
    """The seed, 2 elements a member: axial forces follow squares of the bending, whose harmonics are twice as many."""
    machine, period = seed(2), 2 * np.pi / 32.3
    machine.chart = rigid_cycle(machine, period)
    steps = periodic(machine, period, 180, stages=4).path
    t = period / 96 * np.arange(96)
    q, _, a = steps.when(t)
    errors = []
    for harmonics, instants in ((40, 180), (59, 240)):
        Q, _, A = balanced(machine, period, harmonics, instants)[0].at(t)
        errors.append([np.abs(Q - q).max() / np.abs(q).max(), np.abs(A - a).max() / np.abs(a).max()])
    assert errors[0] < [2e-3, 5e-2]
    assert errors[1] < [5e-5, 3e-3]


def test_multipliers_of_guides_and_damped_modes_are_balanced_too():
    """The slider-crank: its joint forces are multipliers, and 2 % of damping is a stress of modes."""
    scene = load(DEMOS / "slider_crank.toml").changed(effects=("coupling", "large-rotations"))
    machine = machine_of(scene).machine
    machine.chart = rigid_cycle(machine, scene.period)
    damp_modes(machine, scene.period, 0.02)
    steps = periodic(machine, scene.period, 120, stages=4).path
    t = scene.period / 40 * np.arange(40)
    kept = machine.n + machine.held  # modes have no series: their patterns may turn round from instant to instant
    found = balanced(machine, scene.period, 29, 120)[0].at(t)
    assert np.abs(found[0] - steps.when(t)[0]).max() < 1e-7 * np.abs(found[0]).max()
    for by_series, by_steps in zip(found, steps.when(t)):
        size = np.abs(by_steps[:, :kept]).max()
        assert np.abs(by_series - by_steps)[:, :kept].max() < 1e-3 * size  # accelerations end steps of order 4


def test_what_cannot_be_balanced_is_refused():
    machine, period = oscillator(0.8)
    with pytest.raises(UnresolvedError, match="40 harmonics need more than 160 sub_intervals, and there are 64"):
        balanced(machine, period, 40, 64)
    machine, period = oscillator(1.0, damping=0.0)
    with pytest.raises(SolverError, match="not converged"):
        balanced(machine, period, 5, 32, most=2)
