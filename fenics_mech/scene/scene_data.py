"""What a scene file states, by pydantic. All numbers are in SI once read."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.analysis_options import Analysis
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.applied_loads import AnyLoad, Impulse, LineLoad
from fenics_mech.scene.base import SCENE, Name, Part, place_in
from fenics_mech.scene.bodies import Ground, Link, Material, Member, Mesh, Point, PointMass
from fenics_mech.scene.damping_options import Damping
from fenics_mech.scene.design import Design
from fenics_mech.scene.drives import Drive, Drives, common_rate
from fenics_mech.scene.formulas.expression import Jet
from fenics_mech.scene.freedoms import Freedom
from fenics_mech.scene.joint_laws import OPEN, AnyJointLaw
from fenics_mech.scene.joints import Joint, Prismatic, Slot
from fenics_mech.scene.load_case import Cases
from fenics_mech.scene.observations import Measurement, TracedPoint
from fenics_mech.scene.plugged import Tables
from fenics_mech.scene.sections import AnySection, Rigidity, Stock
from fenics_mech.scene.solver_options import SolverOptions
from fenics_mech.scene.springs_dampers import Damper, Spring
from fenics_mech.scene.study import Study
from fenics_mech.scene.tolerance import Tolerance
from fenics_mech.scene.units import Acceleration


class SceneData(Part):
    """The keys of a scene, and what is looked up by them; `Scene` also checks them."""

    name: Annotated[str, Field(max_length=SCENE.longest_name)] = "scene"
    units: tuple[str, ...] = ()
    materials: dict[Name, Material] = Field(default_factory=dict)
    sections: dict[Name, AnySection] = Field(default_factory=dict)
    ground: Ground = Field(default_factory=lambda: Ground(points={}))
    links: Annotated[dict[Name, Link], Field(min_length=1, max_length=SCENE.most_links)]
    joints: dict[Name, Joint] = Field(default_factory=dict)
    masses: dict[Name, PointMass] = Field(default_factory=dict)
    gravity: tuple[Acceleration, Acceleration] = (0.0, 0.0)
    loads: dict[Name, AnyLoad] = Field(default_factory=dict)
    impulses: dict[Name, Impulse] = Field(default_factory=dict)
    springs: dict[Name, Spring] = Field(default_factory=dict)
    dampers: dict[Name, Damper] = Field(default_factory=dict)
    joint_laws: dict[Name, AnyJointLaw] = Field(default_factory=dict)
    drive: Drives = ()
    freedoms: dict[Name, Freedom] = Field(default_factory=dict)
    effects: Literal["auto"] | tuple[str, ...] = ()
    tolerance: Tolerance = None
    damping: Damping = Damping()
    mesh: Mesh = Mesh()
    analysis: Analysis = Analysis()
    measurements: tuple[Measurement, ...] = ()
    points: dict[Name, TracedPoint] = Field(default_factory=dict)
    study: Study | None = None
    design: Design = Design()
    cases: Cases = ()
    petsc: SolverOptions = Field(default_factory=dict)
    plugins: Annotated[dict[str, Any], Tables()] = Field(default_factory=dict)

    def changed(self, values: Mapping[str, Any] | None = None, /, **keys: Any) -> Self:
        """Give a copy of the scene with other values.

        Parameters
        ----------
        values
            New values by dotted path: numbers in SI, texts with a unit, or whole parts.
        **keys
            The same by keys of the scene itself, such as ``effects="auto"``; below them with "__" for the dots.

        Raises
        ------
        SceneError
            When a path does not exist or the new scene is not valid.

        Examples
        --------
        >>> scene = fm.load("demos/four_bar.toml")
        >>> round(scene.changed({"drive.speed": "400 rpm", "analysis.modes": 3}).drive.speed, 3)
        41.888
        """
        data = self.stated_data(by_alias=True)  # so that paths are those of a scene file
        dotted = {key.replace("__", "."): value for key, value in keys.items()} | dict(values or {})
        for path, value in dotted.items():
            place_in(data, path, value)
        return self.read(data)

    def stated_data(self, **options: Any) -> dict[str, Any]:
        """Give plain data, without numbers of mesh and analysis that nobody stated: they are the program's choice."""
        unset = {
            name: set(type(part).model_fields) - part.model_fields_set
            for name, part in (("mesh", self.mesh), ("analysis", self.analysis))
        }
        return self.model_dump(exclude=unset, **options)

    @property
    def answer_units(self) -> AnswerUnits:
        """Units in which answers are printed."""
        return AnswerUnits.of(self.units)

    @property
    def named_effects(self) -> tuple[str, ...]:
        """Effects that the scene lists; none where it leaves the choice to the program."""
        return () if self.effects == "auto" else self.effects

    @property
    def neglected(self) -> float:
        """Share of the strains that ``effects = "auto"`` may neglect: the smallest tolerance of any quantity."""
        return min(self.tolerances.values(), default=SCENE.neglected)

    @property
    def tolerances(self) -> dict[str, float]:
        """Tolerance of each quantity that has one."""
        if self.tolerance is None:
            return {}
        return {"strain": self.tolerance} if isinstance(self.tolerance, float) else self.tolerance

    @property
    def drives(self) -> tuple[Drive, ...]:
        """All drives; the run-up of the first is that of all."""
        return self.drive if isinstance(self.drive, tuple) else (self.drive,)

    @property
    def drives_by_place(self) -> dict[str, Drive]:
        """All drives by their place in the scene."""
        return {
            f"drive.{i}" if isinstance(self.drive, tuple) else "drive": drive for i, drive in enumerate(self.drives)
        }

    @property
    def moved_joints(self) -> tuple[str, ...]:
        """Joints whose angle or stroke says where the linkage is: those of the drives, then those of the freedoms."""
        return (*(drive.joint for drive in self.drives), *self.freedoms)

    @property
    def open_joints(self) -> frozenset[str]:
        """Joints whose constraint is replaced by a clearance or a bushing."""
        return frozenset(law.joint for law in self.joint_laws.values() if isinstance(law, OPEN))

    @property
    def constraints(self) -> dict[str, Joint]:
        """Joints that have one, by name."""
        open_joints = self.open_joints
        return {name: joint for name, joint in self.joints.items() if name not in open_joints}

    @property
    def cycle_rate(self) -> float:
        """Rate of the drive coordinate theta (rad/s); where nothing is driven, of a phase that turns once in all."""
        if not self.drives:
            return 2 * math.pi / (self.analysis.duration or 1.0)
        return common_rate(self.drives)

    @property
    def period(self) -> float:
        """Duration of the cycle that all drives have in common, or of a motion that nothing drives (s)."""
        return 2 * math.pi / abs(self.cycle_rate)

    def coordinate(self, time: Array) -> Jet:
        """Drive coordinate theta (rad), its rate and acceleration, at times (s) from 0 on, ``(times,)``."""
        first = self.drives[0]
        own, share = first.coordinate(time), self.cycle_rate / first.cycle_rate
        return Jet(share * own.value, share * own.first, share * own.second)

    def drive_angles(self, count: int) -> Array:
        """Drive coordinate at equal steps over a cycle, from 0, in the order of time (rad), ``(count,)``."""
        return math.copysign(2 * math.pi, self.cycle_rate) * np.arange(count) / count

    def guide_angle(self, joint: Slot | Prismatic) -> float:
        """Direction (rad) of a guide in its first body's frame: the joint's `angle`, or that of its `member`."""
        if joint.member is None:
            return joint.angle
        link = self.links[joint.bodies[0]]
        (x, y), (x2, y2) = (link.points[end] for end in link.members[joint.member].ends)
        return math.atan2(y2 - y, x2 - x)

    def point(self, name: str) -> tuple[str, Point]:
        """Give the body of a point "body.point", and its coordinates in the body's frame (m)."""
        body, point = name.split(".")
        return body, (self.ground if body == "ground" else self.links[body]).points[point]

    def place(self, at: str) -> tuple[str, Point]:
        """Give body and coordinates (m) of a point "body.point", or of a place "member@0.3" along a member."""
        if "@" not in at:
            return self.point(at)
        label, s = at.split("@")
        (x, y), (x2, y2) = self.member_ends(label)
        return self.members()[label][0], (x + float(s) * (x2 - x), y + float(s) * (y2 - y))

    def loaded_places(self, traced: bool = False) -> dict[str, list[float]]:
        """Places 0 to 1 along members of loads and impulses, and of traced points, ascending, by label."""
        places: dict[str, set[float]] = {}
        for acting in (*self.loads.values(), *self.impulses.values(), *(self.points.values() if traced else ())):
            if not isinstance(acting, LineLoad) and "@" in acting.at:
                label, s = acting.at.split("@")
                places.setdefault(label, set()).add(float(s))
        return {label: sorted(found) for label, found in places.items()}

    def member_ends(self, label: str) -> tuple[Point, Point]:
        """Give both ends (x, y) of a member, by label, in its link's frame (m)."""
        link, member = self.members()[label]
        first, second = (self.links[link].points[end] for end in member.ends)
        return first, second

    def members(self) -> dict[str, tuple[str, Member]]:
        """Give all members as label -> (link, member); the label is the link's name when it has one member."""
        return {
            (link if len(body.members) == 1 else f"{link}.{name}"): (link, member)
            for link, body in self.links.items()
            for name, member in body.members.items()
        }

    def size_at(self, joint: str) -> float:
        """Largest distance between two points of the links at a joint (m)."""
        bodies = (body for body in self.joints[joint].bodies if body != "ground")
        found = [list(self.links[body].points.values()) for body in bodies]
        return max((math.dist(a, b) for points in found for a in points for b in points), default=0.0)

    def drag_width(self, label: str) -> float:
        """Width of a member, by label, by which the air drags it (m); an error where nothing states it."""
        name = self.members()[label][1].section
        for part in (self.damping.air, self.sections[name]):
            for quantity in ("width", "diameter"):
                if value := getattr(part, quantity, None):
                    return float(value)
        hint = "Give `width` here, that of the members across the plane"
        raise SceneError(
            f"section {name!r} of member {label} has no width by which the air drags it", place="damping.air", hint=hint
        )

    def rigidity(self, label: str, s: Array) -> Rigidity:
        """Stiffness, mass and fibres of a member, by label, at places ``(places,)``, 0..1 along it."""
        member = self.members()[label][1]
        return self.sections[member.section].rigidity(s, self._stock(member)).moved(member.offset)

    def rigidities(self, s: Array) -> list[Rigidity]:
        """Stiffness, mass and fibres of every member at places ``(places,)``, 0..1 along it."""
        return [self.rigidity(label, s) for label in self.members()]

    def shear_stiffness(self, label: str, s: Array) -> Array:
        """G A_s (N) of a member, by label, at places ``(places,)``, 0..1 along it; an error where it is not stated."""
        member = self.members()[label][1]
        return self.sections[member.section].shear_stiffness(s, self._stock(member), f"sections.{member.section}")

    def _stock(self, member: Member) -> Stock:
        """What the section of a member draws on."""
        name = member.material
        return Stock(None if name is None else self.materials[name], self.materials, self.sections)
