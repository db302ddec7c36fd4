"""How far an answer may be trusted: axial forces against the Euler load, bow against length, rotations."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fenics_mech.errors import SolverError
from fenics_mech.forces.section_forces import MemberState
from fenics_mech.mechanism import System
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class ValidityLimits:
    """How far the theories hold."""

    euler_ratio: float = 0.05  # beyond it the axial force changes the bending by more than about as much
    bow: float = 0.02  # of the length; beyond it bending shortens a member noticeably
    rotation: float = 1.3  # rad; there 8 elements give a cantilever's tip to 1e-4, and at 90 degrees the strain ends
    acting: float = 0.1  # rad, of an axis that a motor or a travelling pin takes as straight
    farthest: float = 1.0  # rad, or of the length; a cantilever's end at 1 rad in linear theory turns by 0.78


VALIDITY = ValidityLimits()


def refuse_far(scene: Scene, system: System, members: MemberState) -> None:
    """Raise `SolverError` where deflections are far beyond small ones, unless the scene lets them pass."""
    if scene.analysis.allow_large:
        return
    if system.terms.law is not None:
        _refuse_turned(scene, system, members)
        return
    lengths = np.array([math.dist(*scene.member_ends(label)) for label in scene.members()])
    moved = np.linalg.norm(members.deflection - members.deflection[:, :, :1], axis=-1).max(axis=2) / lengths
    turned = np.abs(members.rotation).max(axis=2)
    if not max(turned.max(), moved.max()) > VALIDITY.farthest:
        return
    k, i = np.unravel_index(np.maximum(turned, moved).argmax(), turned.shape)
    raise SolverError(
        f"elastic deflection turns member {list(scene.members())[i]!r} by {turned[k, i]:.3g} rad and moves its points "
        f"by {moved[k, i]:.3g} of its length, at drive angle {np.degrees(system.motion.theta[k]):.6g} deg. The theory "
        f"of small deflections does not hold near {VALIDITY.farthest:g}. "
        "Lower loads or speed, keep away from resonances, buckling and dead centres, or take stiffer members or more "
        "damping; analysis.allow_large lets it pass"
    )


def _refuse_turned(scene: Scene, system: System, members: MemberState) -> None:
    """Raise `SolverError` where an axis turns by more than exact strains allow."""
    turned = np.abs(members.rotation).max(axis=2)
    if turned.max() > VALIDITY.rotation:
        k, i = np.unravel_index(turned.argmax(), turned.shape)
        raise SolverError(
            f"elastic deflection turns the axis of member {list(scene.members())[i]!r} by {turned[k, i]:.3g} rad, at "
            f"drive angle {np.degrees(system.motion.theta[k]):.6g} deg: strains are good up to {VALIDITY.rotation:g} "
            "rad. Lower loads or speed, keep away from resonances, or take stiffer members; analysis.allow_large lets "
            "it pass"
        )
    largest = dict(zip(scene.members(), turned.max(axis=0)))
    for what, labels in _acting_on_rotations(scene):
        label = max(labels, key=largest.__getitem__, default=None)
        if label is not None and largest[label] > VALIDITY.acting:
            raise SolverError(
                f"{what} acts on member {label!r}, whose axis turns by up to {largest[label]:.3g} rad. Forces on "
                f"rotations are taken with the axis straight, and are good up to {VALIDITY.acting:g} rad. Lower loads "
                "or speed, or take stiffer members; analysis.allow_large lets it pass"
            )


def _acting_on_rotations(scene: Scene) -> Iterator[tuple[str, list[str]]]:
    """Name what acts on the rotation of axes as if they were straight, and the members that it may act on."""
    of_link = {link: [label for label, (of, _) in scene.members().items() if of == link] for link in scene.links}
    for drive in scene.drives:
        if drive.motor is not None:
            links = (point.split(".")[0] for point in scene.joints[drive.joint].connect)
            yield f"the motor of joint {drive.joint!r}", [label for link in links for label in of_link.get(link, [])]
    for name, joint in scene.joints.items():
        if getattr(joint, "member", None) is not None:
            yield f"the pin of joint {name!r}", of_link[joint.connect[0].split(".")[0]]


def euler_ratio(scene: Scene, members: MemberState) -> np.ndarray:
    """Largest axial force over the Euler load pi^2 EI/L^2 of each member, in tension or compression, ``(members,)``."""
    lengths = np.array([math.dist(*scene.member_ends(label)) for label in scene.members()])
    stiffness = np.array([scene.rigidity(label, members.s).bending.min() for label in scene.members()])
    euler = np.pi**2 * stiffness / lengths**2
    return np.abs(members.axial_force).max(axis=(0, 2)) / euler


def bow(scene: Scene, members: MemberState) -> np.ndarray:
    """Largest distance of each member's axis from its chord, over its length, ``(members,)``."""
    lengths = np.array([math.dist(*scene.member_ends(label)) for label in scene.members()])
    s = members.s[:, None]
    chord = (1 - s) * members.deflection[:, :, :1] + s * members.deflection[:, :, -1:]
    return np.linalg.norm(members.deflection - chord, axis=-1).max(axis=(0, 2)) / lengths


def largest_rotation(members: MemberState) -> np.ndarray:
    """Largest rotation of each member's axis from its rigid position (rad), ``(members,)``."""
    return np.abs(members.rotation).max(axis=(0, 2))
