"""From a scene to its machine: poses of nodes and rigid links, beams from UFL forms, joints."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.element_dofs import member_rotation
from fenics_mech.beams.element_matrices import Beams as LinkMatrices
from fenics_mech.errors import SceneError
from fenics_mech.geometry import PLANE, End
from fenics_mech.kinematics import start_motion
from fenics_mech.machine.acting_from_scene import add_acting
from fenics_mech.machine.machine import Machine, Row
from fenics_mech.mechanism.beam_links import links as matrices_of_links
from fenics_mech.scene import Scene
from fenics_mech.scene.drives import Drive
from fenics_mech.scene.joints import Prismatic, Revolute, Slot, Weld
from fenics_mech.terms import Beams, Element, Look, Measure

STRAINED = np.array([[0, 0, 0, 1, 0, 0], [0, 0, 1, 0, 0, 1], [0, 0, -0.5, 0, 0, 0.5]])  # u, w, phi of both nodes
SHALLOW = np.array([1, 2, 4, 5])  # w and phi of both nodes


@dataclass
class SceneMachine:
    """A machine with the names of its scene.

    Parameters
    ----------
    scene
        The scene.
    machine
        Its machine, as drawn at the start of the cycle.
    links
        The local matrices of its links.
    node_pose
        Pose of every node of the mesh.
    element_ends
        Ends of every element of the mesh.
    driven
        Row of every drive.
    """

    scene: Scene
    machine: Machine
    links: LinkMatrices
    node_pose: list[int]
    element_ends: list[tuple[End, End]]
    driven: list[int] = field(default_factory=list)

    @property
    def beams(self) -> Beams:
        """The elements, which are the first term."""
        beams = self.machine.terms[0]
        assert isinstance(beams, Beams)
        return beams


def machine_of(scene: Scene) -> SceneMachine:
    """Build the machine of a planar scene that is driven.

    Parameters
    ----------
    scene
        The scene, with its effects chosen.

    Raises
    ------
    SceneError
        When the scene has what no term or joint states yet.
    """
    machine = Machine(PLANE, scene.gravity)
    links, start = matrices_of_links(scene), start_motion(scene)
    names = list(start.links)
    frames = {name: (start.position[0, i], PLANE.turn(start.angle[0, i, None])) for i, name in enumerate(names)}
    frames["ground"] = np.zeros(2), np.eye(2)
    nodes = _Nodes(scene, machine, links, frames)
    made = SceneMachine(scene, machine, links, nodes.pose, [])
    for name, joint in scene.joints.items():
        if isinstance(joint, Slot | Prismatic):
            if joint.member is not None:
                raise SceneError("no term states a slider on a member yet", place=f"joints.{name}.member")
            _add_guide(machine, nodes, name, joint)
        elif isinstance(joint, Revolute):
            _add_pins(machine, nodes, name, joint)
    _add_drives(made, nodes)
    _add_beams(made)
    _add_bodies(scene, machine, nodes)
    add_acting(scene, machine, nodes)
    return made


class _Nodes:
    """Poses of the nodes of a mesh and of rigid links, and ends at the points of links."""

    def __init__(
        self, scene: Scene, machine: Machine, links: LinkMatrices, frames: dict[str, tuple[Array, Array]]
    ) -> None:
        self.scene, self.machine, self.frames = scene, machine, frames
        mesh = links.mesh
        self.mesh, self.names = mesh, list(scene.links)
        self._rigid: dict[str, int] = {"ground": machine.ground}
        welded = self._welded(scene)
        poses: dict[int, int] = {}
        for name, link in scene.links.items():
            if link.rigid is not None and welded.get(name, name) == name:
                place, axes = frames[name]
                self._rigid[name] = machine.add_pose(place + axes @ np.array(link.rigid.centre), axes)
        for name in welded:
            if name in scene.links and scene.links[name].rigid is not None and name not in self._rigid:
                self._rigid[name] = self._rigid[welded[name]]
        fixed, shared = self._pinned(scene)
        for node, (link, at) in enumerate(zip(mesh.node_link, mesh.node_xy)):
            body, label = self.names[link], mesh.node_name[node]
            place, axes = frames[body]
            if scene.links[body].rigid is not None:
                poses[node] = self._rigid[body]
            elif label in welded:
                poses[node] = self._carrier(welded[label], poses)
            else:
                other = shared.get(label)
                known = poses[mesh.node(other)] if other is not None and mesh.node(other) in poses else None
                poses[node] = machine.add_pose(place + axes @ at, axes, known, "place" if label in fixed else "")
        self.pose = [poses[node] for node in range(len(mesh.node_name))]

    def _welded(self, scene: Scene) -> dict[str, str]:
        """Give by "link.point", or by rigid link, what carries it: "ground", a rigid link, or another point."""
        carried: dict[str, str] = {}
        for name, joint in scene.joints.items():
            if not isinstance(joint, Weld):
                continue
            sides = []
            for point in joint.connect:
                link = point.split(".")[0]
                sides.append(link if link == "ground" or scene.links[link].rigid is not None else point)
            one, other = sorted(sides, key=lambda side: (side != "ground", "." in side, sides.index(side)))
            if other in carried:
                raise SceneError("no joint states two welds at one point yet", place=f"joints.{name}")
            carried[other] = carried.get(one, one)
        return carried

    def _carrier(self, name: str, poses: dict[int, int]) -> int:
        return self._rigid[name] if name in self._rigid else poses[self.mesh.node(name)]

    def _pinned(self, scene: Scene) -> tuple[set[str], dict[str, str]]:
        """Give the points of bending links that pins hold at the ground, and by other points the one they share."""
        fixed: set[str] = set()
        shared: dict[str, str] = {}
        self.by_places: dict[str, set[str]] = {}  # pins, and the points that need no row
        for name, joint in scene.joints.items():
            if not isinstance(joint, Revolute):
                continue
            links = [point.split(".")[0] for point in joint.connect]
            bending = [
                point
                for point, link in zip(joint.connect, links)
                if link != "ground" and scene.links[link].rigid is None
            ]
            if "ground" in links:
                fixed |= set(bending)
            else:
                shared |= {point: bending[0] for point in bending[1:]}
            self.by_places[name] = set(bending)
        return fixed, shared

    def end(self, point: str, turn: float = 0.0) -> End:
        """Give the end at a point of a link or the ground, or at a node inside a member "member@0.3".

        Its axes are turned by an angle from those of the link (rad).
        """
        if "@" in point:
            node = self.mesh.node(point)
            link, (x, y) = self.names[self.mesh.node_link[node]], self.mesh.node_xy[node]
        else:
            link, (x, y) = self.scene.point(point)
        place, axes = self.frames[link]
        return self.machine.end(self._pose_at(link, point), place + axes @ [x, y], axes @ PLANE.turn(np.array([turn])))

    def _pose_at(self, link: str, point: str) -> int:
        return self._rigid[link] if link in self._rigid else self.pose[self.mesh.node(point)]


def _add_pins(machine: Machine, nodes: _Nodes, name: str, joint: Revolute) -> None:
    """Hold the points of rigid links, which share no place, at the pin."""
    held = nodes.by_places[name]
    ground = [point for point in joint.connect if point.startswith("ground.")]
    first = (ground or sorted(held, key=joint.connect.index) or [joint.connect[0]])[0]
    for point in joint.connect:
        if point != first and point not in held:
            ends = nodes.end(first), nodes.end(point)
            machine.rows += [Row(ends, Measure(Look.PLACE, axis), name=name) for axis in range(2)]


def _add_guide(machine: Machine, nodes: _Nodes, name: str, joint: Slot | Prismatic) -> None:
    """Hold a pin on the line of a guide, and in a prismatic joint its angle."""
    guide, slide = (nodes.end(point, joint.angle) for point in joint.connect)
    machine.rows.append(Row((guide, slide), Measure(Look.ALONG, 1), name=name))
    if isinstance(joint, Prismatic):
        own = machine.end(slide.pose, None, machine.R[guide.pose] @ guide.turn)  # drawn along the guide
        machine.rows.append(Row((guide, own), Measure(Look.ALIGNED, 1, 0), name=name))


def _add_drives(made: SceneMachine, nodes: _Nodes) -> None:
    """Lead the angle of pins, and the stroke of guides, by the laws of the drives."""
    scene, machine = made.scene, made.machine
    for drive in scene.drives:
        joint = scene.joints[drive.joint]
        turn = joint.angle if isinstance(joint, Slot | Prismatic) else 0.0
        ends = nodes.end(joint.connect[0], turn), nodes.end(joint.connect[1], turn)
        measure = Measure(Look.ANGLE) if isinstance(joint, Revolute) else Measure(Look.ALONG, 0)
        made.driven.append(len(machine.rows))
        machine.rows.append(Row(ends, measure, _law(drive, scene.cycle_rate), name=drive.joint))


def _law(drive: Drive, rate: float) -> Callable[[Array], Array]:
    """Give the angle (rad) or stroke (m) of a drive by time (s)."""
    return lambda t: drive.jet(rate * t, rate).value


def _add_beams(made: SceneMachine) -> None:
    """Make the elements of the mesh beams: stiffness, mass and shallow-arch numbers from the forms."""
    links, machine, mesh = made.links, made.machine, made.links.mesh
    rotation = member_rotation(mesh)
    bow = np.einsum("eai,eij,ebj->eab", rotation, links.stretching.bow, rotation)
    stiffness, mass = links.element_stiffness, links.element_mass
    rotary = links.element_rotary_mass
    elements = []
    for e, (nodes, member) in enumerate(zip(mesh.cell_nodes, mesh.cell_member)):
        link = list(made.scene.links)[mesh.member_link[member]]
        place, axes = _frame(made, link)
        own = axes @ PLANE.turn(mesh.member_angle[member, None])
        first, second = (machine.end(made.node_pose[n], place + axes @ mesh.node_xy[n], own) for n in nodes)
        length = float(mesh.cell_length[e])
        shapes = STRAINED * np.array([[length], [1.0], [1.0]])
        arch = np.einsum("ia,ab,jb->ij", shapes, bow[e], shapes) / (2 * length)
        numbers = np.array([[arch[1, 1], 2 * arch[1, 2], arch[2, 2]]])
        made.element_ends.append((first, second))
        turning = np.array([0, 0, 1, 0, length, 1.0])  # of the element about its first node
        section = np.array([turning @ rotary[e] @ turning])
        across = (mass - rotary)[e][np.ix_(SHALLOW, SHALLOW)]
        elements.append(Element(length, shapes @ stiffness[e] @ shapes.T, numbers, across, section))
    machine.add_beams(made.element_ends, elements, made.scene.damping.material)


def _frame(made: SceneMachine, link: str) -> tuple[Array, Array]:
    start = start_motion(made.scene)
    i = start.links.index(link)
    return start.position[0, i], PLANE.turn(start.angle[0, i, None])


def _add_bodies(scene: Scene, machine: Machine, nodes: _Nodes) -> None:
    """Add the inertia of rigid links and of masses at points."""
    for name, link in scene.links.items():
        if link.rigid is not None:
            place, axes = nodes.frames[name]
            end = machine.end(nodes._rigid[name], place + axes @ np.array(link.rigid.centre), axes)
            machine.masses.add_body(end, link.rigid.mass, np.eye(2) * link.rigid.inertia / 2)
    for mass in scene.masses.values():
        machine.masses.add_body(nodes.end(mass.at), mass.mass, np.eye(2) * mass.inertia / 2)
