"""Choosing the friction and the clearance of joints that a scene calls for, by estimates made before the run.

They come from the forces and deflections of the same linkage with tight joints without friction, led by its drives.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech._guard import guarded
from fenics_mech.effects.effect import Choice, Effect
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.forces.joint_forces import joint_forces, joint_names, nodal_forces, reactions
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.joints.dry_friction import DryFriction, coefficient
from fenics_mech.joints.joint_state import JointPlace
from fenics_mech.kinematics.link_states import LinkStates
from fenics_mech.kinematics.motion import coordinates
from fenics_mech.planning.effect_choice import CHOICE
from fenics_mech.response.setup import mechanism
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.scene import Clearance, Friction, GuideClearance, Scene


@dataclass(frozen=True)
class TightMotion:
    """One cycle of a linkage whose joints have no laws.

    Parameters
    ----------
    links
        How its links move.
    forces
        Force of each joint (N), ``(angles, 2)`` each.
    torque
        Torque or force of the first drive (N m or N), ``(angles,)``.
    speed
        Its rate (rad/s or m/s).
    deflection
        Largest elastic displacement of a node (m).
    """

    links: LinkStates
    forces: dict[str, Array]
    torque: Array
    speed: float
    deflection: float

    @classmethod
    def of(cls, scene: Scene) -> TightMotion:
        """Find it in linear theory, without vibration.

        Parameters
        ----------
        scene
            The scene, with its laws.
        """
        changes = {"joint_laws": {}, "effects": (), "analysis": {"method": "quasi-static"}}
        plain = scene.changed({**changes, "analysis.sub_intervals": CHOICE.positions, "tolerance": None})
        system = mechanism(plain)
        still, motion = solve_static(system), system.motion
        q, rate = coordinates(motion.position, motion.angle), coordinates(motion.velocity, motion.omega)
        moved = system.to_links(still.displacement).reshape(len(q), -1, 3)[..., :2]
        forces = joint_forces(plain.joints, reactions(system, nodal_forces(system, still)))
        torque = next(iter(Forces(plain, system, still).efforts().values()))
        deflection = float(np.linalg.norm(moved, axis=-1).max(initial=0.0))
        return cls(LinkStates.of(q, rate), forces, torque, abs(plain.cycle_rate), deflection)

    def friction(self, scene: Scene, law: Friction) -> float:
        """Give the power of a friction over that of the drive at its largest torque.

        Parameters
        ----------
        scene, law
            The scene, and the law.
        """
        place = JointPlace.of(scene, law.joint)
        state, arm = place.state(self.links), DryFriction(place, law).arm
        sliding = arm * state.rate - law.belt_speed
        dry = np.abs(coefficient(law, sliding) * sliding) * np.linalg.norm(self.forces[law.joint], axis=-1)
        lost = dry + law.viscous * state.rate**2
        return float(lost.max() / max(np.abs(self.torque).max() * self.speed, TINY))

    def clearance(self, law: Clearance | GuideClearance) -> float:
        """Give a clearance over the largest deflection.

        Parameters
        ----------
        law
            The law.
        """
        way = law.play if isinstance(law, GuideClearance) else law.radial
        return way / max(self.deflection, TINY)


@guarded()
def choose_laws(scene: Scene) -> tuple[Scene, tuple[Choice, ...]]:
    """Leave out friction and clearance that are too small to count, and say how large each is.

    Those of a scene whose drives lead all links are estimated, with ``effects = "auto"``. All others stay.

    Parameters
    ----------
    scene
        The scene.

    Returns
    -------
    tuple
        The scene with the laws that count, and what was decided about each that was estimated.
    """
    estimated = {
        name: law for name, law in scene.joint_laws.items() if isinstance(law, Friction | Clearance | GuideClearance)
    }
    led = scene.effects == "auto" and scene.members() and scene.drives and not scene.freedoms
    if not led or not estimated or any(joint_names({n: scene.joints[n]}) != [n] for n in scene.joints):
        return scene, ()
    try:
        tight = TightMotion.of(scene)
    except (AssemblyError, SceneError):  # its drives do not lead it, or its loads are not of a cycle
        return scene, ()
    choices = []
    for name, law in estimated.items():
        rubs = isinstance(law, Friction)
        size = tight.friction(scene, law) if isinstance(law, Friction) else tight.clearance(law)
        effect = Effect(
            name=f"joint_laws.{name}",
            meaning=f"{law.kind} at joint {law.joint}",
            source="see the law",
            estimate="its power over that of the drive at its largest torque"
            if rubs
            else "its way over the deflection",
        )
        choices.append(Choice(effect, size, acts=size > scene.neglected / 2))
    left = {choice.effect.name.removeprefix("joint_laws.") for choice in choices if not choice.acts}
    kept = {name: law for name, law in scene.joint_laws.items() if name not in left}
    return scene.model_copy(update={"joint_laws": kept}) if left else scene, tuple(choices)
