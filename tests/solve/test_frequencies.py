"""Natural modes against closed forms, and against dense matrices of the free coordinates."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp

from fenics_mech.geometry import PLANE, SPACE
from fenics_mech.machine import Machine
from fenics_mech.solve import equilibrium, frequencies, tangents_at
from fenics_mech.terms import Damper, Look
from tests.machine.builders import STEEL, Bar, Members, pin
from tests.solve.test_lateral_buckling import TIP, clamped
from tests.solve.test_spatial_linkages import rssr
from tests.solve.test_statics import CRITICAL, column

THICK, DENSITY = 0.02, 7850.0
EI = STEEL * THICK**4 / 12


def square(geometry, thick, tau):
    """Give a square steel bar."""
    bends, area = geometry.d - 1, thick**2
    bending, rotary = [STEEL * thick**4 / 12] * bends, [DENSITY * thick**4 / 12] * bends
    return Bar(STEEL * area, bending, DENSITY * area, 0.14 * STEEL / 2.6 * thick**4, rotary, tau)


def bars(geometry, count, elements, tau=0.0, fixed="place and turn", scale=1.0):
    """Build bars of 1 m, or of a scale, side by side, each with one end clamped or free."""
    machine, (x, y) = Machine(geometry), scale * np.eye(geometry.d)[:2]
    members = Members(machine)
    for k in range(count):
        ends = machine.add_pose(k * y, fixed=fixed), machine.add_pose(x + k * y)
        members.add(*ends, elements, square(geometry, THICK * scale, tau), y)
    members.done()
    return machine


def unloaded(machine):
    return tangents_at(machine, *np.zeros((2, machine.size)))


def dense(machine, M, C, K):
    """Give the rates by dense matrices of the coordinates that the rows leave free."""
    n, rows = machine.n, K.toarray()[machine.n :, : machine.n]
    free = scipy.linalg.null_space(rows) if len(rows) else np.eye(n)
    M, C, K = (free.T @ X.toarray()[:n, :n] @ free for X in (M, C, K))
    first = np.block([[0 * M, np.eye(len(M))], [-np.linalg.solve(M, np.hstack([K, C]))]])
    rates = np.linalg.eigvals(first)
    return rates[np.lexsort((rates.imag, np.abs(rates)))]


@pytest.mark.parametrize("count", [1, 5, 12])
@pytest.mark.parametrize("tau", [None, 0.0, 1e-4])
def test_bars_that_are_alike_have_all_their_equal_modes(count, tau):
    """Every bar has the modes of a cantilever in two planes, at roots of cos z cosh z = -1."""
    machine = bars(SPACE, count, 8, tau or 0.0)
    M, C, K = unloaded(machine)
    rates, shapes = frequencies(M, None if tau is None else C, K, 2 * count + 2)
    held = np.array([1.875104, 4.694091]) ** 2 * np.sqrt(EI / (DENSITY * THICK**2))
    exact = np.repeat(held, [2 * count, 2])
    ratio = (tau or 0.0) * exact / 2
    # the rotary inertia lowers the second pair by 1e-3, which the closed form leaves out
    np.testing.assert_allclose(rates.imag, exact * np.sqrt(1 - ratio**2), rtol=1.5e-3)
    np.testing.assert_allclose(rates.real, -ratio * exact, rtol=3e-3, atol=0 if tau is None else 1e-6)
    first = shapes[: machine.n, : 2 * count]
    assert np.linalg.matrix_rank(first, tol=1e-6 * np.linalg.norm(first)) == 2 * count


def test_small_machines_have_the_same_modes_in_their_units():
    """Lengths a millionth: frequencies a million times as high, and damping of the same ratio."""
    found = [frequencies(*unloaded(bars(SPACE, 1, 4, 1e-4 * scale, scale=scale)), 6)[0] * scale for scale in (1, 1e-6)]
    np.testing.assert_allclose(*found, rtol=1e-8)


@pytest.mark.parametrize("geometry", [PLANE, SPACE], ids=lambda g: g.name)
@pytest.mark.parametrize("elements", [1, 2, 40])
@pytest.mark.parametrize("with_rates", [False, True])
def test_a_free_bar_has_its_rigid_motions_at_0_and_its_modes_beside(geometry, elements, with_rates):
    rigid, bends = {2: (3, 1), 3: (6, 2)}[geometry.d]
    M, C, K = unloaded(bars(geometry, 1, elements, fixed=""))
    rates, shapes = frequencies(M, C if with_rates else None, K, rigid + 4 * bends)
    assert (rates[:rigid] == 0).all()
    assert np.linalg.matrix_rank(shapes[:, :rigid], tol=1e-6 * np.linalg.norm(shapes)) == rigid
    exact = 4.730041**2 * np.sqrt(EI / (DENSITY * THICK**2))
    np.testing.assert_allclose(rates[rigid : rigid + bends].imag, exact, rtol={1: 0.25, 2: 3e-3, 40: 1e-3}[elements])


def test_a_rigid_motion_with_a_damper_has_its_decay():
    machine = bars(PLANE, 1, 2, fixed="")
    tip = machine.end(1)
    machine.terms.append(Damper([(machine.at_ground(), tip)], 3.0, Look.PLACE, 0))
    rates, _ = frequencies(*unloaded(machine), 4)
    assert (rates[:3] == 0).all()
    assert rates[3] == pytest.approx(-3.0 / (DENSITY * THICK**2), rel=1e-6)


@pytest.mark.parametrize("count", [3, 8])
def test_rows_of_joints_hold_as_without_them(count):
    """An RSSR held as drawn, with the dampers at its thirds and without: against dense matrices."""
    machine = rssr(count, 60.0).machine
    q, a = equilibrium(machine, moving=False)
    M, C, K = tangents_at(machine, q, a, moving=False)
    for damping in (None, C):
        exact = dense(machine, M, 0 * M if damping is None else damping, K)
        exact = exact[exact.imag > 0][:6]
        found, shapes = frequencies(M, damping, K, 6)
        np.testing.assert_allclose(found, exact, rtol=1e-7, atol=1e-7 * np.abs(exact[0]))
        gaps = K[machine.n :] @ shapes
        assert np.abs(gaps).max() < 1e-9 * np.abs(shapes[: machine.n]).max()


def test_a_hanging_double_pendulum_has_its_two_frequencies_and_no_more():
    """M = m l^2 (4/3, 1/2; 1/2, 1/3), K = m g l (3/2, 0; 0, 1/2) of two equal rods."""
    machine, thin = Machine(PLANE, [0, -9.81]), np.eye(2) / 24
    first, second = machine.add_pose(np.zeros(2), fixed="place"), machine.add_pose(np.array([0, -1.0]))
    for pose, centre in ((first, -0.5), (second, -1.5)):
        machine.masses.add_body(machine.end(pose, np.array([0, centre])), 1.0, thin)
    joint = np.array([0, -1.0])
    pin(machine, machine.end(first, joint), machine.end(second, joint))
    exact = scipy.linalg.eigvalsh(9.81 * np.diag([1.5, 0.5]), [[4 / 3, 1 / 2], [1 / 2, 1 / 3]])
    M, C, K = tangents_at(machine, *equilibrium(machine))
    for damping in (None, C):
        np.testing.assert_allclose(frequencies(M, damping, K, 9)[0], 1j * np.sqrt(exact), rtol=1e-9, atol=1e-9)


def test_a_column_beyond_its_load_grows_and_its_other_modes_swing():
    machine, _ = column(4, 1.1 * CRITICAL)
    M, C, K = tangents_at(machine, *equilibrium(machine))
    exact = np.abs(dense(machine, M, 0 * M, K)[[0, 2]])
    np.testing.assert_allclose(frequencies(M, None, K, 2)[0], exact * [1, 1j], rtol=1e-7)
    both = frequencies(M, C, K, 2)[0]
    np.testing.assert_allclose(np.sort(both.real), [-exact[0], exact[0]], rtol=1e-7)


def test_coordinates_without_mass_follow():
    """A strip without rotary inertia beyond its lateral buckling load, where rounding makes its mass indefinite."""
    machine = clamped(2, 1.3 * TIP)
    M, _, K = tangents_at(machine, *equilibrium(machine))
    squares = 1 / scipy.linalg.eigvals(M.toarray(), K.toarray()).real
    exact = squares[np.argsort(np.abs(squares))][:3]
    np.testing.assert_allclose(frequencies(M, None, K, 3)[0], np.emath.sqrt(-exact), rtol=1e-7)


def test_a_follower_force_flutters():
    """Two equal frequencies that a force drives together: rates +-r + i w, though no force goes with rates."""
    M, K = sp.eye(2, format="csr"), sp.csr_matrix(np.array([[4.0, 1.0], [-1.0, 4.0]]))
    exact = np.sqrt(-4 + 1j)
    found = frequencies(M, None, K, 2)[0]
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex([exact, -exact.conj()]), rtol=1e-9)
