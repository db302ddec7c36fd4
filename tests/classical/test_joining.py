"""The parts that join sub-intervals: one oscillator, the cyclic system (5.16), modes that are followed."""

import numpy as np
import pytest

from fenics_mech.classical.joining import Closed, flat, forced, free, marched, steady, whole
from fenics_mech.classical.modes import closing, followed
from fenics_mech.errors import SolverError

RNG = np.random.default_rng(5)


def test_an_oscillator_from_rest_is_that_of_the_closed_form():
    """Constant load, y = p/w^2 (1 - cos w t), and a ramp without damping, y = s/w^2 (t - sin(w t)/w)."""
    omega, zeta, load, slope, t = (np.array([[x]]) for x in (3.0, 0.0, 2.0, 0.7, 0.4))
    y = (2.0 / 9) * (1 - np.cos(1.2)) + 0.7 / 9 * (0.4 - np.sin(1.2) / 3)
    rate = 2.0 / 3 * np.sin(1.2) + 0.7 / 9 * (1 - np.cos(1.2))
    np.testing.assert_allclose(forced(omega, zeta, load, slope, 0.4)[0, 0], [y, rate / 3], rtol=1e-14)
    assert t[0, 0] == 0.4


def test_a_damped_oscillator_fulfils_its_equation():
    """Half a step twice is a whole step, and the load without vibration goes on by itself."""
    omega, load, slope = RNG.uniform(1, 50, (3, 4, 2))
    zeta = RNG.uniform(0, 0.6, (4, 2))
    np.testing.assert_allclose(free(omega, zeta, 0.05) @ free(omega, zeta, 0.05), free(omega, zeta, 0.1), atol=1e-14)
    still, later = (steady(omega, zeta, load, slope, t) for t in (0.0, 0.1))
    carried = np.einsum("kmij,kmj->kmi", free(omega, zeta, 0.1), still) + forced(omega, zeta, load, slope, 0.1)
    np.testing.assert_allclose(carried, later, rtol=1e-12)
    y = [steady(omega, zeta, load, slope, t)[..., 0] for t in (-1e-3, 0.0, 1e-3)]
    left = 2 * zeta * omega * (y[2] - y[0]) / 2e-3 + omega**2 * y[1]
    np.testing.assert_allclose(left, load, rtol=1e-9)


def cycle(count=7, modes=3):
    omega, zeta = RNG.uniform(20, 90, (count, modes)), np.full((count, modes), 0.05)
    join = np.tile(np.eye(2 * modes), (count, 1, 1)) + RNG.uniform(-0.2, 0.2, (count, 2 * modes, 2 * modes))
    force = flat(forced(omega, zeta, *RNG.uniform(-1, 1, (2, count, modes)), 0.02))
    return join, whole(free(omega, zeta, 0.02)), force


@pytest.mark.parametrize(
    "options", [{}, {"periodic_ksp_type": "gmres", "periodic_pc_type": "ilu", "periodic_ksp_rtol": 1e-13}]
)
def test_the_states_go_on_from_one_sub_interval_to_the_next(options):
    """Every one of (5.14), and (5.15) from the last to the first."""
    join, transition, force = cycle()
    starts = Closed(join @ transition, options).solve(np.einsum("kij,kj->ki", join, force))
    ends = np.einsum("kij,kj->ki", transition, starts) + force
    ahead = np.einsum("kij,kj->ki", join, ends)
    np.testing.assert_allclose(np.roll(ahead, 1, axis=0), starts, atol=1e-11 * np.abs(starts).max())


def test_a_ksp_that_does_not_converge_raises_with_its_reason():
    options = {"periodic_ksp_type": "gmres", "periodic_pc_type": "none", "periodic_ksp_max_it": 2}
    join, transition, force = cycle()
    with pytest.raises(SolverError, match="DIVERGED_MAX_IT"):
        Closed(join @ transition, options).solve(np.einsum("kij,kj->ki", join, force))


def test_a_march_without_load_stays_at_rest():
    join, transition, force = cycle()
    assert not marched(join, transition, 0 * force, 0 * force).any()


def test_modes_that_cross_are_followed_by_their_shapes():
    """Two modes whose frequencies cross, with shapes that turn slowly and signs by chance, for half a turn."""
    angle = np.linspace(0, np.pi, 25)[:-1]
    shapes = np.stack([np.stack([np.cos(angle), np.sin(angle)], -1), np.stack([-np.sin(angle), np.cos(angle)], -1)], 1)
    omega = np.stack([10 + 5 * np.sin(angle), np.full(24, 12.0)], axis=-1)
    order = np.argsort(omega, axis=1)
    rows = np.arange(24)[:, None]
    mixed = shapes[rows, order] * RNG.choice([-1, 1], (24, 2, 1))
    mixed[0] = shapes[0]
    modes = followed(omega[rows, order], mixed, mixed)
    np.testing.assert_allclose(modes.omega, omega)
    np.testing.assert_allclose(modes.shapes, shapes)
    np.testing.assert_array_equal(closing(modes), -np.eye(2))  # after half a turn they point the other way
