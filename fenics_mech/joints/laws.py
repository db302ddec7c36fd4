"""The laws of a scene's joints, as they are stated."""

from __future__ import annotations

from fenics_mech.joints.bushings import SoftBearing
from fenics_mech.joints.dry_friction import DryFriction
from fenics_mech.joints.given_efforts import GivenEffort
from fenics_mech.joints.guide_clearance import SliderContact
from fenics_mech.joints.joint_state import JointLaw, JointPlace
from fenics_mech.joints.pin_clearance import JournalContact
from fenics_mech.joints.stops import StopContact
from fenics_mech.scene import Bushing, Clearance, Friction, GuideClearance, JointEffort, Scene, Stop
from fenics_mech.scene.joint_laws import AnyJointLaw


def laws_of(scene: Scene) -> dict[str, JointLaw]:
    """Give the laws of a scene's joints, by name.

    Parameters
    ----------
    scene
        The scene.
    """
    return {name: _law(JointPlace.of(scene, stated.joint), stated) for name, stated in scene.joint_laws.items()}


def _law(joint: JointPlace, stated: AnyJointLaw) -> JointLaw:
    match stated:
        case Friction():
            return DryFriction(joint, stated)
        case Stop():
            return StopContact(joint, stated)
        case Clearance():
            return JournalContact(joint, stated)
        case GuideClearance():
            return SliderContact(joint, stated)
        case Bushing():
            return SoftBearing(joint, stated)
        case JointEffort():
            return GivenEffort(joint, stated)
