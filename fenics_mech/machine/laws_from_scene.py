"""Efforts in freedoms, and laws of joints, as terms of a scene's machine."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.element_matrices import Beams as LinkMatrices
from fenics_mech.errors import SceneError
from fenics_mech.geometry import End
from fenics_mech.joints.bent_guide import BentGuide, nodes_along
from fenics_mech.joints.joint_state import JointPlace
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.joints.laws import laws_of
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.joints.rubbing import Rubbing
from fenics_mech.machine.drawn_from_scene import Bodies, law_of
from fenics_mech.machine.machine import Machine
from fenics_mech.scene import Bushing, Friction, JointEffort, Scene
from fenics_mech.scene.freedoms import Effort as Stated
from fenics_mech.scene.freedoms import with_slopes
from fenics_mech.scene.joints import Prismatic, Slot
from fenics_mech.scene.paired_joints import PairedJoints
from fenics_mech.terms import Effort, Look, Measure, Shaft, SoftBearing, Term

SHAFT = "drive.motor"  # place of the one motor that a scene may have


def add_laws(
    scene: Scene, machine: Machine, end: Callable[..., End], bodies: Bodies, links: LinkMatrices | None
) -> dict[str, Term]:
    """Give the terms of motors, of freedoms and of laws of joints, by place in the scene, and add rotors."""
    # end (rad)
    found: dict[str, Term] = {}
    rotors: dict[str, tuple[str, float]] = {}  # joint and inertia, by place
    for number, drive in enumerate(scene.drives):
        if (motor := drive.motor) is not None:
            pair, _, _ = _joint(scene, machine, end, drive.joint, bodies)
            found[SHAFT] = Shaft(pair, motor.stiffness, motor.damping, law_of(scene, number), scene.cycle_rate)
            rotors[f"{SHAFT}.inertia"] = drive.joint, motor.inertia
    for name, freedom in scene.freedoms.items():  # without an effort too: steps in time count its whole turns
        pair, measure, _ = _joint(scene, machine, end, name, bodies)
        found[f"freedoms.{name}"] = _effort(pair, measure, freedom.effort, freedom.start or 0.0)
        rotors[f"freedoms.{name}.inertia"] = name, freedom.inertia
    for place, (joint, inertia) in rotors.items():
        if not inertia:
            continue
        moving = [point for point in scene.joints[joint].connect if not point.startswith("ground.")]
        if len(moving) > 1:
            raise SceneError("no term states inertia between two links yet", place=place, hint="Write solver = 'auto'")
        machine.masses.add_body(end(moving[0]), 0.0, np.eye(2) * inertia / 2)
    for name, law in scene.joint_laws.items():
        place = f"joint_laws.{name}"
        pair, measure, start = _joint(scene, machine, end, law.joint, bodies)
        match law:
            case JointEffort():
                found[place] = _effort(pair, measure, law.effort, start)
            case Bushing():
                stiffness, damping = (*law.stiffness, law.turning_stiffness), (*law.damping, law.turning_damping)
                found[place] = SoftBearing(pair, stiffness, damping, law.turned, start)
            case Friction():
                pressing = {Look.PLACE} if measure.look is Look.ANGLE else {Look.ALONG}
                named = ((k, row) for k, row in enumerate(machine.rows) if row.name == law.joint and not row.leads)
                rows = [k for k, row in named if row.measure.look in pressing]
                found[place] = Rubbing(pair, measure, law, rows, start)
            case _:
                found |= _touching(scene, machine, end, bodies, links, name)
    return found


def _touching(
    scene: Scene, machine: Machine, end: Callable[..., End], bodies: Bodies, links: LinkMatrices | None, name: str
) -> dict[str, LawTerm]:
    """Give the terms of a law that looks at its bodies: of gears and cams one for each of both joints."""
    law = scene.joint_laws[name]
    joints = [law.joint, law.drives] if isinstance(law, PairedJoints) else [law.joint]
    points = [point for joint in joints for point in scene.joints[joint].connect if not point.startswith("ground.")]
    along = [] if links is None else nodes_along(scene, links.mesh, law.joint)  # of a member that is the guide
    points = list(dict.fromkeys([*points, *along]))
    ends, turned = [end(point) for point in points], bodies.at_start
    angles = [turned[point.split("@")[0].split(".")[0]] for point in points]

    def place(joint: str) -> JointPlace:
        """Give a joint between the frames, whose origins are its points."""
        stated, connect = JointPlace.of(scene, joint), scene.joints[joint].connect
        numbers = [points.index(point) if point in points else -1 for point in connect[:2]]
        own = [at if number < 0 else (0.0, 0.0) for number, at in zip(numbers, stated.points)]
        found = replace(stated, bodies=(numbers[0], numbers[1]), points=(own[0], own[1]))
        if not along:
            return found
        nodes = tuple(map(points.index, along))
        steps = np.linalg.norm(np.diff([machine.drawn(ends[node]) for node in nodes], axis=0), axis=1)
        return BentGuide(**vars(found), nodes=nodes, distances=tuple(np.append(0.0, np.cumsum(steps)).tolist()))

    pose = np.array([[*machine.drawn(one), angle] for one, angle in zip(ends, angles)])
    start = LinkStates.of(pose.reshape(1, -1), np.zeros((1, pose.size)))
    laws = laws_of(scene, name, start, place)
    return {f"joint_laws.{key}": LawTerm(key, machine.at_ground(), ends, one, angles) for key, one in laws.items()}


def _effort(pair: tuple[End, End], measure: Measure, effort: Stated, start: float) -> Effort:
    """Give the term of an effort at a joint that starts from a place."""

    def law(t: Array, place: Array, rate: Array) -> tuple[Array, Array, Array]:
        return with_slopes(effort, t, (place, rate), start)

    return Effort(pair, measure, law, start)


def _joint(
    scene: Scene, machine: Machine, end: Callable[..., End], name: str, bodies: Bodies
) -> tuple[tuple[End, End], Measure, float]:
    """Give the ends of a joint, the measure that is its angle or stroke, and the angle at the start (rad)."""
    joint = scene.joints[name]
    first, second = joint.connect[:2]
    if joint.member is not None and name in scene.moved_joints:
        return machine.along(name), Measure(Look.ALONG, 0), 0.0
    if isinstance(joint, Slot | Prismatic):
        return (end(first, joint.angle), end(second, joint.angle)), Measure(Look.ALONG, 0), 0.0
    one, other = (bodies.at_start[point.split(".")[0]] for point in (first, second))
    return (end(first), end(second)), Measure(Look.ANGLE), float(other - one)
