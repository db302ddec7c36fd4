"""What beams carry beside their viscous stress: the strains of the fibres follow from it, and not from the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import scipy.sparse as sp
from scipy.sparse.linalg import spsolve

from fenics_mech._arrays import Array
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.machine import Machine
from fenics_mech.terms import Beams, Response

MASSLESS = 1e-14  # of the largest entry: coordinates without mass, which no viscous stress pulls, keep it solvable


def elastic_part(machine: Machine, t: Array, q: Array, v: Array, a: Array, found: Evaluation) -> Evaluation:
    """Give the same motion without the viscous stress of beams, and with accelerations that balance the rest.

    A viscous stress goes with the rate of a vibration. Its inertia is taken as that which it accelerates, so that both
    parts are in equilibrium within elements.

    Parameters
    ----------
    machine
        The machine.
    t, q, v, a
        Instants and motion, as its residual takes them.
    found
        The residual there, with tangents.
    """
    zero = np.zeros_like(found.M)
    viscous, elastic = np.zeros_like(found.force), []
    for term, group, here in zip(machine.terms, machine.groups, found.terms):
        kept = here
        if isinstance(term, Beams):
            kept = here.with_response(Response(np.einsum("eij,tej->tei", term.stiffness, here.x)))
            rest = Response(here.response.stress - kept.response.stress)
            group.spread(here.with_response(rest), None, found.pattern, False, (viscous, zero, zero, zero))
        elastic.append(kept)
    moved = a + _accelerated(machine, found, viscous)
    return replace(machine.residual(t, q, v, moved, tangents=False), terms=elastic)


def _accelerated(machine: Machine, found: Evaluation, force: Array) -> Array:
    """Give what forces accelerate at rest, within the rows, ``(instants, size)``."""
    n, kept, pattern = machine.n, machine.n + len(machine.rows), found.pattern
    of_rows = (np.repeat(np.arange(pattern.size), np.diff(pattern.indptr)) >= n) & (pattern.indices < n)
    accelerations = np.zeros_like(force)
    for k in range(len(force)):
        matrix = pattern.matrix(np.where(of_rows, found.K[k], found.M[k]))[:kept, :kept]
        least = np.zeros(kept)
        least[:n] = MASSLESS * np.abs(found.M[k]).max()
        accelerations[k, :n] = spsolve((matrix + sp.diags(least)).tocsc(), force[k, :kept])[:n]
    return accelerations
