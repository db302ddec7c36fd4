"""What is read off a periodic motion of poses: strains and forces along members, forces of joints, efforts, places."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.estimate.quantities import Quantities
from fenics_mech.geometry import PLANE, End
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine.acting_from_scene import point_of
from fenics_mech.machine.along_members import along_members, on_elements
from fenics_mech.machine.drawn_from_scene import clock_of
from fenics_mech.machine.energy import power_of_weight
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.joint_forces import Reactions
from fenics_mech.machine.laws_from_scene import SHAFT
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.section_forces import EndForces, InnerForces, Sections
from fenics_mech.recovery.rigid_places import between_ends
from fenics_mech.recovery.strains import elastic_strain, stress_over_modulus, without_modes, young_modulus
from fenics_mech.scene import Bushing, Friction, JointEffort
from fenics_mech.scene.applied_loads import Load
from fenics_mech.scene.joints import Joint, Prismatic, Slot, Weld
from fenics_mech.scene.springs_dampers import Line
from fenics_mech.terms import Beams, Term
from fenics_mech.terms.causes import Cause, cause_of_efforts

GROUND = "ground"
EVEN = 201  # places along members at which their largest strain is looked for
BESIDE = 1e-9  # of a member, beside a place where a load acts: couples leave two moments there
Variables = dict[str, tuple[tuple[str, ...], Array]]


@dataclass(frozen=True)
class OfPoses:
    """A periodic motion of a scene's machine at its positions."""

    made: SceneMachine  # the machine of the scene
    motion: Motion
    # whether forces have levers by the bow within elements
    bent: bool = field(default=True, kw_only=True)
    # stations along members, 0..1; None for those of the scene
    places: Array | None = field(default=None, kw_only=True)

    # ---- along members ----
    @cached_property
    def stations(self) -> Array:
        """Places along members, 0..1."""
        return np.linspace(0, 1, self.made.scene.analysis.stations) if self.places is None else self.places

    @property
    def largest_strains(self) -> Array:
        """Largest strain of every member ``(members,)``: at stations, and to both sides of what acts between them."""
        # It is looked for at even places too, where pins travel along members or their sections vary. Where it is
        # largest, it is looked for to both sides of these pins as well.
        scene, places = self.made.scene, self.made.scene.loaded_places()
        beside = np.add.outer([x for own in places.values() for x in own], [-BESIDE, BESIDE]).ravel()
        if self.made.machine.rides or any(np.ptp(part.bending) > 0 for part in scene.rigidities(self.stations)):
            beside = np.append(beside, np.linspace(0.0, 1.0, EVEN))
        between = np.setdiff1d(np.clip(beside, 0.0, 1.0), self.stations)
        found = [self._largest_at(self.stations)] + ([self._largest_at(between)] if len(between) else [])
        if self.made.machine.rides:
            at = np.unique(np.max(found, axis=0).argmax(axis=0))
            pins = np.add.outer(self._under_pins()[at].ravel(), [-BESIDE, BESIDE]).ravel()
            if len(pins := np.unique(pins[(pins > 0) & (pins < 1)])):
                found.append(self._largest_at(pins))
        return np.max(found, axis=(0, 1))

    def _largest_at(self, places: Array) -> Array:
        """Give the largest strain of every member at some places ``(instants, members)``."""
        axial, bending = (self if places is self.stations else replace(self, places=places)).strains
        return np.abs(axial[..., None] + bending).max(axis=(2, 3), initial=0.0)

    def _under_pins(self) -> Array:
        """Give where along its member each pin is, 0..1 where it is on an element ``(instants, elements)``."""
        motion, mesh = self.motion, self.mesh
        here = InnerForces.of_rides(motion.machine.beams, motion.machine.riders, motion.found.at, motion.a)
        lengths = mesh.cell_length[here.element], mesh.member_length[mesh.cell_member[here.element]]
        places = (mesh.cell_start[here.element] + here.place * lengths[0]) / lengths[1]
        return np.where((here.place > -BESIDE) & (here.place < 1 + BESIDE), places, -1.0)

    @cached_property
    def sections(self) -> Sections:
        """Forces in sections at the stations."""
        return along_members(self.made, self.motion.found, self.motion.a, self.stations, self.bent)

    @cached_property
    def bare(self) -> Sections:
        """Forces in sections without what damps modes, which is no strain."""
        if self.made.machine.beams.modal is None:
            return self.sections
        return along_members(self.made, self.elastic, self.motion.a, self.stations, self.bent)

    @cached_property
    def elastic(self) -> Evaluation:
        """The residual without what damps modes."""
        return without_modes(self.motion)

    @cached_property
    def strains(self) -> tuple[Array, Array]:
        """Strains of the axes ``(instants, members, stations)``, and by bending of both fibres ``(..., 2)``."""
        scene, bare = self.made.scene, self.bare
        stretch, bending = stress_over_modulus(scene.rigidities(self.stations), bare.axial, bare.moment)
        if (retardation := scene.damping.material) and scene.analysis.method == "periodic":
            return tuple(elastic_strain(part, retardation, scene.period) for part in (stretch, bending))  # type: ignore[return-value]
        return stretch, bending

    @cached_property
    def quantities(self) -> Quantities:
        """What is compared between two motions, at the stations."""
        axial, bending = self.strains
        forces, efforts, none = list(self.joint_forces.values()), list(self.efforts().values()), (len(axial), 0)
        force = np.stack(forces, axis=1) if forces else np.zeros((*none, 2))
        effort = np.stack(efforts, axis=1) if efforts else np.zeros(none)
        return Quantities(axial, bending, self.deflection, force, effort)

    def members(self) -> Variables:
        """Give strains, stresses, section forces and deflections at the stations of all members."""
        if self.made.links is None:
            return {}
        forces, s, lengths = self.sections, self.stations, self.mesh.member_length
        sections, along = self.made.scene.rigidities(s), ("theta", "member", "s")
        stretch, bending = self.strains
        by_force, by_moment = stress_over_modulus(sections, forces.axial, forces.moment)
        deflection = self.deflection
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

    @cached_property
    def deflection(self) -> Array:
        """Displacement of the members' axes from the rigid motion ``(instants, members, stations, 2)`` (m)."""
        ends = np.stack([self._places(which) for which in (0, -1)], axis=2)
        return self.sections.place - between_ends(ends, self.stations)

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
                angle = np.abs(PLANE.vector(turn)).max()
                largest[member] = max(largest[member], angle)
        return largest

    # ---- joints and drives ----
    def efforts(self) -> dict[str, Array]:
        """Give the torque (N m) or force (N) of drives and in freedoms on the second body of their joints."""
        # They are ``(instants,)`` each. A rotor takes its own part of what the term of a motor or freedom gives.
        scene, first = self.made.scene, self.motion.machine.n
        by_rows = [drive.joint for drive in scene.drives if drive.motor is None]
        found = {joint: -self.motion.a[:, first + row] for joint, row in zip(by_rows, self.made.driven)}
        rotors = {drive.joint: drive.motor.inertia for drive in scene.drives if drive.motor is not None}
        rotors |= {name: freedom.inertia for name, freedom in scene.freedoms.items()}
        for joint, inertia in rotors.items():
            term = self.made.acting[self._place_of(joint)]
            found[joint] = self._exerted(term) - inertia * self.motion.jet(term)[2]
        return found

    def _place_of(self, joint: str) -> str:
        """Give the place of what acts in the freedom of a joint instead of a row: a motor, or a freedom's effort."""
        return f"freedoms.{joint}" if joint in self.made.scene.freedoms else SHAFT

    def _exerted(self, term: Term) -> Array:
        """Give what a term over the angle or stroke of a joint exerts on its second body ``(instants,)`` (N m, N)."""
        return -self.motion.of_term(term).response.stress[:, 0, 0]

    def _of_drive(self, name: str, joint: Joint, body: str) -> Array:
        """Give force and moment of a motor or of an effort on a body of a joint, where it has no row (N, N m)."""
        scene, along = self.made.scene, np.zeros((len(self.motion.t), 3))
        term = self.made.acting.get(self._place_of(name))
        if term is None or name not in scene.moved_joints:
            return along
        if isinstance(joint, Slot | Prismatic):
            along[:, :2] = self.motion.axes(self.made.end(joint.connect[0], joint.angle))[:, :, 0]
        else:
            along[:, 2] = 1.0
        effort = self._exerted(term)[:, None]
        return along * (effort if joint.connect[1].split(".")[0] == body else -effort)

    @cached_property
    def joint_forces(self) -> dict[str, Array]:
        """Give the force of the first body of every joint on each other one, ``(instants, 2)`` (N)."""
        # What laws exert beside what holds the joint is a part of it.
        found: dict[str, Array] = {}
        for name, joint in self.made.scene.joints.items():
            others = joint.connect[1:]
            for point in others:
                body = point.split(".")[0]
                found[name if len(others) == 1 else f"{name}:{body}"] = self.held(name, joint, body)[:, :2]
            if name not in self.made.scene.open_joints:
                for term in self._laws_at(name):
                    found[name] = found[name] + self._on_second(term)[:, :2]
        return found

    def _laws_at(self, joint: str) -> list[Term]:
        """Give the terms of laws at a joint of two bodies, whose first one takes the opposite of what they exert."""
        found = []
        for name, term in self._laws.items():
            stated, _, driven = name.partition(":")
            apart = isinstance(term, LawTerm) and term.law.joint.elsewhere
            if not apart and joint == (driven or self.made.scene.joint_laws[stated].joint):
                found.append(term)
        return found

    def _on_second(self, term: Term) -> Array:
        """Give force and moment of a law on the second body of its joint, about its point ``(instants, 3)``."""
        if isinstance(term, LawTerm):
            return np.asarray(-self.motion.of_term(term).response.stress[:, term.law.joint.bodies[1]])
        return self._on_end(term, 1)

    @cached_property
    def _reactions(self) -> Reactions:
        return Reactions(self.motion)

    def held(self, name: str, joint: Joint, body: str) -> Array:
        """Give force and moment, about its point, of a joint on one of its bodies ``(instants, 3)`` (N, N m)."""
        bodies = {point.split(".")[0]: point for point in joint.connect}
        if body == GROUND:
            return -np.sum([self.held(name, joint, other) for other in bodies if other != GROUND], axis=0)
        if name in self.made.scene.open_joints:
            law = next(key for key, law in self.made.scene.joint_laws.items() if law.joint == name)
            if isinstance(term := self.made.acting[f"joint_laws.{law}"], LawTerm):
                return self._on_second(term) if list(bodies).index(body) == 1 else -self._on_second(term)
            return self._on_end(self.made.acting[f"joint_laws.{law}"], list(bodies).index(body))
        end = self.made.end(bodies[body])
        if joint.member is not None:
            return self._under_pin(name, body)
        if isinstance(joint, Weld) and not all(self._rigid(part) for part in bodies):
            if self._rigid(body):  # it shares its pose with what bends, which has all elements there
                return -self.held(name, joint, next(part for part in bodies if part != body))
            return self._at_weld(body, end)
        found = self._reactions.of(name)[:, end.pose]
        arm = self.motion.of_end(end)[0] - self.motion.found.at.r[:, end.pose]
        moment = found[:, 2] - arm[:, 0] * found[:, 1] + arm[:, 1] * found[:, 0]
        return np.concatenate([found[:, :2], moment[:, None]], axis=1) + self._of_drive(name, joint, body)

    def _rigid(self, body: str) -> bool:
        return body == GROUND or self.made.scene.links[body].rigid is not None

    def _at_weld(self, body: str, end: End) -> Array:
        """Give what a body needs from a weld, whose pose it shares: for its elements, and what acts on it there."""
        motion, ends, names = self.motion, self._ends, list(self.made.scene.links)
        links = self.mesh.member_link[self.mesh.cell_member]
        place = motion.of_end(end)[0]
        found = np.zeros((len(motion.t), 3))
        for e, side in zip(*np.nonzero(motion.machine.groups[0].pose == end.pose)):
            if names[links[e]] == body:
                force, arm = ends.force[:, e, side], ends.place[:, e, side] - place
                found[:, :2] += force
                found[:, 2] += ends.moment[:, e, side, 0] + arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0]
        for term, side in self._acting_on(body, end.pose):
            on, at = self._on_end(term, side), motion.of_end(term.pairs[0][side])[0] - place
            found -= on
            found[:, 2] -= at[:, 0] * on[:, 1] - at[:, 1] * on[:, 0]
        for mass in self.made.scene.masses.values():
            at_mass = self.made.end(mass.at)
            if mass.at.split(".")[0] == body and at_mass.pose == end.pose:
                here, _, second = motion.of_end(at_mass)
                force, arm = mass.mass * (second - motion.machine.gravity), here - place
                found[:, :2] += force
                turning = mass.inertia * (motion.poses.al[:, end.pose, 0] if motion.moving else 0.0)
                found[:, 2] += arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0] + turning
        return found

    def _acting_on(self, body: str, pose: int) -> Iterator[tuple[Term, int]]:
        """Give terms of loads, springs and dampers at points of a body with this pose, and their ends there."""
        scene = self.made.scene
        for place, term in self.made.acting.items():
            kind, _, name = place.partition(".")
            if kind == "loads" and isinstance(load := scene.loads[name], Load):
                points = ["", point_of(scene, load.at)]
            elif kind in ("springs", "dampers") and isinstance(part := getattr(scene, kind)[name], Line):
                points = list(part.between)
            elif kind in ("springs", "dampers"):
                joint = scene.joints[part.joint].connect
                points = list(part.bodies or joint)
            else:
                continue
            for side, point in enumerate(points):
                if point.split(".")[0] == body and term.pairs[0][side].pose == pose:
                    yield term, side

    def _under_pin(self, name: str, body: str) -> Array:
        """Give the force and moment of a pin or block that rides along a member on one of both bodies."""
        motion, riders, points = self.motion, self.motion.machine.riders, self.made.scene.joints[name].connect
        which = [k for k, ride in enumerate(riders.rides) if ride.name == name]
        push = np.concatenate(riders.pushes(motion.found.at, motion.a)[1:], axis=2)
        whole = push[:, np.isin(riders.of, which)].sum(axis=1)  # on the member, which is that of the first point
        if body != points[0].split(".")[0]:
            return -whole
        guide, pin = (motion.of_end(self.made.end(point))[0] for point in points[:2])
        arm = pin - guide
        whole[:, 2] += arm[:, 0] * whole[:, 1] - arm[:, 1] * whole[:, 0]
        return whole

    @cached_property
    def _ends(self) -> EndForces:
        return on_elements(self.made, self.motion.found, self.motion.a)

    @cached_property
    def supports(self) -> dict[str, tuple[Array, Array]]:
        """Force and couple on the ground ``(instants, 3)``, and where they act, of its joints, springs and dampers."""
        found = {}
        for name, joint in self.made.scene.constraints.items():
            bodies = {point.split(".")[0]: point for point in joint.connect}
            if GROUND in bodies:
                pin = next(point for body, point in bodies.items() if body != GROUND)
                found[name] = self.held(name, joint, GROUND), self.motion.of_end(self.made.end(pin))[0]
        return found | {name: (held, place) for name, held, place in self._of_springs()}

    def joint_moments(self) -> dict[str, Array]:
        """Give the moment of the first body of every weld and prismatic joint on its second ``(instants,)`` (N m)."""
        return {
            name: self.held(name, joint, joint.connect[1].split(".")[0])[:, 2]
            for name, joint in self.made.scene.joints.items()
            if isinstance(joint, Weld | Prismatic)
        }

    def frame(self) -> Variables:
        """Give forces and couples on the ground at every support, and their sums about its origin."""
        force, couple, moment = [], [], []
        for held, place in self.supports.values():
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
        """Give place, velocity and acceleration of all points, with links that do not bend, and with bent ones."""
        found: Variables = {}
        bent = () if self.made.links is None else (("_bent", self.moved),)
        for suffix, moved in (("", self.motion.chart.of_end), *bent):
            for name, values in zip(("position", "velocity", "acceleration"), zip(*map(moved, self.traced.values()))):
                found[f"point_{name}{suffix}"] = (("theta", "point", "component"), np.stack(values, axis=1))
        return found

    def moved(self, end: End) -> tuple[Array, ...]:
        """Give place (m), velocity and acceleration of an end, ``(instants, 2)`` each."""
        return self.motion.of_end(end)

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
        angle = np.unwrap(PLANE.vector(axes)[..., 0], axis=0)
        drawn = np.array([link.angle for link in scene.links.values()])  # whole turns count from the rough angles
        angle += 2 * np.pi * np.round((drawn - angle[0]) / (2 * np.pi))
        omega, alpha = (chart.moving * x[:, poses, 0] for x in (known.w, known.al))
        return LinkMotion(self.theta, t, tuple(origins), r, v, a, angle, omega, alpha)

    @cached_property
    def theta(self) -> Array:
        """Drive angles (rad), or phases where nothing is driven."""
        scene = self.made.scene
        found = np.asarray(scene.cycle_rate * clock_of(scene)(self.motion.t))
        stated = [scene.analysis.position] if scene.analysis.method == "static" else scene.drive_angles(len(found))
        # positions have the angles that are stated, to the last digit: results are compared by them
        return np.asarray(stated) if scene.drives and np.allclose(found, stated, rtol=1e-12, atol=1e-12) else found

    # ---- power ----
    def drive_rates(self) -> Array:
        """Give the rates of angles (rad/s) and strokes (m/s) of the drives ``(instants, drives)``."""
        if SHAFT in self.made.acting:
            return self.rate_of(SHAFT)[:, None]
        motion, rows = self.motion, self.motion.machine.rows
        value = [row.value(motion.t) if callable(row.value) else np.zeros(len(motion.t)) for row in rows]
        measured = motion.machine.row_group.measure(motion.found.at, np.stack(value, axis=1)[..., None])
        return measured.rate[:, self.made.driven, 0]

    def rate_of(self, place: str) -> Array:
        """Give the rate of the measure of a term, by its place in the scene ``(instants,)``."""
        return self.motion.of_term(self.made.acting[place]).rate[:, 0, 0]

    @property
    def measured(self) -> Sequence[Measured]:
        """Measures and stresses of every term."""
        return self.motion.found.terms

    def powers(self) -> dict[str, Array]:
        """Give what drives, loads and damping give to the machine ``(instants,)`` (W)."""
        machine, found = self.motion.machine, self.motion.found
        given, efforts = np.zeros(len(self.motion.t)), self.efforts()
        if drives := self.made.scene.drives:
            of_drives = np.stack([efforts[drive.joint] for drive in drives], axis=1)
            given = np.sum(of_drives * self.drive_rates(), axis=1)
        for joint in self.made.scene.freedoms:
            given = given + efforts[joint] * self.rate_of(f"freedoms.{joint}")
        by_cause = {cause_of_efforts(self.made.scene): given}
        causes = {id(term): CAUSES.get(place.split(".")[0]) for place, term in self.made.acting.items()}
        causes |= {id(term): None for term in self.made.acting.values() if type(term).energy is not Term.energy}
        for key, law in self._laws.items():
            of_law = law.law.cause if isinstance(law, LawTerm) else LAWS[type(self.made.scene.joint_laws[key])]
            causes[id(law)] = of_law
        taken: list[tuple[str | None, Array]] = []
        if self.made.links is not None:
            taken += _of_beams(machine.beams, self.measured[0])
        drag, at = machine.drag, found.at
        for cause, factor, rates in (
            (Cause.EXTERNAL_DRAG, drag.external, at.rates),
            (Cause.RELATIVE_DRAG, drag.relative, at.own),
        ):
            taken.append((cause, factor * machine.inertia.taken(at, rates)[:, None]))
        taken += [(causes[id(term)], here.power) for term, here in self._acting]
        for name, power in taken:
            if name is not None and power.any():
                by_cause[name] = by_cause.get(name, 0.0) - power.sum(axis=1)
        return by_cause

    # ---- springs and dampers ----
    @property
    def _acting(self) -> list[tuple[Term, Measured]]:
        own = {id(term) for term in self.made.acting.values()}
        return [x for x in zip(self.motion.machine.terms, self.measured) if id(x[0]) in own]

    def springs(self) -> Variables:
        """Give tensions of springs and dampers, or the moments with which they turn the bodies of a joint back."""
        scene, found = self.made.scene, Variables()
        stresses = {id(term): here.response.stress[:, 0, 0] for term, here in self._acting}
        for kind, parts in (("spring", scene.springs), ("damper", scene.dampers)):
            if parts:
                each = [stresses[id(self.made.acting[f"{kind}s.{name}"])] for name in parts]
                found[f"{kind}_force"] = (("theta", kind), np.stack(each, axis=1))
        return found

    def laws(self) -> dict[str, Array]:
        """Give what each law exerts on the second body of its joint ``(instants,)``: of a bushing the force's size."""
        found = {}
        for name, term in self._laws.items():
            if isinstance(term, LawTerm):
                here, alone = self.motion.of_term(term), term.law.joint.name in self.made.scene.open_joints
                found[name] = term.size(self.motion.t, here.x, here.rate, alone)
            else:
                stress = self.motion.of_term(term).response.stress[:, 0]
                found[name] = -stress[:, 0] if stress.shape[1] == 1 else norms(stress[:, :2])
        return found

    def depths(self) -> dict[str, Array]:
        """Give the largest indentation of each law of contact ``(instants,)`` (m or rad), negative where it is open."""
        terms = {name: term for name, term in self._laws.items() if isinstance(term, LawTerm) and term.contacts}
        found = {name: (term, self.motion.of_term(term)) for name, term in terms.items()}
        return {name: term.depths(here.x, here.rate)[0].max(axis=0) for name, (term, here) in found.items()}

    @property
    def _laws(self) -> dict[str, Term]:
        """Terms of laws of joints: those of gears and cams have one for each of both joints."""
        own = ((place.partition("."), term) for place, term in self.made.acting.items())
        return {name: term for (table, _, name), term in own if table == "joint_laws"}

    def _of_springs(self) -> Iterator[tuple[str, Array, Array]]:
        """Give springs and dampers on the ground: force and couple on it ``(instants, 3)``, and where they act."""
        machine = self.motion.machine
        for group, term in zip(machine.groups, machine.terms):
            place = next((place for place, own in self.made.acting.items() if own is term), "")
            kind, _, name = place.partition(".")
            if kind not in SUPPORTING or machine.ground not in group.pose[0]:
                continue
            if isinstance(term, LawTerm):
                if -1 in term.law.joint.bodies and not term.law.joint.elsewhere:
                    body = max(term.law.joint.bodies)
                    on = self.motion.of_term(term).response.stress[:, body]
                    yield f"{SUPPORTING[kind]} {name}", on, self.motion.of_end(term.pairs[body][1])[0]
                continue
            side = int(group.pose[0, 1] == machine.ground)
            yield f"{SUPPORTING[kind]} {name}", self._on_end(term, side), self.motion.of_end(term.pairs[0][side])[0]

    def _on_end(self, term: Term, side: int) -> Array:
        """Give force and couple of a term of one element on one of its ends, about it ``(instants, 3)`` (N, N m)."""
        number, end = self.motion.machine.terms.index(term), term.pairs[0][side]
        here, group = self.motion.found.terms[number], self.motion.machine.groups[number]
        force, couple = group.on_ends(np.einsum("tekn,tek->ten", here.gradient, here.response.stress))
        force, couple = -force[:, 0, side], -couple[:, 0, side]
        arm = self.motion.of_end(end)[0] - self.motion.found.at.r[:, end.pose]
        about_end = couple - (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0])[:, None]
        return np.concatenate([force, about_end], axis=1)


