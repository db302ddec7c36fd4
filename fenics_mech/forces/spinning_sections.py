"""What the inertia of sections needs beyond linear theory, where axes turn far."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.section_spin import SectionSpin
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.kinematics import Motion
from fenics_mech.mechanism import System


def spinning(system: System, response: ElasticResponse) -> tuple[SectionSpin, tuple[Array, Array, Array]] | None:
    """Give the inertia of sections beyond linear theory, and v with its derivatives; None where there is none.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    """
    if system.spin is None:
        return None
    v = system.to_links(response.displacement)
    rate = np.zeros_like(v) if response.velocity is None else response.velocity
    second = response.inertia - system.rigid_acceleration - system.terms.damping.drag * rate
    if response.rotation is not None:
        second = second - response.rotation.centripetal
    return system.spin.on_elements, (v, rate, second)


def work_against_spin(system: System, response: ElasticResponse, motion: Motion, deformation: Array) -> Array:
    """Work against this inertia in some rates of the mechanism, ``(angles,)`` (W); 0 where there is none.

    Parameters
    ----------
    system, response
        The mechanism, and its motion.
    motion
        The rigid motion with these rates.
    deformation
        Rate of the elastic displacement v in link axes, ``(angles, nodal dofs)``.
    """
    if (spun := spinning(system, response)) is None:
        return np.zeros(len(deformation))
    spin, state = spun
    on_links = np.sum(spin.on_frames(*state) * motion.omega[:, spin.link], axis=-1)
    forces = spin.force(*state, system.motion.alpha)
    return np.asarray(on_links + np.sum(forces * deformation[:, spin.dofs], axis=(1, 2)))
