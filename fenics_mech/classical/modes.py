"""Natural modes at every position (E.2) by SLEPc, followed over the positions by their momenta."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from fenics_mech._arrays import Array, Index
from fenics_mech._petsc import SLOWEST_MODES, WHOLE_SPECTRUM, PETSc, SLEPc, configured, to_petsc
from fenics_mech.classical.mechanism import Mechanism
from fenics_mech.errors import SolverError

SPARE = 10  # vectors of a Krylov space beside two for each mode: it then restarts few times
EQUAL = 1e-6  # relative distance of squares of frequencies that count as one: a Krylov space may miss one of them


@dataclass(frozen=True)
class Modes:
    """Natural modes. Mode number i is the i-th slowest at the first position."""

    omega: Array  # natural frequencies (rad/s), (positions, modes)
    shapes: Array  # shapes, orthonormal in M (E.7), (positions, modes, coordinates)
    momenta: Array  # M times the shapes, (positions, modes, coordinates)

    def part(self, which: slice, those: Index | slice = slice(None)) -> Modes:
        """Give some of the modes at some of the positions."""
        return Modes(*(x[which][:, those] for x in (self.omega, self.shapes, self.momenta)))

    @property
    def ahead(self) -> Array:
        """``Phi_{k+1}^T M_{k+1} Phi_k``, after the last position comes the first, ``(positions, modes, modes)``."""
        return np.roll(self.momenta, -1, axis=0) @ self.shapes.transpose(0, 2, 1)

    @property
    def back(self) -> Array:
        """``Phi_k^T M_k Phi_{k+1}``, ``(positions, modes, modes)``."""
        return self.momenta @ np.roll(self.shapes, -1, axis=0).transpose(0, 2, 1)

    @property
    def assurance(self) -> Array:
        """How far each mode is that of the next position, 0..1 ``(positions, modes)``; the last: which it is most."""
        alike = self.ahead**2
        found = np.einsum("kmm->km", alike).copy()
        found[-1] = alike[-1].max(axis=0)
        return np.minimum(found, 1.0)

    def superposed(self, y: Array) -> Array:
        """Give the coordinates of modal ones (5.3), ``(positions, coordinates)``."""
        return np.einsum("kmi,km->ki", self.shapes, y)

    def modal(self, load: Array) -> Array:
        """Give modal loads (5.2), ``(positions, modes)``."""
        return np.einsum("kmi,ki->km", self.shapes, load)

    def coordinates(self, q: Array) -> Array:
        """Give the modal coordinates of a displacement (E.10), ``(positions, modes)``."""
        return np.einsum("kmi,ki->km", self.momenta, q)


def slowest(mechanism: Mechanism, count: int, options: Mapping[str, Any]) -> Modes:
    """Find the slowest modes at all positions, and follow them."""
    size = len(mechanism.P.kept)
    few = 2 * count + SPARE < size
    omega, shapes = _found(
        mechanism, count, (SLOWEST_MODES | {"eps_ncv": 2 * count + SPARE}) if few else WHOLE_SPECTRUM, options
    )
    if few and _misses_one(mechanism, omega):
        omega, shapes = _found(mechanism, count, WHOLE_SPECTRUM, options)
    momenta = mechanism.mass.times(shapes)
    norms = np.sqrt(np.einsum("kmi,kmi->km", shapes, momenta))[..., None]
    return followed(omega, shapes / norms, momenta / norms)  # (E.7)


def _found(
    mechanism: Mechanism, count: int, defaults: Mapping[str, Any], options: Mapping[str, Any]
) -> tuple[Array, Array]:
    """Frequencies and shapes of the slowest modes, by one solver for all positions."""
    positions, size = len(mechanism.P.t), len(mechanism.P.kept)
    omega, shapes = np.empty((positions, count)), np.empty((positions, count, size))
    eps = SLEPc.EPS().create(comm=PETSc.COMM_SELF)
    eps.setProblemType(SLEPc.EPS.ProblemType.GHEP)
    eps.setDimensions(count)
    start = PETSc.Vec().createWithArray(np.random.default_rng(0).uniform(-1, 1, size), comm=PETSc.COMM_SELF)
    stacks = mechanism.stiffness, mechanism.mass
    matrices = [to_petsc(stack.at(0)) for stack in stacks]
    shape = matrices[0].createVecRight()
    with configured(eps, "modes_", defaults, options):
        for k in range(positions):
            for matrix, stack in zip(matrices, stacks):
                matrix.setValuesCSR(*matrix.getRowIJ(), stack.values[k])
                matrix.assemble()
            eps.setOperators(*matrices)
            eps.setInitialSpace(start)  # the same at all positions: answers do not depend on those before
            eps.solve()
            if (found := eps.getConverged()) < count:
                raise SolverError(f"{found} of {count} modes were found: keep fewer modes")
            squares = np.array([eps.getEigenvalue(i).real for i in range(count)])
            if squares.min() <= 0:
                raise SolverError("a mode has no stiffness: drives and joints leave something free to move")
            omega[k] = np.sqrt(np.sort(squares))
            for place, i in enumerate(np.argsort(squares)):
                eps.getEigenvector(int(i), shape)
                shapes[k, place] = shape.array_r
    for thing in (*matrices, shape, start):
        thing.destroy()  # Python by itself does not
    return omega, shapes


def _misses_one(mechanism: Mechanism, omega: Array) -> bool:
    """Say whether a mode is missing: ``K - number M`` has as many negative pivots as are slower (Sylvester)."""
    squares = omega**2
    close = (np.diff(squares, axis=1) < EQUAL * squares[:, 1:]).any(axis=1)
    close[0] = True
    for k in np.flatnonzero(close):
        bound = float(squares[k, -1]) * (1 - EQUAL)
        if mechanism.slower(k, math.sqrt(bound)) > (squares[k] < bound).sum():
            return True
    return False


def followed(omega: Array, shapes: Array, momenta: Array) -> Modes:
    """Put modes into an order that follows their shapes, with signs that do not jump."""
    alike = momenta[1:] @ shapes[:-1].transpose(0, 2, 1)  # (steps, modes, modes of the position before)
    count, modes = omega.shape
    order, sign = np.tile(np.arange(modes), (count, 1)), np.ones((count, modes))
    for k in range(1, count):
        likeness = alike[k - 1][:, order[k - 1]] * sign[k - 1]
        if (np.diagonal(likeness[order[k - 1]]) ** 2).min() > 0.5:  # no other mode is more like it
            order[k] = order[k - 1]
        else:
            order[k] = linear_sum_assignment(likeness.T**2, maximize=True)[1]
        sign[k] = np.where(likeness[order[k], np.arange(modes)] < 0, -1.0, 1.0)
    rows = np.arange(count)[:, None]
    signs = sign[..., None]
    return Modes(omega[rows, order], signs * shapes[rows, order], signs * momenta[rows, order])


def closing(modes: Modes) -> Array:
    """Signed permutation by which the modes come back after a cycle, ``(modes, modes)``."""
    last = modes.ahead[-1]
    target = linear_sum_assignment(last.T**2, maximize=True)[1]
    found = np.zeros_like(last)
    for mode, place in enumerate(target):
        found[place, mode] = np.copysign(1.0, last[place, mode])
    return found
