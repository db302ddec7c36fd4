"""Damping ratios of modes: of a held machine, of a rigid motion, and what is left out."""

import numpy as np
import pytest

from fenics_mech.solve import damp_modes, frequencies, held_modes, periodic, rigid_cycle, tangents_at
from tests.machine.builders import Bar, chain, seed

PERIOD = 2 * np.pi / 32.3  # s


def arm():
    bar = Bar(2e6, [3.0, 5.0], 0.1, 2.0, [1e-5, 2e-5])
    machine, _ = chain(np.outer(np.linspace(0, 1, 5), [0.3, 0.1, 0.2]), bar, np.array([0, 0, 1.0]))
    machine.masses.add_body(machine.end(4), 0.2, 1e-3 * np.diag([1, 2, 3]))
    return machine


@pytest.mark.parametrize("build", [lambda: seed(3, tau=0.0), arm], ids=["plane", "space"])
def test_a_held_machine_vibrates_with_the_ratios_of_its_modes(build):
    """Eigenvalues -zeta w +- i w sqrt(1 - zeta^2), by definition."""
    machine, stated = build(), np.array([0.03, 0.01, 0.02])
    omega, _ = held_modes(machine, 0.0)
    damp_modes(machine, 1.0, stated, fastest=1e9, positions=1)
    zero = np.zeros(machine.size)
    found = frequencies(*tangents_at(machine, zero, zero, moving=False), len(omega))[0][:8]
    ratios = stated[np.minimum(np.arange(8), 2)]
    exact = omega[:8] * (-ratios + 1j * np.sqrt(1 - ratios**2))
    np.testing.assert_allclose(found, exact, atol=1e-6 * omega[0])


def test_a_rigid_motion_has_no_drag():
    machine = seed(3, tau=0.0)
    machine.chart = rigid_cycle(machine, PERIOD)
    undamped = machine.size
    damp_modes(machine, PERIOD, 0.02)
    assert machine.size == undamped + machine.terms[0].modes
    zero = np.zeros((5, machine.size))
    found = machine.residual(PERIOD * np.arange(5) / 5, zero, zero, zero)
    # N m s^-1/2 each, of patterns of 1 to 10; the chart's places are known to 1e-12 of 0.3 m
    assert np.abs(found.force[:, -machine.terms[0].modes :]).max() < 1e-8


@pytest.mark.slow
def test_modes_left_out_and_positions_between_change_little():
    """Against all modes at twice the positions; the seed at its speed."""
    curvatures = []
    for fastest, positions in ((1e9, 72), (32.0, 36), (32.0, 12), (4.0, 36)):
        machine = seed(3, tau=0.0)
        machine.chart = rigid_cycle(machine, PERIOD)
        damp_modes(machine, PERIOD, 0.02, fastest=fastest, positions=positions)
        curvatures.append(periodic(machine, PERIOD, 40).evaluation.terms[0].x[..., 2])
    whole, usual, *poor = curvatures
    assert np.abs(usual - whole).max() < 1e-4 * np.abs(whole).max()
    for coarse in poor:
        assert np.abs(coarse - whole).max() > 1e-4 * np.abs(whole).max()
