"""What a mechanism is made of: materials, meshes, members, links, the ground, and masses at points."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations, pairwise
from typing import Annotated

import numpy as np
from pydantic import ConfigDict, Field

from fenics_mech._arrays import Array
from fenics_mech.scene.base import Name, Part, PointName
from fenics_mech.scene.design import Across, Notch, Surface
from fenics_mech.scene.units import Angle, Density, Inertia, Length, Mass, Modulus

Point = tuple[Length, Length]
POISSON = 0.3  # of materials that state none: metals have 0.25 to 0.35, which changes G by 4 %


class StressLife(Part):
    """A stress-life (S-N) curve by Basquin: ``N = cycles (range / S)^slope`` for a stress range S.

    Parameters
    ----------
    range
        Stress range (Pa), from the least to the largest stress, that is borne `cycles` times.
    cycles
        Number of cycles at that range.
    slope
        Exponent of the curve.
    limit
        Stress range (Pa) up to which a cycle does no damage.
    ultimate
        Tensile strength (Pa). With it a tensile mean stress lowers what is borne, by Goodman's line.

    Examples
    --------
    >>> curve = fm.StressLife(range="90 MPa", cycles=2e6, slope=5)
    >>> float(curve.damage(180e6, 0.0)) * 2e6
    32.0
    """

    range: Annotated[Modulus, Field(gt=0)]
    cycles: Annotated[float, Field(gt=0, le=1e15)] = 2e6
    slope: Annotated[float, Field(ge=1, le=50)] = 5.0
    limit: Annotated[Modulus, Field(ge=0)] = 0.0
    ultimate: Annotated[Modulus, Field(gt=0)] | None = None

    def damage(self, ranges: Array | float, mean: Array | float) -> Array:
        """Damage of cycles by stress range and mean (Pa), 1 over the number borne; infinite at the strength."""
        ranges, mean = np.asarray(ranges, dtype=float), np.asarray(mean, dtype=float)
        if self.ultimate is not None:
            left = 1 - np.clip(mean, 0, None) / self.ultimate
            with np.errstate(divide="ignore", invalid="ignore"):
                ranges = np.where(left > 0, ranges / left, np.inf)
        return np.where(ranges > self.limit, (ranges / self.range) ** self.slope / self.cycles, 0.0)


class Material(Part):
    """Young's modulus E (Pa) and density rho (kg/m^3); for the effect `shear` one of the next two.

    Parameters
    ----------
    modulus, density
        E (Pa), rho (kg/m^3).
    shear_modulus
        G (Pa); without it E/(2 (1 + poisson)).
    poisson
        Poisson's ratio. It also enters the shear factors of the sections. Where neither is stated, the effect `shear`
        takes 0.3, and the result has a notice of it.
    strength
        Allowed stress (Pa): the result says how far it is used, and warns where an outer fibre exceeds it.
    yield_, ultimate
        Yield and tensile strength (Pa) ("yield" and "ultimate" in a scene file), by which the verdict judges members.
    fatigue
        Stress-life curve, by which `fenics-mech fatigue` tells how long members last. The verdict takes it in place of
        an endurance limit.
    surface
        How members are finished, on which their endurance depends: "ground", "machined", "hot-rolled" or "as-forged";
        by default "machined", which also stands for cold-drawn.

    Examples
    --------
    >>> fm.Material(modulus="71 GPa", density=2714, strength="250 MPa").modulus
    71000000000.0
    """

    model_config = ConfigDict(populate_by_name=True)
    modulus: Annotated[Modulus, Field(gt=0)]
    density: Annotated[Density, Field(gt=0)]
    shear_modulus: Annotated[Modulus, Field(gt=0)] | None = None
    poisson: Annotated[float, Field(gt=-1, le=0.5)] | None = None
    strength: Annotated[Modulus, Field(gt=0)] | None = None
    yield_: Annotated[Annotated[Modulus, Field(gt=0)] | None, Field(alias="yield")] = None
    ultimate: Annotated[Modulus, Field(gt=0)] | None = None
    fatigue: StressLife | None = None
    surface: Surface | None = None

    def _check_keys(self) -> None:
        if self.yield_ is not None and self.ultimate is not None and self.ultimate < self.yield_:
            raise ValueError(
                f"the tensile strength is not below the yield strength: expected ultimate >= {self.yield_:g} Pa, "
                f"found {self.ultimate:g} Pa"
            )

    @property
    def shear_unstated(self) -> bool:
        """Whether it states neither its shear modulus nor Poisson's ratio."""
        return self.shear_modulus is None and self.poisson is None

    @property
    def shear_poisson(self) -> float:
        """Poisson's ratio in shear factors: as stated, 0 beside a shear modulus alone, and otherwise that of metals."""
        return POISSON if self.shear_unstated else self.poisson or 0.0

    @property
    def rigidity(self) -> float:
        """Shear modulus G (Pa), stated or of an isotropic material."""
        return self.modulus / (2 * (1 + self.shear_poisson)) if self.shear_modulus is None else self.shear_modulus


