"""What beams carry beside the viscous stress of modes: the strains of fibres follow from it, and not from the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.machine import Machine
from fenics_mech.solve import accelerated
from fenics_mech.terms import Beams, Response


def without_modes(
    machine: Machine, t: Array, q: Array, v: Array, a: Array, found: Evaluation, *, material: bool = False
) -> Evaluation:
    """Give the same motion without the stress of damped modes, and with accelerations that balance the rest."""
    # That stress goes with the rate of a vibration, and its inertia is taken as that which it accelerates. So both
    # parts are in equilibrium within elements. What the material damps is local: over a cycle it is found from the
    # strains that this gives, whose rates the cycle has.
    zero, kept, force = np.zeros_like(found.M), [], np.zeros_like(found.force)
    for term, group, here in zip(machine.terms, machine.groups, found.terms):
        response, damped = here.response, np.zeros_like(here.response.stress)
        if response.modes is not None:
            sizes = np.einsum("temk,tem->tk", response.modes, here.rate)
            damped = np.einsum("temk,tk->tem", response.modes, sizes)
        if material and isinstance(term, Beams):
            damped = damped + np.einsum("eij,tej->tei", term.stiffness, term.damping[:, None] * here.rate)
        if damped.any():
            group.spread(here.with_response(Response(damped)), None, found.pattern, False, (force, zero, zero, zero))
            response = replace(response, stress=response.stress - damped)
        kept.append(here.with_response(response))
    moved = a + accelerated(machine, found, force)
    return replace(machine.residual(t, q, v, moved, tangents=False, known=True), terms=kept)
