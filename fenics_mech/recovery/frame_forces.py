"""Forces of the mechanism on the frame: at each support, and in total, the shaking force and the shaking moment.

All that the links need from outside comes from the frame, but for weight, loads and drag of the surroundings. So the
total is that of weight and loads less the rate of the links' momentum (Berkof and Lowen, 1969).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, turned
from fenics_mech.beams.attachment import Attachment
from fenics_mech.effects.separations import Separation
from fenics_mech.forces.joint_forces import Reactions
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.joints.laws import law_names
from fenics_mech.joints.link_states import cross
from fenics_mech.mechanism import System
from fenics_mech.recovery.fields import Fields
from fenics_mech.scene import Prismatic, Scene, Slot, Weld
from fenics_mech.scene.joints import Joint
from fenics_mech.scene.springs_dampers import Hinge, Line

GROUND = "ground"


@dataclass(frozen=True)
class Support:
    """What a joint, a spring or a damper does to the frame.

    Parameters
    ----------
    force
        Force on the frame in the fixed frame (N), ``(angles, 2)``.
    couple
        Couple on the frame (N m), ``(angles,)``.
    place
        Where the force acts (m), ``(angles, 2)``.
    """

    force: Array
    couple: Array
    place: Array

    @property
    def moment(self) -> Array:
        """Moment of both about the origin of the ground (N m), ``(angles,)``."""
        (x, y), (fx, fy) = self.place.T, self.force.T
        return np.asarray(x * fy - y * fx + self.couple)


def frame_forces(forces: Forces, fields: Fields, efforts: Mapping[str, Array]) -> xr.Dataset:
    """Give the forces on the frame at every support, and their sum.

    Parameters
    ----------
    forces
        The forces of the motion.
    fields
        What was recovered from it.
    efforts
        Effort of each drive and freedom (N m or N), by joint, ``(angles,)`` each.

    Returns
    -------
    xarray.Dataset
        `support_force` (N) and `support_moment` (N m, a couple) by `support`, a joint of the ground or a spring or
        damper on it; `shaking_force` (N) and `shaking_moment` (N m, about the origin of the ground). With welds or
        slides also `joint_moment` (N m). Empty parts where the scene has no such thing.
    """
    scene, system = forces.scene, forces.system
    found = xr.Dataset()
    moments = joint_moments(scene, fields.reactions)
    if moments:
        found["joint_moment"] = (("theta", "held"), np.stack(list(moments.values()), axis=1))
        found = found.assign_coords(held=list(moments))
    supports = dict(_of_joints(forces, fields.reactions, moments, efforts))
    supports |= dict(_of_lines(forces, fields))
    supports |= dict(_of_laws(scene, system))
    if not supports:
        return found
    parts = list(supports.values())
    force, couple = np.stack([part.force for part in parts], axis=1), np.stack([part.couple for part in parts], axis=1)
    moment = np.sum([part.moment for part in parts], axis=0)
    found["support_force"] = (("theta", "support", "component"), force)
    found["support_moment"] = (("theta", "support"), couple)
    found["shaking_force"] = (("theta", "component"), force.sum(axis=1))
    found["shaking_moment"] = (("theta",), moment)
    return found.assign_coords(support=list(supports), theta=system.motion.theta, component=["x", "y"])


def joint_moments(scene: Scene, found: Reactions) -> dict[str, Array]:
    """Moment of the first body of each weld and prismatic joint on its second (N m), ``(angles,)`` each.

    Parameters
    ----------
    scene
        The scene.
    found
        From `forces.joint_forces.reactions`.
    """
    return {
        name: next(value[:, 0] for (of, _, rows), value in found.items() if of == name and rows == 1)
        for name, joint in scene.constraints.items()
        if isinstance(joint, Weld | Prismatic)
    }


def _of_joints(
    forces: Forces, found: Reactions, moments: Mapping[str, Array], efforts: Mapping[str, Array]
) -> Iterator[tuple[str, Support]]:
    """Give the joints of the ground."""
    for name, joint in forces.scene.constraints.items():
        bodies = [point.split(".")[0] for point in joint.connect]
        if GROUND not in bodies:
            continue
        couple = np.zeros(len(forces.system.motion.theta))
        sign = 1.0 if bodies[1] == GROUND else -1.0  # moments and efforts are those on the second body
        if name in moments:
            couple += sign * moments[name]
        elif name in efforts and not isinstance(joint, Slot):
            couple += sign * (efforts[name] + _of_rotor(forces, name, bodies))
        on_others = [found[name, body, 2] for body in bodies if (name, body, 2) in found and body != GROUND]
        force = found[name, GROUND, 2] if not on_others else -np.sum(on_others, axis=0)
        yield name, Support(force, couple, _place(forces, joint))


def _place(forces: Forces, joint: Joint) -> Array:
    """Where a joint's force on the ground acts (m), ``(angles, 2)``: at the pin, which may slide along the ground."""
    motion = forces.system.motion
    at = next((point for point in joint.connect if point.startswith(f"{GROUND}.")), joint.connect[0])
    if not isinstance(joint, Slot | Prismatic) or joint.connect[1] == at:
        return motion.of_point(*forces.scene.point(at))[0]
    rigid = motion.of_point(*forces.scene.point(joint.connect[1]))[0]
    return rigid + displacement_of(forces.scene, forces.system, joint.connect[1], forces.shape)


