"""Joint forces and input torque: what the links' own equations of motion lack at their joints."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fenics_mech.mechanism import System
from fenics_mech.response import History
from fenics_mech.scene import Scene

Array = NDArray[np.float64]


def nodal_forces(system: System, history: History) -> Array:
    """Force on each node of each link from outside the link, ``k u + m a`` in link axes, ``(angles, nodal dofs)``."""
    elastic = system.link_stiffness @ system.to_links(history.displacement).T
    return (elastic + system.link_mass @ history.inertia.T).T  # (4.39), solved for {Q}


def joint_forces(scene: Scene, system: System, forces: Array) -> dict[str, Array]:
    """Force (N) that each joint exerts, in the fixed frame, ``(angles, 2)`` each.

    Parameters
    ----------
    scene, system
        The linkage.
    forces
        From `nodal_forces`.

    Returns
    -------
    dict
        By joint: the force of its first body on its second. A pin through more than two bodies has one entry
        "joint:body" for every body after the first: the force of the pin on it.
    """
    found: dict[str, Array] = {}
    for name, joint in scene.joints.items():
        on_body = {point.split(".")[0]: _on_point(system, forces, point) for point in joint.connect}
        if "ground" in on_body:  # the ground takes what the others leave
            on_body["ground"] = -np.sum([force for body, force in on_body.items() if body != "ground"], axis=0)
        others = list(on_body.items())[1:]
        found |= {name if len(others) == 1 else f"{name}:{body}": force for body, force in others}
    return found


def input_torque(scene: Scene, system: System, forces: Array) -> Array:
    """Torque (N m) of the drive on the second body of the driven joint, ``(angles,)``."""
    first, second = scene.joints[scene.drive.joint].connect
    if second.startswith("ground."):
        return -forces[:, 3 * system.beams.mesh.node(first) + 2]
    return forces[:, 3 * system.beams.mesh.node(second) + 2]


def _on_point(system: System, forces: Array, point: str) -> Array:
    """Force on a link's point, turned into the fixed frame."""
    if point.startswith("ground."):
        return np.zeros((len(forces), 2))
    mesh = system.beams.mesh
    node = mesh.node(point)
    x, y = forces[:, 3 * node], forces[:, 3 * node + 1]
    angle = system.motion.angle[:, mesh.node_link[node]]
    return np.stack([np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y], axis=-1)
