"""A member as its ways to fail see it: stresses and forces over the cycle, its section, and a change of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.recovery.faces import Face, faces_of
from fenics_mech.recovery.peaks import curves_over_cycle
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.signal import last_cycle
from fenics_mech.safety.shapes import Enlarged, enlarged, shape_of
from fenics_mech.safety.side_buckling import between_joints
from fenics_mech.scene import Material, Member, Scene, Section


@dataclass(frozen=True)
class Loaded:
    """A member under its loads."""

    label: str  # label, member: its label and what the scene says of it
    member: Member
    result: Result
    enlarged: Enlarged = field(default_factory=Enlarged)  # A change of its section, under the same loads
    cycles: float | None = None  # cycles of the machine under these loads in its life, where its load cases tell them

    @property
    def scene(self) -> Scene:
        """The scene of the result."""
        return self.result.scene

    @property
    def theta(self) -> Array:
        """Drive angles of the positions (rad), ``(angles,)``."""
        return np.asarray(self.result.data["theta"].to_numpy())

    @property
    def stations(self) -> Array:
        """Places along the member, 0..1, ``(stations,)``."""
        return np.asarray(self.result.data["s"].to_numpy())

    def _of(self, name: str, *dims: str) -> Array:
        return np.asarray(self.result.data[name].sel(member=self.label).transpose("theta", "s", *dims).to_numpy())

    @property
    def normal(self) -> Array:
        """Axial force (N), ``(angles, stations)``."""
        return self._of("axial_force")

    @property
    def moment(self) -> Array:
        """Bending moment (N m), ``(angles, stations)``."""
        return self._of("moment")

    @property
    def deflection(self) -> Array:
        """Size of the elastic displacement (m), ``(angles, stations)``."""
        return np.asarray(np.linalg.norm(self._of("deflection", "component"), axis=-1))

    @cached_property
    def axial_and_bending(self) -> tuple[Array, Array]:
        """Stress of both outer fibres by the axial force and by bending (Pa), ``(angles, stations, fibres)`` each."""
        fibres = [str(fibre) for fibre in self.result.data["fibre"].to_numpy()]
        order = [fibres.index(fibre) for fibre in "+-"]
        stress = self._of("stress", "fibre")[..., order]
        modulus = self.scene.rigidity(self.label, self.stations).modulus
        axial = self._of("strain_axial")[..., None] * modulus
        change = self.enlarged
        return axial / change.area, (stress - axial) * change.fibre / change.inertia

    @cached_property
    def faces(self) -> list[Face]:
        """The faces of its materials."""
        return faces_of(self.member, self.scene.sections[self.member.section], self.scene.materials)

    @property
    def material(self) -> Material | None:
        """Its material, where it has one only."""
        names = {face.material for face in self.faces}
        return self.scene.materials[names.pop()] if len(names) == 1 else None

    @cached_property
    def section(self) -> Section:
        """Its section; a rectangle in place of numbers that are those of one."""
        return shape_of(self.scene.sections[self.member.section])

    @cached_property
    def between_joints(self) -> tuple[float, bool]:
        """Length between the joints beside it (m), and whether one end is free."""
        link = self.scene.members()[self.label][0]
        return between_joints(self.scene, self.result.data, link, self.member.ends)

    @property
    def length(self) -> float:
        """Its own length (m)."""
        return math.dist(*self.scene.member_ends(self.label))

    @property
    def bending(self) -> Array:
        """EI in the plane at its stations (N m^2)."""
        return self.scene.rigidity(self.label, self.stations).bending * self.enlarged.inertia

    @property
    def stretching(self) -> Array:
        """EA at its stations (N)."""
        return self.scene.rigidity(self.label, self.stations).axial * self.enlarged.area

    @cached_property
    def part(self) -> slice | None:
        """Positions that are one cycle; None where there is none."""
        return last_cycle(self.scene.analysis, self.scene.drives, self.result.data)

    def largest(self, values: Array, name: str, signs: tuple[int, ...] = (1, -1)) -> tuple[float, float]:
        """Give the largest value over the positions, and between those of a cycle, and its drive angle (rad)."""
        # values: values at the positions, ``(angles, places)``
        found = [(float((sign * values).max()), self._angle(sign * values)) for sign in signs]
        if self.part is not None:
            curves = curves_over_cycle(self.scene, values[self.part], name)
            theta = self.theta[self.part]
            for sign in signs:
                where, height = curves.highest() if sign > 0 else curves.lowest()
                i = int((sign * height).argmax())
                found.append((float(sign * height[i]), float(theta[0] + where[i] * (theta[1] - theta[0]))))
        return max(found)

    def _angle(self, values: Array) -> float:
        return float(self.theta[int(values.max(axis=1).argmax())])

    def resized(self, key: str, factor: float) -> Loaded:
        """Give it with another section under the same loads."""
        return replace(self, enlarged=enlarged(self.section, key, factor))
