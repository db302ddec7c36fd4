"""What beams carry beside the viscous stress of modes: the strains of fibres follow from it, and not from the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine import Evaluation, Machine
from fenics_mech.solve.sparse import blocks_of, solutions
from fenics_mech.terms import Response

MASSLESS = 1e-14  # of the largest entry: coordinates without mass, which no mode pulls, keep it solvable


def without_modes(machine: Machine, t: Array, q: Array, v: Array, a: Array, found: Evaluation) -> Evaluation:
    """Give the same motion without the stress of damped modes, and with accelerations that balance the rest.

    That stress goes with the rate of a vibration, and its inertia is taken as that which it accelerates. So both parts
    are in equilibrium within elements. What the material damps is local: it is found from the strains that this gives.

    Parameters
    ----------
    machine
        The machine.
    t, q, v, a
        Instants and motion, as its residual takes them.
    found
        The residual there, with tangents.
    """
    zero, kept, force = np.zeros_like(found.M), [], np.zeros_like(found.force)
    for group, here in zip(machine.groups, found.terms):
        response = here.response
        if response.modes is not None:
            sizes = np.einsum("temk,tem->tk", response.modes, here.rate)
            of_modes = np.einsum("temk,tk->tem", response.modes, sizes)
            group.spread(here.with_response(Response(of_modes)), None, found.pattern, False, (force, zero, zero, zero))
            response = replace(response, stress=response.stress - of_modes)
        kept.append(here.with_response(response))
    moved = a + _accelerated(machine, found, force)
    return replace(machine.residual(t, q, v, moved, tangents=False, known=True), terms=kept)


def _accelerated(machine: Machine, found: Evaluation, force: Array) -> Array:
    """Give what forces accelerate at rest, within the rows, ``(instants, size)``."""
    n, kept, pattern = machine.n, machine.n + machine.held, found.pattern
    rows, columns = np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)), pattern.indices
    of_modes, of_rows = (rows >= kept) != (columns >= kept), (rows >= n) & (columns < n)
    values = np.where(of_modes, 0.0, np.where(of_rows, found.K, found.M))
    values[:, (rows == columns) & (rows < n)] += MASSLESS * np.abs(found.M).max(axis=1, keepdims=True)
    pulled = np.where(np.arange(machine.size) < kept, force, 0.0)
    moved = solutions(blocks_of(pattern, 1), values[..., None, None], pulled, "accelerations by the damping of modes")
    return np.where(np.arange(machine.size) < n, moved, 0.0)
