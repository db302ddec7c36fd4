"""A linkage in space: links drawn in place, joints with their axes, beams with two bending stiffnesses and torsion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, model_validator

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.applied_loads import OverCycle
from fenics_mech.scene.base import SCENE, Name, Part, PointName, check_known, check_texts, place_in
from fenics_mech.scene.bodies import MESH, Material
from fenics_mech.scene.damping_options import Ratios
from fenics_mech.scene.drives import Drive, Drives, common_rate
from fenics_mech.scene.sections.plain import ISection, Positive, RectangleSection, RoundSection, TubeSection
from fenics_mech.scene.springs_dampers import HingeDamper, HingeSpring, LineDamper, LineSpring
from fenics_mech.scene.units import (
    Acceleration,
    Angle,
    AngularSpeed,
    Area,
    Force,
    Inertia,
    Length,
    Mass,
    Rate,
    SecondMoment,
    SectionModulus,
    Time,
    Torque,
    Viscosity,
)

Place = tuple[Length, Length, Length]
Way = tuple[float, float, float]
NAME = r"[A-Za-z_][A-Za-z0-9_\-]*"
AtPlace = Annotated[str, Field(pattern=rf"^{NAME}(\.{NAME})?(@(0?\.\d+|[01](\.0*)?))?$")]
GAP = 1e-6  # of the machine's size, by which points of a joint may miss each other: digits of a written coordinate
PARALLEL = 1e-6  # sine of the angle between two directions that are to differ
NEAR = 1e-4  # of a member's length between places along it: 1e-5 loses its bending to rounding
MEETING = ("revolute", "ball", "universal", "weld")  # kinds whose two points are one
WITH_AXIS = ("revolute", "cylinder", "slider", "slot", "plane")
TURNING = ("revolute", "cylinder", "plane")  # kinds with an angle, which a drive, a spring or a damper may take
SLIDING = ("cylinder", "slider", "slot")  # kinds with a stroke


class SpatialCustomSection(Part):
    """A section in space that is given by its numbers.

    Parameters
    ----------
    area
        A (m^2).
    inertia
        Second moments of area (m^4): of bending along the member's `up`, and across it.
    torsion
        Torsion constant (m^4): the moment of a twist per length, over the shear modulus.
    fibre
        Distances of the outer fibres from the centroid (m), along `up` and across it.
    torsion_modulus
        Torque over the largest shear stress that it makes (m^3); without it no shear stress is told.

    Examples
    --------
    >>> fm.SpatialCustomSection(
    ...     area="28 mm^2", inertia=("114.3 mm^4", "37.3 mm^4"), torsion="96 mm^4", fibre=("3.5 mm", "2 mm")
    ... ).fibre
    (0.0035, 0.002)
    """

    shape: Literal["custom"] = "custom"
    area: Annotated[Area, Positive]
    inertia: tuple[Annotated[SecondMoment, Positive], Annotated[SecondMoment, Positive]]
    torsion: Annotated[SecondMoment, Positive]
    fibre: tuple[Annotated[Length, Positive], Annotated[Length, Positive]]
    torsion_modulus: Annotated[SectionModulus, Positive] | None = None


class SpatialPolygonSection(Part):
    """A section of any shape: its numbers come from a finite-element solution of its torsion and from its corners.

    Parameters
    ----------
    outline
        Corners (m): along `up`, and across it, 90 degrees from `up` about the member's axis. Their centroid lies on the
        axis, wherever the origin is.
    holes
        Corners of each hole (m).

    Examples
    --------
    >>> len(fm.SpatialPolygonSection(outline=((0, 0), (0, "9 mm"), ("6 mm", 0))).outline)
    3
    """

    shape: Literal["polygon"] = "polygon"
    outline: Annotated[tuple[tuple[Length, Length], ...], Field(min_length=3, max_length=1000)]
    holes: Annotated[tuple[tuple[tuple[Length, Length], ...], ...], Field(max_length=20)] = ()


SpatialSection = Annotated[
    Annotated[SpatialCustomSection, Tag("custom")]
    | Annotated[SpatialPolygonSection, Tag("polygon")]
    | Annotated[RectangleSection, Tag("rectangle")]
    | Annotated[RoundSection, Tag("round")]
    | Annotated[TubeSection, Tag("tube")]
    | Annotated[ISection, Tag("I")],
    Discriminator(
        lambda value: value.get("shape", "custom") if isinstance(value, dict) else getattr(value, "shape", None),
        custom_error_type="unknown_shape",
        custom_error_message="in space there is no such shape of section; known are custom, polygon, rectangle, round, "
        "tube and I",
    ),
]


class SpatialMember(Part):
    """A straight beam between two points of its link in space.

    Parameters
    ----------
    ends
        Names of the two points.
    section, material
        Names of its section and its material.
    up
        Direction of the section's height in the drawn position; its part across the member counts. It may be left out
        where the section bends alike in all directions.
    elements
        Its own number of elements, instead of the scene's.

    Examples
    --------
    >>> fm.SpatialMember(ends=("A", "B"), section="rod", material="steel", up=(0, 0, 1)).up
    (0.0, 0.0, 1.0)
    """

    ends: tuple[Name, Name]
    section: Name
    material: Name
    up: Way | None = None
    elements: Annotated[int, Field(ge=1, le=MESH.most_elements)] | None = None


class SpatialBody(Part):
    """Inertia of a rigid link in space.

    Parameters
    ----------
    mass
        Mass (kg).
    inertia
        Moments of inertia about the centre of mass, about X, Y and Z in the drawn position (kg m^2).
    products
        Products of inertia, the sums of m x y, m x z and m y z (kg m^2).
    centre
        Centre of mass in the drawn position (m).

    Examples
    --------
    >>> fm.SpatialBody(mass=2.0, inertia=(0.1, 0.1, 0.2), centre=(0, 0, "30 mm")).centre
    (0.0, 0.0, 0.03)
    """

    mass: Annotated[Mass, Field(ge=0)] = 0.0
    inertia: tuple[Inertia, Inertia, Inertia] = (0.0, 0.0, 0.0)
    products: tuple[Inertia, Inertia, Inertia] = (0.0, 0.0, 0.0)
    centre: Place = (0.0, 0.0, 0.0)

    @property
    def second_moments(self) -> Array:
        """Sums of m x_i x_j about the centre of mass ``(3, 3)`` (kg m^2)."""
        xy, xz, yz = self.products
        half = sum(self.inertia) / 2
        return np.array(
            [
                [half - self.inertia[0], xy, xz],
                [xy, half - self.inertia[1], yz],
                [xz, yz, half - self.inertia[2]],
            ]
        )

    @model_validator(mode="after")
    def _has_mass_somewhere(self) -> Self:
        moments = self.second_moments
        if np.linalg.eigvalsh(moments).min() < -1e-12 * np.abs(moments).max():
            raise ValueError(
                f"no body has the moments of inertia {list(self.inertia)} kg m^2: each is at most the sum of the others"
            )
        return self


class SpatialLink(Part):
    """A moving link in space, drawn in its place: named points (m), and beams between them or a rigid body.

    Parameters
    ----------
    points
        Points X, Y, Z in the drawn position of the machine, which is its start. A point of a joint has the same place
        in all its links.
    members
        Beams, by name. They are welded where they share a point.
    rigid
        Inertia of a link that does not bend, instead of members.

    Examples
    --------
    >>> rod = fm.SpatialMember(ends=("A", "B"), section="rod", material="steel")
    >>> list(fm.SpatialLink(points={"A": (0, 0, 0), "B": (0, 0, "0.3 m")}, members={"AB": rod}).members)
    ['AB']
    """

    points: Annotated[dict[Name, Place], Field(min_length=1)]
    members: dict[Name, SpatialMember] = Field(default_factory=dict)
    rigid: SpatialBody | None = None

    @model_validator(mode="after")
    def _bends_or_is_rigid(self) -> Self:
        if bool(self.members) == (self.rigid is not None):
            raise ValueError("a link needs either members or `rigid`, not both")
        return self


class SpatialGround(Part):
    """The fixed frame in space.

    Parameters
    ----------
    points
        Coordinates X, Y, Z (m) of its points, by name.

    Examples
    --------
    >>> fm.SpatialGround(points={"O": (0, 0, 0), "Q": (0.3, 0.1, "5 cm")}).points["Q"]
    (0.3, 0.1, 0.05)
    """

    points: dict[Name, Place]


class Misalignment(Part):
    """An error of making: the axis of the joint's second link is turned against that of the first.

    Parameters
    ----------
    about
        Direction about which it is turned, in the drawn position.
    by
        Angle (rad).

    Examples
    --------
    >>> round(fm.Misalignment(about=(0, 1, 0), by="5 deg").by, 4)
    0.0873
    """

    about: Way
    by: Annotated[Angle, Field(gt=-math.pi / 2, lt=math.pi / 2)]


class SpatialJoint(Part):
    """A joint of two links in space.

    Parameters
    ----------
    connect
        A point of each, "link.point" or "ground.point".
    kind
        "revolute" turns about its axis, "ball" in all directions, "universal" about two axes; "cylinder" turns about
        and slides along its axis, "slider" slides along it, "slot" guides a ball along it, "plane" slides across it
        and turns; "weld" holds.
    axis
        Direction of the axis in the drawn position; of a plane its normal.
    axes
        Of a universal joint: the direction that is fixed in the first link, and the one that is fixed in the second.
    misaligned
        How the second link's axis is turned against the first's.

    Examples
    --------
    >>> fm.SpatialJoint(connect=("ground.O", "crank.O"), axis=(0, 0, 1)).kind
    'revolute'
    """

    connect: tuple[PointName, PointName]
    kind: Literal["revolute", "ball", "universal", "cylinder", "slider", "slot", "plane", "weld"] = "revolute"
    axis: Way | None = None
    axes: tuple[Way, Way] | None = None
    misaligned: Misalignment | None = None

    @model_validator(mode="after")
    def _has_its_axes(self) -> Self:
        if self.kind in WITH_AXIS and self.axis is None:
            raise ValueError(f"a {self.kind} joint in space needs its direction: write axis = [0, 0, 1], for example")
        if self.kind == "universal" and self.axes is None:
            raise ValueError(
                "a universal joint needs both axes: write axes = [[0, 0, 1], [1, 0, 0]], the first fixed in the first "
                "link, the second in the second"
            )
        if (self.axis is not None and self.kind not in WITH_AXIS) or (
            self.axes is not None and self.kind != "universal"
        ):
            raise ValueError(f"a {self.kind} joint has no such direction: leave `axis` or `axes` out")
        if self.misaligned is not None and self.kind == "ball":
            raise ValueError("a ball has no axis that could lean: leave `misaligned` out")
        for way in (self.axis, *(self.axes or ()), None if self.misaligned is None else self.misaligned.about):
            if way is not None and not any(way):
                raise ValueError("a direction of three zeros is none")
        if self.axes is not None:
            one, other = (np.array(way) / np.linalg.norm(way) for way in self.axes)
            if abs(one @ other) > PARALLEL**0.5:
                raise ValueError(
                    f"both axes of a universal joint are at a right angle, as those of its cross are, and these are at "
                    f"{math.degrees(math.acos(np.clip(one @ other, -1, 1))):.4g} deg"
                )
        return self


class SpatialMass(Part):
    """A mass at a point of a link.

    Parameters
    ----------
    at
        The point, "link.point", or a place along a member, such as "coupler@0.5".
    mass
        Mass (kg).

    Examples
    --------
    >>> fm.SpatialMass(at="crank.A", mass="45 g").mass
    0.045
    """

    at: AtPlace
    mass: Annotated[Mass, Field(ge=0)]


class SpatialForce(Part):
    """A force that keeps its direction.

    Parameters
    ----------
    at
        The point, "link.point", or a place along a member, such as "coupler@0.5".
    force
        Force along X, Y and Z (N).
    factor
        What it is multiplied by over the cycle.

    Examples
    --------
    >>> fm.SpatialForce(at="arm.B", force=(0, 0, "-20 N")).force
    (0.0, 0.0, -20.0)
    """

    at: AtPlace
    force: tuple[Force, Force, Force]
    factor: Annotated[OverCycle, Field(discriminator="kind")] | None = None


class SpatialTorque(Part):
    """A torque or a force at a joint, on its second link and opposite on its first.

    Parameters
    ----------
    joint
        A joint that turns about an axis, or slides along it.
    torque
        About the axis (N m).
    push
        Along the axis (N).
    factor
        What it is multiplied by over the cycle.

    Examples
    --------
    >>> fm.SpatialTorque(joint="Q", torque="2 N m").torque
    2.0
    """

    joint: Name
    torque: Torque = 0.0
    push: Force = 0.0
    factor: Annotated[OverCycle, Field(discriminator="kind")] | None = None


class PointDamper(Part):
    """A damper from a point to the fixed frame, alike in all directions.

    Parameters
    ----------
    at
        The point, "link.point", or a place along a member, such as "coupler@0.5".
    damping
        Force over velocity (N s/m).

    Examples
    --------
    >>> fm.PointDamper(at="rocker@0.5", damping="0.3 N s/m").damping
    0.3
    """

    at: AtPlace
    damping: Annotated[Viscosity, Field(gt=0)]


def _by_key(*keys: str) -> Any:
    """Tell tables apart by the first of some keys that they have."""
    return lambda value: next(
        (key for key in keys if (key in value if isinstance(value, dict) else hasattr(value, key))), keys[-1]
    )


SpatialLoad = Annotated[
    Annotated[SpatialTorque, Tag("joint")] | Annotated[SpatialForce, Tag("at")], Discriminator(_by_key("joint", "at"))
]
SpatialSpring = Annotated[
    Annotated[HingeSpring, Tag("joint")] | Annotated[LineSpring, Tag("between")],
    Discriminator(_by_key("joint", "between")),
]
SpatialDamper = Annotated[
    Annotated[HingeDamper, Tag("joint")] | Annotated[PointDamper, Tag("at")] | Annotated[LineDamper, Tag("between")],
    Discriminator(_by_key("joint", "at", "between")),
]


class SpatialDamping(Part):
    """Damping of the elastic motion in space; what is stated adds up.

    Parameters
    ----------
    ratio
        Damping ratio of all modes, or one per mode (the last holds for the rest), of a periodic motion.
    material
        Retardation time of the material (s): its stress is the modulus times the strain plus this times its rate.
    external
        Drag of the surroundings on the velocity, in proportion to the mass (1/s).
    relative
        The same on the velocity relative to the rigid motion (1/s).

    Examples
    --------
    >>> fm.SpatialDamping(material="0.5 ms").material
    0.0005
    """

    ratio: Ratios = 0.0
    material: Annotated[Time, Field(ge=0)] = 0.0
    external: Annotated[Rate, Field(ge=0)] = 0.0
    relative: Annotated[Rate, Field(ge=0)] = 0.0


class SpatialMesh(Part):
    """Elements of the members in space.

    Parameters
    ----------
    elements
        Of every member that states none of its own.

    Examples
    --------
    >>> fm.SpatialMesh().elements
    4
    """

    elements: Annotated[int, Field(ge=1, le=MESH.most_elements)] = 4


class SpatialAnalysis(Part):
    """What is asked of a machine in space, and how finely.

    Parameters
    ----------
    method
        "periodic" finds the motion that repeats every cycle, "quasi-static" the equilibrium at each position with the
        inertia of the rigid motion, "static" the one at the drawn position, at rest. "transient" follows the motion in
        time from the drawn position, with the velocities of rigid links.
    positions
        Positions of the cycle at which results are given, and steps in which it is solved; or even instants.
    duration
        Of a motion in time (s).
    start_speeds
        Of a motion in time: angular speeds of joints at its start, by name (rad/s). What neither a drive nor these lead
        starts as slowly as it can.
    time_tolerance
        Of a motion in time: largest error of a coordinate in a step, over the size of the machine.
    stations
        Places along each member at which results are given.
    modes
        Natural frequencies that are given.
    multipliers
        Floquet multipliers that are given; 0 leaves stability out.
    error_estimates
        Whether the errors by mesh and steps are estimated, which takes two solutions more.
    allow_unstable
        Whether a periodic motion that small disturbances leave is an answer.

    Examples
    --------
    >>> fm.SpatialAnalysis(positions=90).method
    'periodic'
    """

    method: Literal["periodic", "quasi-static", "static", "transient"] = "periodic"
    positions: Annotated[int, Field(ge=8, le=100_000)] = 60
    duration: Annotated[Time, Field(gt=0)] | None = None
    start_speeds: dict[Name, AngularSpeed] = Field(default_factory=dict)
    time_tolerance: Annotated[float, Field(gt=0, le=1e-2)] = 1e-6
    stations: Annotated[int, Field(ge=2, le=SCENE.most_stations)] = 11
    modes: Annotated[int, Field(ge=0, le=200)] = 6
    multipliers: Annotated[int, Field(ge=0, le=50)] = 4
    error_estimates: bool = True
    allow_unstable: bool = False

    @model_validator(mode="after")
    def _is_timed(self) -> Self:
        if (self.method == "transient") != (self.duration is not None):
            raise ValueError('a motion in time needs its duration: method = "transient" and `duration` stand together')
        if self.start_speeds and self.method != "transient":
            raise ValueError('`start_speeds` are of a motion in time: write method = "transient"')
        return self


class SpatialScene(Part):
    """A linkage in space, how it is driven and how it is to be analysed. A scene file has the same keys.

    A scene whose points have three coordinates is one in space. All links are drawn in one position of the machine.

    Parameters
    ----------
    name
        What the linkage is called in plots and reports.
    units
        Units of printed answers, such as ("in", "psi", "lbf"); by default mm, MPa, N and so on.
    materials, sections
        By name; members refer to them.
    ground
        The fixed frame with its points.
    links, joints
        By name.
    masses, loads, springs, dampers
        By name.
    gravity
        Acceleration along X, Y and Z (m/s^2).
    drive
        One drive, or several; none where nothing moves the linkage. A drive begins at the drawn position.
    damping, mesh, analysis
        Damping of the elastic motion, elements of the members, and what is asked.

    Examples
    --------
    >>> scene = fm.load("demos/space/rssr.toml")
    >>> list(scene.members())
    ['crank', 'coupler', 'rocker']
    """

    name: Annotated[str, Field(max_length=SCENE.longest_name)] = "scene"
    units: tuple[str, ...] = ()
    materials: dict[Name, Material] = Field(default_factory=dict)
    sections: dict[Name, SpatialSection] = Field(default_factory=dict)
    ground: SpatialGround = Field(default_factory=lambda: SpatialGround(points={}))
    links: Annotated[dict[Name, SpatialLink], Field(min_length=1, max_length=SCENE.most_links)]
    joints: dict[Name, SpatialJoint] = Field(default_factory=dict)
    masses: dict[Name, SpatialMass] = Field(default_factory=dict)
    gravity: tuple[Acceleration, Acceleration, Acceleration] = (0.0, 0.0, 0.0)
    loads: dict[Name, SpatialLoad] = Field(default_factory=dict)
    springs: dict[Name, SpatialSpring] = Field(default_factory=dict)
    dampers: dict[Name, SpatialDamper] = Field(default_factory=dict)
    drive: Drives = ()
    damping: SpatialDamping = SpatialDamping()
    mesh: SpatialMesh = SpatialMesh()
    analysis: SpatialAnalysis = SpatialAnalysis()

    @model_validator(mode="before")
    @classmethod
    def _texts_are_printable(cls, data: Any) -> Any:
        check_texts(data)
        return data

    @model_validator(mode="after")
    def _is_consistent(self) -> Self:
        _check_members(self)
        _check_joints(self)
        _check_acting(self)
        return self

    def changed(self, values: Mapping[str, Any] | None = None, /, **keys: Any) -> SpatialScene:
        """Give a copy of the scene with other values.

        Parameters
        ----------
        values
            New values by dotted path: numbers in SI, texts with a unit, or whole parts.
        **keys
            The same by keys of the scene itself; below them with "__" for the dots.

        Raises
        ------
        SceneError
            When a path does not exist or the new scene is not valid.

        Examples
        --------
        >>> fm.load("demos/space/rssr.toml").changed({"mesh.elements": 6}).mesh.elements
        6
        """
        data = self.model_dump(by_alias=True)
        dotted = {key.replace("__", "."): value for key, value in keys.items()} | dict(values or {})
        for path, value in dotted.items():
            place_in(data, path, value)
        return self.read(data)

    @property
    def answer_units(self) -> AnswerUnits:
        """Units in which answers are printed."""
        return AnswerUnits.of(self.units)

    @property
    def drives(self) -> tuple[Drive, ...]:
        """All drives."""
        return self.drive if isinstance(self.drive, tuple) else (self.drive,)

    @property
    def cycle_rate(self) -> float:
        """Rate of the drive coordinate theta (rad/s); 2 pi where nothing is driven."""
        return common_rate(self.drives) if self.drives else 2 * math.pi

    @property
    def period(self) -> float:
        """Duration of the cycle that all drives have in common (s)."""
        return 2 * math.pi / abs(self.cycle_rate)

    @property
    def size(self) -> float:
        """Largest distance between points along an axis (m)."""
        places = [*self.ground.points.values(), *(p for link in self.links.values() for p in link.points.values())]
        return float(np.ptp(np.array(places), axis=0).max())

    def members(self) -> dict[str, tuple[str, SpatialMember]]:
        """Give all members as label -> (link, member); the label is the link's name when it has one member."""
        return {
            (link if len(body.members) == 1 else f"{link}.{name}"): (link, member)
            for link, body in self.links.items()
            for name, member in body.members.items()
        }

    def point(self, name: str) -> tuple[str, Place]:
        """Give the body of a point "body.point", and its place in the drawn position (m).

        Parameters
        ----------
        name
            Its name.
        """
        body, point = name.split(".")
        return body, (self.ground if body == "ground" else self.links[body]).points[point]

    def places_inside(self) -> dict[str, list[float]]:
        """Places 0 to 1 along members where something acts, ascending, by the members' labels."""
        found: dict[str, set[float]] = {}
        for part in (*self.masses.values(), *self.loads.values(), *self.dampers.values()):
            at = getattr(part, "at", "")
            if "@" in at:
                label, s = at.split("@")
                found.setdefault(label, set()).add(float(s))
        return {label: sorted(places) for label, places in found.items()}


