"""What every solver of the response gives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class History:
    """Elastic displacement of the mechanism over the drive angles, and the inertia that goes with it.

    Parameters
    ----------
    displacement
        Coordinates q (m, rad), ``(angles, coordinates)``.
    inertia
        Acceleration of every nodal dof in link axes (m/s^2, rad/s^2), ``(angles, nodal dofs)``, such that
        ``K q + P^T m inertia = 0``: rigid and elastic acceleration, and the modal damping force over the mass.
    """

    displacement: NDArray[np.float64]
    inertia: NDArray[np.float64]
