"""The laws of a scene's joints, as they are stated."""

from __future__ import annotations

from collections.abc import Callable

from fenics_mech.joints.bushings import SoftBearing
from fenics_mech.joints.cams import both_sides_of_cam
from fenics_mech.joints.dry_friction import DryFriction
from fenics_mech.joints.gears import both_sides
from fenics_mech.joints.given_efforts import GivenEffort
from fenics_mech.joints.guide_clearance import SliderContact
from fenics_mech.joints.joint_state import JointLaw, JointPlace
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.joints.pin_clearance import JournalContact
from fenics_mech.joints.side_contact import OneSide
from fenics_mech.joints.stops import StopContact
from fenics_mech.scene import (
    Bushing,
    Cam,
    Clearance,
    Friction,
    GuideClearance,
    JointEffort,
    Prismatic,
    Scene,
    SideContact,
    Stop,
)
from fenics_mech.scene.joint_laws import OneJointLaw, PluggedEffort
from fenics_mech.scene.paired_joints import PairedJoints


def laws_of(scene: Scene, start: LinkStates, place: Callable[[str], JointPlace]) -> dict[str, JointLaw]:
    """Give the laws of a scene's joints, by name; the driven side of gears or a cam as "name:joint"."""
    found: dict[str, JointLaw] = {}
    for name, stated in scene.joint_laws.items():
        joint = place(stated.joint)
        if isinstance(stated, PairedJoints):
            pair = joint, place(stated.drives)
            if isinstance(stated, Cam):
                sides: tuple[JointLaw, JointLaw] = both_sides_of_cam(
                    stated, pair, isinstance(scene.joints[stated.drives], Prismatic)
                )
            else:
                sides = both_sides(stated, pair, joint.state(start))
            found[name], found[f"{name}:{stated.drives}"] = sides
        else:
            found[name] = _law(joint, stated)
    return found


def _law(joint: JointPlace, stated: OneJointLaw | PluggedEffort) -> JointLaw:
    match stated:
        case Friction():
            return DryFriction(joint, stated)
        case Stop():
            return StopContact(joint, stated)
        case Clearance():
            return JournalContact(joint, stated)
        case GuideClearance():
            return SliderContact(joint, stated)
        case SideContact():
            return OneSide(joint, stated)
        case Bushing():
            return SoftBearing(joint, stated)
        case JointEffort() | PluggedEffort():
            return GivenEffort(joint, stated)
