"""Natural modes at every position (E.2) by SLEPc, followed over the positions by their momenta."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, SLEPc, configured
from fenics_mech.errors import SolverError


@dataclass(frozen=True)
class Modes:
    """Natural modes. Mode number i is the i-th slowest at the first position.

    Parameters
    ----------
    omega
        Natural frequencies (rad/s), ``(positions, modes)``.
    shapes
        Shapes, orthonormal in M (E.7), ``(positions, modes, coordinates)``.
    momenta
        M times the shapes, ``(positions, modes, coordinates)``.
    """

    omega: Array
    shapes: Array
    momenta: Array

    @property
    def ahead(self) -> Array:
        """``Phi_{k+1}^T M_{k+1} Phi_k``, after the last position comes the first, ``(positions, modes, modes)``."""
        return np.roll(self.momenta, -1, axis=0) @ self.shapes.transpose(0, 2, 1)

    @property
    def back(self) -> Array:
        """``Phi_k^T M_k Phi_{k+1}``, ``(positions, modes, modes)``."""
        return self.momenta @ np.roll(self.shapes, -1, axis=0).transpose(0, 2, 1)


def slowest(
    mass: PETSc.Mat, stiffness: PETSc.Mat, count: int, options: Mapping[str, Any]
) -> tuple[Array, Array, Array]:
    """Find the slowest modes: their frequencies, shapes and momenta.

    Parameters
    ----------
    mass, stiffness
        M and K, which is positive where drives lead all freedoms.
    count
        Number of modes.
    options
        PETSc options with the prefix "modes_".

    Raises
    ------
    SolverError
        When fewer modes are found.
    """
    eps = SLEPc.EPS().create(comm=PETSc.COMM_SELF)
    eps.setOperators(mass, stiffness)  # (E.2) as M x = x/omega^2, so that the slowest modes have the most digits
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setDimensions(count)
    with configured(eps, "modes_", {"eps_type": "lapack", "eps_largest_real": ""}, options):
        eps.solve()
        found = min(eps.getConverged(), count)
        values = np.array([eps.getEigenvalue(i).real for i in range(found)])
        if found < count or values.min() <= 0:
            raise SolverError(f"{(values > 0).sum()} of {count} modes were found: keep fewer modes")
        shapes, momenta = np.empty((2, count, mass.size[0]))
        shape, momentum = mass.createVecs()
        for i in range(count):
            eps.getEigenvector(i, shape)
            mass.mult(shape, momentum)
            norm = np.sqrt(shape.dot(momentum))  # (E.7)
            shapes[i], momenta[i] = shape.array_r / norm, momentum.array_r / norm
        for vector in (shape, momentum):
            vector.destroy()
    return 1 / np.sqrt(values), shapes, momenta


def followed(omega: Array, shapes: Array, momenta: Array) -> Modes:
    """Put modes into an order that follows their shapes, with signs that do not jump.

    Parameters
    ----------
    omega, shapes, momenta
        As of `Modes`, sorted by frequency at each position.
    """
    omega, shapes, momenta = omega.copy(), shapes.copy(), momenta.copy()
    for k in range(1, len(omega)):
        likeness = momenta[k] @ shapes[k - 1].T
        order = linear_sum_assignment(likeness.T**2, maximize=True)[1]
        sign = np.where(likeness[order, np.arange(len(order))] < 0, -1.0, 1.0)[:, None]
        omega[k], shapes[k], momenta[k] = omega[k, order], sign * shapes[k, order], sign * momenta[k, order]
    return Modes(omega, shapes, momenta)


def closing(modes: Modes) -> Array:
    """Signed permutation by which the modes come back after a cycle, ``(modes, modes)``."""
    last = modes.ahead[-1]
    target = linear_sum_assignment(last.T**2, maximize=True)[1]
    found = np.zeros_like(last)
    for mode, place in enumerate(target):
        found[place, mode] = np.copysign(1.0, last[place, mode])
    return found
