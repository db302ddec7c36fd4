"""Close, repeated and crossing modes.

Hard: eigenvectors of equal frequencies are any of their plane; two modes cross, or veer by less than the positions
tell. Right: each mode keeps its shape through a crossing however few positions there are beside it, planes of equal
modes are orthonormal and the same at every position, and responses do not depend on which vectors stand for them.
"""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.eigenmodes import eigen
from fenics_mech.eigenmodes.tracking import track
from fenics_mech.response.setup import mechanism
from fenics_mech.scene import Scene
from tests.common import scene_modes


def followed(omega, shapes):
    """Track modes whose mass matrix is 1."""
    ahead = np.roll(shapes, -1, axis=0)
    transfer = ahead @ shapes.transpose(0, 2, 1)
    size = np.einsum("kmi,kmi->km", shapes, shapes)
    return track(np.arange(float(len(omega))), omega, shapes, transfer, transfer.transpose(0, 2, 1), size)


def of_pair(gap, count, rng):
    """Two modes of ``[[x, gap], [gap, -x]]`` that come near each other twice a cycle, with signs by chance."""
    x = np.cos(2 * np.pi * (np.arange(count) + 0.25) / count)
    matrices = np.array([[[100 + a, gap], [gap, 100 - a]] for a in x])
    squares, vectors = np.linalg.eigh(matrices)
    shapes = vectors.transpose(0, 2, 1) * rng.choice([-1, 1], (count, 2, 1))
    return np.sqrt(squares), shapes, x


@pytest.mark.parametrize("gap", [0.0, 1e-12, 1e-6, 1e-3])
@pytest.mark.parametrize("count", [16, 90, 1000])
def test_modes_that_cross_keep_their_shapes(gap, count, rng):
    """A gap that no position sees is a crossing: frequencies go on smoothly, and signs do not jump."""
    omega, shapes, x = of_pair(gap, count, rng)
    found = followed(omega, shapes)
    rising = np.sqrt(100 + np.sign(x) * np.hypot(x, gap))
    assert np.abs(found.omega[:, int(x[0] > 0)] - rising).max() < 1e-12
    assert np.einsum("kii->ki", found.transfer)[:-1].min() > 0.99 - 2 * gap * count
    assert np.abs(np.abs(found.closing) - np.eye(2)).max() == 0


@pytest.mark.parametrize("gap", [0.3, 1.0])
def test_modes_that_veer_exchange_their_shapes(gap, rng):
    """With a gap that the positions resolve, frequencies stay in order, and each step turns the shapes a little."""
    omega, shapes, _ = of_pair(gap, 90, rng)
    found = followed(omega, shapes)
    assert (np.diff(found.omega, axis=1) > 0).all()
    assert np.einsum("kii->ki", found.transfer)[:-1].min() > 0.95


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
    scene = star(6, analysis={"sub_intervals": 12, "modes": 12})
    system = mechanism(scene)
    modes = scene_modes(scene, system)
    for first in (0, 6):
        same = modes.omega[:, first : first + 6]
        assert np.ptp(same) < 1e-9 * same.mean()
    momenta = system.mass_times(modes.shapes)
    gram = modes.shapes @ momenta.transpose(0, 2, 1)
    assert np.abs(gram - np.eye(12)).max() < 1e-9
    plane = np.einsum("kmi,kmj->kij", modes.shapes[:, :6], momenta[:, :6])
    assert np.abs(plane - plane[0]).max() < 1e-8 * np.abs(plane[0]).max()


def test_a_mode_that_the_solver_leaves_out_is_missed_and_sought_again(monkeypatch):
    """A Krylov space may hold five of six equal modes; the pivots of ``K - number M`` count them."""
    scene = star(6, analysis={"sub_intervals": 4, "modes": 8})
    system = mechanism(scene)
    known = scene_modes(scene, system).omega
    solve = eigen._solve_position

    def forgetful(eps, system, k, count):
        values, shapes = solve(eps, system, k, min(count + 1, system.size))
        forgotten = 0 if eps.getType() == "lapack" else 1  # one of the six that are equal
        return values[forgotten:][:count], shapes[forgotten:][:count]

    monkeypatch.setattr(eigen, "_solve_position", forgetful)
    monkeypatch.setattr(eigen, "SLOWEST_MODES", eigen.SLOWEST_MODES | {"eps_nev": 9})
    assert np.abs(scene_modes(scene, system).omega / known - 1).max() < 1e-9


@pytest.mark.parametrize(("solver", "bound"), [("sub-intervals", 1e-8), ("collocation", 1e-5)])
def test_a_response_does_not_depend_on_the_vectors_of_a_plane(solver, bound):
    """Each arm of six moves as one alone, under its weight; of the six, collocation leaves fast modes undamped."""
    analysis = {"sub_intervals": 72, "solver": solver, "modes": 6, "stations": 3}
    six = analyse(star(6, analysis=analysis)).data["strain"].sel(member="star.m0")
    one = analyse(star(1, analysis=analysis | {"modes": 1})).data["strain"].sel(member="star")
    assert np.abs(six.to_numpy() - one.to_numpy()).max() < bound * np.abs(one).max()
