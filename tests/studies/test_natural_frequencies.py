"""Natural frequencies at positions: convergence, following, large machines by SLEPc, freedoms that are held."""

from importlib import import_module
from types import SimpleNamespace

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.errors import SolverError
from fenics_mech.geometry import PLANE
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.solve import followed_modes, held_modes
from tests.common import modes_of

SOLVER = import_module("fenics_mech.solve.held_modes")  # whose name is that of a function too


def two_oscillators():
    """A machine of two coordinates that are no places."""
    still = SimpleNamespace(at=lambda t: SimpleNamespace(R=np.zeros((len(t), 1, 2, 2))))
    return SimpleNamespace(n=2, places=np.full((1, 3), -1), geometry=PLANE, known=still)


@pytest.fixture
def by_slepc(monkeypatch):
    """Let SLEPc find the slowest modes of machines of all sizes."""
    monkeypatch.setattr(SOLVER, "DENSE", 0)
    monkeypatch.setattr(SOLVER, "DENSE_AT_REST", 0)


def test_simply_supported_members(seed):
    # section 7.4 prints 298.2 and 318.1 rad/s; the data give 298.8 and 318.8
    omega = {label: 2 * np.pi * f[0] for label, f in simply_supported_frequencies(seed).items()}
    assert omega["coupler"] == pytest.approx(298.8, abs=0.05)
    assert omega["follower"] == pytest.approx(318.8, abs=0.05)


@pytest.mark.parametrize("mode", [0, 2])
def test_frequencies_converge_with_the_fourth_power_of_the_element_size(mode):
    def frequency(elements):
        scene = seed_four_bar(mesh={"elements": elements}, analysis={"sub_intervals": 4, "modes": 4})
        return np.sort(modes_of(scene).frequency[0])[mode]

    exact = frequency(48)
    errors = [frequency(n) - exact for n in (4, 8, 16)]
    assert all(error > 0 for error in errors)  # Rayleigh: from above
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(rates - 4) < 0.1)


@pytest.mark.parametrize("elements", [3, 6])
def test_errors_by_the_mesh_are_told(elements):
    """Against 24 elements; of bending a quarter more is told, as errors of stretching fall with the square alone."""
    scene = seed_four_bar(mesh={"elements": elements}, analysis={"sub_intervals": 8, "modes": 5})
    coarse, fine = (fm.modes(one).data for one in (scene, scene.changed(mesh__elements=24)))
    both = (np.sort(one["frequency"].to_numpy(), axis=1) for one in (coarse, fine))
    first, second = (one[0] for one in both)
    told = coarse["frequency_error"].to_numpy()
    assert (told > 0.6 * (first / second - 1)).all()  # the mean of the cycle, and at its start
    assert told.max() < 2 * (first / second - 1).max()


def test_modes_are_orthonormal_and_their_signs_do_not_jump(seed):
    found = modes_of(seed.changed(analysis__modes="all", analysis__sub_intervals=72)).modes
    for shape, momentum in zip(found.shapes, found.momenta):
        assert np.abs(shape.T @ momentum - np.eye(27)).max() < 1e-8
    overlap = np.einsum("knm,knm->km", found.momenta[:-1], found.shapes[1:])
    assert overlap[:, :6].min() > 0.8


def test_assurance_is_at_most_one(seed):
    assurance = modes_of(seed.changed(analysis__sub_intervals=90, analysis__modes=8)).modes.assurance
    assert assurance.max() <= 1 + 1e-12
    assert assurance.min() > 0.8


def test_slepc_finds_what_lapack_finds(seed, monkeypatch):
    scene = seed.changed(analysis__sub_intervals=8, analysis__modes=6)
    dense = modes_of(scene).frequency
    monkeypatch.setattr(SOLVER, "DENSE", 0)
    np.testing.assert_allclose(modes_of(scene).frequency, dense, rtol=1e-7)  # it stops at 1e-8 of an eigenvalue


def test_slepc_finds_rigid_motions_too(by_slepc):
    free = seed_four_bar(drive=(), analysis={"method": "static", "modes": 3})
    found = fm.modes(free)
    assert found.free == ("link crank can turn freely about joint O and moves coupler, follower with it",)
    frequency = found.data["frequency"].to_numpy()[0]
    assert frequency[0] == 0
    assert frequency.shape == (4,)
    assert frequency[1] > 1


def test_a_solver_that_cannot_converge_names_the_position(seed, by_slepc):
    options = {"modes_eps_max_it": 1, "modes_eps_tol": 1e-30, "modes_eps_ncv": 7}
    held = modes_of(seed.changed(analysis__sub_intervals=4))
    with pytest.raises(SolverError, match="modes of the machine held at 0 s: SLEPc has found"):
        followed_modes(held.made.machine, held.t, 5, options=options)
    with pytest.raises(SolverError, match="modes_"):
        followed_modes(held.made.machine, held.t, 5, options={"modes_eps_type": "abacus"})


def test_modes_do_not_depend_on_the_positions_before_them(seed):
    held = modes_of(seed.changed(analysis__sub_intervals=8))
    found = np.sort(held.every.omega, axis=1)
    np.testing.assert_allclose(held_modes(held.made.machine, held.t[5])[0], found[5], rtol=1e-9)


def test_a_mode_is_followed_through_a_crossing(monkeypatch):
    """Two uncoupled oscillators whose frequencies cross in the middle of the cycle."""
    theta = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    first, second = 10 + np.cos(theta), np.full(40, 10.1)

    def each(*_):
        for k, pair in enumerate(zip(first, second)):
            order = np.argsort(pair)
            yield np.array(pair)[order], (1 - 2 * (k % 3 > 0)) * np.eye(2)[:, order] / np.array(pair)[order], np.eye(2)

    monkeypatch.setattr(SOLVER, "_each_held", each)
    found = followed_modes(two_oscillators(), theta)
    np.testing.assert_allclose(found.omega, np.stack([second, first], axis=1))
    assert found.assurance.min() > 1 - 1e-12


def test_freedoms_are_held_where_they_start():
    """A clamped beam on a shaft with a freedom has the frequencies of one whose shaft a drive holds."""
    beam = {
        "materials": {"steel": {"modulus": 206e9, "density": 7850}},
        "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.002}},
        "ground": {"points": {"O": (0, 0)}},
        "links": {"arm": {"points": {"O": (0, 0), "T": (0.3, 0)}, "members": {"OT": {"ends": ("O", "T")}}}},
        "joints": {"O": {"connect": ["ground.O", "arm.O"]}},
        "analysis": {"method": "static", "modes": 3},
    }
    beam["links"]["arm"]["members"]["OT"] |= {"section": "strip", "material": "steel", "mesh": {"elements": 8}}
    found = fm.modes(fm.Scene.read(beam | {"freedoms": {"O": {"start": "30 deg"}}}))
    assert found.free == ("the freedom at joint O is held where it starts, at 30 deg",)
    roots = np.array([1.875104, 4.694091, 7.854757])  # of cos z cosh z = -1
    line, bending = 7850 * 0.02 * 0.002, 206e9 * 0.02 * 0.002**3 / 12
    exact = roots**2 / 0.3**2 * np.sqrt(bending / line) / (2 * np.pi)
    np.testing.assert_allclose(found.data["frequency"][0], exact, rtol=1e-3)  # eight elements
