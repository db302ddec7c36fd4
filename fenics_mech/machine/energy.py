"""Energy that a motion of a machine holds: of its velocities, in its terms, and by its weight."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.motion import Motion


def kinetic_energy(motion: Motion) -> Array:
    """Give half of the rates of all vectors of poses times their constant mass ``(instants,)`` (J)."""
    at, d = motion.found.at, motion.machine.geometry.d
    columns = np.einsum("tpjik,tpk->tpji", at.J, at.ways[..., d:])
    return _between(motion, np.concatenate([at.ways[:, :, None, :d], columns], axis=2)) / 2


def energy_of_terms(motion: Motion) -> Array:
    """Give what beams and springs store ``(instants,)`` (J)."""
    stored = (term.energy(motion.t, here.x).sum(axis=1) for term, here in zip(motion.machine.terms, motion.found.terms))
    return sum(stored, np.zeros(len(motion.t)))


def energy_of_weight(motion: Motion) -> Array:
    """Give what the weight of all masses stores ``(instants,)`` (J), 0 at the origin of the fixed frame."""
    at = motion.found.at
    return -_weighed(motion, np.concatenate([at.r[:, :, None], np.swapaxes(at.R, -1, -2)], axis=2))


def power_of_weight(motion: Motion) -> Array:
    """Give what the weight of all masses gives to them ``(instants,)`` (W)."""
    return _weighed(motion, motion.found.at.rates)


def _weighed(motion: Motion, vectors: Array) -> Array:
    """Give vectors of all poses, or their rates, times the mass and free fall ``(instants,)``."""
    falling = np.zeros_like(vectors)
    falling[:, :, 0] = motion.machine.gravity
    return _between(motion, vectors, falling)


def _between(motion: Motion, one: Array, other: Array | None = None) -> Array:
    """Give one set of vectors of all poses times the mass times another ``(instants, poses, 1 + d, d)``."""
    plan, other = motion.machine.inertia, one if other is None else other
    a, i, b, j = plan.entries.T
    return np.asarray(np.einsum("k,tkx,tkx->t", plan.mass, one[:, a, i], other[:, b, j]))