@dataclass(frozen=True)
class MeshLimits:
    """Limits of the meshes of members. Those of a ratio are of the longest element of a member over the shortest."""

    most_elements: int = 20_000  # in a member
    most_unreduced: int = 300  # measured: relative strain error 4e-10 with 30, 5e-7 with 100, 6e-5 with 300
    most_refined: int = 1_000_000  # in a refined scene
    largest_ratio: float = 1e10  # measured where members are reduced: quasi-static strains to 1e-13
    largest_unreduced_ratio: float = 1e3  # rounding changes strains by 1e-5 there
    closest: float = 1e-3  # of a member's length, between places at which loads need a node
    short: float = 0.35  # of an element, between its end and a load, up to which it carries the load inside
    just_before: float = 1e-15  # of an element, by which a load acts before a station at its place, as at a node
    past_end: float = 1e-9  # of a member's length, by which a pin may leave it
    same_place: float = 1e-6  # of a link's size, between points that are one: digits to which drawings are written


MESH = MeshLimits()


class Mesh(Part):
    """How a member is cut into elements.

    Parameters
    ----------
    elements
        Number of elements per member.
    grading
        Length of each element over that of the element before it.
    stations
        Instead of the two above: the nodes, as increasing numbers from 0 to 1 along the member.

    Examples
    --------
    >>> round(fm.Mesh(elements=4, grading=2).ratio, 6)
    8.0
    """

    elements: Annotated[int, Field(ge=1)] = 3
    grading: Annotated[float, Field(gt=0)] = 1.0
    stations: tuple[float, ...] | None = None

    def _check_keys(self) -> None:
        nodes = self.stations
        if self.count > MESH.most_elements:
            raise ValueError(f"{self.count} elements in one member, and at most {MESH.most_elements} are taken")
        if nodes is not None:
            if len(nodes) < 2 or nodes[0] != 0 or nodes[-1] != 1 or any(b <= a for a, b in pairwise(nodes)):
                raise ValueError(f"stations must increase from 0 to 1, found {list(nodes)}")
            if self.elements != 3 or self.grading != 1:
                raise ValueError("give either stations, or elements and grading, not both")
        if self.ratio > MESH.largest_ratio * (1 + 1e-9):
            raise ValueError(
                f"the longest element of a member is {self.ratio:.3g} times as long as the shortest: beyond "
                f"{MESH.largest_ratio:g} the strains would be lost to rounding"
            )

    @property
    def count(self) -> int:
        """Number of elements."""
        return self.elements if self.stations is None else len(self.stations) - 1

    @property
    def ratio(self) -> float:
        """Length of the longest element over that of the shortest."""
        if self.stations is None:
            return math.exp(min(abs(math.log(self.grading)) * (self.elements - 1), 700.0))
        lengths = [b - a for a, b in pairwise(self.stations)]
        return max(lengths) / min(lengths)


