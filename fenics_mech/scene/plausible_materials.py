"""Materials that a scene states and hardly means, and what checks of all numbers share."""

from __future__ import annotations

import math

from fenics_mech.scene.bodies import Material
from fenics_mech.scene.models import Scene
from fenics_mech.scene.plausible_limits import USUAL, Found, likely


def materials(scene: Scene) -> Found:
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
    lengths = lengths_of(scene)
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


def lengths_of(scene: Scene) -> dict[str, float]:
    """Give the length of every member (m), by label."""
    return {label: math.dist(*scene.member_ends(label)) for label in scene.members()}
