"""What beams carry beside the viscous stress of modes: the strains of fibres follow from it, and not from the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fenics_mech._arrays import Array
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.machine import Machine
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
    of_rows = (np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)) >= n) & (pattern.indices < n)
    accelerations = np.zeros_like(force)
    for k in range(len(force)):
        matrix = pattern.matrix(np.where(of_rows, found.K[k], found.M[k]))[:kept, :kept]
        least = np.zeros(kept)
        least[:n] = MASSLESS * np.abs(found.M[k]).max()
        accelerations[k, :n] = spsolve((matrix + sp.diags(least)).tocsc(), force[k, :kept])[:n]
    return accelerations