class Member(Part):
    """A straight beam between two points of its link.

    The member's axis runs from its first to its second point; its normal is 90 degrees counter-clockwise of it.

    Parameters
    ----------
    ends
        Names of the two points of the link.
    section
        Name of its section, in the scene's `sections`.
    material
        Name of its material; a section that names the materials of its parts needs none.
    mesh
        Its own mesh, instead of the scene's.
    offset
        How far its section is beside the line through its two points (m), + towards the normal. Pins, welds and loads
        are on that line, and what joins them to the section is rigid. A beam that is pinned at its lower face has half
        its height.
    notches
        Places where its stress is raised, in fatigue.
    across
        How its ends are held across the plane of motion, where it may buckle: "pinned", which is the default, or
        "clamped", as by forks on stiff pins.

    Examples
    --------
    >>> fm.Member(ends=("A", "B"), section="strip", material="steel").ends
    ('A', 'B')
    """

    ends: tuple[Name, Name]
    section: Name
    material: Name | None = None
    mesh: Mesh | None = None
    offset: Length = 0.0
    notches: tuple[Notch, ...] = ()
    across: Across | None = None


class Ground(Part):
    """The fixed frame.

    Parameters
    ----------
    points
        Coordinates X, Y (m) of its points, by name.

    Examples
    --------
    >>> fm.Ground(points={"O": (0, 0), "C": ("10 in", 0)}).points["C"]
    (0.254, 0.0)
    """

    points: dict[Name, Point]


class RigidBody(Part):
    """Inertia of a rigid link.

    Parameters
    ----------
    mass
        Mass (kg).
    inertia
        Moment of inertia about the centre of mass (kg m^2).
    centre
        Centre of mass in the link's frame (m).

    Examples
    --------
    >>> fm.RigidBody(mass="0.4 kg", inertia=1e-4).centre
    (0.0, 0.0)
    """

    mass: Annotated[Mass, Field(ge=0)] = 0.0
    inertia: Annotated[Inertia, Field(ge=0)] = 0.0
    centre: Point = (0.0, 0.0)


class Link(Part):
    """A moving link: named points in its own frame (m), and the beams between them.

    Parameters
    ----------
    points
        Points in the link's frame, whose origin moves with the link. Where it has members, each is at an end of one.
        Several points may be at one place: each joint there has its own.
    members
        Beams, by name. They are welded where they share a point.
    rigid
        Inertia of a link that does not bend, instead of members.
    angle
        Rough angle of the link's x axis at the start of the cycle (rad). It chooses the assembly branch. Where no rough
        angles lead to one, all are searched for, and a warning says which is taken and how to choose another.
    position
        Rough place of the link's origin at the start (m); without it, the joints and angles give one.

    Examples
    --------
    >>> bar = fm.Member(ends=("A", "B"), section="strip", material="steel")
    >>> list(fm.Link(points={"A": (0, 0), "B": ("0.3 m", 0)}, members={"AB": bar}).members)
    ['AB']
    """

    points: Annotated[dict[Name, Point], Field(min_length=1)]
    members: dict[Name, Member] = Field(default_factory=dict)
    rigid: RigidBody | None = None
    angle: Angle = 0.0
    position: Point | None = None

    def _check_keys(self) -> None:
        if bool(self.members) == (self.rigid is not None):
            raise ValueError("a link needs either members or `rigid`, not both")

    def end_at(self, point: str) -> str | None:
        """Name of the member's end at the place of a point of the link; itself where it is an end, None without one."""
        ends = [end for member in self.members.values() for end in member.ends]
        if point in ends:
            return point
        near = MESH.same_place * max(math.dist(*pair) for pair in combinations(self.points.values(), 2))
        return next((end for end in ends if math.dist(self.points[end], self.points[point]) <= near), None)


class PointMass(Part):
    """A mass fixed to a point of a link; it turns with the link.

    Parameters
    ----------
    at
        The point, as "link.point".
    mass
        Mass (kg).
    inertia
        Moment of inertia about the point (kg m^2).

    Examples
    --------
    >>> fm.PointMass(at="crank.A", mass="45 g").mass
    0.045
    """

    at: PointName
    mass: Annotated[Mass, Field(ge=0)] = 0.0
    inertia: Annotated[Inertia, Field(ge=0)] = 0.0