def is_spatial(data: Any) -> bool:
    """Say whether plain data of a scene is of one in space: a point has three coordinates.

    Parameters
    ----------
    data
        What a scene file holds.
    """

    def triple(body: Any) -> bool:
        points = body.get("points") if isinstance(body, dict) else None
        return isinstance(points, dict) and any(isinstance(p, list | tuple) and len(p) == 3 for p in points.values())

    if not isinstance(data, dict):
        return False
    links = data.get("links")
    return triple(data.get("ground")) or (isinstance(links, dict) and any(map(triple, links.values())))


def _check_members(scene: SpatialScene) -> None:
    """Raise `SceneError` where a member names what there is not, has no length, or its `up` lies along it."""
    for name, link in scene.links.items():
        for label, member in link.members.items():
            place = f"links.{name}.members.{label}"
            for end in member.ends:
                check_known(end, link.points, "point", f"{place}.ends", f" of link {name}")
            check_known(member.section, scene.sections, "section", f"{place}.section")
            check_known(member.material, scene.materials, "material", f"{place}.material")
            first, last = (np.array(link.points[end]) for end in member.ends)
            length = float(np.linalg.norm(last - first))
            if length <= GAP * scene.size:
                raise SceneError("both ends of the member are at one place", place=f"{place}.ends")
            section = scene.sections[member.section]
            alike = isinstance(section, RoundSection | TubeSection) or (
                isinstance(section, RectangleSection) and section.width == section.height
            )
            if member.up is None and not alike:
                raise SceneError(
                    f"section {member.section!r} does not bend alike in all directions, and the member does not say "
                    "how it stands",
                    place=place,
                    hint="Add up = [0, 0, 1], the direction of the section's height",
                )
            if member.up is not None:
                across = np.cross(member.up, (last - first) / length)
                if np.linalg.norm(across) <= PARALLEL * max(float(np.linalg.norm(member.up)), 1e-300):
                    raise SceneError(
                        f"the direction {list(member.up)} of the section's height is none, or lies along the member",
                        place=f"{place}.up",
                        hint="Give one across the member",
                    )


