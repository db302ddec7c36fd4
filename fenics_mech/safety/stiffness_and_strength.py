"""Yield of a member, and its deflection."""

from __future__ import annotations

import numpy as np

from fenics_mech.safety.check import Check, unknown, wanted
from fenics_mech.safety.grades import yield_of
from fenics_mech.safety.loaded import Loaded

BEARS = "state materials.{}.yield"
ASSUMED = "deflections up to L/200"


def yielding(of: Loaded) -> Check:
    """Judge the largest stress of every material against its yield strength."""
    # ``n = Sy/max |N/A + M y/I|`` over places, positions and between them (Shigley's, 9th ed., eq. (5-1) for one
    # normal stress). An allowed stress, `strength`, has its factor in it: it is to be reached once, unless `[design]
    # safety` states more. The least of both counts.
    found: list[Check] = []
    axial, bending = of.axial_and_bending
    for face in of.faces:
        material = of.scene.materials[face.material]
        stress = face.stress(*np.moveaxis(axial + bending, -1, 0))
        acting, theta = of.largest(stress, "stress")
        asked = wanted(of.scene.design, "yield")
        if material.strength is not None:
            allowed = of.scene.design.safety.get("yield", 1.0)
            found.append(Check("yield", acting, material.strength, "stress", allowed, theta, "allowed stress"))
        if material.yield_ is not None or material.strength is None:
            if (known := yield_of(face.material, material)) is None:
                return unknown("yield", BEARS.format(face.material))
            rests = (known[1],) if known[1] else ()
            found.append(Check("yield", acting, known[0], "stress", asked, theta, rests_on=rests))
    return min(found, key=lambda check: check.share, default=unknown("yield", "its section names no material"))


def deflecting(of: Loaded) -> Check:
    """Judge the largest elastic displacement from the rigid linkage against the limit of `[design] deflection`."""
    # ``n = u_allowed/max |u|``. Where no limit is stated it is 1/200 of the length, which does not decide.
    acting, theta = of.largest(of.deflection, "deflection", signs=(1,))
    allowed = of.scene.design.allowed_deflection(of.length)
    on = (ASSUMED,) if of.scene.design.deflection is None else ()
    return Check("deflection", acting, allowed, "length", 1.0, theta, rests_on=on)
