"""How far an answer may be trusted: axial forces against the Euler load, bow against length, rotations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech.errors import SolverError
from fenics_mech.forces.section_forces import MemberState
from fenics_mech.mechanism import System
from fenics_mech.scene import Drive, Member, Scene
from fenics_mech.scene.joints import Joint
from fenics_mech.scene.sections import Rigidity


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
    """Raise `SolverError` where deflections are far beyond small ones, unless the scene lets them pass.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the positions of the result.
    members
        Deflections and rotations there.
    """
    if scene.analysis.allow_large:
        return
    if system.terms.law is not None:
        _refuse_turned(_acting_on_rotations(scene.members(), scene.joints, scene.drives), system, members)
        return
    moved = norms(members.deflection - members.deflection[:, :, :1]).max(axis=2)
    moved = moved / system.beams.mesh.member_length
    turned = np.abs(members.rotation).max(axis=2)
    if not max(turned.max(), moved.max()) > VALIDITY.farthest:
        return
    k, i = np.unravel_index(np.maximum(turned, moved).argmax(), turned.shape)
    raise SolverError(
        f"elastic deflection turns member {system.beams.mesh.members[i]!r} by {turned[k, i]:.3g} rad and moves its "
        f"points by {moved[k, i]:.3g} of its length, at drive angle {np.degrees(system.motion.theta[k]):.6g} deg. "
        f"The theory of small deflections does not hold near {VALIDITY.farthest:g}. "
        "Lower loads or speed, keep away from resonances, buckling and dead centres, or take stiffer members or more "
        "damping; analysis.allow_large lets it pass"
    )


def _refuse_turned(acting: Iterable[tuple[str, list[str]]], system: System, members: MemberState) -> None:
    """Raise `SolverError` where an axis turns by more than exact strains, or what acts on its rotation, allow."""
    turned = np.abs(members.rotation).max(axis=2)
    if turned.max() > VALIDITY.rotation:
        k, i = np.unravel_index(turned.argmax(), turned.shape)
        raise SolverError(
            f"elastic deflection turns the axis of member {system.beams.mesh.members[i]!r} by {turned[k, i]:.3g} rad, "
            f"at drive angle {np.degrees(system.motion.theta[k]):.6g} deg: strains are good up to "
            f"{VALIDITY.rotation:g} rad. Lower loads or speed, keep away from resonances, or take stiffer members. "
            "In statics, cut the member into links at rough angles along its bent shape, which stiff torsional springs "
            "hold in line; analysis.allow_large lets it pass"
        )
    largest = dict(zip(system.beams.mesh.members, turned.max(axis=0)))
    for what, labels in acting:
        label = max(labels, key=largest.__getitem__, default=None)
        if label is not None and largest[label] > VALIDITY.acting:
            raise SolverError(
                f"{what} acts on member {label!r}, whose axis turns by up to {largest[label]:.3g} rad. Forces on "
                f"rotations are taken with the axis straight, and are good up to {VALIDITY.acting:g} rad. Lower loads "
                "or speed, or take stiffer members; analysis.allow_large lets it pass"
            )


def _acting_on_rotations(
    members: Mapping[str, tuple[str, Member]], joints: Mapping[str, Joint], drives: Iterable[Drive]
) -> Iterator[tuple[str, list[str]]]:
    """Name what acts on the rotation of axes as if they were straight, and the members that it may act on."""
    of_link: dict[str, list[str]] = {}
    for label, (link, _) in members.items():
        of_link.setdefault(link, []).append(label)
    for drive in drives:
        if drive.motor is not None:
            links = (point.split(".")[0] for point in joints[drive.joint].connect)
            yield f"the motor of joint {drive.joint!r}", [label for link in links for label in of_link.get(link, [])]
    for name, joint in joints.items():
        if joint.member is not None:
            yield f"the pin of joint {name!r}", of_link[joint.connect[0].split(".")[0]]


def euler_ratio(sections: Sequence[Rigidity], lengths: Array, members: MemberState) -> Array:
    """Largest axial force over the Euler load pi^2 EI/L^2 of each member, in tension or compression, ``(members,)``.

    Parameters
    ----------
    sections
        Stiffness of each member, ``(members,)``.
    lengths
        Their lengths (m), ``(members,)``.
    members
        Their axial forces.
    """
    stiffness = np.array([section.bending.min() for section in sections])
    euler = np.pi**2 * stiffness / lengths**2
    return np.abs(members.axial_force).max(axis=(0, 2)) / euler


def bow(lengths: Array, members: MemberState) -> Array:
    """Largest distance of each member's axis from its chord, over its length, ``(members,)``.

    Parameters
    ----------
    lengths
        Lengths of the members (m), ``(members,)``.
    members
        Their deflections.
    """
    s = members.s[:, None]
    chord = (1 - s) * members.deflection[:, :, :1]
    chord += s * members.deflection[:, :, -1:]
    return norms(np.subtract(members.deflection, chord, out=chord)).max(axis=(0, 2)) / lengths


def largest_rotation(members: MemberState) -> Array:
    """Largest rotation of each member's axis from its rigid position (rad), ``(members,)``.

    Parameters
    ----------
    members
        Rotations of the members.
    """
    return np.abs(members.rotation).max(axis=(0, 2))
