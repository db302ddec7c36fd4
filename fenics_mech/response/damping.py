"""Modal damping as a matrix over the coordinates."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fenics_mech.mechanism import System
from fenics_mech.modes import solve_modes
from fenics_mech.scene import Scene

Array = NDArray[np.float64]


def damping_ratios(scene: Scene, omega: Array) -> Array:
    """Ratio of every mode (E.12), of the shape of `omega`; the last one stated holds for the modes after it."""
    stated = np.atleast_1d(scene.damping.ratio)
    return np.broadcast_to(stated[np.minimum(np.arange(omega.shape[1]), len(stated) - 1)], omega.shape)


def modal_damping(scene: Scene, system: System) -> Array | None:
    """Give ``M Phi 2 zeta omega Phi^T M`` at every angle, ``(angles, coordinates, coordinates)``; None if undamped."""
    if not np.any(scene.damping.ratio):
        return None
    modes = solve_modes(system, system.size, scene.petsc)
    momenta = system.mass_times(modes.shapes)
    weight = 2 * damping_ratios(scene, modes.omega) * modes.omega  # (E.12)
    return momenta.transpose(0, 2, 1) @ (weight[..., None] * momenta)
