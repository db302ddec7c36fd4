"""Natural frequencies about the running motion: with spin, and with axial forces of loads and rigid motion.

A mode of the mechanism held at a position knows no speed and no load. About the motion ``v = P q`` vibrates in axes
that turn, under axial forces. Here the coordinates go with the links: ``q = U y, U' = W U, W = -M^-1 P^T m P'``, by
which v changes least in the links' axes. With ``Z = P' + P W`` the terms of (4.49)-(4.53) become

    ``M y'' + 2 P^T m_v P y' + [K + K_N + P^T m_a P + 2 P^T m_v Z - Z^T m Z] y = 0``,

which no choice of coordinates enters. It is solved at each position in the lowest modes there. K_N is the stiffness of
the axial forces and of rigid links, whose rotation phi moves the places p of forces F back by ``phi^2 p/2``:
``phi^2 sum p.F``.

Source: Genta, Dynamics of Rotating Systems, ch. 2; the stiffness of forces on arms: Argyris, Comput. Methods Appl.
Mech. Eng. 32 (1982) 85.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp
from scipy.linalg import eig
from scipy.optimize import linear_sum_assignment

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.effects import NOTHING, Entries
from fenics_mech.effects.geometric_stiffness import of_forces
from fenics_mech.eigenmodes import Modes, solve_modes
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_ends import axial_forces
from fenics_mech.forces.joint_forces import nodal_forces, reactions
from fenics_mech.mechanism import RigidModes, System
from fenics_mech.response.setup import static_response, without_stiffening
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class RunningLimits:
    """How frequencies about the motion are found, and when they are told."""

    beside: int = 12  # modes beside those that are asked for, in which motions about the running one are sought
    most: int = (
        30  # modes that are looked at, the lowest: the time goes with the third power, and high ones change little
    )
    told: float = 0.005  # share of a frequency, from which spin and axial forces are told


RUNNING = RunningLimits()


def running_frequencies(scene: Scene, system: System, modes: Modes) -> Array | None:
    """Give natural frequencies about the loaded motion (Hz), ``(angles, modes)``; None where nothing runs or loads.

    Where a disturbance diverges there instead of vibrating, its frequency is 0. Beyond the lowest `RUNNING.most` modes
    they are those held.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism.
    modes
        Its modes, held at the same angles.
    """
    idle = not system.motion.omega.any() and not system.load.any()
    if idle or scene.freedoms or len(RigidModes.of(system)):
        return None
    held = system.without_axial_forces
    count = min(modes.omega.shape[1], RUNNING.most)
    wide = solve_modes(held, count + RUNNING.beside, scene.petsc).elastic
    straight = without_stiffening(scene, replace(system, terms=NOTHING))
    response = static_response(scene, straight)
    forces = of_forces(system.beams, axial_forces(straight, response))
    stiffening = Entries.of_elements(system.beams.mesh, np.sum(forces.axial_stiffness, axis=0))
    added = [stiffening, _of_rigid_links(scene, straight, response)]
    damping, stiffness = _about_motion(held, wide, [held.on_links(entries) for entries in added])
    likeness = np.einsum("kmi,kni->kmn", modes.shapes[:, :count], held.mass_times(wide.shapes))
    found = np.zeros_like(modes.omega)
    for k, (c, s) in enumerate(zip(damping, stiffness)):
        found[k] = _of_modes(c, s, likeness[k], modes.omega[k])
    return found / (2 * np.pi)


def _about_motion(system: System, wide: Modes, added: list[Entries]) -> tuple[Array, Array]:
    """C and K about the motion in the coordinates of modes, ``(angles, modes, modes)`` each; M is the unit matrix."""
    transformation, link = system.transformation, system.link_of_coordinate
    omega, alpha = (np.take(rate, link, axis=1)[:, None] for rate in (system.motion.omega, system.motion.alpha))
    turned = transformation.derivatives(system.motion)[0][:, None]
    v, moved = (transformation.forward(values, wide.shapes) for values in (system.values[:, None], turned))
    carried = _with_mass(system.held_matrices()[0]).solve(
        transformation.backward(system.values[:, None], _times(system.link_mass, moved))
    )
    left = moved - transformation.forward(system.values[:, None], carried)  # Z
    spin = _times(system.link_gyroscopic, v)
    inertia = _times(system.link_mass - system.link_rotary_mass, v)
    damping = 2 * _products(v, omega * spin)  # (4.29)
    stiffness = _products(v, alpha * spin - omega**2 * inertia)  # (4.30)
    stiffness += 2 * _products(v, omega * _times(system.link_gyroscopic, left))
    stiffness -= _products(left, _times(system.link_mass, left))
    for entries in added:
        forces = np.stack([entries.times(v[:, mode]) for mode in range(v.shape[1])], axis=1)
        stiffness += _products(v, forces)
    stiffness += np.square(wide.omega)[:, None] * np.eye(wide.omega.shape[1])
    return damping, stiffness


def _times(matrix: sp.csr_matrix, vectors: Array) -> Array:
    """Product of a matrix over the links' coordinates with vectors, ``(angles, vectors, coordinates)``."""
    return np.asarray((matrix @ vectors.reshape(-1, vectors.shape[-1]).T).T).reshape(vectors.shape)


