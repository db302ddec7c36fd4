"""Modal damping as a factor of its matrix over the coordinates."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import held_matrices
from fenics_mech.mechanism.matrices import not_positive
from fenics_mech.scene import Scene


def damping_ratios(scene: Scene, omega: Array) -> Array:
    """Ratio of every mode (E.12), of the shape of `omega`; the last one stated holds for the modes after it."""
    stated = np.atleast_1d(scene.damping.ratio)
    return np.broadcast_to(stated[np.minimum(np.arange(omega.shape[1]), len(stated) - 1)], omega.shape)


def modal_damping(scene: Scene, system: System) -> Array | None:
    """Give F of ``F^T F = M Phi 2 zeta omega Phi^T M`` at every angle; None if nothing is damped.

    The modes are those of ``K^{-1} M``, so that the slow ones are exact beside members as good as rigid. With shapes
    ``Psi`` of unit stiffness, the matrix is ``K Psi (2 zeta/omega) Psi^T K``. F changes smoothly with the angle.

    Returns
    -------
    numpy.ndarray or None
        ``(angles, modes, coordinates)``.

    Raises
    ------
    SolverError
        When the stiffness is not positive.
    """
    if not np.any(scene.damping.ratio):
        return None
    mass, stiffness = system.once("held matrices", lambda: _held(system))
    return system.once("modal damping", lambda: _damping(scene, mass, stiffness), str(scene.damping.ratio))


def _held(system: System) -> tuple[Stack, Stack]:
    """Mass and positive stiffness at the angles."""
    mass, stiffness = held_matrices(system)
    if len(indefinite := not_positive(stiffness)):
        least = [np.linalg.eigvalsh(stiffness.dense(k))[0] for k in indefinite]
        theta = np.degrees(system.motion.theta[indefinite[int(np.argmin(least))]])
        raise SolverError(f"the stiffness is not positive at drive angle {theta:.6g} deg: it has no modes to damp")
    return mass, stiffness


def _damping(scene: Scene, mass: Stack, stiffness: Stack) -> Array:
    """Factor of the damping of all modes, which LAPACK finds in whole arrays."""
    unit = np.sqrt(stiffness.diagonal)
    pairs = unit[:, :, None] * unit[:, None, :]  # so that rounding of stiff coordinates stays with them
    lower = np.linalg.cholesky(stiffness.full / pairs)
    scaled = np.linalg.solve(lower, np.linalg.solve(lower, mass.full / pairs).transpose(0, 2, 1))
    squares, shapes = (part[..., ::-1] for part in np.linalg.eigh(scaled))  # (E.2) of 1/omega^2
    times = np.sqrt(np.maximum(squares, 0))
    root = (shapes * np.sqrt(2 * damping_ratios(scene, times) * times)[:, None]) @ shapes.transpose(0, 2, 1)  # (E.12)
    return root @ (unit[:, :, None] * lower).transpose(0, 2, 1)
