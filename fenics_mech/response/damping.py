"""Modal damping as a matrix over the coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fenics_mech.errors import SolverError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import held_matrices
from fenics_mech.scene import Scene

Array = NDArray[np.float64]


def damping_ratios(scene: Scene, omega: Array) -> Array:
    """Ratio of every mode (E.12), of the shape of `omega`; the last one stated holds for the modes after it."""
    stated = np.atleast_1d(scene.damping.ratio)
    return np.broadcast_to(stated[np.minimum(np.arange(omega.shape[1]), len(stated) - 1)], omega.shape)


def modal_damping(scene: Scene, system: System) -> Array | None:
    """Give ``M Phi 2 zeta omega Phi^T M`` at every angle, ``(angles, coordinates, coordinates)``; None if undamped.

    All modes of all angles are needed, and in no order but that of their frequencies: LAPACK finds them in whole arrays
    five times as fast as a solver object that goes from angle to angle.

    Raises
    ------
    SolverError
        When the mass or the stiffness is not positive.
    """
    if not np.any(scene.damping.ratio):
        return None
    mass, stiffness = held_matrices(system)
    try:
        lower = np.linalg.cholesky(mass)
    except np.linalg.LinAlgError as error:
        raise SolverError("modal damping needs a mass at every coordinate: some part has none") from error
    scaled = np.linalg.solve(lower, np.linalg.solve(lower, stiffness).transpose(0, 2, 1))
    squares, shapes = np.linalg.eigh(scaled)  # (E.2)
    if squares.min() <= 0:
        theta = np.degrees(system.motion.theta[squares.min(axis=1).argmin()])
        raise SolverError(f"the stiffness is not positive at drive angle {theta:.6g} deg: it has no modes to damp")
    omega, momenta = np.sqrt(squares), lower @ shapes
    return (momenta * (2 * damping_ratios(scene, omega) * omega)[:, None]) @ momenta.transpose(0, 2, 1)  # (E.12)
