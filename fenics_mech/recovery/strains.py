"""Strains of the outer fibres from the forces in sections, without what damps modes and the material."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.motion import Motion
from fenics_mech.scene.sections import Rigidity
from fenics_mech.solve import accelerated
from fenics_mech.terms import Beams, Response


def stress_over_modulus(sections: Sequence[Rigidity], axial_force: Array, moment: Array) -> tuple[Array, Array]:
    """Give what stress over modulus an axial force and a moment make: the strain where the material does not damp."""
    # axial_force, moment: n (N) and M (N m), ``(angles, members, stations)``
    # Gives by the axial force N/EA, ``(angles, members, stations)``, and by the moment in both outer fibres, - M e/EI
    # with e the fibre's place on the normal's side, ``(angles, members, stations, 2)``. Their sum is (6.38).
    axial, bending, fibre = (np.stack([getattr(r, part) for r in sections]) for part in ("axial", "bending", "fibre"))
    return axial_force / axial, -moment[..., None] * fibre / bending[..., None]


def young_modulus(sections: Sequence[Rigidity]) -> Array:
    """Young's modulus (Pa) at both outer fibres, ``(members, stations, 2)``."""
    return np.stack([section.modulus for section in sections])


def without_vibration(sections: Sequence[Rigidity], axial_force: Array, moment: Array) -> dict[str, Any]:
    """Give strains and stresses of a static answer, as variables."""
    by_force, by_moment = stress_over_modulus(sections, axial_force, moment)
    strain, along = by_force[..., None] + by_moment, ("theta", "member", "s", "fibre")
    return {"strain_quasi_static": (along, strain), "stress_quasi_static": (along, young_modulus(sections) * strain)}


def elastic_strain(total: Array, retardation: float, period: float) -> Array:
    """Solve ``strain + retardation strain' = total`` over a cycle (s), harmonic by harmonic."""
    harmonics = np.fft.rfft(total, axis=0)
    omega = 2 * np.pi / period * np.arange(len(harmonics))
    lag = (1 + 1j * omega * retardation).reshape(-1, *(1,) * (total.ndim - 1))
    return np.fft.irfft(harmonics / lag, n=len(total), axis=0)


def without_modes(motion: Motion, *, material: bool = False) -> Evaluation:
    """Give the same motion without the stress of damped modes, and with accelerations that balance the rest."""
    # That stress goes with the rate of a vibration, and its inertia is taken as that which it accelerates. So both
    # parts are in equilibrium within elements. What the material damps is local: over a cycle it is found from the
    # strains that this gives, whose rates the cycle has.
    machine, found = motion.machine, motion.with_tangents
    zero, kept, force = np.zeros_like(found.M), [], np.zeros_like(found.force)
    for term, group, here in zip(machine.terms, machine.groups, found.terms):
        response, damped = here.response, np.zeros_like(here.response.stress)
        if here.modes is not None:
            damped = np.einsum("temk,tk->tem", here.modes, np.einsum("temk,tem->tk", here.modes, here.rate))
        if material and isinstance(term, Beams):
            damped = damped + np.einsum("eij,tej->tei", term.stiffness, term.damping[:, None] * here.rate)
        if damped.any():
            group.spread(
                replace(here, response=Response(damped)), None, found.pattern, False, (force, zero, zero, zero)
            )
            response = replace(response, stress=response.stress - damped)
        kept.append(replace(here, response=response))
    moved = motion.a + accelerated(machine, found, force)
    return replace(machine.residual(motion.t, motion.q, motion.v, moved, tangents=False, known=True), terms=kept)