def displacement_of(scene: Scene, system: System, point: str, v: Array) -> Array:
    """Displacement of a point of a link in the fixed frame by that of the nodes (m), ``(angles, 2)``.

    Parameters
    ----------
    scene, system
        The scene and its mechanism.
    point
        The point, "link.point".
    v
        Displacement of the nodal dofs in link axes, ``(angles, nodal dofs)``.
    """
    at = Attachment.of(scene.links, scene.joints, system.beams.mesh, point)
    return turned((at.shift @ v[:, at.dofs].T).T, system.motion.angle[:, at.link])


def _of_rotor(forces: Forces, name: str, bodies: list[str]) -> Array | float:
    """Torque that a rotor or flywheel between drive and link takes for itself (N m)."""
    scene, motion = forces.scene, forces.system.motion
    inertia = sum(drive.motor.inertia for drive in scene.drives if drive.joint == name and drive.motor is not None)
    inertia += scene.freedoms[name].inertia if name in scene.freedoms else 0.0
    if not inertia:
        return 0.0
    first, second = (0.0 if body == GROUND else motion.alpha[:, motion.links.index(body)] for body in bodies)
    return np.asarray(inertia * (second - first))


def _of_lines(forces: Forces, fields: Fields) -> Iterator[tuple[str, Support]]:
    """Give the springs and dampers that take hold of the ground."""
    scene, mesh, motion = forces.scene, forces.system.beams.mesh, forces.system.motion
    for kind, parts in (("spring", scene.springs), ("damper", scene.dampers)):
        for i, (name, part) in enumerate(parts.items()):
            sign = _side_of_ground(scene, part)
            if not sign:
                continue
            tension = sign * fields.variables[f"{kind}_force"][1][:, i]
            nothing = np.zeros((len(tension), 2))
            if isinstance(part, Hinge):
                yield f"{kind} {name}", Support(nothing, tension, nothing)
                continue
            separation = Separation.of(scene, mesh, motion, part)
            whole = separation.value + separation.elastic(forces.displacement)
            length = np.maximum(np.linalg.norm(whole, axis=1), np.finfo(float).tiny)
            at = next(point for point in part.between if point.startswith(f"{GROUND}."))
            place = motion.of_point(*scene.point(at))[0]
            yield f"{kind} {name}", Support((tension / length)[:, None] * whole, np.zeros(len(tension)), place)


def _of_laws(scene: Scene, system: System) -> Iterator[tuple[str, Support]]:
    """Give the joint laws that take hold of the ground."""
    for name, law in zip(law_names(scene), system.terms.joint_laws):
        if law.joint and -1 in law.bodies:
            force, moment = law.values[:, -1, :2], law.values[:, -1, 2]
            at = next(point for point in scene.joints[law.joint].connect if point.startswith(f"{GROUND}."))
            place = np.broadcast_to(scene.point(at)[1], force.shape)
            yield f"joint law {name}", Support(force, moment - cross(place, force), place)


def _side_of_ground(scene: Scene, part: Line | Hinge) -> int:
    """Sign with which a pull acts on the ground along the line to the second body: 0 where the ground has no part."""
    if isinstance(part, Hinge):
        bodies = list(part.bodies or (point.split(".")[0] for point in scene.joints[part.joint].connect))
    else:
        bodies = [point.split(".")[0] for point in part.between]
    return 0 if GROUND not in bodies else 1 if bodies[0] == GROUND else -1
