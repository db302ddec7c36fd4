"""Natural modes of a mechanism at all angles, in whole arrays: all of them, or the slowest."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.eigenmodes import natural
from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.matrices import not_positive


@dataclass(frozen=True)
class ShapeLimits:
    """How the slowest modes are found."""

    at_a_time: int = 20  # angles, whose shapes are alike and stay in the processor's cache
    more_shapes: int = 8  # beside those wanted
    most: float = 0.5  # of the coordinates, as shapes: with more of them all modes are found, which is as fast
    most_iterations: int = 60  # of a subspace, before modes count as not found
    rounding: float = 1e-13  # of the largest energy of a shape, up to which another's is lost to rounding
    converged: float = 1e-4  # change of 1/omega^2 of the fastest mode in an iteration: for the slow ones it is 1e-10


SHAPES = ShapeLimits()


def held(system: System) -> tuple[Stack, Stack]:
    """Give mass and positive stiffness at the angles of a mechanism, by which it has its natural modes.

    Parameters
    ----------
    system
        The mechanism.

    Raises
    ------
    SolverError
        When the stiffness is not positive.
    """
    system = natural(system)
    return system.once("held matrices", lambda: _positive(system))


def _positive(system: System) -> tuple[Stack, Stack]:
    mass, stiffness = system.held_matrices()
    if len(indefinite := not_positive(stiffness)):
        least = [np.linalg.eigvalsh(stiffness.dense(k))[0] for k in indefinite]
        theta = np.degrees(system.motion.theta[indefinite[int(np.argmin(least))]])
        raise SolverError(
            f"the stiffness is not positive at drive angle {theta:.6g} deg, so that there are no modes to damp. Take "
            "weaker springs where they push links over, or fewer elements in members that are far stiffer than others"
        )
    return mass, stiffness


def slowest(mass: Stack, stiffness: Stack, start: Array, count: int) -> tuple[Array, Array, Array]:
    """Iterate the subspace of some shapes at all angles (Bathe and Wilson, 1972).

    Parameters
    ----------
    mass, stiffness
        Of the mechanism at the angles.
    start
        Shapes to begin from, ``(shapes, coordinates)``.
    count
        Number of modes that are to be found, fewer than the shapes.

    Returns
    -------
    tuple
        ``1/omega^2`` of so many modes, ``(angles, count)``, and all shapes of unit stiffness and their momenta,
        ``(angles, shapes, coordinates)``; without those that are lost to rounding.

    Raises
    ------
    SolverError
        When rounding leaves fewer shapes than the modes to be found.
    """
    moved, squares = mass.times(np.broadcast_to(start, (len(mass), *start.shape))), np.zeros((len(mass), count))
    for _ in range(SHAPES.most_iterations):
        shapes = stiffness.solve(moved)
        shapes = _of_unit_stiffness(shapes, moved, count)
        moved, before = mass.times(shapes), squares
        every, turn = np.linalg.eigh(shapes @ moved.transpose(0, 2, 1))  # ascending
        squares, turn = every[:, : -count - 1 : -1], np.ascontiguousarray(turn[..., ::-1]).transpose(0, 2, 1)
        shapes, moved = turn @ shapes, turn @ moved
        if np.all(np.abs(squares - before) < SHAPES.converged * squares):
            break
    return squares, shapes, moved


def _of_unit_stiffness(shapes: Array, moved: Array, count: int) -> Array:
    """Combine shapes to ones of unit stiffness that are orthogonal to each other, without those lost to rounding.

    With the energies of the shapes, ``S K S^T = T diag(e) T^T``, they are ``diag(e)^(-1/2) T^T S``.

    Parameters
    ----------
    shapes
        The shapes at the angles, ``(angles, shapes, coordinates)``.
    moved
        The forces that displace the mechanism by them (N, N m), of the same shape.
    count
        How many are needed.

    Returns
    -------
    numpy.ndarray
        Of shape ``(angles, shapes left, coordinates)``.

    Raises
    ------
    SolverError
        When fewer are left.
    """
    energy, turn = np.linalg.eigh(shapes @ moved.transpose(0, 2, 1))  # ascending
    lost = int(np.any(energy <= SHAPES.rounding * energy[:, -1:], axis=0).sum())
    if energy.shape[1] - lost < count:
        raise SolverError(
            f"the damping needs {count} modes, and rounding leaves {energy.shape[1] - lost}, as some members are far "
            "stiffer than others. Take fewer elements in these"
        )
    kept = turn[..., lost:] / np.sqrt(energy[:, None, lost:])
    return np.asarray(kept.transpose(0, 2, 1) @ shapes)


def every(mass: Stack, stiffness: Stack) -> tuple[Array, Array, Array]:
    """Find all modes, which LAPACK does in whole arrays.

    Parameters
    ----------
    mass, stiffness
        Of the mechanism at the angles.

    Returns
    -------
    tuple
        ``1/omega^2``, ``(angles, modes)``. The elastic forces of shapes of unit stiffness, ``(angles, modes,
        coordinates)``. An orthonormal matrix that turns these to be smooth, ``(angles, coordinates, modes)``.
    """
    unit = np.sqrt(stiffness.diagonal)
    pairs = unit[:, :, None] * unit[:, None, :]  # so that rounding of stiff coordinates stays with them
    lower = np.linalg.cholesky(stiffness.full / pairs)
    scaled = np.linalg.solve(lower, np.linalg.solve(lower, mass.full / pairs).transpose(0, 2, 1))
    squares, shapes = (np.ascontiguousarray(part[..., ::-1]) for part in np.linalg.eigh(scaled))  # (E.2) of 1/omega^2
    return squares, (unit[:, :, None] * lower @ shapes).transpose(0, 2, 1), shapes
