"""Rigid-body modes: small motions of a mechanism at rest that no joint, drive, spring or axial force holds.

They make the stiffness singular (Nath and Ghosh, Mechanism and Machine Theory 15, 1980, p. 179). The mechanism's other
motions are at right angles to them in the mass matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr
from scipy.sparse.linalg import SuperLU, splu

from fenics_mech._arrays import Array
from fenics_mech.effects import Entries
from fenics_mech.kinematics.freedom import row_reduced
from fenics_mech.mechanism.system import System


@dataclass(frozen=True)
class RigidModeLimits:
    """Limits by which motions count as held, and loads as balanced."""

    held: float = 1e-12  # energy of a motion in springs and axial forces, of that of its parts: less is rounding
    noise: float = 1e-22  # the same, of the links' own energy: axial forces of 0 are that large by rounding
    turn: float = 0.1  # rad, of a whole link about its rough angle; there small motions are 0.5 % off
    balanced: float = 1e-8  # share of a load that moves a freedom, in M^-1, up to which it is in equilibrium


RIGID = RigidModeLimits()


@dataclass(frozen=True)
class Separate:
    """M and K over coordinates y, ``q = T y``, that separate motions of rigid links from those that bend them.

    The links' stiffness does nothing to a motion of rigid links. In ``T^T K T`` such a motion has that of springs and
    axial forces only: small as they may be, they are not rounded away beside the links' own.

    Parameters
    ----------
    basis
        T: the unit matrix, with motions of rigid links as its last columns, ``(coordinates, coordinates)``.
    mass, stiffness
        ``T^T M T`` and ``T^T K T``.
    """

    basis: sp.csr_matrix
    mass: sp.csr_matrix
    stiffness: sp.csr_matrix

    @classmethod
    def of(cls, motions: Array, mass: sp.csr_matrix, links: sp.csr_matrix, added: sp.csr_matrix) -> Separate:
        """Separate independent motions of rigid links, ``(motions, coordinates)``, by the two parts of K.

        Parameters
        ----------
        motions
            The motions of rigid links, ``(motions, coordinates)``.
        mass
            M, ``(coordinates, coordinates)``.
        links, added
            Stiffness of the links, and that of springs and axial forces, ``(coordinates, coordinates)``.
        """
        size = links.shape[0]
        stiff = np.sqrt(np.abs(links.diagonal()) + np.abs(added.diagonal()))
        places = qr(motions * stiff, mode="r", pivoting=True)[1][: len(motions)]
        others = np.setdiff1d(np.arange(size), places)
        bends = sp.identity(size, format="csc")[:, others]
        basis = sp.hstack([bends, motions.T], format="csr")
        whole = sp.block_diag([bends.T @ links @ bends, sp.csr_matrix((len(motions),) * 2)])
        stiffness = (whole + basis.T @ added @ basis).tocsr()
        return cls(basis, (basis.T @ mass @ basis).tocsr(), stiffness)


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
    separate
        The same, with all motions that joints and drives leave as coordinates of their own; None where there is none.
        The rigid-body modes are the last of its coordinates.
    """

    shapes: Array
    freedoms: Array
    coordinates: Array
    mass: sp.csr_matrix
    stiffness: sp.csr_matrix
    separate: Separate | None = None

    @classmethod
    def of(cls, system: System, symmetric: bool = True, held_by: System | None = None) -> RigidModes:
        """Find the rigid-body modes of a system, which has none where all its freedoms are driven.

        Its K has the stiffness of loads that turn with the links unless it is to be symmetric. What holds a motion is
        the stiffness of `held_by`, by default the system itself.

        Parameters
        ----------
        system
            The mechanism.
        symmetric
            Whether K leaves out the stiffness of loads that turn with the links.
        held_by
            The mechanism whose stiffness decides what is held.
        """
        free = system.motion.free
        if not len(free):
            empty = sp.csr_matrix((system.size, system.size))
            none = np.zeros((0, system.size))
            return cls(none, np.zeros((0, 0)), none, empty, empty)
        p = _links_by_coordinates(system)
        mass, links = (p.T @ matrix @ p for matrix in (system.link_mass, system.link_stiffness))
        holding = _joined(system, p, (held_by or system).symmetric_stiffness)
        added = _joined(system, p, system.symmetric_stiffness if symmetric else system.added_stiffness)
        candidates = _in_coordinates(system, free)
        unheld = _not_held(candidates, holding, links)
        found = unheld @ candidates
        shapes = _normed(found, mass) if len(unheld) else found
        freedoms = row_reduced(unheld, np.zeros(len(free), dtype=bool))
        motions = np.concatenate([_without(candidates, unheld), found])
        separate = Separate.of(motions, mass, links, added)
        return cls(shapes, freedoms, freedoms @ candidates, mass, (links + added).tocsr(), separate)

    @classmethod
    def giving_way(cls, system: System) -> RigidModes:
        """Find the motions in which links give way to the system's load, as nothing holds them.

        Beside the rigid-body modes these are freedoms that only axial forces resist. They count where the load moves
        them and the axial forces do not hold them within `RIGID.turn`. The links then accelerate, and are in no
        equilibrium whose stability axial forces could decide. A weight that hangs still holds its links.

        Parameters
        ----------
        system
            The mechanism.
        """
        held = cls.of(system, symmetric=False)
        if system.terms.stiffening is None or not len(system.motion.free):
            return held
        free = cls.of(system, symmetric=False, held_by=system.without_axial_forces)
        if len(free) == len(held) or not free.moved_by(system.load[0]):
            return held
        resistance, push = free.shapes @ (free.stiffness @ free.shapes.T), free.shapes @ system.load[0]
        if np.linalg.eigvalsh(resistance + resistance.T).min() > 0:
            moved = system.to_links((np.linalg.solve(resistance, push) @ free.shapes)[None])
            if np.abs(moved[:, 2::3]).max() <= RIGID.turn:
                return held
        return free

    def elastic(self) -> Array:
        """Stiffness of the motions at right angles to the modes, ``(coordinates, coordinates)``.

        The modes have a stiffness of the size of the lowest elastic one in it, so that it is positive where that is.
        """
        momenta = self.mass @ self.shapes.T
        projection = np.eye(len(momenta)) - self.shapes.T @ momenta.T
        elastic = projection.T @ (self.stiffness @ projection)
        return np.asarray(elastic + abs(self.lowest_elastic()) * momenta @ momenta.T)

    def __len__(self) -> int:
        return len(self.shapes)

    def moved_by(self, load: Array) -> list[int]:
        """Which of the freedoms a load ``(coordinates,)`` does work on.

        Parameters
        ----------
        load
            The load on the coordinates.
        """
        if not len(self):
            return []
        whole = load @ splu(self.mass.tocsc()).solve(load)  # square of the load's size
        sizes = np.einsum("mi,mi->m", self.coordinates @ self.mass, self.coordinates)
        work = np.abs(self.coordinates @ load)
        return [int(i) for i in np.flatnonzero(work > RIGID.balanced * np.sqrt(sizes * max(whole, 0.0)))]

    @cached_property
    def separate_shapes(self) -> Array:
        """The modes over the coordinates of `separate`, ``(modes, coordinates)``."""
        assert self.separate is not None
        return np.asarray(splu(self.separate.basis.tocsc()).solve(self.shapes.T).T)

    @cached_property
    def _bordered(self) -> SuperLU:
        assert self.separate is not None
        momenta = sp.csr_matrix(self.separate.mass @ self.separate_shapes.T)
        return splu(sp.bmat([[self.separate.stiffness, momenta], [momenta.T, None]], format="csc"))

    def relieved(self, load: Array) -> tuple[Array, Array]:
        """Solve ``K q + M a = load`` for the elastic q and the rigid acceleration a, each ``(coordinates,)``.

        q is at right angles to the modes; a is their combination that takes up what of the load is not in equilibrium
        (inertia relief).

        Parameters
        ----------
        load
            The load on the coordinates.
        """
        assert self.separate is not None
        basis = self.separate.basis
        answer = self._bordered.solve(np.append(basis.T @ load, np.zeros(len(self))))
        return basis @ answer[: len(load)], answer[len(load) :] @ self.shapes

    def lowest_elastic(self) -> float:
        """Rough square of the lowest natural frequency that is not 0 (rad^2/s^2), from above: Rayleigh's quotient."""
        assert self.separate is not None
        mass, stiffness = self.separate.mass, self.separate.stiffness
        start = mass @ np.random.default_rng(0).normal(size=self.shapes.shape[1])
        y = self._bordered.solve(np.append(start, np.zeros(len(self))))[: len(start)]
        return float(y @ (stiffness @ y) / (y @ (mass @ y)))


