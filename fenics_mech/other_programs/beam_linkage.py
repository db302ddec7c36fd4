"""A linkage as beams between joints, in plain numbers: what a program for multibody systems is given of a scene.

Beams are straight and uniform, and start at drive angle 0 in the motion of rigid links. Nothing here needs another
program.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import Revolute, Slot

End = tuple[int, int]  # number of a beam, and 0 or -1: its first or its last node


@dataclass(frozen=True)
class Beam:
    """A member at drive angle 0."""

    label: str  # label of the member
    # ends, velocities: places (m) and velocities (m/s) of both ends, ``(2, 2)``
    ends: Array
    velocities: Array
    turning: float  # angular velocity (rad/s)
    # line_density, axial, bending: mass per length (kg/m), EA (N) and EI (N m^2)
    line_density: float
    axial: float
    bending: float
    fibres: Array  # distances of the "+" and "-" fibres from the axis, along the normal (m), ``(2,)``

    @property
    def length(self) -> float:
        """Length (m)."""
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    @property
    def direction(self) -> Array:
        """Unit vector from the first to the second end."""
        return (self.ends[1] - self.ends[0]) / self.length


@dataclass(frozen=True)
class BeamLinkage:
    """Beams and what joins them."""

    beams: tuple[Beam, ...]  # all members
    welds: tuple[tuple[End, End], ...]  # pairs of ends that share their place and turn together
    pins: tuple[tuple[End, End], ...]  # pairs of ends that share their place
    supports: tuple[End, ...]  # ends that stay where they are
    guides: tuple[tuple[End, Array], ...]  # ends that keep their distance from a line, each with the normal of the line
    masses: tuple[tuple[End, float], ...]  # ends with point masses (kg)
    drive: End  # the end whose beam is turned about it at a constant speed; it is one of the supports
    speed: float  # that speed (rad/s)
    retardation: float  # ratio of viscous to elastic moduli of the Kelvin-Voigt material (s)
    joints: tuple[str, ...]  # names of the joints of the pins, then of the supports, then of the guides

    @property
    def period(self) -> float:
        """Time of a cycle (s)."""
        return 2 * math.pi / abs(self.speed)


def with_material_damping(scene: Scene) -> Scene:
    """Give a scene whose damping is of the material alone, which other programs have too."""
    # A ratio of the modes becomes the retardation time that damps the lowest mode of the softest member on two pins
    # by that ratio, ``2 ratio/omega`` with ``omega = (pi/L)^2 sqrt(EI/(rho A))``.
    damping = scene.damping
    if damping.external or damping.relative or damping.air:
        raise SceneError("other programs are given damping of modes or material", place="damping")
    ratio = damping.ratio if isinstance(damping.ratio, float) else damping.ratio[0]
    slowest = 2 * math.pi * min(float(each[0]) for each in simply_supported_frequencies(scene).values())
    return scene.changed(damping={"material": damping.material + 2 * ratio / slowest})


def exported_linkage(scene: Scene) -> BeamLinkage:
    """Give a scene as beams between joints, with the damping that other programs have too."""
    if not scene.members():
        raise SceneError("no link has a member, and other programs are given links that bend", place="links")
    return beam_linkage(with_material_damping(scene))


def beam_linkage(scene: Scene) -> BeamLinkage:
    """Give a scene as beams between joints."""
    _check(scene)
    places = _ends(scene)
    welds = [pair for ends in places.values() for pair in pairwise(ends)]
    pins, supports, guides = dict[tuple[End, End], str](), dict[End, str](), list[tuple[End, Array]]()
    guided = [name for name, joint in scene.joints.items() if isinstance(joint, Slot)]
    for name, joint in scene.joints.items():
        ends = [places[point][0] for point in joint.connect if not point.startswith("ground.")]
        if isinstance(joint, Slot):
            guides.append((ends[0], np.array([-math.sin(joint.angle), math.cos(joint.angle)])))
            continue
        pins |= dict.fromkeys(pairwise(ends), name)
        if len(ends) < len(joint.connect):
            supports[ends[0]] = name
    return BeamLinkage(
        beams=tuple(_beams(scene)),
        welds=tuple(welds),
        pins=tuple(pins),
        supports=tuple(supports),
        guides=tuple(guides),
        masses=tuple((places[mass.at][0], mass.mass) for mass in scene.masses.values() if mass.mass),
        drive=places[scene.joints[scene.drives[0].joint].connect[1]][0],
        speed=scene.cycle_rate,
        retardation=scene.damping.material,
        joints=(*pins.values(), *supports.values(), *guided),
    )


def _ends(scene: Scene) -> dict[str, list[End]]:
    """Ends of beams at each point of the links, by "link.point"."""
    found: dict[str, list[End]] = {}
    for number, (link, member) in enumerate(scene.members().values()):
        for which, point in zip((0, -1), member.ends):
            found.setdefault(f"{link}.{point}", []).append((number, which))
    return found


def _beams(scene: Scene) -> Iterator[Beam]:
    motion = solve_motion(scene, np.zeros(1))
    for label, (link, _) in scene.members().items():
        states = [motion.of_point(link, end) for end in scene.member_ends(label)]
        section = scene.rigidity(label, np.array([0.5]))
        yield Beam(
            label=label,
            ends=np.stack([place[0] for place, _, _ in states]),
            velocities=np.stack([velocity[0] for _, velocity, _ in states]),
            turning=float(motion.omega[0, motion.links.index(link)]),
            line_density=float(section.line_density[0]),
            axial=float(section.axial[0]),
            bending=float(section.bending[0]),
            fibres=section.fibre[0],
        )


def _check(scene: Scene) -> None:
    """Refuse what there are no beams and joints for."""
    places = _ends(scene)
    for name, link in scene.links.items():
        if link.rigid is not None or any(f"{name}.{point}" not in places for point in link.points):
            raise SceneError("other programs are given links of beams between their points", place=f"links.{name}")
    for label, (_, member) in scene.members().items():
        section = scene.rigidity(label, np.array([0.5]))
        if not scene.sections[member.section].constant or section.neutral.any() or section.mass_centre.any():
            raise SceneError("other programs are given uniform beams about their axis", place=f"links.{label}")
    for name, joint in scene.joints.items():
        grounded = [point for point in joint.connect if point.startswith("ground.")]
        guide = isinstance(joint, Slot) and joint.connect[0] in grounded and len(grounded) == 1
        if not (guide or (isinstance(joint, Revolute) and len(grounded) < 2)):
            raise SceneError("other programs are given pins, and guides of the ground", place=f"joints.{name}")
    for name, mass in scene.masses.items():
        if mass.inertia or mass.at not in places:
            raise SceneError("other programs are given masses of links, without inertia", place=f"masses.{name}")
    for name in ("loads", "impulses", "springs", "dampers", "gravity"):
        stated = getattr(scene, name)
        if any(stated):
            raise SceneError(f"other programs are given no {name}", place=name)
    drive = scene.drives[0] if len(scene.drives) == 1 else None
    driven = scene.joints[drive.joint] if drive else None
    turned = isinstance(driven, Revolute) and len(driven.connect) == 2 and driven.connect[0].startswith("ground.")
    if drive is None or drive.speed is None or drive.motor is not None or not turned:
        raise SceneError("other programs are given one drive, at constant speed, from the ground", place="drive")