SUPPORTING = {"springs": "spring", "dampers": "damper", "joint_laws": "joint law"}  # names of supports, by table
LAWS = {
    Friction: Cause.FRICTION,
    JointEffort: Cause.EFFORTS,
    Bushing: Cause.BUSHINGS,
}  # of laws
CAUSES = {
    "loads": Cause.LOADS,
    "dampers": Cause.DAMPERS,
    "damping": Cause.AIR_DRAG,
    "effects": Cause.LOADS,
}  # by table; springs store


def _of_beams(beams: Beams, here: Measured) -> Iterator[tuple[str, Array]]:
    """Give the power that beams take for good, by cause ``(instants, parts)`` each."""
    viscous = beams.damping[:, None] * np.einsum("eij,tej->tei", beams.stiffness, here.rate)
    yield Cause.MATERIAL, np.sum(viscous * here.rate, axis=2)
    if here.modes is not None:
        yield Cause.MODAL_DAMPING, np.einsum("temk,tem->tk", here.modes, here.rate) ** 2


@dataclass(frozen=True)
class OfRigid(OfPoses):
    """A motion of rigid links at some instants, in the chart itself."""

    angle: Array  # angles of the links, whole turns and all ``(instants, links)`` (rad)
    turned: Array  # drive angles ``(instants,)`` (rad)

    def links(self) -> LinkMotion:
        """Give the motion of the links' frames."""
        return replace(super().links(), angle=self.angle)

    @cached_property
    def theta(self) -> Array:
        """Drive angles (rad)."""
        return self.turned

    def powers(self) -> dict[str, Array]:
        """Give what drives, weight, loads and damping give to the machine ``(instants,)`` (W)."""
        found = super().powers()
        if any(self.made.scene.gravity):
            drive = next(iter(found))
            found = {drive: found[drive], Cause.WEIGHT: power_of_weight(self.motion)} | found
        return found
