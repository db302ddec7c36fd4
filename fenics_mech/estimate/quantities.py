"""Quantities whose errors are estimated: strains, deflections, joint forces, and the efforts of drives."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech._constants import TINY
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import Joint, effort_units, joint_names
from fenics_mech.scene.sections import Rigidity


@dataclass(frozen=True)
class MeasureLimits:
    """What the errors of quantities are measured by, where their own largest values are small."""

    small_member: float = 0.1  # of the mechanism's largest value: a member's own must be that to measure its error
    small_effort: float = 0.01  # of the largest joint force, at the link's size: an effort must be that to do the same
    small_force: float = 0.01  # of the force that bends members as they are bent: joints must carry that for the same
    small_power: float = 1e-6  # of the mean magnitude of a power: below it its mean is nothing, as without losses


MEASURE = MeasureLimits()

ERROR_VARIABLES = {  # by quantity: its variable, the prefix of its relative errors (strains have none), its dimension
    "strain": ("strain", "", "member"),
    "deflection": ("deflection", "deflection_", "member"),
    "joint_force": ("joint_force", "joint_force_", "joint"),
    "torque": ("drive_effort", "drive_effort_", "drive"),
}


class Quantities(NamedTuple):
    """What is compared between two motions of a mechanism, or the difference of it."""

    # axial, bending: strain of the axis, ``(angles, members, stations)``, and by bending of both fibres, with another
    # axis of 2
    axial: Array
    bending: Array
    deflection: Array  # in the fixed frame (m), ``(angles, members, stations, 2)``
    force: Array  # in the joints (N), ``(angles, joints, 2)``
    effort: Array  # of the drives (N m, or N along a slide), ``(angles, drives)``

    def minus(self, other: Quantities) -> Quantities:
        """Give the difference of two motions."""
        return Quantities(*(mine - theirs for mine, theirs in zip(self, other)))

    @property
    def largest(self) -> dict[str, Array]:
        """Largest magnitude of each quantity over the drive angles, ``(members, joints or drives,)``."""
        sizes = {
            "strain": (np.abs(self.axial) + np.abs(self.bending).max(axis=-1)).max(axis=2),
            "deflection": norms(self.deflection).max(axis=2),
            "joint_force": norms(self.force),
            "torque": np.abs(self.effort),
        }
        return {name: size.max(axis=0, initial=0.0) for name, size in sizes.items()}


def places_of(members: Iterable[str], joints: Mapping[str, Joint], moved: Sequence[str]) -> dict[str, list[str]]:
    """Give the members, joints or drives that each quantity belongs to."""
    labels = list(members)
    return {
        "strain": labels,
        "deflection": labels,
        "joint_force": joint_names(joints),
        "torque": list(moved),
    }


def measures(scene: Scene, largest: dict[str, Array]) -> dict[str, Array]:
    """Give the values that errors are relative to, by quantity."""
    # Strains and deflections are measured by the largest of their member, or by `MEASURE.small_member` of the
    # mechanism's where that is more. Joint forces are measured by the largest of all joints, or by
    # `MEASURE.small_force` of the force that bends members to their strains: joints may carry moments alone. Efforts
    # of drives are measured by the largest of the drives that have the same unit. Where the mechanism is balanced
    # that is next to nothing, and the measure is `MEASURE.small_effort` of the largest joint force, times the size of
    # the driven link for a torque.
    lengths = [math.dist(*scene.member_ends(label)) for label in scene.members()]
    bent = MEASURE.small_force * _bending_force(scene.rigidities(np.array([0.5])), lengths, largest.get("strain", ()))
    force = max(float(largest["joint_force"].max(initial=0.0)), bent, TINY)
    of_members: dict[str, Array] = {  # none of rigid links
        name: np.maximum(np.maximum(largest[name], MEASURE.small_member * largest[name].max()), TINY)
        for name in ("strain", "deflection")
        if name in largest
    }
    return {
        **of_members,
        "joint_force": np.full_like(largest["joint_force"], force),
        "torque": measures_of_efforts(scene, largest["torque"], force),
    }


def measures_of_efforts(scene: Scene, largest: Array, force: float) -> Array:
    """Give the values that errors of efforts are relative to; see `measures`."""
    # largest: the largest of each drive and freedom (N m, or N along a slide), ``(moved joints,)``; force: the
    # largest joint force (N)
    sliding = np.array([unit == "N" for unit in effort_units(scene.moved_joints, scene.joints)], dtype=bool)
    arms = np.array([scene.size_at(joint) for joint in scene.moved_joints])
    arms[arms == 0] = arms.max(initial=0.0) or 1.0  # of links that have one point alone (m)
    efforts = np.zeros(len(sliding))
    for same in (sliding, ~sliding):
        efforts[same] = largest[same].max(initial=0.0)
    return np.maximum(efforts, np.maximum(MEASURE.small_effort * force * np.where(sliding, 1.0, arms), TINY))


def _bending_force(sections: Sequence[Rigidity], lengths: Sequence[float], strain: Iterable[float]) -> float:
    """Largest force across a member, at its end, that bends it to its largest strain (N): ``strain EI/(c L)``."""
    arms = [np.abs(section.fibre).max() * length for section, length in zip(sections, lengths)]
    forces = [size * section.bending[0] / max(arm, TINY) for size, section, arm in zip(strain, sections, arms)]
    return float(max(forces, default=0.0))
