"""Cycles closed by marches, against closed forms and dense matrices."""

import numpy as np
import pytest

from fenics_mech.errors import SolverError
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.mechanism.modal_forces import ModalForces
from fenics_mech.response.periodic.collocation import periodic_orbit
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.tableau import Tableau
from tests.response.synthetic import PERIOD, Manufactured, oscillators, places

RATE = 2 * np.pi / PERIOD


def growing(power, count=200):
    """``x'' - s^2 x = cos(rate t)``: motions beside the periodic one grow by 10^power in a cycle."""
    tableau = Tableau.of("radau", 3)
    time = places(tableau.points, count)
    s = power * np.log(10) / PERIOD
    matrices = oscillators(time, np.array([1.0]), np.zeros(1), np.cos(RATE * time)[:, None])
    matrices.stiffness.values[:] = -(s**2)
    flow = Flow(matrices, tableau, PERIOD / count)
    starts = PERIOD / count * np.arange(count)
    return flow, -np.cos(RATE * starts) / (RATE**2 + s**2)


@pytest.mark.parametrize("power", [11, 50, 110])
def test_motions_that_grow_out_of_all_bounds(power):
    """Where a march through the cycle is lost to rounding, it is cut; the steps' own error is below 1e-6."""
    flow, expected = growing(power)
    found = periodic_orbit(flow).start[:, 0]
    assert len(flow.cycle.cuts) >= power / 6
    assert found == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


def test_a_march_that_does_not_grow_is_not_cut():
    flow, _ = growing(2)
    assert len(flow.cycle.cuts) == 1


@pytest.mark.parametrize("modes", [1, 2, 4])  # up to 2 of 6 stand beside the sparse matrices
def test_damped_modes_are_like_their_damping_matrix(modes):
    """The force ``F^T (F q' + H q)``, beside the matrices of the links or in them."""
    tableau, count = Tableau.of("radau", 3), 24
    plain = Manufactured().matrices(places(tableau.points, count))
    chance = np.random.default_rng(1)
    padded = [np.pad(part, ((0, 0), (0, 4), (0, 4))) + np.diag([0, 0, 1, 1, 1, 1]) for part in plain.full]
    load = np.pad(plain.load, ((0, 0), (0, 4)), constant_values=1.0)
    g, h = chance.standard_normal((2, len(load), modes, 6))
    whole = Matrices.of_full(*padded, load)
    back = g.transpose(0, 2, 1)
    modal = ModalForces(g, g, h)
    with_modes = Matrices(whole.mass, whole.damping, whole.stiffness, load, modal)
    expected = Matrices.of_full(padded[0], padded[1] + back @ g, padded[2] + back @ h, load)
    one, other = (periodic_orbit(Flow(part, tableau, PERIOD / count)) for part in (with_modes, expected))
    assert one.displacement == pytest.approx(other.displacement, abs=1e-10 * np.abs(other.displacement).max())
    assert one.acceleration == pytest.approx(other.acceleration, abs=1e-9 * np.abs(other.acceleration).max())


def test_iterations_that_end_too_early_are_refused():
    tableau, count = Tableau.of("radau", 3), 24
    matrices = Manufactured().matrices(places(tableau.points, count))
    flow = Flow(matrices, tableau, PERIOD / count, {"periodic_ksp_max_it": 1})
    with pytest.raises(SolverError, match=r"no reliable answer \(PETSc says DIVERGED_(ITS|MAX_IT), relative residual"):
        periodic_orbit(flow)


def test_states_that_die_out_are_not_lost():
    """A disturbance that decays by e^-2000 in a cycle is followed to its end."""
    tableau, count = Tableau.of("gauss", 3), 2000
    time = places(tableau.points, count)
    decay = 2000 / PERIOD
    matrices = oscillators(time, np.array([1.1 * decay]), np.array([2 * decay]))
    flow = Flow(matrices, tableau, PERIOD / count)
    states, power = flow.passed(np.array([[1.0, 0.5], [0.2j, 0.0]], dtype=complex))
    assert np.isfinite(states).all()
    np.testing.assert_allclose(power[-1] + np.log(np.linalg.norm(states[-1], axis=-1)), -2000, rtol=0.01)


@pytest.mark.parametrize("states", [1, 4, 7])
@pytest.mark.parametrize("modes", [0, 1])
def test_states_beside_each_other_go_through_a_cycle_as_each_alone(states, modes):
    """Several at once are another compiled loop; the sums of a product may be rounded in another order."""
    tableau, count = Tableau.of("radau", 3), 24
    plain = Manufactured().matrices(places(tableau.points, count))
    padded = [np.pad(part, ((0, 0), (0, 4), (0, 4))) + np.diag([0, 0, 1, 1, 1, 1]) for part in plain.full]
    chance = np.random.default_rng(2)
    matrices = Matrices.of_full(*padded, np.zeros((count * 3, 6)))
    if modes:
        g, h = chance.standard_normal((2, count * 3, modes, 6))
        matrices = Matrices(matrices.mass, matrices.damping, matrices.stiffness, matrices.load, ModalForces(g, g, h))
    flow, starts = Flow(matrices, tableau, PERIOD / count), chance.standard_normal((12, states))
    passed = np.stack([flow.march(state) for state in starts.T], axis=-1)
    assert flow.after_cycle(starts) == pytest.approx(passed[-1], abs=1e-12 * np.abs(passed).max())
    of_step = flow.transitions[5] @ passed[5]
    assert of_step == pytest.approx(passed[6], abs=1e-12 * np.abs(passed).max())
    through, _ = flow.passed(starts.T.astype(complex))
    assert through == pytest.approx(passed.swapaxes(1, 2), abs=1e-12 * np.abs(passed).max())
