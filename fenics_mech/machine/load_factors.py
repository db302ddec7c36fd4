"""Factors of loads in a motion: over the drive angle, over time, and over the place and rate of a joint."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.joints.joint_state import JointPlace
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.kinematics import Motion, coordinates
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import Varying
from fenics_mech.scene.state_factors import StateFactor


def load_factor(scene: Scene, load: Varying, theta: Array, time: Array, links: LinkStates) -> Array:
    """Give the factor of a load, ``(states,)``."""
    # theta, time (states,) each
    if not isinstance(load.factor, StateFactor):
        return load.factor_at(theta)
    none = np.zeros_like(time)
    place, rate = (none, none) if load.factor.joint is None else joint_motion(scene, load.factor.joint, links)
    return load.factor.of_state(time, place, rate)


def joint_motion(scene: Scene, name: str, links: LinkStates) -> tuple[Array, Array]:
    """Give the angle (rad) or the stroke (m) of a joint of two bodies, and its rate, ``(states,)`` each."""
    state = JointPlace.of(scene, name).state(links)
    return state.place, state.rate


def factor_in(scene: Scene, load: Varying, motion: Motion) -> Array:
    """Give the factor of a load in a motion of the links, ``(angles,)``."""
    rates = coordinates(motion.velocity, motion.omega)
    links = LinkStates.of(coordinates(motion.position, motion.angle), rates)
    return load_factor(scene, load, motion.theta, motion.time, links)
