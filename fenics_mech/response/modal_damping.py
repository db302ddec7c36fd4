"""Modal damping as a matrix over the coordinates."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._ranks import over_positions
from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import held_matrices
from fenics_mech.scene import Scene


def damping_ratios(scene: Scene, omega: Array) -> Array:
    """Ratio of every mode (E.12), of the shape of `omega`; the last one stated holds for the modes after it."""
    stated = np.atleast_1d(scene.damping.ratio)
    return np.broadcast_to(stated[np.minimum(np.arange(omega.shape[1]), len(stated) - 1)], omega.shape)


def modal_damping(scene: Scene, system: System) -> Array | None:
    """Give ``M Phi 2 zeta omega Phi^T M`` at every angle, ``(angles, coordinates, coordinates)``; None if undamped.

    The modes are those of ``K^{-1} M``, so that the slow ones are exact beside members as good as rigid: with ``K = L
    L^T`` and Y the eigenvectors of ``L^{-1} M L^{-T}``, the matrix is ``L Y (2 zeta/omega) Y^T L^T``. All modes of all
    angles are needed, and in no order but that of their frequencies: LAPACK finds them in whole arrays five times as
    fast as a solver object that goes from angle to angle.

    Raises
    ------
    SolverError
        When the stiffness is not positive.
    """
    if not np.any(scene.damping.ratio):
        return None
    return system.once("modal damping", lambda: _modal_damping(scene, system), str(scene.damping.ratio))


def _modal_damping(scene: Scene, system: System) -> Array:
    return over_positions(len(system.values), lambda among: (_modal_damping_at(scene, system, among),))[0]


def _modal_damping_at(scene: Scene, system: System, among: slice) -> Array:
    """Give it at some of the angles."""
    mass, stiffness = held_matrices(system, among)
    unit = np.sqrt(np.abs(np.einsum("tii->ti", stiffness)))
    pairs = unit[:, :, None] * unit[:, None, :]  # so that rounding of stiff coordinates stays with them
    try:
        lower = np.linalg.cholesky(stiffness / pairs)
    except np.linalg.LinAlgError as error:
        theta = np.degrees(system.motion.theta[among][np.linalg.eigvalsh(stiffness / pairs)[:, 0].argmin()])
        message = f"the stiffness is not positive at drive angle {theta:.6g} deg: it has no modes to damp"
        raise SolverError(message) from error
    scaled = np.linalg.solve(lower, np.linalg.solve(lower, mass / pairs).transpose(0, 2, 1))
    squares, shapes = (part[..., ::-1] for part in np.linalg.eigh(scaled))  # (E.2) of 1/omega^2
    times = np.sqrt(np.maximum(squares, 0))
    forces = unit[:, :, None] * (lower @ shapes)
    return (forces * (2 * damping_ratios(scene, times) * times)[:, None]) @ forces.transpose(0, 2, 1)  # (E.12)
