"""Sections whose neutral line and centre of mass are beside the member's axis, on which pins, welds and loads are.

An element's functions are those of its neutral line, where axial force and bending do not mix: its nodes are joined to
the member's axis by rigid arms. The mass moves as the centre of mass of its section does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.shapes import AXIAL
from fenics_mech.errors import SceneError
from fenics_mech.scene.joints import members_under_pins

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh
    from fenics_mech.scene import Member
    from fenics_mech.scene.joints import Joint
    from fenics_mech.scene.sections import Rigidity

    Rigidities = Callable[[str, Array], Rigidity]  # of a member, by label, at places 0..1 along it
    Members = Mapping[str, tuple[str, Member]]  # link and member, by label


@dataclass(frozen=True)
class Offsets:
    """Places along the members' normals (m), ``(elements,)`` each."""

    neutral: Array  # of the neutral line, from the member's axis
    mass: Array  # of the centre of mass, from the neutral line

    @classmethod
    def of(cls, mesh: BeamMesh, rigidity: Rigidities, members: Members, joints: Mapping[str, Joint]) -> Offsets | None:
        """Find the offsets of the members' sections; None where there is none."""
        lines = np.array([_lines(rigidity, label) for label in mesh.members]).reshape(-1, 2)
        if not lines.any():
            return None
        neutral, centre = lines[mesh.cell_member].T
        _refuse_travelling(rigidity, members, joints)
        return cls(neutral, centre - neutral)

    @property
    def arms(self) -> Array:
        """From nodal displacements of the axis to those of the neutral line, ``(elements, 6, 6)``."""
        arms = np.tile(np.eye(6), (len(self.neutral), 1, 1))
        arms[:, AXIAL, [2, 5]] = -self.neutral[:, None]
        return arms


def _lines(rigidity: Rigidities, label: str) -> tuple[float, float]:
    """Places of the neutral line and of the centre of mass of a member from its axis (m), the same all along it."""
    here = rigidity(label, np.zeros(1))
    return float(here.neutral[0]), float(here.mass_centre[0])


def refuse_offsets(rigidity: Rigidities, members: Members, effect: str) -> None:
    """Raise `SceneError` where a section has offsets that an effect does not know."""
    for label, (link, member) in members.items():
        neutral, centre = _lines(rigidity, label)
        if neutral or centre:
            raise SceneError(
                f"the neutral line of section {member.section!r} is {neutral:.4g} m, and its centre of mass "
                f"{centre:.4g} m, beside the axis of member {label}. The effect {effect!r} does not know that",
                place=f"links.{link}.members" if member.offset else f"sections.{member.section}",
                hint=f"Leave the effect out, or {_remedy(member, neutral_only=False)}",
            )


def _remedy(member: Member, neutral_only: bool) -> str:
    """Say which key puts the neutral line, or both lines, on the axis."""
    if member.offset:
        return "leave out the member's offset"
    return "give the section axis = 'neutral'" if neutral_only else "take a symmetric section"


def _refuse_travelling(rigidity: Rigidities, members: Members, joints: Mapping[str, Joint]) -> None:
    """Raise `SceneError` where a pin travels along a member whose neutral line is beside its axis."""
    for name, label in members_under_pins(joints, members).items():
        if neutral := _lines(rigidity, label)[0]:
            raise SceneError(
                f"a pin travels along member {label}, and the neutral line of its section "
                f"{members[label][1].section!r} is {neutral:.4g} m beside the member's axis",
                place=f"joints.{name}.member",
                hint=f"Let no pin travel along it, or {_remedy(members[label][1], neutral_only=True)}",
            )
