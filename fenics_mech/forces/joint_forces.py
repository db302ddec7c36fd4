"""Joint forces: the multipliers of the joints' equations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from fenics_mech._arrays import Array, turned
from fenics_mech.effects.joint_frames import LawForces
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.spinning_sections import spinning
from fenics_mech.mechanism import System
from fenics_mech.mechanism.elimination import Group
from fenics_mech.scene import Prismatic, Slot
from fenics_mech.scene.joints import Joint
from fenics_mech.scene.numbering import GROUND

Reactions = dict[tuple[str, str, int], Array]  # by joint, body and number of components


def nodal_forces(system: System, response: ElasticResponse) -> Array:
    """Force of the joints on each node of each link in link axes, ``k u + m a - f``, ``(angles, nodal dofs)``.

    Where members are reduced, what acts inside them stands at their ends.

    Parameters
    ----------
    system
        The mechanism.
    response
        A motion of it.
    """
    forces, strained = without_elastic(system, response), response.strained(system)  # (4.39)
    reduction = system.beams.reduction
    if reduction is None:
        return forces + (system.nodal_stiffness @ strained.T).T
    kept, count = reduction.kept, len(reduction.kept)
    at_ends = np.zeros_like(forces)
    at_ends[:, kept] = (reduction.shape[:, :count].T @ forces.T).T
    at_ends[:, kept] += (reduction.stiffness[:count, :count] @ strained[:, kept].T).T
    return at_ends


def without_elastic(system: System, response: ElasticResponse) -> Array:
    """Force that the nodes need from joints and from the links' stress, ``m a - f``, ``(angles, nodal dofs)``.

    Parameters are those of `nodal_forces`.
    """
    terms, v = system.terms, system.to_links(response.displacement)
    forces = (system.nodal_mass @ response.inertia.T).T - system.applied
    for entries in system.added_stiffness:
        forces += entries.times(v)
    if (rotation := response.rotation) is not None:
        forces += (system.nodal_gyroscopic @ rotation.turning.T - system.nodal_rotary_mass @ rotation.centripetal.T).T
    if response.velocity is not None:
        for entries in terms.matrices.damping:
            forces += entries.times(response.velocity)
        if terms.law is not None:
            forces += system.assembled(terms.law.on_elements.force(v, response.velocity))
            for part in terms.rotation_forces:
                forces += part.on_nodes(v, response.velocity)
    if (spun := spinning(system, response)) is not None:
        forces += system.assembled(spun[0].force(*spun[1], system.motion.alpha))
    if response.modal_damping is not None and response.modal_damping.on_bent_axis is not None:
        forces += system.assembled(response.modal_damping.on_bent_axis)
    return forces


def reactions(system: System, forces: Array) -> Reactions:
    """Force or moment of every joint on every body that it holds, from `nodal_forces`.

    Parameters
    ----------
    system
        The mechanism.
    forces
        Forces of the joints on the nodal dofs in link axes, ``(..., angles, nodal dofs)``.

    Returns
    -------
    dict
        By (joint, body, number of components): forces in the fixed frame (N), ``(..., angles, 2)``, and moments
        (N m), ``(..., angles, 1)``.
    """
    found: Reactions = {}
    for group, multipliers in _multipliers(system, forces):
        start = 0
        for equation in group.equations:
            value = multipliers[..., start : start + equation.rows]
            start += equation.rows
            if equation.rows == 2 and equation.frame != GROUND:
                value = turned(value, system.motion.angle[:, equation.frame])
            found[equation.joint, equation.body, equation.rows] = value
    return found


def _multipliers(system: System, forces: Array) -> Iterator[tuple[Group, Array]]:
    """Groups of the joints' equations with their multipliers, ``(..., angles, rows)``."""
    forces = system.transformation.on_unknowns(forces)
    for group in system.transformation.groups:
        nodal = group.dependent < system.transformation.height
        residual = np.zeros((*forces.shape[:-1], len(group.dependent)))
        residual[..., nodal] = forces[..., group.dependent[nodal]]
        yield group, group.multipliers(system.motion, residual)


def joint_forces(joints: Mapping[str, Joint], found: Reactions, laws: Sequence[LawForces] = ()) -> dict[str, Array]:
    """Force (N) that each joint exerts, in the fixed frame, ``(angles, 2)`` each.

    Parameters
    ----------
    joints
        The joints, by name.
    found
        From `reactions`.
    laws
        What joint laws exert beside these, or in their place.

    Returns
    -------
    dict
        By name, see `joint_names`: the force of a joint's first body on its second, or of its pin on a body.
    """
    forces: list[Array] = []
    for name, joint in joints.items():
        bodies = [point.split(".")[0] for point in joint.connect]
        exerted = [law.force for law in laws if law.joint == name]
        held = {body: found[name, body, 2] for body in bodies if (name, body, 2) in found}
        if not held:  # a law takes the place of its equations
            forces.append(np.sum(exerted, axis=0))
            continue
        for body in bodies:  # a body that has no equation takes what the others leave
            if body not in held:
                held[body] = -np.sum(list(held.values()), axis=0)
        forces += [sum(exerted, held[body]) for body in bodies[1:]]
    return dict(zip(joint_names(joints), forces))


def joint_names(joints: Mapping[str, Joint]) -> list[str]:
    """Give the names of joint forces: one to a joint, or "joint:body" for every body on a pin but the first.

    Parameters
    ----------
    joints
        The joints, by name.
    """
    bodies = {name: [point.split(".")[0] for point in joint.connect[1:]] for name, joint in joints.items()}
    return [name if len(there) == 1 else f"{name}:{body}" for name, there in bodies.items() for body in there]


def effort_units(moved: Sequence[str], joints: Mapping[str, Joint]) -> list[str]:
    """Give the unit of each drive's effort: N where it slides, N m where it turns.

    Parameters
    ----------
    moved
        Joints of the drives and the freedoms.
    joints
        The joints, by name.
    """
    return ["N" if isinstance(joints[name], Slot | Prismatic) else "N m" for name in moved]
