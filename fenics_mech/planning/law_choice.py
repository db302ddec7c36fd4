"""Choosing the friction and the clearance of joints that a scene calls for, by estimates made before the run.

They come from the forces and deflections of the same linkage with tight joints without friction, led by its drives.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping

import numpy as np

from fenics_mech._arrays import norms
from fenics_mech._constants import TINY
from fenics_mech._guard import guarded
from fenics_mech.answers.solved_by_poses import AtRest
from fenics_mech.effects.effect import Choice, Effect
from fenics_mech.errors import MechanismError
from fenics_mech.joints.dry_friction import coefficient
from fenics_mech.joints.joint_state import JointPlace
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.kinematics import coordinates
from fenics_mech.scene import Clearance, Friction, GuideClearance, Scene

logger = logging.getLogger(__name__)
EstimatedLaw = Friction | Clearance | GuideClearance
POSITIONS = 48  # of a cycle, at which laws are judged


def _sizes(scene: Scene, laws: Mapping[str, EstimatedLaw]) -> dict[str, float]:
    """Give the power of frictions over that of the drive at its largest torque, and clearances over the deflection."""
    changes = {"joint_laws": {}, "effects": (), "analysis": {"method": "quasi-static"}}
    found = AtRest.of(scene.changed({**changes, "analysis.sub_intervals": POSITIONS, "tolerance": None})).positions
    motion, torque = found.links(), next(iter(found.efforts().values()))
    states = (motion.position, motion.angle), (motion.velocity, motion.omega)
    links = LinkStates.of(*(coordinates(*x) for x in states))
    deflection, power = norms(found.deflection).max(initial=0.0), np.abs(torque).max() * abs(scene.cycle_rate)
    sizes = {}
    for name, law in laws.items():
        if not isinstance(law, Friction):
            way = law.play if isinstance(law, GuideClearance) else law.radial
            sizes[name] = way / max(float(deflection), TINY)
            continue
        place = JointPlace.of(scene, law.joint)
        state, arm = place.state(links), 1.0 if law.radius is None else law.radius
        sliding = arm * state.rate - law.belt_speed
        dry = np.abs(coefficient(law, sliding) * sliding) * np.linalg.norm(found.joint_forces[law.joint], axis=-1)
        sizes[name] = float((dry + law.viscous * state.rate**2).max() / max(power, TINY))
    return sizes


@guarded()
def choose_laws(scene: Scene) -> tuple[Scene, tuple[Choice, ...]]:
    """Leave out friction and clearance that are too small to count, and say how large each is."""
    # Those of a scene whose drives lead all links are estimated, with ``effects = "auto"``. All others stay.
    estimated = {name: law for name, law in scene.joint_laws.items() if isinstance(law, EstimatedLaw)}
    led = scene.effects == "auto" and scene.members() and scene.drives and not scene.freedoms
    if not led or not estimated:
        return scene, ()
    if any(len(joint.connect) > 2 for joint in scene.joints.values()):
        return scene, _kept(estimated, "pins go through more than two links")
    try:
        sizes = _sizes(scene, estimated)
    except MechanismError as error:  # such as drives that do not lead it alone, or a member that buckles
        logger.info("friction and clearance are not estimated: %s", error)
        return scene, _kept(estimated, "without laws of joints the scene has no answer")
    choices = []
    for name, law in estimated.items():
        rubs = isinstance(law, Friction)
        estimate = "its power over that of the drive at its largest torque" if rubs else "its way over the deflection"
        choices.append(Choice(_effect(name, law, estimate), sizes[name], acts=sizes[name] > scene.neglected / 2))
    left = {choice.effect.name.removeprefix("joint_laws.") for choice in choices if not choice.acts}
    kept = {name: law for name, law in scene.joint_laws.items() if name not in left}
    return scene.model_copy(update={"joint_laws": kept}) if left else scene, tuple(choices)


def _kept(laws: Mapping[str, EstimatedLaw], why: str) -> tuple[Choice, ...]:
    """Say of laws that they act, and why they are not estimated."""
    more = f"; not estimated, as {why}"
    return tuple(Choice(_effect(name, law, more=more), None, acts=True) for name, law in laws.items())


def _effect(name: str, law: EstimatedLaw, estimate: str = "", more: str = "") -> Effect:
    """Give a law as an effect that can be chosen, and how its size is estimated; `more` comes after its meaning."""
    meaning = f"{law.kind} at joint {law.joint}{more}{estimate and '; '}{estimate}"
    return Effect(name=f"joint_laws.{name}", meaning=meaning, source="see the law")