def _products(left: Array, right: Array) -> Array:
    """Products of all vectors at each angle, ``(angles, vectors, vectors)``."""
    return left @ right.transpose(0, 2, 1)


def _with_mass(mass: Stack) -> Stack:
    """Give M with units on the diagonal where a coordinate has no mass, which then carries nothing."""
    on_diagonal = np.flatnonzero(mass.pattern.rows == mass.pattern.columns)
    values = mass.values.copy()
    values[:, on_diagonal] = np.where(values[:, on_diagonal] > 0, values[:, on_diagonal], 1.0)
    return replace(mass, values=values)


def _of_modes(damping: Array, stiffness: Array, likeness: Array, held: Array) -> Array:
    """Circular frequencies about the motion at one angle, in the order of the held modes that they are most like."""
    size = len(stiffness)
    state = np.block([[np.zeros((size, size)), np.eye(size)], [-stiffness, -damping]])
    values, vectors = eig(state)
    share = np.abs(likeness @ vectors[:size]) ** 2 / np.sum(np.abs(vectors[:size]) ** 2, axis=0)
    modes, places = linear_sum_assignment(-share * (values.imag >= 0))
    found = held.copy()
    found[modes] = values.imag[places]
    return found


def _of_rigid_links(scene: Scene, system: System, response: ElasticResponse) -> Entries:
    """Stiffness of rigid links against rotation, by joints' forces on arms from their centres, over the nodal dofs."""
    found, angle = reactions(system, nodal_forces(system, response)), system.motion.angle
    links = [(i, name, link.rigid.centre) for i, (name, link) in enumerate(scene.links.items()) if link.rigid]
    virial = np.zeros((len(angle), len(links)))
    for joint_name, joint in scene.constraints.items():
        bodies = [point.split(".")[0] for point in joint.connect]
        known = {body: found[joint_name, body, 2] for body in bodies if (joint_name, body, 2) in found}
        for place, (link, name, centre) in enumerate(links):
            if name in bodies and known:
                rest = -np.sum(list(known.values()), axis=0)  # a body that has no equation takes what others leave
                x, y = np.subtract(scene.point(joint.connect[bodies.index(name)])[1], centre)
                c, s = np.cos(angle[:, link]), np.sin(angle[:, link])
                arm = np.stack([c * x - s * y, s * x + c * y], axis=1)
                virial[:, place] += np.sum(arm * known.get(name, rest), axis=1)
    nodes = system.beams.mesh.node_name
    dofs = np.array([3 * nodes.index(f"{name}.centre") + 2 for _, name, _ in links], dtype=np.int64)
    return Entries(dofs, dofs, virial)
