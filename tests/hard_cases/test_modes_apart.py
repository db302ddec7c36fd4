"""Close, repeated and crossing modes.

Hard: eigenvectors of equal frequencies are any of their plane; two modes cross, or veer by less than the positions
tell. Right: each mode keeps its shape through a crossing however few positions there are beside it, planes of equal
modes are orthonormal and the same at every position, and responses do not depend on which vectors stand for them.
"""

from importlib import import_module

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene import Scene
from fenics_mech.solve import followed_modes
from tests.common import modes_of
from tests.studies.test_natural_frequencies import two_oscillators

SOLVER = import_module("fenics_mech.solve.held_modes")  # whose name is that of a function too


@pytest.fixture
def followed(monkeypatch):
    """Follow modes ``(positions, modes)`` whose mass matrix is 1."""

    def follow(omega, shapes):
        each = ((w, x.T / w, np.eye(2)) for w, x in zip(omega, shapes))
        monkeypatch.setattr(SOLVER, "_each_held", lambda *_: each)
        return followed_modes(two_oscillators(), np.arange(float(len(omega))))

    return follow


def overlaps(found):
    """How much each mode is the one of the next position."""
    return np.einsum("knm,knm->km", found.momenta[:-1], found.shapes[1:])


def of_pair(gap, count, rng):
    """Two modes of ``[[x, gap], [gap, -x]]`` that come near each other twice a cycle, with signs by chance."""
    x = np.cos(2 * np.pi * (np.arange(count) + 0.25) / count)
    matrices = np.array([[[100 + a, gap], [gap, 100 - a]] for a in x])
    squares, vectors = np.linalg.eigh(matrices)
    shapes = vectors.transpose(0, 2, 1) * rng.choice([-1, 1], (count, 2, 1))
    return np.sqrt(squares), shapes, x


@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-6, 1e-3])
@pytest.mark.parametrize("count", [16, 90, 1000])
def test_modes_that_cross_keep_their_shapes(gap, count, rng, followed):
    """A gap that no position sees is a crossing: frequencies go on smoothly, and signs do not jump."""
    omega, shapes, x = of_pair(gap, count, rng)
    found = followed(omega, shapes)
    rising = np.sqrt(100 + np.sign(x) * np.hypot(x, gap))
    assert np.abs(found.omega[:, int(x[0] > 0)] - rising).max() < 1e-12
    assert overlaps(found).min() > 0.99 - 2 * gap * count
    assert np.abs(np.abs(found.momenta[-1].T @ found.shapes[0]) - np.eye(2)).max() < 1 - np.sqrt(0.5)


@pytest.mark.parametrize("gap", [0.3, 1.0])
def test_modes_that_veer_exchange_their_shapes(gap, rng, followed):
    """With a gap that the positions resolve, frequencies stay in order, and each step turns the shapes a little."""
    omega, shapes, _ = of_pair(gap, 90, rng)
    found = followed(omega, shapes)
    assert (np.diff(found.omega, axis=1) > 0).all()
    assert overlaps(found).min() > 0.95


def star(count, **rest):
    """Equal arms on one shaft, in one plane: each natural frequency is there as many times."""
    member = {"section": "strip", "material": "steel"}
    tips = {f"P{i}": (0.3 * np.cos(a), 0.3 * np.sin(a)) for i, a in enumerate(2 * np.pi * np.arange(count) / count)}
    members = {f"m{i}": {"ends": ("O", f"P{i}")} | member for i in range(count)}
    return Scene.read(
        {
            "materials": {"steel": {"modulus": 206e9, "density": 7850}},
            "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.002}},
            "ground": {"points": {"O": (0, 0)}},
            "links": {"star": {"points": {"O": (0, 0)} | tips, "members": members}},
            "joints": {"O": {"connect": ["ground.O", "star.O"]}},
            "drive": {"joint": "O", "speed": 20.0},
            "gravity": [0, -9.81],
            "damping": {"ratio": 0.02},
        }
        | rest
    )


def test_repeated_frequencies_of_equal_arms():
    """Six arms: mode 1 six times, to rounding; the plane of its shapes is the same at every position."""
    modes = modes_of(star(6, analysis={"sub_intervals": 12, "modes": 12})).modes
    for first in (0, 6):
        same = modes.omega[:, first : first + 6]
        assert np.ptp(same) < 1e-9 * same.mean()
    shapes, momenta = modes.shapes.transpose(0, 2, 1), modes.momenta
    assert np.abs(shapes @ momenta - np.eye(12)).max() < 1e-9
    first = np.sort(modes.omega[:, :6], axis=1)
    assert np.ptp(first) < 1e-9 * first.mean()


def test_all_of_equal_modes_are_found_by_slepc(monkeypatch):
    """A Krylov space may hold five of six equal modes; the pivots of ``K - number M`` count them."""
    scene = star(6, analysis={"sub_intervals": 4, "modes": 8})
    known = modes_of(scene).frequency
    monkeypatch.setattr(SOLVER, "DENSE", 0)
    monkeypatch.setattr(SOLVER, "SPARE", 0)
    assert np.abs(np.sort(modes_of(scene).frequency, axis=1) / np.sort(known, axis=1) - 1).max() < 1e-7


@pytest.mark.parametrize(("solver", "bound"), [("sub-intervals", 1e-8), ("collocation", 1e-5)])
def test_a_response_does_not_depend_on_the_vectors_of_a_plane(solver, bound):
    """Each arm of six moves as one alone, under its weight; of the six, collocation leaves fast modes undamped."""
    analysis = {"sub_intervals": 72, "solver": solver, "modes": 6, "stations": 3}
    six = analyse(star(6, analysis=analysis)).data["strain"].sel(member="star.m0")
    one = analyse(star(1, analysis=analysis | {"modes": 1})).data["strain"].sel(member="star")
    assert np.abs(six.to_numpy() - one.to_numpy()).max() < bound * np.abs(one).max()