def _not_held(candidates: Array, holding: sp.csr_matrix, links: sp.csr_matrix) -> Array:
    """Combinations of motions ``(motions, coordinates)`` that a stiffness does not hold, ``(combinations, motions)``.

    It is that of springs and axial forces. The links' own, which holds none of them, gives the size of rounding.
    """
    energy = candidates @ (holding @ candidates.T)
    size = np.abs(candidates)
    parts, most = (np.einsum("mi,im->m", size, abs(matrix) @ size.T) for matrix in (holding, links))
    unit = 1 / np.sqrt(np.maximum(np.maximum(parts, RIGID.noise / RIGID.held * most), np.finfo(float).tiny))
    values, vectors = np.linalg.eigh((energy + energy.T) / 2 * np.outer(unit, unit))
    return np.asarray((vectors[:, np.abs(values) < RIGID.held] * unit[:, None]).T)


def _normed(motions: Array, mass: sp.csr_matrix) -> Array:
    """Give combinations of motions whose mass matrix is 1."""
    root = np.linalg.cholesky(motions @ (mass @ motions.T))
    return np.asarray(np.linalg.solve(root, motions), dtype=np.float64)


def _without(candidates: Array, unheld: Array) -> Array:
    """Those of the candidates that, with combinations of them, ``(combinations, motions)``, span the same motions."""
    if not len(unheld):
        return candidates
    left_out = qr(unheld / np.abs(unheld).max(axis=1, keepdims=True), mode="r", pivoting=True)[1][: len(unheld)]
    return np.delete(candidates, left_out, axis=0)


