"""The laws of a scene's joints, as they are stated."""

from __future__ import annotations

from collections.abc import Callable

from fenics_mech.joints.cams import both_sides_of_cam
from fenics_mech.joints.gears import both_sides
from fenics_mech.joints.given_efforts import GivenEffort
from fenics_mech.joints.guide_clearance import SliderContact
from fenics_mech.joints.joint_state import JointLaw, JointPlace
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.joints.pin_clearance import JournalContact
from fenics_mech.joints.side_contact import OneSide
from fenics_mech.joints.stops import StopContact
from fenics_mech.scene import Cam, Clearance, GuideClearance, Prismatic, Scene, SideContact, Stop
from fenics_mech.scene.joint_laws import PluggedEffort
from fenics_mech.scene.paired_joints import PairedJoints

ALONE = {Stop: StopContact, Clearance: JournalContact, GuideClearance: SliderContact, SideContact: OneSide}


def laws_of(scene: Scene, name: str, start: LinkStates, place: Callable[[str], JointPlace]) -> dict[str, JointLaw]:
    """Give a law of a scene's joints by its name, and the driven side of gears or a cam as "name:joint"."""
    stated = scene.joint_laws[name]
    joint = place(stated.joint)
    if isinstance(stated, PairedJoints):
        pair, slides = (joint, place(stated.drives)), isinstance(scene.joints[stated.drives], Prismatic)
        sides: tuple[JointLaw, JointLaw] = (
            both_sides_of_cam(stated, pair, slides)
            if isinstance(stated, Cam)
            else both_sides(stated, pair, joint.state(start))
        )
        return dict(zip((name, f"{name}:{stated.drives}"), sides))
    if isinstance(stated, PluggedEffort):
        return {name: GivenEffort(joint, stated)}
    return {name: ALONE[type(stated)](joint, stated)}
