"""Natural frequencies against printed values, textbook beams and convergence rates; tracking."""

import numpy as np
import pytest
import scipy.linalg

from benchmarks import scaling
from fenics_mech._petsc import to_scipy
from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.eigenmodes.eigen import _solve_among
from fenics_mech.eigenmodes.tracking import track
from fenics_mech.errors import SolverError
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.setup import CommonParts, mechanism
from fenics_mech.scene.factories import seed_four_bar
from tests.common import scene_modes


def test_frequencies_of_27_dofs():
    # computed once by two independent programs: 27 dofs, Hz, at drive angles 0 and 90 deg
    scene = seed_four_bar(analysis={"sub_intervals": 4, "modes": 6})
    frequency = np.sort(scene_modes(scene, mechanism(scene)).frequency, axis=1)
    assert np.allclose(frequency[0], [43.303, 48.744, 62.157, 194.597, 208.326, 475.912], atol=6e-4)
    assert np.allclose(frequency[1], [46.651, 50.171, 81.399, 192.463, 206.778, 476.599], atol=6e-4)


def test_simply_supported_members(seed):
    # section 7.4 prints 298.2 and 318.1 rad/s; the data give 298.8 and 318.8
    omega = {label: 2 * np.pi * f[0] for label, f in simply_supported_frequencies(seed).items()}
    assert omega["coupler"] == pytest.approx(298.8, abs=0.05)
    assert omega["follower"] == pytest.approx(318.8, abs=0.05)


@pytest.mark.parametrize(("mode", "order"), [(0, 4), (2, 4)])
def test_frequencies_converge_with_the_fourth_power_of_the_element_size(mode, order):
    def frequency(elements):
        scene = seed_four_bar(mesh={"elements": elements}, analysis={"sub_intervals": 4, "modes": 4})
        return np.sort(scene_modes(scene, mechanism(scene)).frequency[0])[mode]

    exact = frequency(48)
    errors = [frequency(n) - exact for n in (4, 8, 16)]
    assert all(error > 0 for error in errors)  # Rayleigh: from above
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(rates - order) < 0.1)


def test_no_speed_changes_modes_and_damping_under_exact_strains():
    """Their law has the axial forces, so that modes are those of the linear links, made once for all speeds."""
    scene = seed_four_bar(effects=("coupling", "large-rotations"), analysis={"sub_intervals": 4, "modes": 4})
    common = CommonParts()
    systems = [mechanism(scene.changed(drive__speed=speed), common=common) for speed in (20.0, 40.0)]
    slow, fast = (solve_modes(system, 4) for system in systems)
    assert fast is slow
    one, other = (modal_damping(0.02, system) for system in systems)
    assert other.values is one.values
    linear = mechanism(scene.changed(effects=("coupling",)))
    assert (slow.frequency == scene_modes(scene, linear).frequency).all()


def test_sparse_and_dense_eigensolvers_agree():
    scene = seed_four_bar(analysis={"sub_intervals": 8, "modes": 6})
    system = mechanism(scene)
    dense = solve_modes(system, 6)
    sparse = solve_modes(
        system,
        6,
        {
            "modes_eps_type": "krylovschur",
            "modes_eps_target": 0.0,
            "modes_eps_target_magnitude": "",
            "modes_st_type": "sinvert",
        },
    )
    assert np.allclose(dense.frequency, sparse.frequency, rtol=1e-9)


def test_modes_are_orthonormal_and_their_signs_do_not_jump(seed):
    modes = scene_modes(
        seed.changed(analysis__modes="all", analysis__sub_intervals=72),
        mechanism(seed.changed(analysis__sub_intervals=72)),
    )
    system = mechanism(seed.changed(analysis__sub_intervals=72))
    for k, mass, _ in system.positions():
        gram = modes.shapes[k] @ mass[:, :] @ modes.shapes[k].T
        assert np.abs(gram - np.eye(27)).max() < 1e-8
    assert np.einsum("kii->ki", modes.transfer)[:-1, :6].min() > 0.8


def test_tracking_follows_modes_through_a_crossing():
    # two uncoupled oscillators whose frequencies cross at the middle of the cycle
    theta = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    first, second = 10 + np.cos(theta), np.full(40, 10.1)
    swapped = second < first
    omega = np.where(swapped[:, None], np.stack([second, first], 1), np.stack([first, second], 1))
    shapes = (
        np.where(swapped[:, None, None], np.eye(2)[::-1], np.eye(2)) * np.where(np.arange(40) % 3, 1, -1)[:, None, None]
    )
    transfer = np.roll(shapes, -1, axis=0) @ shapes.transpose(0, 2, 1)
    modes = track(theta, omega, shapes, transfer, transfer.transpose(0, 2, 1), np.ones_like(omega))
    start = [second, first] if swapped[0] else [first, second]
    assert np.array_equal(modes.omega, np.stack(start, axis=1))
    assert modes.assurance.min() == 1
    assert np.all(np.einsum("kii->ki", modes.transfer)[:-1] > 0)


def test_solver_that_cannot_converge_names_the_angle(seed_system):
    options = {"modes_eps_type": "krylovschur", "modes_eps_max_it": 1, "modes_eps_tol": 1e-30}
    with pytest.raises(SolverError, match="at drive angle 0 deg"):
        solve_modes(seed_system, 5, options)


def test_solver_that_does_not_exist_is_an_error(seed_system):
    with pytest.raises(SolverError, match="modes_"):
        solve_modes(seed_system, 5, {"modes_eps_type": "abacus"})


def test_assurance_is_at_most_one(seed):
    scene = seed.changed(analysis__sub_intervals=90, analysis__modes=8)
    assurance = scene_modes(scene, mechanism(scene)).assurance
    assert assurance.max() <= 1 + 1e-12
    assert assurance.min() > 0.8


def test_links_that_are_alike_have_modes_at_nearly_one_frequency(monkeypatch):
    # 14 couplers and followers of each kind: nine of the lowest ten frequencies are within 1e-4 of each other
    monkeypatch.setattr(scaling, "THICKER", 0.0)
    system = mechanism(scaling.chain(14, analysis__sub_intervals=4))
    found = np.sort(solve_modes(system, 5).omega, axis=1)
    for k, mass, stiffness in system.positions(symmetric=True):
        dense = scipy.linalg.eigh(to_scipy(stiffness).toarray(), to_scipy(mass).toarray(), eigvals_only=True)
        assert np.allclose(found[k], np.sqrt(dense[:5]), rtol=1e-7)  # SLEPc stops at 1e-8 of an eigenvalue


def test_modes_do_not_depend_on_the_positions_before_them(seed):
    system = mechanism(seed.changed(analysis__sub_intervals=8))
    whole, part = (_solve_among(system, among, 3, {}) for among in (slice(0, 8), slice(5, 8)))
    for one, other in zip(whole, part):
        assert np.array_equal(one[5:], other)
