"""What acts at some instants of a motion of rigid links."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.mechanism.rigid_dynamics import RigidDynamics, RigidStates
from fenics_mech.terms.causes import Cause, cause_of_efforts


@dataclass(frozen=True)
class RigidInstants:
    """What acts at some instants of a motion.

    Parameters
    ----------
    states
        The motion.
    efforts
        Of the drives, then of the freedoms (N m or N), ``(times, drives)``.
    joint_forces
        Force of each joint (N), ``(times, 2)`` each, by its name.
    law_efforts
        What each joint law exerts (N or N m), ``(times,)`` each: along the guide or about the pin; the size of its
        force where it takes the place of a pin.
    depths
        Indentation at the contacts of each law that has some (m or rad), ``(times,)`` each: the largest of its
        contacts, negative where none touches.
    powers
        Power of each cause (W), ``(times,)`` each.
    energy
        Of motion and of springs (J), ``(times,)``.
    on_frame
        Force on the frame (N), and its moment about the origin of the ground (N m), ``(times, 3)``.
    """

    states: RigidStates
    efforts: Array
    joint_forces: dict[str, Array]
    law_efforts: dict[str, Array]
    depths: dict[str, Array]
    powers: dict[str, Array]
    energy: Array
    on_frame: Array


def instants_of(dynamics: RigidDynamics, states: RigidStates, contacts: dict) -> RigidInstants:
    """Give what acts in a motion.

    Parameters
    ----------
    dynamics
        The forces of the linkage.
    states
        The motion.
    contacts
        Which contacts are closed, by law.
    """
    balance = dynamics.balance(states, contacts)
    efforts = dynamics.efforts(balance.multipliers)
    joints, exerted, depths = dynamics.law_states(states.links), {}, {}
    for name, wrench in dynamics.wrenches(states, contacts).items():
        exerted[name] = dynamics.size_of(name, states, wrench) + balance.friction.get(name, 0.0)
        if dynamics.laws[name].contacts:
            depths[name] = dynamics.laws[name].depths(joints[name])[0].max(axis=0)
    rates = (
        dynamics.loops.jacobian(states.q)[:, len(dynamics.loops.names) - dynamics.loops.drives :]
        @ states.velocity[..., None]
    )
    ordered = np.empty(efforts.shape)
    ordered[:, list(dynamics.loops.drive_order)] = rates[..., 0]
    powers = {cause_of_efforts(dynamics.scene): np.sum(efforts * ordered, axis=1)}
    powers |= {name: np.sum(force * states.velocity, axis=1) for name, force in balance.forces.items()}
    energy = dynamics.loads.inertia.kinetic_energy(states.links) + dynamics.loads.spring_energy(states.links)
    powers.pop(Cause.SPRINGS, None)
    forces = dynamics.joint_forces(states, balance, contacts)
    shaking = dynamics.on_frame(states, balance)
    return RigidInstants(states, efforts, forces, exerted, depths, powers, energy, shaking)


def states_part(states: RigidStates, part: slice) -> RigidStates:
    """Give some states of several.

    Parameters
    ----------
    states
        The states.
    part
        Which of them.
    """
    names = ("time", "theta", "q", "velocity", "acceleration", "inverse")
    return RigidStates(*(getattr(states, name)[part] for name in names))


def part_of(found: RigidInstants, part: slice) -> RigidInstants:
    """Give some instants of several, to be kept: without what the solver needed the Jacobian for.

    Parameters
    ----------
    found
        The instants.
    part
        Which of them.
    """

    def cut(by_name: dict[str, Array]) -> dict[str, Array]:
        return {name: values[part] for name, values in by_name.items()}

    return RigidInstants(
        states=replace(states_part(found.states, part), inverse=np.zeros((0, 0, 0))),
        efforts=found.efforts[part],
        joint_forces=cut(found.joint_forces),
        law_efforts=cut(found.law_efforts),
        depths=cut(found.depths),
        powers=cut(found.powers),
        energy=found.energy[part],
        on_frame=found.on_frame[part],
    )