def _check_joints(scene: SpatialScene) -> None:
    """Raise `SceneError` where a joint names points that there are not, or that do not meet."""
    for name, joint in scene.joints.items():
        place = f"joints.{name}"
        for point in joint.connect:
            body, own = point.split(".")
            check_known(body, ["ground", *scene.links], "link", f"{place}.connect")
            points = (scene.ground if body == "ground" else scene.links[body]).points
            check_known(own, points, "point", f"{place}.connect", f" of {body}")
        (one, first), (other, last) = map(scene.point, joint.connect)
        if one == other:
            raise SceneError(f"both points are of {one}", place=f"{place}.connect", hint="Name two bodies")
        way = np.array(last) - np.array(first)
        if joint.kind in MEETING:
            gap, what = float(np.linalg.norm(way)), "are at one place"
        else:
            n = np.array(joint.axis) / np.linalg.norm(joint.axis)  # type: ignore[arg-type]
            along = float(way @ n)
            gap, what = (
                (abs(along), "lie in one plane across the axis")
                if joint.kind == "plane"
                else (float(np.linalg.norm(way - along * n)), "lie on one line along the axis")
            )
        if gap > GAP * scene.size:
            raise SceneError(
                f"the points {joint.connect[0]} and {joint.connect[1]} of a {joint.kind} joint {what}, and they miss "
                f"each other by {gap:.6g} m",
                place=f"{place}.connect",
                hint="In space all links are drawn in one position of the machine: give both the same coordinates",
            )


