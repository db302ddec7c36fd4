"""The block-cyclic system: direct and iterative answers."""

import numpy as np
import pytest

from fenics_mech.errors import SolverError
from fenics_mech.response.periodic.cyclic import BlockCyclic


def system(multipliers, count=90, size=8):
    """Random transitions whose product has the given eigenvalues; the others are 0."""
    chance = np.random.default_rng(3)
    turned = [np.linalg.qr(chance.normal(size=(size, size)))[0] for _ in range(count)]
    step = np.diag(np.pad(np.asarray(multipliers, float), (0, size - len(multipliers))) ** (1 / count))
    transitions = np.stack([turned[(k + 1) % count] @ step @ turned[k].T for k in range(count)])
    return transitions, chance.normal(size=(count, size))


@pytest.mark.parametrize("options", [{}, {"periodic_ksp_type": "gmres"}, {"periodic_ksp_type": "bcgs"}])
@pytest.mark.parametrize("count", [1, 2, 24, 25, 90])
def test_states_follow_each_other_round_the_cycle(options, count):
    transitions, right = system([0.9, 0.5, 0.1], count)
    states = BlockCyclic(transitions, options).solve(right)
    ends = (transitions @ states[..., None])[..., 0] + right
    assert np.abs(np.roll(states, -1, axis=0) - ends).max() < 1e-10 * np.abs(states).max()


def test_an_iteration_that_ends_too_early_is_refused():
    options = {"periodic_ksp_type": "gmres", "periodic_pc_type": "none", "periodic_ksp_max_it": 1}
    transitions, right = system([0.9, 0.5, 0.1])
    with pytest.raises(SolverError, match=r"no reliable answer .*DIVERGED"):
        BlockCyclic(transitions, options).solve(right)


def test_states_that_grow_too_much_are_refused():
    """Where all steps are made one, the last equation holds, and rounding shows in the states at 1e-5 of them."""
    transitions, right = system([1e12, 0.5, 0.1])
    with pytest.raises(SolverError, match=r"no reliable answer .* Some motion grows too fast: a member buckles"):
        BlockCyclic(transitions, {}).solve(right)


def test_options_that_petsc_reads_as_it_factorises_are_heard():
    blocks = {"periodic_ksp_type": "gmres", "periodic_pc_type": "bjacobi", "periodic_sub_pc_type": "nonsense"}
    transitions, right = system([0.9, 0.5, 0.1], 10)
    said = r"periodic_\* stopped: .* no method of that name \(PETSc's code 86\)\. .*periodic_sub_pc_type = nonsense"
    with pytest.raises(SolverError, match=said):
        BlockCyclic(transitions, blocks).solve(right)


def test_the_solver_is_destroyed_with_its_system():
    transitions, right = system([0.9, 0.5, 0.1], 10)
    cycle = BlockCyclic(transitions, {})
    cycle.solve(right)
    ksp = cycle._ksp
    assert ksp
    del cycle
    assert not ksp
