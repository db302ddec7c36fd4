"""Buckling of a member: as a strut in the plane of motion and across it, and sideways by bending in the plane."""

from __future__ import annotations

import math

from fenics_mech._arrays import Array
from fenics_mech.safety.check import Check, unknown, wanted
from fenics_mech.safety.grades import yield_of
from fenics_mech.safety.loaded import Loaded
from fenics_mech.safety.shapes import torsion_of, warping_of
from fenics_mech.safety.side_buckling import PLACES
from fenics_mech.scene.sections import Stock

FREE, PINNED, CLAMPED = 2.0, 1.0, 0.5  # effective over real length of ends (Timoshenko and Gere, section 2.1)


def in_plane(of: Loaded) -> Check:
    """Judge a strut that buckles in the plane of motion, where its ends turn on pins."""
    _, free = of.between_joints
    factor = FREE if free else PINNED
    told = "" if free else "K = 1 in the plane"
    return _strut(of, "buckling in plane", of.bending, factor).also_assumed(told)


def across(of: Loaded) -> Check:
    """Judge a strut that buckles across the plane of motion."""
    # Pins let it turn a little there; stiff forks clamp it, as the ends of connecting rods: K = 0.5, by which the
    # load is 4 times as large (Khurmi and Gupta, A Textbook of Machine Design, section 32.12).
    mode = "buckling across"
    stiffness = _across(of)
    if stiffness is None:
        return unknown(mode, f"sections.{of.member.section} does not tell its width: state its shape")
    _, free = of.between_joints
    factor = FREE if free else CLAMPED if of.member.across == "clamped" else PINNED
    clamped = "" if of.member.across or free else "K = 1 across the plane"
    stated = of.section is of.scene.sections[of.member.section]
    shape = "" if stated else f"section {of.member.section} is the rectangle of its numbers"
    return _strut(of, mode, stiffness, factor).also_assumed(clamped, shape)


def lateral_torsion(of: Loaded) -> Check:
    """Judge a blade that is bent in its stiff plane and tips sideways, under a uniform moment between its joints."""
    # ``M0 = pi/L sqrt(E Iy (G J + E Cw pi^2/L^2))`` (Timoshenko and Gere, Theory of Elastic Stability, section 6.2;
    # of solid shapes Cw is 0). Loads that vary along it leave it more; a free end doubles L.
    mode = "lateral torsion"
    stiffness, torsion, material = _across(of), torsion_of(of.section), of.material
    if stiffness is None or torsion is None or material is None:
        return unknown(mode, f"sections.{of.member.section} has no known torsion constant: state its shape")
    acting, theta = of.largest(of.moment, "moment")
    if float(stiffness.min()) >= float(of.bending.max()):  # stiffer across: then bending in the plane is stable
        acting = 0.0
    length, free = of.between_joints
    share, across = math.pi / (length * (2 if free else 1)), float(stiffness.min())
    of_torsion = material.rigidity * torsion * of.enlarged.torsion
    of_warping = across * warping_of(of.section) * of.enlarged.warping
    borne = share * math.sqrt(across * (of_torsion + of_warping * share**2))
    return Check(mode, acting, borne, "moment", wanted(of.scene.design, mode), theta)


def _strut(of: Loaded, mode: str, stiffness: Array, factor: float) -> Check:
    """Judge the largest compression against Euler's load, or Johnson's where the member is stocky."""
    push, theta = of.largest(of.normal, "axial_force", signs=(-1,))
    length, rests = factor * of.between_joints[0], ""
    weakest = float(stiffness.min())
    borne = math.pi**2 * weakest / length**2  # Shigley's, 9th ed., eq. (4-42), C = 1/K^2
    material, name = of.material, of.faces[0].material if of.faces else ""
    if material is not None and (known := yield_of(name, material)) is not None:
        area, strength = float(of.stretching.min()) / material.modulus, known[0]
        slender = length / math.sqrt(weakest / material.modulus / area)
        if slender < math.sqrt(2 * math.pi**2 * material.modulus / strength):  # eq. (4-45)
            fall = strength * slender**2 / (4 * math.pi**2 * material.modulus)
            borne = area * strength * (1 - fall)  # eq. (4-48), J. B. Johnson
            rests = known[1]
    on = (rests,) if rests else ()
    return Check(mode, max(push, 0.0), borne, "force", wanted(of.scene.design, mode), theta, rests_on=on)


def _across(of: Loaded) -> Array | None:
    """EI across the plane (N m^2); None where the section does not tell it."""
    stock = Stock(of.scene.materials.get(of.member.material or ""), of.scene.materials, of.scene.sections)
    found = of.section.bending_across(PLACES, stock)
    return None if found is None else found * of.enlarged.across
