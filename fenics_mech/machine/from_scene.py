"""From a scene to its machine: poses of nodes and rigid links, beams from UFL forms, joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.element_matrices import Beams as LinkMatrices
from fenics_mech.beams.element_matrices import assemble_beams
from fenics_mech.beams.lumped import lumped
from fenics_mech.beams.made_once import LastMade
from fenics_mech.beams.mesh import BeamMesh, mesh_scene
from fenics_mech.beams.timoshenko import sheared, with_rotary_inertia
from fenics_mech.effects import EFFECTS
from fenics_mech.errors import SceneError
from fenics_mech.geometry import PLANE, End
from fenics_mech.joints import Ride, Riding
from fenics_mech.machine.acting_from_scene import add_acting
from fenics_mech.machine.drawn_from_scene import Bodies, Law, bodies_of, clock_of, law_of
from fenics_mech.machine.machine import Machine
from fenics_mech.scene import Friction, Ground, Scene
from fenics_mech.scene.applied_loads import Load
from fenics_mech.scene.joints import Prismatic, Revolute, Weld, members_under_pins
from fenics_mech.scene.numbering import order_of
from fenics_mech.terms import Element, Term

STRAINED = np.array([[0, 0, 0, 1, 0, 0], [0, 0, 1, 0, 0, 1], [0, 0, -0.5, 0, 0, 0.5]])  # u, w, phi of both nodes
SECTIONS = {
    "lumped-mass": lumped,
    "rotary-inertia": with_rotary_inertia,
    "shear": sheared,
}  # effects that change the matrices of links
RESTING, BENDING, STIFF = range(3)  # what carries a point: the ground, a link that bends, a rigid link
SHALLOW = np.array([1, 2, 4, 5])  # w and phi of both nodes
MADE = LastMade(2 ** len(SECTIONS))  # matrices of links: those of a scene with and without each of these effects


@dataclass
class SceneMachine:
    """A machine with the names of its scene."""

    scene: Scene  # the scene
    machine: Machine  # its machine, as drawn at the start of the cycle
    links: LinkMatrices | None  # the local matrices of its links; None where all are rigid
    node_pose: list[int]  # pose of every node of the mesh
    element_ends: list[tuple[End, End]]  # ends of every element of the mesh
    # gives the end at a point, "link.point" or "ground.point", with axes that are turned by an angle (rad)
    end: Callable[..., End]
    bodies: Bodies  # its links as rigid bodies
    driven: list[int] = field(default_factory=list)  # row of every drive; a motor's shaft has none
    # terms of springs, dampers, loads and air, by their place in the scene, such as "springs.NAME"; and those of
    # effects of other packages
    acting: dict[str, Term] = field(default_factory=dict)

    @property
    def period(self) -> float:
        """Duration of its cycle (s)."""
        return self.scene.period


def machine_of(scene: Scene, inner: int = 0) -> SceneMachine:
    """Build the machine of a planar scene that is driven."""
    machine, bodies = Machine(PLANE, scene.gravity), bodies_of(scene)
    links = _matrices(scene)
    nodes = _Nodes(scene, machine, None if links is None else links.mesh, bodies.frames())
    made = SceneMachine(scene, machine, links, nodes.pose, [], nodes.end, bodies)
    _add_joints(scene, machine, nodes)
    if links is not None:
        _add_beams(made, links, nodes.frames, inner)
        _add_rides(made, links)
    clock = clock_of(scene)
    for number, drive in enumerate(scene.drives):
        if drive.motor is None:
            made.driven.append(lead(made, drive.joint, law_of(scene, number, clock)))
    _add_bodies(made, nodes)
    made.acting.update(add_acting(scene, machine, nodes, bodies, links))
    for effect in EFFECTS.values():
        if effect.acting is not None and (effect.name in scene.named_effects or effect.stated(scene)):  # of a package
            found = {f"effects.{effect.name}.{name}": term for name, term in effect.acting(made).items()}
            made.acting |= found
            machine.terms += found.values()
            machine.forget_plan()
    return made


def _matrices(scene: Scene) -> LinkMatrices | None:
    """Give the matrices of the links that bend, by their UFL forms on the mesh of gmsh; None where all are rigid."""
    # They are made from a scene with nothing but what they depend on. Where that is equal they are those made before.
    if not scene.members():
        return None
    stated = Scene.model_construct(
        ground=Ground.model_construct(points={}),
        links=scene.links,
        joints=scene.joints,  # pins that travel along members, which not all members can have
        masses=scene.masses,
        materials=scene.materials,
        sections=scene.sections,
        mesh=scene.mesh,
        loads={
            (at := f"{label}@{s}"): Load.model_construct(at=at)
            for label, inside in scene.loaded_places(traced=True).items()
            for s in inside
        },
        effects=tuple(name for name in SECTIONS if name in scene.named_effects),
    )
    return MADE.once((order_of(stated), stated), _assembled, stated)


def _assembled(stated: Scene) -> LinkMatrices:
    """Assemble the links of a scene, with a node at each load."""
    links = assemble_beams(stated, mesh_scene(stated, loads_at_nodes=True))
    for name in stated.effects:
        links = SECTIONS[name](stated, links)
    return links


class _Nodes:
    """Poses of the nodes of a mesh and of rigid links, and ends at the points of links."""

    def __init__(
        self, scene: Scene, machine: Machine, mesh: BeamMesh | None, frames: dict[str, tuple[Array, Array]]
    ) -> None:
        self.scene, self.machine, self.frames = scene, machine, frames
        names = list(scene.links)
        nodes = [] if mesh is None else list(zip(mesh.node_name, mesh.node_link, mesh.node_xy))
        self._number = {label: node for node, (label, *_) in enumerate(nodes)}
        self._same = {} if mesh is None else mesh.other_names  # points at the place of another one
        self._drawn = {label: (names[link], at) for label, link, at in nodes}
        self.rigid: dict[str, int] = {"ground": machine.ground}
        welded = self._welded()
        poses: dict[int, int] = {}
        for name, link in scene.links.items():
            if link.rigid is not None:
                place, axes = frames[name]
                self.rigid[name] = machine.add_pose(place + axes @ np.array(link.rigid.centre), axes)
        fixed, shared = self._pinned()
        for node, (label, link, at) in enumerate(nodes):
            body = names[link]
            place, axes = frames[body]
            if scene.links[body].rigid is not None:
                poses[node] = self.rigid[body]
            elif label in welded:
                carrier = welded[label]
                poses[node] = self.rigid[carrier] if carrier in self.rigid else poses[self._number[carrier]]
            else:
                known = poses.get(self._number[shared[label]]) if label in shared else None
                poses[node] = machine.add_pose(place + axes @ at, axes, known, "place" if label in fixed else "")
        self.pose = [poses[node] for node in range(len(nodes))]

    def _welded(self) -> dict[str, str]:
        """Give by "link.point" of a link that bends what carries it: "ground", a rigid link, or another point."""
        carried: dict[str, str] = {}
        for name, joint in self.scene.joints.items():
            if not isinstance(joint, Weld) or not any(self.stiffness(point) == BENDING for point in joint.connect):
                continue
            sides = [point if self.stiffness(point) == BENDING else point.split(".")[0] for point in joint.connect]
            sides = [self._same.get(side, side) for side in sides]
            one, other = sorted(sides, key=lambda side: (side != "ground", "." in side, sides.index(side)))
            if other in carried:
                raise SceneError("no joint states two welds at one point yet", place=f"joints.{name}")
            carried[other] = carried.get(one, one)
        return carried

    def _pinned(self) -> tuple[set[str], dict[str, str]]:
        """Give the points of bending links that pins hold at the ground, and by other points the one they share."""
        # Pins that rub have rows, which tell their forces.
        rub = set()
        for law in self.scene.joint_laws.values():
            if isinstance(law, Friction):
                rub.add(law.joint)
        fixed: set[str] = set()
        shared: dict[str, str] = {}
        for name, joint in self.scene.constraints.items():
            if not isinstance(joint, Revolute) or name in rub:
                continue
            bending = [
                node
                for point in joint.connect
                if self.stiffness(point) == BENDING
                # a point a rounding beside a node is held by rows, at an offset
                and self.scene.point(node := self._same.get(point, point)) == self.scene.point(point)
            ]
            if min(map(self.stiffness, joint.connect)) == RESTING:
                fixed |= set(bending)
            else:
                shared |= {point: bending[0] for point in bending[1:]}
        return fixed, shared

    def end(self, point: str, turn: float = 0.0) -> End:
        """Give the end at a point of a link or the ground, or at a node inside a member "member@0.3"."""
        # Its axes are turned by an angle from those of the link (rad).
        if "@" in point:
            link, (x, y) = self._drawn[point]
        else:
            link, (x, y) = self.scene.point(point)
        place, axes = self.frames[link]
        pose = self.rigid[link] if link in self.rigid else self.pose[self._number[self._same.get(point, point)]]
        return self.machine.end(pose, place + axes @ [x, y], axes @ PLANE.turn(np.array([turn])))

    def stiffness(self, point: str) -> int:
        """Order points by what carries them."""
        link = point.split(".", maxsplit=1)[0]
        return RESTING if link == "ground" else BENDING if self.scene.links[link].rigid is None else STIFF


def _add_joints(scene: Scene, machine: Machine, nodes: _Nodes) -> None:
    """Hold pins and guides by rows."""
    # The points of a pin come in the order of what carries them: the ground, links that bend, rigid links. So no
    # place is shared after it has rows. Welds have no rows, and pins that ride along members follow with the
    # elements.
    for name, joint in scene.constraints.items():
        if isinstance(joint, Revolute):
            first, *others = sorted(joint.connect, key=nodes.stiffness)
            for point in others:
                machine.join(joint.kind, (nodes.end(first), nodes.end(point)), name=name)
        elif isinstance(joint, Weld):
            if all(nodes.stiffness(point) != BENDING for point in joint.connect):
                machine.join(joint.kind, _with_same_axes(machine, *map(nodes.end, joint.connect)), name=name)
        elif joint.member is None:
            ends = (nodes.end(point, joint.angle) for point in joint.connect)
            machine.join(joint.kind, _with_same_axes(machine, *ends), name=name)


def _with_same_axes(machine: Machine, one: End, other: End) -> tuple[End, End]:
    """Give two ends, the second with the axes of the first, as both are drawn."""
    return one, replace(other, turn=machine.R[other.pose].T @ machine.R[one.pose] @ one.turn)


def moved_ends(made: SceneMachine, name: str) -> tuple[str, tuple[End, End]]:
    """Give the freedom of a joint that a drive may lead, "angle" or "stroke", and its ends."""
    joint = made.scene.joints[name]
    if joint.member is not None:
        return "stroke", made.machine.along(name)
    turn, freedom = (0.0, "angle") if isinstance(joint, Revolute) else (joint.angle, "stroke")  # type: ignore[union-attr]
    return freedom, (made.end(joint.connect[0], turn), made.end(joint.connect[1], turn))


def lead(made: SceneMachine, name: str, law: Law) -> int:
    """Lead the angle or the stroke of a joint by a law of time, and give the number of the row."""
    freedom, ends = moved_ends(made, name)
    return made.machine.drive(made.scene.joints[name].kind, freedom, ends, law, name)


def _add_beams(made: SceneMachine, links: LinkMatrices, frames: dict[str, tuple[Array, Array]], inner: int) -> None:
    """Make the elements of the mesh beams: stiffness, mass and shallow-arch numbers from the forms."""
    machine, mesh = made.machine, links.mesh
    offsets, moment, angle = links.layout.offsets, links.mass_moment, links.layout.shear_angle
    back = np.eye(6) if offsets is None else np.linalg.inv(offsets.arms)  # from the member's axis to its neutral line
    of_elements = links.element_stiffness, links.element_mass, links.element_rotary_mass
    stiffness, mass, rotary = (np.swapaxes(back, -1, -2) @ matrix @ back for matrix in of_elements)
    elements = []
    for e, (nodes, member) in enumerate(zip(mesh.cell_nodes, mesh.cell_member)):
        place, axes = frames[list(made.scene.links)[mesh.member_link[member]]]
        own = axes @ PLANE.turn(mesh.member_angle[member, None])
        beside = 0.0 if offsets is None else offsets.neutral[e] * own[:, 1]  # the neutral line from the member's axis
        first, second = (machine.end(made.node_pose[n], place + axes @ mesh.node_xy[n] + beside, own) for n in nodes)
        length = float(mesh.cell_length[e])
        shapes = STRAINED * np.array([[length], [1.0], [1.0]])
        arch = np.einsum("ia,ab,jb->ij", shapes, links.element_bow[e], shapes) / (2 * length)
        numbers = np.array([[arch[1, 1], 2 * arch[1, 2], arch[2, 2]]])
        made.element_ends.append((first, second))
        if inner:
            elements.append(_with_places(made.scene, links, e, inner))
            continue
        turning = np.array([0, 0, 1, 0, length, 1.0])  # of the element about its first node
        section = np.array([turning @ rotary[e] @ turning])
        across = float(links.inertia.spread is None) * (mass - rotary)[e][np.ix_(SHALLOW, SHALLOW)]  # or at the nodes
        beside_line = np.zeros(1) if moment is None else moment[e, None]
        sheared = np.zeros(4) if angle is None else angle[e] * [length, 1.0, length, 1.0]
        elements.append(
            Element(length, shapes @ stiffness[e] @ shapes.T, numbers, across, section, beside_line, sheared)
        )
    machine.add_beams(made.element_ends, elements, made.scene.damping.material)


def _with_places(scene: Scene, links: LinkMatrices, e: int, inner: int) -> Element:
    """Give an element with places inside, whose numbers are those of its sections."""
    mesh, member = links.mesh, links.mesh.cell_member[e]
    label = mesh.members[member]
    first, length, whole = (float(x) for x in (mesh.cell_start[e], mesh.cell_length[e], mesh.member_length[member]))
    if "shear" in scene.effects or (links.mass_moment is not None and links.mass_moment[e]):
        raise SceneError(
            "elements with places inside have neither shear nor mass beside their neutral line. Use more elements",
            place=f"links.{label}",
        )

    def along(name: str) -> Callable[[Array], Array]:
        return lambda x: getattr(scene.rigidity(label, (first + x * length) / whole), name)

    rotary = along("rotary_inertia") if "rotary-inertia" in scene.effects else 0.0
    return Element.with_places(inner, length, along("axial"), along("bending"), along("line_density"), rotary)


def _add_rides(made: SceneMachine, links: LinkMatrices) -> None:
    """Let pins ride along the bent axes of members, blocks turn with them, and scales show strokes that others need."""
    scene, machine, mesh = made.scene, made.machine, links.mesh
    for name, label in members_under_pins(scene.constraints, scene.members()).items():
        joint, member = scene.joints[name], list(mesh.members).index(label)
        elements = tuple(made.element_ends[e] for e in np.nonzero(mesh.cell_member == member)[0])
        first, pin = _with_same_axes(machine, elements[0][0], made.end(joint.connect[1]))
        if isinstance(joint, Prismatic):
            own = [machine.beams.elements[e] for e in np.nonzero(mesh.cell_member == member)[0]]
            bends = tuple((element.length, 1 / float(element.stiffness[2, 2])) for element in own)
            looks = Riding.ACROSS, Riding.TURNED
            machine.rides += [Ride(pin, elements, name=name, look=look, bends=bends) for look in looks]
        else:
            machine.rides.append(Ride(pin, elements, name=name))
        if name in (*scene.moved_joints, *(getattr(load.factor, "joint", None) for load in scene.loads.values())):
            along = (machine.R[first.pose] @ first.turn)[:, 0]
            places = [machine.drawn(end) for end in (first, *(last for _, last in elements), pin)]
            *marks, value = (np.array(places) - machine.drawn(made.end(joint.connect[0]))) @ along
            scale = machine.add_scale(value)
            machine.rides.append(Ride(pin, elements, 0.0, name, Riding.STROKE, tuple(marks), scale))


def _add_bodies(made: SceneMachine, nodes: _Nodes) -> None:
    """Add the inertia of rigid links, of masses at points, and of elements whose mass is lumped at nodes."""
    scene, machine, links = made.scene, made.machine, made.links
    for name, link in scene.links.items():
        if link.rigid is not None:
            place, axes = nodes.frames[name]
            end = machine.end(nodes.rigid[name], place + axes @ np.array(link.rigid.centre), axes)
            machine.masses.add_body(end, link.rigid.mass, np.eye(2) * link.rigid.inertia / 2)
    for mass in scene.masses.values():
        machine.masses.add_body(nodes.end(mass.at), mass.mass, np.eye(2) * mass.inertia / 2)
    if links is not None and links.inertia.spread is not None:
        for node, lump in links.inertia.bodies[len(links.inertia.spread.bodies) :]:
            place, axes = nodes.frames[list(scene.links)[links.mesh.node_link[node]]]
            end = machine.end(made.node_pose[node], place + axes @ links.mesh.node_xy[node], axes)
            machine.masses.add_body(end, lump.mass, np.eye(2) * lump.inertia / 2)