def _links_by_coordinates(system: System) -> sp.csr_matrix:
    """P at the first position."""
    transformation = system.transformation
    entries = (system.values[0], (transformation.rows, transformation.columns))
    return sp.csr_matrix(entries, shape=transformation.shape)


def _joined(system: System, p: sp.csr_matrix, added: tuple[Entries, ...]) -> sp.csr_matrix:
    """Stiffness that effects add, over the coordinates q."""
    parts = [system.on_links(entries) for entries in added]
    places = [(part.values[0], (part.rows, part.columns)) for part in parts]
    whole = sum((sp.csr_matrix(place, shape=(p.shape[0],) * 2) for place in places), sp.csr_matrix((p.shape[0],) * 2))
    return (p.T @ whole @ p).tocsr()


def _in_coordinates(system: System, free: Array) -> Array:
    """Coordinates q of small motions of the links, ``(motions, coordinates)``: those for which P q is the motion."""
    mesh, motion = system.beams.mesh, system.motion
    angle = motion.angle[0, mesh.node_link]
    c, s, (x, y) = np.cos(angle), np.sin(angle), mesh.node_xy.T
    dx, dy, turn = np.moveaxis(free[:, mesh.node_link], -1, 0)
    along = c * dx + s * dy - turn * y, c * dy - s * dx + turn * x, turn
    nodal = np.stack(along, axis=-1).reshape(len(free), -1)
    p = _links_by_coordinates(system)
    if (reduction := system.beams.reduction) is not None:
        p = reduction.shape @ p
    return np.atleast_2d(splu((p.T @ p).tocsc()).solve((nodal @ p).T).T)
