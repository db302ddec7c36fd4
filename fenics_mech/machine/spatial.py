"""From a scene in space to its machine: poses of nodes and rigid links, beams, rows of joints, and what acts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.geometry import SPACE, End
from fenics_mech.joints import Row, kind_of
from fenics_mech.joints.kinds import turn
from fenics_mech.machine.groups import Drag
from fenics_mech.machine.machine import Machine
from fenics_mech.machine.mobility import hold_idle, loosen, mobility
from fenics_mech.scene.in_space import PointDamper, SpatialForce, SpatialMember, SpatialScene, SpatialTorque
from fenics_mech.scene.springs_dampers import HingeDamper, LineDamper, LineSpring
from fenics_mech.sections import SectionNumbers, numbers_of
from fenics_mech.terms import Damper, DeadLoad, Effort, Element, Look, Measure, Spring

STROKE_AXIS = {"slider": 0, "slot": 0, "cylinder": 2}  # along which axis of its ends a joint slides


@dataclass
class MemberInSpace:
    """A member as its machine knows it.

    Parameters
    ----------
    label, link
        Its name, and that of its link.
    stated
        What the scene says of it.
    section
        Numbers of its section.
    elements
        Numbers of its elements in the term of all beams, ascending along it.
    nodes
        Shares 0 to 1 of its length at which its nodes are ``(elements + 1,)``.
    length
        m.
    modulus, shear_modulus, density
        Of its material (Pa, Pa, kg/m^3).
    """

    label: str
    link: str
    stated: SpatialMember
    section: SectionNumbers
    elements: list[int]
    nodes: Array
    length: float
    modulus: float
    shear_modulus: float
    density: float


@dataclass
class SpatialMachine:
    """A machine in space with the names of its scene.

    Parameters
    ----------
    scene
        The scene.
    machine
        Its machine, as drawn.
    members
        Its members, in the order of the scene.
    joints
        Ends of every joint, drawn with the same axes.
    driven
        Row of every drive.
    freedoms
        How the machine can move where no drive acts and no member bends.
    idle
        Rows that hold turns which nothing drives and nothing resists, with the link that would turn.
    redundant
        Names of joints of which the others say a part already, where links do not bend.
    """

    scene: SpatialScene
    machine: Machine
    members: list[MemberInSpace] = field(default_factory=list)
    joints: dict[str, tuple[End, End]] = field(default_factory=dict)
    driven: list[int] = field(default_factory=list)
    freedoms: int = 0
    idle: dict[int, str] = field(default_factory=dict)
    redundant: tuple[str, ...] = ()


def spatial_machine(scene: SpatialScene, finer: int = 1) -> SpatialMachine:
    """Build the machine of a scene in space.

    Parameters
    ----------
    scene
        The scene.
    finer
        Elements for each one that the scene states.

    Raises
    ------
    SceneError
        When something can move that nothing drives, and it is no turn of a link about its own line.
    """
    machine = Machine(SPACE, scene.gravity)
    machine.drag = Drag(scene.damping.external, scene.damping.relative)
    made, nodes = SpatialMachine(scene, machine), _Nodes(scene, machine, finer)
    pairs: list[tuple[End, End]] = []
    elements: list[Element] = []
    for label, (link, member) in scene.members().items():
        own, places, shares = _member(scene, label, nodes)
        own.elements = list(range(len(pairs), len(pairs) + len(places) - 1))
        axes = _axes_of(scene, link, member, own.section)
        ends = [machine.end(pose, machine.r[pose], axes) for pose in places]
        for (one, other), share in zip(pairwise(ends), np.diff(shares)):
            pairs.append((one, other))
            elements.append(_element(own, float(share) * own.length))
        made.members.append(own)
    if pairs:
        machine.add_beams(pairs, elements, scene.damping.material)
    for name, body in scene.links.items():
        if body.rigid is not None:
            machine.masses.add_body(machine.end(nodes.rigid[name]), body.rigid.mass, body.rigid.second_moments)
    for mass in scene.masses.values():
        machine.masses.add_body(nodes.end(mass.at), mass.mass, np.zeros((3, 3)))
    _add_joints(made, nodes)
    _add_drives(made)
    _judge_mobility(made, nodes)
    _add_acting(made, nodes)
    return made


class _Nodes:
    """Poses at the points of links and inside members, by their names."""

    def __init__(self, scene: SpatialScene, machine: Machine, finer: int) -> None:
        self.scene, self.machine, self.finer = scene, machine, finer
        self.pose: dict[str, int] = {}  # of points of bending links "link.point", and places "label@s"
        self.rigid: dict[str, int] = {"ground": machine.ground}
        self.link_of: dict[int, str] = {}
        used = {
            name: {end for member in link.members.values() for end in member.ends} for name, link in scene.links.items()
        }
        for name, link in scene.links.items():
            if link.rigid is not None:
                self.rigid[name] = machine.add_pose(np.array(link.rigid.centre))
                self.link_of[self.rigid[name]] = name
                continue
            for point, place in link.points.items():
                if point not in used[name]:
                    raise SceneError(
                        f"point {point!r} is at no end of a member of its link, which bends",
                        place=f"links.{name}.points.{point}",
                        hint="Begin or end a member there, or leave the point out",
                    )
                self.pose[f"{name}.{point}"] = machine.add_pose(np.array(place))
                self.link_of[self.pose[f"{name}.{point}"]] = name

    def end(self, at: str) -> End:
        """Give the end at a point "body.point" or a place "label@s"."""
        if "@" in at:
            label, s = at.split("@")
            return self.machine.end(self.pose[f"{label}@{float(s):.12g}"])
        body, place = self.scene.point(at)
        pose = self.rigid[body] if body in self.rigid else self.pose[at]
        return self.machine.end(pose, np.array(place))


def _member(scene: SpatialScene, label: str, nodes: _Nodes) -> tuple[MemberInSpace, list[int], Array]:
    """Put nodes along a member, also where something acts inside it; give the poses of all, and their shares."""
    link, stated = scene.members()[label]
    material = scene.materials[stated.material]
    first, last = (np.array(scene.links[link].points[end]) for end in stated.ends)
    count = nodes.finer * (stated.elements or scene.mesh.elements)
    inside = np.array(scene.places_inside().get(label, []))
    even = np.arange(count + 1) / count
    shares = np.concatenate([even[np.abs(even[:, None] - inside).min(axis=1, initial=1.0) > 1 / (3 * count)], inside])
    shares = np.unique(np.concatenate([[0.0, 1.0], shares]))
    poses = [nodes.pose[f"{link}.{stated.ends[0]}"]]
    for share in shares[1:-1]:
        poses.append(nodes.machine.add_pose(first + share * (last - first)))
        nodes.link_of[poses[-1]] = link
    poses.append(nodes.pose[f"{link}.{stated.ends[1]}"])
    for share, pose in zip(shares, poses):
        nodes.pose[f"{label}@{share:.12g}"] = pose
    own = MemberInSpace(
        label=label,
        link=link,
        stated=stated,
        section=numbers_of(scene.sections[stated.section]),
        elements=[],
        nodes=shares,
        length=float(np.linalg.norm(last - first)),
        modulus=material.modulus,
        shear_modulus=material.rigidity,
        density=material.density,
    )
    return own, poses, shares


def _axes_of(scene: SpatialScene, link: str, member: SpatialMember, section: SectionNumbers) -> Array:
    """Give the axes of a member: along it, then both principal axes of its section ``(3, 3)``."""
    first, last = (np.array(scene.links[link].points[end]) for end in member.ends)
    axes = SPACE.axes(last - first, None if member.up is None else np.array(member.up))
    return axes @ SPACE.about(np.array([1.0, 0.0, 0.0]), np.array(section.turn))


def _element(own: MemberInSpace, length: float) -> Element:
    """Give the numbers of an element of a uniform beam: E A, E I about both axes, G J, and rho I of its sections."""
    section, E, rho = own.section, own.modulus, own.density
    return Element.uniform(
        length,
        E * section.area,
        [E * inertia for inertia in section.inertia],
        own.shear_modulus * section.torsion,
        rho * section.area,
        [rho * inertia for inertia in section.inertia],
    )


def _add_joints(made: SpatialMachine, nodes: _Nodes) -> None:
    """Hold both links of every joint by rows; the axes of a misaligned second link are turned."""
    for name, joint in made.scene.joints.items():
        one, other = map(nodes.end, joint.connect)
        first = np.array(joint.axis or (0.0, 0.0, 1.0))
        # a slider lies along the first of its axes, and the axis of the others is the last
        axes = SPACE.axes(first) if joint.kind in ("slider", "slot") else SPACE.axes(first)[:, [1, 2, 0]]
        both = axes, axes
        if joint.axes is not None:
            both = tuple(SPACE.axes(np.array(way))[:, [1, 2, 0]] for way in joint.axes)  # type: ignore[assignment]
        if joint.misaligned is not None:
            turned = SPACE.about(np.array(joint.misaligned.about), np.array(joint.misaligned.by))
            both = both[0], turned @ both[1]
        made.joints[name] = _with_axes(made.machine, one, both[0]), _with_axes(made.machine, other, both[1])
        made.machine.join(joint.kind, made.joints[name], name=name)


def _with_axes(machine: Machine, end: End, axes: Array) -> End:
    return machine.end(end.pose, machine.drawn(end), axes)


def _add_drives(made: SpatialMachine) -> None:
    """Lead an angle or a stroke of a joint from the drawn position."""
    scene = made.scene
    for drive in scene.drives:
        kind = scene.joints[drive.joint].kind
        by_stroke = kind in ("slider", "slot") or (kind == "cylinder" and drive.speed is None)
        ends = made.joints[drive.joint]
        start = float(drive.jet(np.zeros(1), scene.cycle_rate).value[0]) if drive.law is not None else 0.0
        drawn = 0.0
        if by_stroke:
            way = made.machine.drawn(ends[1]) - made.machine.drawn(ends[0])
            drawn = float(way @ (made.machine.R[ends[0].pose] @ ends[0].turn)[:, STROKE_AXIS[kind]])

        def law(t: Array, drive: object = drive, off: float = drawn - start) -> Array:
            return drive.jet(scene.cycle_rate * t, scene.cycle_rate).value + off  # type: ignore[attr-defined, no-any-return]

        made.driven.append(made.machine.drive(kind, "stroke" if by_stroke else "angle", ends, law, drive.joint))


def _judge_mobility(made: SpatialMachine, nodes: _Nodes) -> None:
    """Count freedoms, hold idle turns of links, give slack to rows that say nothing new, and refuse what is loose."""
    scene, machine = made.scene, made.machine
    found = mobility(machine)
    made.freedoms = found.freedoms
    if len(found.idle) and scene.analysis.method != "transient":  # in which what is free moves
        places = np.append(found.idle, np.zeros((len(found.idle), 1)), axis=1)[:, machine.places]
        moved = places[..., :3].reshape(len(found.idle), -1) / machine.extent
        ways, sizes, _ = np.linalg.svd(moved, full_matrices=True)
        sizes = np.pad(sizes, (0, len(ways) - len(sizes)))
        turning = sizes <= IDLE * max(float(np.abs(places[..., 3:]).max()), IDLE)
        loose = ways.T[~turning] @ moved
        if len(loose) and not scene.springs:
            link = nodes.link_of.get(int(np.argmax(np.abs(loose).max(axis=0))) // 3, "a link")
            raise SceneError(
                f"the linkage can move in {len(loose)} independent ways that no drive leads: link {link} moves most",
                place="drive",
                hint="Drive them, hold them by joints or springs, or take kinds of joints that let less pass",
            )
        spins = ways.T[turning] @ found.idle
        if len(spins):
            turns = np.append(spins, np.zeros((len(spins), 1)), axis=1)[:, machine.places[:, 3:]]
            poses = np.argmax(np.linalg.norm(turns, axis=2), axis=1)
            for pose, row in zip(poses, hold_idle(machine, replace(found, idle=spins))):
                made.idle[row] = nodes.link_of.get(int(pose), "a link")
    if found.surplus:
        loosen(machine, found.redundant)
        made.redundant = tuple(dict.fromkeys(machine.rows[k].name for k in found.redundant if k < len(machine.rows)))


IDLE = 1e-6  # of a turn times the machine's extent: places that move less are those of a turn about the link's own line


@contextmanager
def held_as_drawn(made: SpatialMachine) -> Iterator[None]:
    """Hold joints as they are drawn where springs lead what the drives do not: the rest of the machine can then move.

    Parameters
    ----------
    made
        The machine; after it, nothing is held.
    """
    machine, rows = made.machine, len(made.machine.rows)
    left = len(mobility(machine).idle) if made.scene.springs else 0
    sprung = {getattr(spring, "joint", "") for spring in made.scene.springs.values()}
    for name in sorted(made.joints, key=lambda name: name not in sprung):
        one, other = made.joints[name]
        there = machine.drawn(other)
        pair = machine.end(one.pose, there), machine.end(other.pose, there)
        for measure in (*turn(SPACE), *(Measure(Look.ALONG, axis) for axis in range(3))):
            if not left:
                break
            machine.rows.append(Row(pair, measure, name=name))
            machine.forget_plan()
            if (now := len(mobility(machine).idle)) < left:
                left = now
            else:
                machine.rows.pop()
    machine.forget_plan()
    yield
    del machine.rows[rows:]
    machine.forget_plan()


def _add_acting(made: SpatialMachine, nodes: _Nodes) -> None:
    """Add loads, springs and dampers."""
    scene, machine = made.scene, made.machine
    for load in scene.loads.values():
        factor = _factor_of(load, scene.cycle_rate)
        if isinstance(load, SpatialForce):
            for axis, force in enumerate(load.force):
                if force:
                    machine.terms.append(DeadLoad(machine.at_ground(), nodes.end(load.at), axis, _times(factor, force)))
        else:
            machine.terms.append(_effort(made, load, factor))
    for spring in scene.springs.values():
        if isinstance(spring, LineSpring):
            pair = nodes.end(spring.between[0]), nodes.end(spring.between[1])
            drawn = float(np.linalg.norm(machine.drawn(pair[1]) - machine.drawn(pair[0])))
            rest = drawn if spring.length is None else spring.length
            machine.terms.append(Spring([pair], spring.stiffness, rest))
        else:
            rest = 0.0 if spring.angle is None else spring.angle
            machine.terms.append(Spring([made.joints[spring.joint]], spring.stiffness, rest, Look.ANGLE))
    for damper in scene.dampers.values():
        if isinstance(damper, LineDamper):
            pair = nodes.end(damper.between[0]), nodes.end(damper.between[1])
            machine.terms.append(Damper([pair], damper.damping))
        elif isinstance(damper, HingeDamper):
            machine.terms.append(Damper([made.joints[damper.joint]], damper.damping, Look.ANGLE))
        else:
            assert isinstance(damper, PointDamper)
            pair = machine.at_ground(), nodes.end(damper.at)
            machine.terms += [Damper([pair], damper.damping, Look.PLACE, axis) for axis in range(3)]
    machine.forget_plan()


def _factor_of(load: SpatialForce | SpatialTorque, rate: float) -> Callable[[Array], Array]:
    """Give the factor of a load by time (s)."""
    factor = load.factor
    if factor is None:
        return np.ones_like
    return lambda t: factor.at(rate * t)


def _times(factor: Callable[[Array], Array], force: float) -> Callable[[Array], Array]:
    return lambda t: force * factor(t)


def _effort(made: SpatialMachine, load: SpatialTorque, factor: Callable[[Array], Array]) -> Effort:
    """Give the torque about, or the push along, the axis of a joint."""
    kind = made.scene.joints[load.joint].kind
    measure = kind_of(kind, SPACE).drives["stroke" if load.push else "angle"]
    size = load.push or load.torque

    def law(t: Array, x: Array, v: Array) -> tuple[Array, Array, Array]:
        return size * factor(t), 0 * x, 0 * x

    return Effort(made.joints[load.joint], measure, law, 0.0)
