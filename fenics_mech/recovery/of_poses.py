"""What is read off a periodic motion of poses: strains and forces along members, forces of joints, efforts, places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.effects.causes import Cause, cause_of_efforts
from fenics_mech.forces.strains import stress_over_modulus, young_modulus
from fenics_mech.forces.viscous import elastic_strain
from fenics_mech.geometry import End
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.drawn_from_scene import clock_of
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.joint_forces import Reactions
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.section_forces import EndForces, Sections, end_forces
from fenics_mech.machine.without_modes import without_modes
from fenics_mech.recovery.rigid_places import between_ends
from fenics_mech.scene.joints import Joint, Weld
from fenics_mech.terms import Beams, Damper, PointLoad, Term

GROUND = "ground"
Variables = dict[str, tuple[tuple[str, ...], Array]]


@dataclass(frozen=True)
class OfPoses:
    """A periodic motion of a scene's machine at its positions.

    Parameters
    ----------
    made
        The machine of the scene.
    motion
        Its motion at all positions.
    """

    made: SceneMachine
    motion: Motion

    # ---- along members ----
    @cached_property
    def stations(self) -> Array:
        """Places along members, 0..1."""
        return np.linspace(0, 1, self.made.scene.analysis.stations)

    @cached_property
    def sections(self) -> Sections:
        """Forces in sections at the stations."""
        return along_members(self.made, self.motion.found, self.motion.a, self.stations)

    @cached_property
    def strains(self) -> tuple[Array, Array]:
        """Strains of the axes ``(instants, members, stations)``, and by bending of both fibres ``(..., 2)``."""
        scene, motion, bare = self.made.scene, self.motion, self.sections
        if self.made.machine.beams.modal is not None:  # what damps modes is no strain
            elastic = without_modes(motion.machine, motion.t, motion.q, motion.v, motion.a, motion.found)
            bare = along_members(self.made, elastic, motion.a, self.stations)
        parts = stress_over_modulus(scene.rigidities(self.stations), bare.axial, bare.moment)
        stretch, bending = (elastic_strain(scene, part) for part in parts)
        return stretch, bending

    def members(self) -> Variables:
        """Give strains, stresses, section forces and deflections at the stations of all members."""
        forces, s, lengths = self.sections, self.stations, self.mesh.member_length
        sections, along = self.made.scene.rigidities(s), ("theta", "member", "s")
        stretch, bending = self.strains
        by_force, by_moment = stress_over_modulus(sections, forces.axial, forces.moment)
        ends = np.stack([self._places(which) for which in (0, -1)], axis=2)
        deflection = forces.place - between_ends(ends, s)
        euler = np.pi**2 * np.array([part.bending.min() for part in sections]) / lengths**2
        apart = deflection - between_ends(deflection[:, :, [0, -1]], s)
        return {
            "strain": ((*along, "fibre"), stretch[..., None] + bending),  # (6.38)
            "strain_axial": (along, stretch),
            "strain_bending": ((*along, "fibre"), bending),
            "stress": ((*along, "fibre"), young_modulus(sections) * (by_force[..., None] + by_moment)),
            "moment": (along, forces.moment),
            "axial_force": (along, forces.axial),
            "shear_force": (along, forces.shear),
            "deflection": ((*along, "component"), deflection),
            "euler_ratio": (("member",), np.abs(forces.axial).max(axis=(0, 2)) / euler),
            "bow": (("member",), norms(apart).max(axis=(0, 2)) / lengths),
            "rotation": (("member",), self._rotations()),
        }

    def _places(self, which: int) -> Array:
        """Give the first or last end of every member in the rigid motion ``(instants, members, 2)`` (m)."""
        mesh = self.mesh
        cells = [np.nonzero(mesh.cell_member == member)[0][which] for member in range(len(mesh.members))]
        return np.stack([self.motion.chart.of_end(self.made.element_ends[e][which])[0] for e in cells], axis=1)

    @property
    def mesh(self) -> BeamMesh:
        """The mesh of the members."""
        assert self.made.links is not None
        return self.made.links.mesh

    def _rotations(self) -> Array:
        """Give the largest rotation of each member's sections from the rigid motion (rad)."""
        mesh = self.mesh
        largest = np.zeros(len(mesh.members))
        for ends, member in zip(self.made.element_ends, mesh.cell_member):
            for end in ends:
                turn = np.swapaxes(self.motion.chart.axes(end), -1, -2) @ self.motion.axes(end)
                angle = np.abs(np.arctan2(turn[:, 1, 0], turn[:, 0, 0])).max()
                largest[member] = max(largest[member], angle)
        return largest

    # ---- joints and drives ----
    def efforts(self) -> dict[str, Array]:
        """Give the torque (N m) or force (N) of drives and in freedoms on the second body of their joints.

        They are ``(instants,)`` each.
        """
        joints = [drive.joint for drive in self.made.scene.drives]
        first = self.motion.machine.n
        found = {joint: -self.motion.a[:, first + row] for joint, row in zip(joints, self.made.driven)}
        return found | {name: np.zeros(len(self.motion.t)) for name in self.made.scene.freedoms}  # nothing leads them

    def joint_forces(self) -> dict[str, Array]:
        """Give the force of the first body of every joint on each other one, ``(instants, 2)`` (N)."""
        found: dict[str, Array] = {}
        for name, joint in self.made.scene.joints.items():
            others = joint.connect[1:]
            for point in others:
                body = point.split(".")[0]
                found[name if len(others) == 1 else f"{name}:{body}"] = self.held(name, joint, body)[:, :2]
        return found

    @cached_property
    def _reactions(self) -> Reactions:
        return Reactions(self.motion)

    def held(self, name: str, joint: Joint, body: str) -> Array:
        """Give force and moment, about its point, of a joint on one of its bodies ``(instants, 3)`` (N, N m)."""
        bodies = {point.split(".")[0]: point for point in joint.connect}
        if body == GROUND:
            return -np.sum([self.held(name, joint, other) for other in bodies if other != GROUND], axis=0)
        end = self.made.end(bodies[body])
        if joint.member is not None:
            return self._under_pin(name, body)
        if isinstance(joint, Weld):
            return self._at_weld(body, end)
        found = self._reactions.of(name)[:, end.pose]
        arm = self.motion.of_end(end)[0] - self.motion.found.at.r[:, end.pose]
        moment = found[:, 2] - arm[:, 0] * found[:, 1] + arm[:, 1] * found[:, 0]
        return np.concatenate([found[:, :2], moment[:, None]], axis=1)

    def _at_weld(self, body: str, end: End) -> Array:
        """Give what a body needs from a weld, whose pose it shares: for its elements and its masses there."""
        motion, ends, names = self.motion, self._ends, list(self.made.scene.links)
        links = self.mesh.member_link[self.mesh.cell_member]
        place = motion.of_end(end)[0]
        found = np.zeros((len(motion.t), 3))
        for e, side in zip(*np.nonzero(motion.machine.groups[0].pose == end.pose)):
            if names[links[e]] == body:
                force, arm = ends.force[:, e, side], ends.place[:, e, side] - place
                found[:, :2] += force
                found[:, 2] += ends.moment[:, e, side, 0] + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        return found

    def _under_pin(self, name: str, body: str) -> Array:
        """Give the force of a pin that rides along a member on one of both bodies; a pin holds no moment."""
        motion, riders = self.motion, self.motion.machine.riders
        push = riders.pushes(motion.found.at, motion.a)[1]
        which = [k for k, ride in enumerate(riders.rides) if ride.name == name]
        whole = push[:, np.isin(riders.of, which)].sum(axis=1)  # on the member, which is that of the first point
        first = self.made.scene.joints[name].connect[0].split(".")[0]
        return np.concatenate([whole if body == first else -whole, np.zeros((len(motion.t), 1))], axis=1)

    @cached_property
    def _ends(self) -> EndForces:
        machine, found = self.motion.machine, self.motion.found
        return end_forces(self.made.machine.beams, machine.groups[0], found.terms[0], found.at)

    @property
    def supports(self) -> dict[str, Joint]:
        """The joints of the ground."""
        joints = self.made.scene.joints
        return {name: joint for name, joint in joints.items() if any(p.startswith("ground.") for p in joint.connect)}

    def frame(self) -> Variables:
        """Give forces and couples on the ground at every support, and their sums about its origin."""
        motion = self.motion
        force, couple, moment = [], [], []
        for name, joint in self.supports.items():
            bodies = {point.split(".")[0]: point for point in joint.connect}
            held = self.held(name, joint, GROUND)
            pin = next(point for body, point in bodies.items() if body != GROUND)
            place = motion.of_end(self.made.end(pin))[0]
            force.append(held[:, :2])
            couple.append(held[:, 2])
            moment.append(held[:, 2] + place[:, 0] * held[:, 1] - place[:, 1] * held[:, 0])
        if not force:
            return {}
        return {
            "support_force": (("theta", "support", "component"), np.stack(force, axis=1)),
            "support_moment": (("theta", "support"), np.stack(couple, axis=1)),
            "shaking_force": (("theta", "component"), np.sum(force, axis=0)),
            "shaking_moment": (("theta",), np.sum(moment, axis=0)),
        }

    # ---- places ----
    def points(self) -> Variables:
        """Give place, velocity and acceleration of all points, with links that do not bend and with bent ones."""
        found: Variables = {}
        for suffix, motion in (("", self.motion.chart), ("_bent", self.motion)):
            for name, values in zip(
                ("position", "velocity", "acceleration"), zip(*(motion.of_end(end) for end in self.traced.values()))
            ):
                found[f"point_{name}{suffix}"] = (("theta", "point", "component"), np.stack(values, axis=1))
        return found

    @cached_property
    def traced(self) -> dict[str, End]:
        """Ends at all points of links, and at those that the scene adds, by name."""
        scene = self.made.scene
        points = [f"{link}.{point}" for link, body in scene.links.items() for point in body.points]
        names = {point: self.made.end(point) for point in points}
        for name, traced in scene.points.items():
            end = self.made.end(traced.at)
            names[name] = End(end.pose, end.offset + end.turn @ np.array(traced.offset), end.turn)
        return names

    def links(self) -> LinkMotion:
        """Give the motion of the links' frames where they do not bend."""
        scene, chart, t = self.made.scene, self.motion.chart, self.motion.t
        origins = {}
        for name, link in scene.links.items():
            point, at = next(iter(link.points.items()))
            end = self.made.end(f"{name}.{point}")
            origins[name] = End(end.pose, end.offset - end.turn @ np.array(at), end.turn)
        r, v, a = (np.stack(x, axis=1) for x in zip(*(chart.of_end(end) for end in origins.values())))
        axes = np.stack([chart.axes(end) for end in origins.values()], axis=1)
        poses = [end.pose for end in origins.values()]
        known = chart.machine.known.at(t)
        angle = np.unwrap(np.arctan2(axes[..., 1, 0], axes[..., 0, 0]), axis=0)
        omega, alpha = known.w[:, poses, 0], known.al[:, poses, 0]
        return LinkMotion(self.theta, t, tuple(origins), r, v, a, angle, omega, alpha)

    @cached_property
    def theta(self) -> Array:
        """Drive angles (rad), or phases where nothing is driven."""
        return np.asarray(self.made.scene.cycle_rate * clock_of(self.made.scene)(self.motion.t))

    # ---- power ----
    def drive_rates(self) -> Array:
        """Give the rates of angles (rad/s) and strokes (m/s) of the drives ``(instants, drives)``."""
        motion, rows = self.motion, self.motion.machine.rows
        value = [row.value(motion.t) if callable(row.value) else np.zeros(len(motion.t)) for row in rows]
        measured = motion.machine.row_group.measure(motion.found.at, np.stack(value, axis=1)[..., None])
        return measured.rate[:, self.made.driven, 0]

    def powers(self) -> dict[str, Array]:
        """Give what drives, loads and damping give to the machine ``(instants,)`` (W)."""
        given = np.zeros(len(self.motion.t))
        if drives := len(self.made.driven):
            efforts = np.stack(list(self.efforts().values())[:drives], axis=1)
            given = np.sum(efforts * self.drive_rates(), axis=1)
        found = {cause_of_efforts(self.made.scene): given}
        for term, here in zip(self.motion.machine.terms, self.motion.found.terms):
            for cause, power in _taken(term, here):
                if power.any():
                    found[cause] = found.get(cause, 0.0) - power
        return found


def _taken(term: Term, here: Measured) -> Iterator[tuple[str, Array]]:
    """Give the power that a term takes for good, by cause."""
    if isinstance(term, Beams):
        viscous = term.damping[:, None] * np.einsum("eij,tej->tei", term.stiffness, here.rate)
        yield Cause.MATERIAL, np.sum(viscous * here.rate, axis=(1, 2))
        if here.response.modes is not None:
            size = np.einsum("temk,tem->tk", here.response.modes, here.rate)
            yield Cause.MODAL_DAMPING, np.sum(size**2, axis=1)
    elif isinstance(term, Damper):
        yield Cause.DAMPERS, here.power.sum(axis=1)
    elif isinstance(term, PointLoad):
        yield Cause.LOADS, here.power.sum(axis=1)
