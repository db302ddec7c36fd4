"""What beams carry beside the viscous stress of modes: the strains of fibres follow from it, and not from the whole."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.machine import Machine
from fenics_mech.solve import accelerated
from fenics_mech.terms import Response


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
    moved = a + accelerated(machine, found, force)
    return replace(machine.residual(t, q, v, moved, tangents=False, known=True), terms=kept)
