"""Vibration by the nodes that a slider passes, where it turns with the member that it travels along.

It turns with its element's shape function, without the bend by the couple under it; see `PointLoad.gap`. In the
middle of an element that is a gap in proportion to the element's length, and none at nodes. So it has a kink at every
node, whatever the length of the elements. There the slider's rate of rotation jumps by ``2 v M/EI``, v being its speed
along the member and M the couple. The whole beam would carry it past smoothly. Differences between positions (see
`mesh_residual`) do not show what such a jump puts into fast modes.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import scipy.linalg as la

from fenics_mech._arrays import Array
from fenics_mech.accuracy.mesh_residual import yielded
from fenics_mech.effects import AddedMatrices, Terms
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_loads import PointLoad, pin_loads
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class KinkLimits:
    """How blows of pins that pass element ends are looked at."""

    modes: int = 8  # that are looked at: the blows put less into higher ones
    blows: int = 8  # that are looked at, the strongest
    massless: float = 1e-12  # of the largest 1/omega^2, up to which a mode has no mass, as with lumped ones


KINKS = KinkLimits()


def ringing(system: System, response: ElasticResponse, step: float) -> Iterator[ElasticResponse]:
    """Give the amplitudes of one mode after another by the blows that positions do not show.

    They are at the positions before the blows, and 0 at all others. The modes are those of `unloaded`.

    Parameters
    ----------
    system
        The mechanism at the positions.
    response
        Its motion there.
    step
        Duration between positions (s).
    """
    contacts = system.transformation.constraints.contacts
    pins = pin_loads(system, response)
    jumps = [_jump(system, name, pin) for name, pin in zip(contacts, pins)]
    if not np.any(jumps):
        return
    v = yielded(system, {name: (np.zeros_like(jump), jump) for name, jump in zip(contacts, jumps)})
    momenta = (system.link_mass @ v.T).T
    strength = np.einsum("ki,ki->k", v, momenta)
    struck = [int(k) for k in np.argsort(strength)[-KINKS.blows :] if strength[k] > 0]
    count = min(KINKS.modes, system.size)
    amplitudes, accelerations = np.zeros((2, count, *response.displacement.shape))
    free = unloaded(system)
    on_coordinates = system.transformation.backward(system.values, momenta)
    held = free.held_matrices()
    for k in struck:
        mass, stiffness = (part.dense(k) for part in held)
        last = [system.size - count, system.size - 1]
        inverse, shapes = la.eigh(mass, stiffness, subset_by_index=last)  # 1/omega^2, and shapes of unit stiffness
        omega = 1 / np.sqrt(np.maximum(inverse, KINKS.massless * inverse[-1]))
        missed = 1 - np.sinc(omega * step / (2 * np.pi)) ** 2  # a blow that is spread over the steps beside it
        amplitudes[:, k] = (missed * omega * (shapes.T @ on_coordinates[k]) * shapes).T
        accelerations[:, k] = -(omega[:, None] ** 2) * amplitudes[:, k]
    for q, acceleration in zip(amplitudes, accelerations):
        yield ElasticResponse(q, system.to_links(acceleration))


def unloaded(system: System) -> System:
    """Give the mechanism with its springs, and no other effect.

    Parameters
    ----------
    system
        The mechanism.
    """
    return system.with_terms(Terms(matrices=AddedMatrices(stiffness=system.terms.matrices.stiffness)))


def _jump(system: System, name: str, pin: PointLoad) -> Array:
    """By how much the rate of rotation jumps at a node between each position and the next (rad/s), ``(angles,)``.

    At a distance a from a clamped end a couple M turns a beam by ``M a / EI``, to the first order of a.
    """
    element, place = system.transformation.constraints.contacts[name].place(system.motion, 3)
    speed = np.abs(place[1]) * system.beams.mesh.cell_length[element]
    flexibility = 1 / system.beams.rigidity.bending.mean[element]
    after = np.roll(element, -1)
    return np.where(element != after, speed * pin.moment * (flexibility + np.roll(flexibility, -1)), 0.0)