def _check_acting(scene: SpatialScene) -> None:
    """Raise `SceneError` where a mass, load, spring, damper or drive is at a place or joint that there is not."""
    members = scene.members()
    for table in ("masses", "loads", "dampers", "springs"):
        for name, part in getattr(scene, table).items():
            place = f"{table}.{name}"
            if (at := getattr(part, "at", None)) is not None:
                if "@" in at:
                    check_known(at.split("@")[0], members, "member", f"{place}.at")
                else:
                    _check_point(scene, at, f"{place}.at")
            for point in getattr(part, "between", ()):
                _check_point(scene, point, f"{place}.between")
            if between := getattr(part, "between", ()):
                first, last = (np.array(scene.point(point)[1]) for point in between)
                if np.linalg.norm(last - first) <= GAP * scene.size:
                    raise SceneError(
                        f"the points {between[0]} and {between[1]} are at one place, and what acts along a line "
                        "between them has no direction",
                        place=f"{place}.between",
                        hint="Name two places, or a joint for what acts about its axis",
                    )
            if (joint := getattr(part, "joint", None)) is not None:
                check_known(joint, scene.joints, "joint", f"{place}.joint")
                needed = SLIDING if getattr(part, "push", 0.0) else TURNING
                _check_freedom(scene, joint, needed, f"{place}.joint")
                if isinstance(part, SpatialTorque) and bool(part.torque) == bool(part.push):
                    raise SceneError("a load at a joint has either a torque or a push", place=place)
    for label, inside in scene.places_inside().items():
        places = np.unique([0.0, *inside, 1.0])
        if (gaps := np.diff(places)).min() < (1 - GAP) * NEAR:
            k = int(np.argmin(gaps))
            raise SceneError(
                f"the places {places[k]:.12g} and {places[k + 1]:.12g} along member {label} are {gaps[k]:.3g} of its "
                f"length apart, and an element between them is stiff beyond rounding: expected {NEAR:g} at least",
                place="links",
                hint="Name one place for both, or the member's end",
            )
    driven: set[str] = set()
    for number, drive in enumerate(scene.drives):
        place = "drive" if len(scene.drives) == 1 else f"drive.{number}"
        check_known(drive.joint, scene.joints, "joint", f"{place}.joint")
        _check_freedom(scene, drive.joint, (*TURNING, *SLIDING), f"{place}.joint")
        if drive.motor is not None or drive.run_up is not None or drive.start:
            raise SceneError(
                "a drive in space has no motor, no run-up and no start: it begins at the drawn position", place=place
            )
        if drive.joint in driven:
            raise SceneError(f"joint {drive.joint!r} is driven twice", place=f"{place}.joint")
        driven.add(drive.joint)
    for joint in scene.analysis.start_speeds:
        place = f"analysis.start_speeds.{joint}"
        check_known(joint, scene.joints, "joint", place)
        _check_freedom(scene, joint, TURNING, place)
        if joint in driven:
            raise SceneError(f"joint {joint!r} is driven, which gives its speed", place=place)
    if scene.damping.ratio and scene.analysis.method == "transient":
        raise SceneError(
            "damping ratios are those of modes about a cycle, which a motion in time in space does not have",
            place="damping.ratio",
            hint="State damping.material or damping.external",
        )
    if scene.analysis.method not in ("static", "transient") and not scene.drives:
        raise SceneError(
            f"a {scene.analysis.method} answer needs a drive, and the scene has none: there is no cycle",
            place="analysis.method",
            hint="Add a [drive], or write method = 'static'",
        )


def _check_point(scene: SpatialScene, at: str, place: str) -> None:
    body, dot, point = at.partition(".")
    check_known(body, ["ground", *scene.links], "link", place)
    if not dot:
        raise SceneError(f"{at!r} names a link and no point", place=place, hint="Write it as 'link.point'")
    check_known(point, (scene.ground if body == "ground" else scene.links[body]).points, "point", place, f" of {body}")


def _check_freedom(scene: SpatialScene, joint: str, kinds: tuple[str, ...], place: str) -> None:
    kind = scene.joints[joint].kind
    if kind not in kinds:
        raise SceneError(
            f"joint {joint!r} is a {kind} joint, which has no such freedom: expected {', '.join(kinds)}", place=place
        )
