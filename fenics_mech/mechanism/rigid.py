"""Rigid-body modes: small motions of a mechanism at rest that no joint, drive, spring or axial force holds.

They make the stiffness singular (Nath and Ghosh, Mechanism and Machine Theory 15, 1980, p. 179). The mechanism's other
motions are at right angles to them in the mass matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import SuperLU, splu

from fenics_mech._petsc import to_scipy
from fenics_mech.kinematics.freedom import apart
from fenics_mech.mechanism.system import System

Array = NDArray[np.float64]
HELD = 1e-12  # energy of a motion, of that of its parts, up to which nothing holds it
BALANCED = 1e-8  # share of a load that moves a freedom, in M^-1, up to which it is in equilibrium


@dataclass(frozen=True)
class RigidModes:
    """Rigid-body modes of a system that nothing drives.

    Parameters
    ----------
    shapes
        Coordinates q of each, orthonormal in M, ``(modes, coordinates)``.
    freedoms
        Combinations of `Motion.free` that nothing holds, ``(modes, motions)``; they span the same motions.
    coordinates
        Coordinates q of those, ``(modes, coordinates)``.
    mass, stiffness
        M and K of the system; empty where there are no rigid-body modes.
    """

    shapes: Array
    freedoms: Array
    coordinates: Array
    mass: sp.csr_matrix
    stiffness: sp.csr_matrix

    @classmethod
    def of(cls, system: System, symmetric: bool = True) -> RigidModes:
        """Find the rigid-body modes of a system, which has none where all its freedoms are driven.

        Its K has the stiffness of loads that turn with the links unless it is to be symmetric.
        """
        free = system.motion.free
        if not len(free):
            empty = sp.csr_matrix((system.size, system.size))
            none = np.zeros((0, system.size))
            return cls(none, np.zeros((0, 0)), none, empty, empty)
        mass, stiffness = _matrices(system, symmetric=True)
        candidates = _in_coordinates(system, free)
        root = np.linalg.cholesky(candidates @ (mass @ candidates.T))
        shapes = np.linalg.solve(root, candidates)
        energy = shapes @ (stiffness @ shapes.T)
        parts = np.einsum("mi,im->m", np.abs(shapes), abs(stiffness) @ np.abs(shapes.T))
        values, vectors = np.linalg.eigh((energy + energy.T) / 2)
        loose = vectors[:, np.abs(values) < HELD * parts.max()].T
        freedoms = apart(loose @ np.linalg.inv(root), np.zeros(len(free), dtype=bool))
        whole = stiffness if symmetric or not system.terms.follower else _matrices(system, symmetric=False)[1]
        return cls(loose @ shapes, freedoms, freedoms @ candidates, mass, whole)

    def __len__(self) -> int:
        return len(self.shapes)

    def moved_by(self, load: Array) -> list[int]:
        """Which of the freedoms a load ``(coordinates,)`` does work on."""
        if not len(self):
            return []
        whole = load @ splu(self.mass.tocsc()).solve(load)  # square of the load's size
        sizes = np.einsum("mi,mi->m", self.coordinates @ self.mass, self.coordinates)
        work = np.abs(self.coordinates @ load)
        return [int(i) for i in np.flatnonzero(work > BALANCED * np.sqrt(sizes * max(whole, 0.0)))]

    @cached_property
    def _bordered(self) -> SuperLU:
        momenta = sp.csr_matrix(self.mass @ self.shapes.T)
        return splu(sp.bmat([[self.stiffness, momenta], [momenta.T, None]], format="csc"))

    def relieved(self, load: Array) -> tuple[Array, Array]:
        """Solve ``K q + M a = load`` for the elastic q and the rigid acceleration a, each ``(coordinates,)``.

        q is at right angles to the modes; a is their combination that takes up what of the load is not in equilibrium
        (inertia relief).
        """
        answer = self._bordered.solve(np.append(load, np.zeros(len(self))))
        return answer[: len(load)], answer[len(load) :] @ self.shapes

    def lowest_elastic(self) -> float:
        """Rough square of the lowest natural frequency that is not 0 (rad^2/s^2), from above: Rayleigh's quotient."""
        start = self.mass @ np.random.default_rng(0).normal(size=self.shapes.shape[1])
        q = self.relieved(start)[0]
        return float(q @ (self.stiffness @ q) / (q @ (self.mass @ q)))


def _matrices(system: System, symmetric: bool) -> tuple[sp.csr_matrix, sp.csr_matrix]:
    """M and K at the first position."""
    _, mass, stiffness = next(system.positions(symmetric=symmetric))
    return to_scipy(mass), to_scipy(stiffness)


def _in_coordinates(system: System, free: Array) -> Array:
    """Coordinates q of small motions of the links, ``(motions, coordinates)``: those for which P q is the motion."""
    mesh, motion, transformation = system.beams.mesh, system.motion, system.transformation
    angle = motion.angle[0, mesh.node_link]
    c, s, (x, y) = np.cos(angle), np.sin(angle), mesh.node_xy.T
    dx, dy, turn = np.moveaxis(free[:, mesh.node_link], -1, 0)
    along = c * dx + s * dy - turn * y, c * dy - s * dx + turn * x, turn
    nodal = np.stack(along, axis=-1).reshape(len(free), -1)
    entries = (system.values[0], (transformation.rows, transformation.columns))
    p = sp.csr_matrix(entries, shape=transformation.shape)
    if (reduction := system.beams.reduction) is not None:
        p = reduction.shape @ p
    return np.atleast_2d(splu((p.T @ p).tocsc()).solve((nodal @ p).T).T)
