"""What a scene states and hardly means: a wrong unit, a decimal point in a wrong place, an option that changes nothing.

Each check compares one kind of number with what machines have, and says what is likely meant; it refuses nothing. The
limits are wide: what lies beyond them is off by a factor that units explain.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import numpy as np

from fenics_mech._constants import TURN
from fenics_mech.scene.applied_loads import FactorExpression, FactorTable, LineLoad, Pulse
from fenics_mech.scene.bodies import Material
from fenics_mech.scene.models import Scene
from fenics_mech.scene.plausible_limits import USUAL, Found, likely
from fenics_mech.scene.plausible_motion import bending_strain, motion
from fenics_mech.scene.sections import CustomSection, Section
from fenics_mech.scene.springs_dampers import HingeSpring, LineSpring
from fenics_mech.scene.units import OfTurning


def implausible(scene: Scene) -> tuple[str, ...]:
    """Find what a scene states and hardly means: a sentence for each, with the place and the value in SI."""
    found: dict[str, str] = {}  # the first about each place
    groups = (ALONE, *IN_TURN) if scene.members() else ()  # numbers are compared with those of members
    for checks in groups:
        before = len(found)
        with np.errstate(all="ignore"):  # what overflows is beyond any limit
            for place, what in (finding for check in checks for finding in check(scene)):
                found.setdefault(place, what)
        if checks is not ALONE and len(found) > before:
            break
    return tuple(f"{place}: {what}" for place, what in found.items())


def _materials(scene: Scene) -> Found:
    """Compare density, modulus, shear modulus and strength of each material with those of engineering materials."""
    for name, material in scene.materials.items():
        place, e, rho = f"materials.{name}", material.modulus, material.density
        if e > USUAL.stiffest and _only_short(scene, name):
            stands = "where it stands for what does not bend, state a member's `offset`, or a `rigid` link and a weld"
            yield f"{place}.modulus", f"{e:.6g} Pa is the modulus of no engineering material: {stands}"
            continue
        heavy, stiff = USUAL.lightest <= rho <= USUAL.heaviest, USUAL.softest <= e <= USUAL.stiffest
        if not heavy:
            units = (("g/cm^3", 1e3), ("kg/mm^3", 1e9), ("t/mm^3", 1e12), ("g/m^3", 1e-3))
            meant = likely(rho, "kg/m^3", units, 500, USUAL.heaviest)
            yield f"{place}.density", f"{rho:.6g} kg/m^3 is the density of no engineering material{meant}"
        if not stiff:
            units = (("GPa", 1e9), ("MPa", 1e6), ("kPa", 1e3), ("", 1e-6))
            meant = likely(e, "Pa", units, 1e9, USUAL.stiffest)
            yield f"{place}.modulus", f"{e:.6g} Pa is the modulus of no engineering material{meant}"
        speed = math.sqrt(e / rho)
        if heavy and stiff and not USUAL.slowest <= speed <= USUAL.fastest:
            fitting = [e * f for f in (1e6, 1e3, 1e-3) if USUAL.slowest < math.sqrt(e * f / rho) < USUAL.fastest]
            meant = f": {fitting[0]:.4g} Pa may be meant, or a density in another unit" if fitting else ""
            yield (
                f"{place}.modulus",
                f"{e:.6g} Pa with {rho:.6g} kg/m^3 makes a speed of sound of {speed:.3g} m/s, and materials of "
                f"machines have {USUAL.slowest:g} to {USUAL.fastest:g}{meant}",
            )
        yield from _of_shear_and_strength(place, material)


def _only_short(scene: Scene, material: str) -> bool:
    """Whether all members of a material are short beside the longest of another: arms that are made stiff."""
    lengths = _lengths(scene)
    own = [lengths[label] for label, (_, member) in scene.members().items() if member.material == material]
    others = [lengths[label] for label, (_, member) in scene.members().items() if member.material != material]
    return max(own, default=0.0) < USUAL.short_arm * max(others, default=0.0)


def _of_shear_and_strength(place: str, material: Material) -> Found:
    e, g, strength = material.modulus, material.shear_modulus, material.strength
    if g is not None and not USUAL.least_shear <= g / e <= USUAL.largest_shear:
        meant = likely(g, "Pa", (("MPa", 1e6), ("GPa", 1e9), ("", 1e3), ("", 1e-3)), e / 50, e / 2)
        yield f"{place}.shear_modulus", f"{g:.6g} Pa is {g / e:.2g} times Young's modulus{meant}"
    if strength is not None and not USUAL.weakest * e <= strength <= USUAL.strongest:
        meant = likely(strength, "Pa", (("MPa", 1e6), ("kPa", 1e3), ("", 1e-6)), 1e-4 * e, 0.1 * e)
        yield f"{place}.strength", f"{strength:.6g} Pa beside a modulus of {e:.6g} Pa is no strength{meant}"


def _lengths(scene: Scene) -> dict[str, float]:
    """Give the length of every member (m), by label."""
    return {label: math.dist(*scene.member_ends(label)) for label in scene.members()}


def _sections(scene: Scene) -> Found:
    """Look at each section as a rectangle of the same radius of gyration, beside the members that have it."""
    for label, (link, member) in scene.members().items():
        place, length = f"sections.{member.section}", math.dist(*scene.member_ends(label))
        section, rigid = scene.sections[member.section], scene.rigidity(label, np.array([0.5]))
        radius = math.sqrt(float(rigid.bending[0] / rigid.axial[0]))
        height, beside = math.sqrt(12) * radius, f"member {label} is {length:.4g} m long"
        key = _key(section, "height", "diameter", "inertia")
        custom = isinstance(section, CustomSection)
        what = "area and inertia make a section" if custom else "the section is"
        if height < USUAL.thinnest * length:
            yield place + key, f"{what} {height:.3g} m high, as good as nothing, and {beside}"
        elif height > USUAL.highest * length:
            stated = getattr(section, key.removeprefix("."), height) if key in (".height", ".diameter") else height
            least = max(1e-3 * length, USUAL.thinnest_in_mm)
            meant = "" if custom else likely(stated, "m", (("mm", 1e-3),), least, 0.5 * length)
            yield place + key, f"{what} {stated:.4g} m high, and {beside}: it is no beam{meant}"
        width = section.area / height if isinstance(section, CustomSection) else getattr(section, "width", None)
        if width is not None and not USUAL.narrowest <= width / length <= USUAL.widest:
            meant = "" if custom else likely(width, "m", (("mm", 1e-3), ("", 1e3)), 1e-3 * length, length)
            yield place + _key(section, "width", "area"), f"{what} {width:.4g} m wide, and {beside}{meant}"
        outer = float(np.abs(rigid.fibre[0]).max())
        if abs(member.offset) > USUAL.farthest_offset * outer:
            meant = likely(member.offset, "m", (("mm", 1e-3),), 0, USUAL.farthest_offset * outer)
            yield (
                f"links.{link}.members.{label.removeprefix(f'{link}.')}.offset",
                f"the section is {member.offset:.4g} m beside its pins, and {2 * outer:.3g} m high{meant}",
            )
        if custom and not radius * (1 - 1e-3) <= outer <= USUAL.farthest_fibre * radius:
            yield (
                f"{place}.fibre",
                f"the outer fibre is {outer:.4g} m from the neutral line; expected is 1 to {USUAL.farthest_fibre:g} "
                f"times as far as the radius of gyration sqrt(inertia/area), which is {radius:.4g} m",
            )


def _key(section: Section, *names: str) -> str:
    """Give the first of some keys that a section states, after a dot; nothing where it states none."""
    return next((f".{name}" for name in names if name in type(section).model_fields), "")


def _proportions(scene: Scene) -> Found:
    """Compare the longest member with the next, and the shortest."""
    lengths = sorted(_lengths(scene).items(), key=lambda item: item[1])

    def place(label: str) -> str:
        return f"links.{scene.members()[label][0]}.points"

    label, longest = lengths[-1]
    too_long = longest > USUAL.longest
    if too_long:
        meant = likely(longest, "m", (("mm", 1e-3),), 0, USUAL.longest)
        yield place(label), f"member {label} is {longest:.6g} m long{meant}"
    if len(lengths) > 1:
        second, third = lengths[-2][1], lengths[1][1]
        if longest > USUAL.most_alike * second:
            meant = likely(longest, "m", (("mm", 1e-3), ("cm", 1e-2)), second / 10, 10 * second)
            yield (place(label), f"member {label} is {longest:.6g} m long, and the next {second:.4g} m{meant}")
        label, shortest = lengths[0]
        if shortest < USUAL.least_alike * third and not too_long:
            meant = likely(shortest, "m", (("", 1e3), ("", 1e2)), third / 10, 10 * third)
            yield (place(label), f"member {label} is {shortest:.4g} m long, and the next {third:.4g} m{meant}")


def _masses(scene: Scene) -> Found:
    lengths = _lengths(scene)
    reach = max(lengths.values())
    along = np.linspace(0, 1, 11)
    whole = sum(float(scene.rigidity(label, along).line_density.mean()) * lengths[label] for label in lengths)
    for name, point in scene.masses.items():
        if point.mass > USUAL.heaviest_point * whole:
            meant = likely(point.mass, "kg", (("g", 1e-3),), 0, USUAL.heaviest_point * whole)
            yield f"masses.{name}.mass", f"{point.mass:.6g} kg, and all members together have {whole:.3g} kg{meant}"
        yield from _of_inertia(f"masses.{name}.inertia", point.inertia, max(point.mass, whole), reach)
    for name, link in scene.links.items():
        if link.rigid is not None:
            size = max((math.dist(a, b) for a in link.points.values() for b in link.points.values()), default=0.0)
            heavy = max(link.rigid.mass, whole)
            yield from _of_inertia(f"links.{name}.rigid.inertia", link.rigid.inertia, heavy, max(size, reach))
    g = math.hypot(*scene.gravity)
    if g and not USUAL.weak_gravity <= g <= USUAL.strong_gravity:
        meant = likely(g, "m/s^2", (("mm/s^2", 1e-3), ("km/s^2", 1e3)), 1, 30)
        yield "gravity", f"{g:.6g} m/s^2, and the earth's is 9.81{meant}"


def _of_inertia(place: str, inertia: float, mass: float, reach: float) -> Found:
    largest = USUAL.largest_inertia * mass * reach**2
    if inertia > largest:
        meant = likely(inertia, "kg m^2", (("kg cm^2", 1e-4), ("kg mm^2", 1e-6), ("g mm^2", 1e-9)), 0, largest / 100)
        yield place, f"{inertia:.6g} kg m^2 is that of {mass:.3g} kg at {math.sqrt(inertia / mass):.3g} m{meant}"


def _angles(scene: Scene) -> Found:
    """Look for degrees without their unit, which are read as radians."""
    for place, angle in _stated_angles(scene):
        if isinstance(angle, OfTurning):  # its unit is written
            continue
        whole = angle == round(angle) and abs(angle) > USUAL.largest_whole
        if whole or abs(angle) > USUAL.largest_angle * (1 + 1e-9):
            text = f"{angle:.6g} rad are {angle / TURN:.3g} turns"
            yield place, f'{text}: "{angle:.6g} deg" is likely meant, as a number without a unit is in rad'


def _stated_angles(scene: Scene) -> Iterator[tuple[str, float]]:
    """Give angles that lie within a turn or two, with their places."""
    for name, link in scene.links.items():
        yield f"links.{name}.angle", link.angle
    for name, joint in scene.joints.items():
        for key in ("angle", "turn"):
            yield f"joints.{name}.{key}", getattr(joint, key, 0.0)
    for name, load in scene.loads.items():
        place = f"loads.{name}.factor"
        if isinstance(load.factor, Pulse):
            for key in ("start", "end", "ramp"):
                yield f"{place}.{key}", getattr(load.factor, key)
        if isinstance(load.factor, FactorTable):
            yield f"{place}.angles", max(load.factor.angles, key=abs)
    for name, impulse in scene.impulses.items():
        if impulse.angle is not None:
            yield f"impulses.{name}.angle", impulse.angle
    for name, spring in scene.springs.items():
        if isinstance(spring, HingeSpring) and spring.angle is not None:
            yield f"springs.{name}.angle", spring.angle
    for place, drive in scene.drives_by_place.items():
        if not scene.joints[drive.joint].slides:
            yield f"{place}.start", drive.start
    if scene.analysis.method == "static":
        yield "analysis.position", scene.analysis.position


def _pulses(scene: Scene) -> Found:
    """Look for pulses that act in the part of the cycle in which they were to be off."""
    for name, load in scene.loads.items():
        pulse = load.factor
        if not isinstance(pulse, Pulse):
            continue
        start, end = math.degrees(pulse.start), math.degrees(pulse.end)
        acts = f"it acts through {math.degrees(pulse.width):.4g} deg of the cycle"
        if pulse.end < pulse.start and pulse.width > math.pi:
            yield (
                f"loads.{name}.factor",
                f"the pulse ends at {end:.6g} deg, before its start at {start:.6g} deg, so that {acts}: "
                "start and end are likely the other way round",
            )
        elif pulse.end - pulse.start > TURN * (1 + 1e-9):
            what = f"the pulse goes from {start:.6g} to {end:.6g} deg, more than a cycle: {acts}"
            yield f"loads.{name}.factor.end", what


def _waves(scene: Scene) -> Found:
    """Look for waves that do not go into the cycle a whole number of times, as theta begins anew in every cycle."""
    for name, load in scene.loads.items():
        wave = load.factor
        if isinstance(wave, FactorExpression) and wave.jumps and re.search(r"\b(sin|cos)\b", wave.formula):
            what = f"the formula {wave.formula!r} does not end as it began, so that the load jumps in every cycle"
            more = "theta goes from 0 to 2 pi, and then from 0 again. Whole numbers of waves in a cycle may be meant"
            yield f"loads.{name}.factor.formula", f"{what}: {more}"


def _loads(scene: Scene) -> Found:
    """Estimate the strain of members on two pins by loads across them."""
    for name, load in scene.loads.items():
        label, _, s = (load.member, "", "") if isinstance(load, LineLoad) else load.at.partition("@")
        if label not in scene.members() or not (s or isinstance(load, LineLoad)):
            continue
        largest = max(map(abs, load.factor_range))
        rigid, length = scene.rigidity(label, np.array([0.5])), math.dist(*scene.member_ends(label))
        if isinstance(load, LineLoad):
            size = max(math.hypot(*line) for line in load.ends)
            key, unit, moment = "line", "N/m", size * length**2 / 8
        else:
            size = math.hypot(*load.force)
            key, unit, moment = "force", "N", size * length * float(s) * (1 - float(s))
        strain = bending_strain(rigid, largest * moment)
        if strain > USUAL.largest_strain:
            yield (
                f"loads.{name}.{key}",
                f"{largest * size:.6g} {unit} across member {label} strains it by about {strain:.2g}, where metals "
                "yield at 0.001 to 0.01. The load, its unit or the section is likely wrong",
            )


def _damping(scene: Scene) -> Found:
    damping = scene.damping
    ratios = damping.ratio if isinstance(damping.ratio, tuple) else (damping.ratio,)
    if (ratio := max(ratios)) >= USUAL.largest_ratio:
        what = f"{ratio:.6g} is {100 * ratio:.4g} % of critical damping, and structures have 0.1 to 10 %"
        yield "damping.ratio", f'{what}: "{ratio:.6g} %" may be meant'
    if not scene.drives:
        return
    rate = abs(scene.cycle_rate)
    if damping.material * rate > USUAL.longest_retardation:
        meant = likely(damping.material, "s", (("ms", 1e-3), ("us", 1e-6)), 0, USUAL.longest_retardation / rate / 10)
        yield (
            "damping.material",
            f"{damping.material:.6g} s is long beside a cycle of {scene.period:.4g} s: the material would creep rather "
            f"than vibrate{meant}",
        )
    for name, drag in (("external", damping.external), ("relative", damping.relative)):
        if drag > USUAL.largest_drag * rate:
            what = f"{drag:.6g} 1/s stops the links' vibration within {1 / drag:.2g} s, "
            yield f"damping.{name}", what + f"and a cycle takes {scene.period:.4g} s"


def _numerics(scene: Scene) -> Found:
    for quantity, share in scene.tolerances.items():
        if share >= USUAL.largest_tolerance:
            place = "tolerance" if isinstance(scene.tolerance, float) else f"tolerance.{quantity}"
            yield place, f'{share:.6g} is {100 * share:.4g} % of the {quantity}: "{share:.6g} %" may be meant'
    size = sum(_lengths(scene).values())
    for name, spring in scene.springs.items():
        if isinstance(spring, LineSpring) and (spring.length or 0.0) > USUAL.longest_spring * size:
            meant = likely(spring.length or 0.0, "m", (("mm", 1e-3),), 0, size)
            yield f"springs.{name}.length", f"{spring.length:.6g} m, and all members together have {size:.4g} m{meant}"
    for place, drive in scene.drives_by_place.items():
        if (drive.run_up or 0.0) > USUAL.longest_run_up * scene.period:
            meant = likely(drive.run_up or 0.0, "s", (("ms", 1e-3),), 0, USUAL.longest_run_up * scene.period)
            yield f"{place}.run_up", f"{drive.run_up:.6g} s are {(drive.run_up or 0) / scene.period:.4g} cycles{meant}"


ALONE = (_angles, _pulses, _waves, _damping, _numerics)
IN_TURN = ((_materials, _proportions), (_sections,), (_masses, motion, _loads))  # each needs what is before it
