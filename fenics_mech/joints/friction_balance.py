"""Dry friction of several joints together: each is a share of its joint's force, which all of them change."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.errors import SolverError


@dataclass(frozen=True)
class FrictionLimits:
    """Limits of Newton's method for the friction in joints."""

    most_iterations: int = 30
    converged: float = 1e-13  # of the largest friction
    small_force: float = 1e-9  # of the largest force of a joint, over which the size of a small one is rounded
    no_force: float = 1e-150  # N, the same where no joint has a force: its square is not 0


FRICTION = FrictionLimits()


@dataclass(frozen=True)
class FrictionBalance:
    """The friction F of joints, with ``F = shares |l|`` of their forces ``l = alone - by_friction F``."""

    alone: Array  # forces of the joints without friction (N), (states, rows)
    by_friction: Array  # what friction of size 1 takes off them, (states, rows, laws)
    shares: Array  # friction over the joint's force (m of a pin, 1 of a slider), (states, laws)
    pressed: Sequence[Index]  # rows whose forces press the bodies of each law's joint against each other

    def solve(self) -> tuple[Array, Array]:
        """Find the friction, ``(states, laws)``, and the forces with it, ``(states, rows)``, by Newton's method."""
        friction, one = np.zeros_like(self.shares), np.eye(self.shares.shape[1])
        for _ in range(FRICTION.most_iterations):
            sizes, along = self.sizes(friction)
            slopes = -np.einsum("tkr,trl->tkl", along, self.by_friction)
            left = friction - self.shares * sizes
            tangent = one - self.shares[..., None] * slopes
            change = np.linalg.solve(tangent, -left[..., None])[..., 0]
            friction = friction + change
            if np.abs(change).max() <= FRICTION.converged * np.abs(friction).max() + np.finfo(float).tiny:
                return friction, self.forces(friction)
        raise SolverError("the friction of the joints locks the linkage: their forces are not determined")

    def sizes(self, friction: Array) -> tuple[Array, Array]:
        """Give the sizes of the joints' forces (N), ``(states, laws)``, and their derivatives by these forces."""
        # friction (states, laws)
        forces = self.forces(friction)
        floor = FRICTION.small_force * np.abs(self.alone).max(axis=1, initial=0.0) + FRICTION.no_force
        along = np.zeros((*friction.shape, forces.shape[1]))
        sizes = np.zeros_like(friction)
        for k, rows in enumerate(self.pressed):
            sizes[:, k] = np.sqrt(np.sum(forces[:, rows] ** 2, axis=1) + floor**2)
            along[:, k, rows] = forces[:, rows] / sizes[:, k, None]
        return sizes, along

    def forces(self, friction: Array) -> Array:
        """Give the forces of the joints (N), ``(states, rows)``."""
        # friction (states, laws)
        return np.asarray(self.alone - (self.by_friction @ friction[..., None])[..., 0])
