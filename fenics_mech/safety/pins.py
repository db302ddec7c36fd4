"""Pins and the eyes of members that they go through."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.safety.check import Check, unknown, wanted
from fenics_mech.safety.endurance import AXIAL, endurance
from fenics_mech.safety.grades import ultimate_of, yield_of
from fenics_mech.safety.loaded import Loaded
from fenics_mech.scene import Material, RectangleSection, Revolute, RoundSection, TubeSection
from fenics_mech.scene.design import Pin

MODE = "pin and eye"
SHEAR = 1 / math.sqrt(3)  # shear yield over tensile yield (von Mises)
BEARING = 1.5  # bearing strength over yield strength (EN 1993-1-8, table 3.10)
LOCKING = math.radians(55)  # angle of the shear planes beside a pin that fills its hole (ASME BTH-1, section 3-3.3.1)
CLEARANCE = 1.35  # of pins that turn raises Kt by 35 to 50 % (Shigley's, 9th ed., figure A-15-12)
ASSUMED = "pins half as thick as members are high"
NARROW, BROAD = 0.15, 0.75  # diameter over width, between which the fit of Kt holds
DIMENSIONS = {  # of a pin: what is to be enlarged where that is weakest
    "net section": "eye",
    "tear-out": "eye",
    "eye in fatigue": "eye",
    "bearing": "thickness",
    "bush": "thickness",
    "bush by its speed": "thickness",
    "pin in shear": "diameter",
}


def pins(of: Loaded) -> Check:
    """Judge the pins at the ends of a member, with its own eyes, by the largest force at each joint."""
    found = [pinned(of, name, joint.pin) for name, joint in joints_of(of)]
    known = [check for check in found if check.known]
    if not found:
        return unknown(MODE, "no pin holds it")
    return min(known, key=lambda check: check.share) if known else found[0]


def joints_of(of: Loaded) -> Iterator[tuple[str, Revolute]]:
    """Give the pins at the ends of a member, with their names."""
    link = of.scene.members()[of.label][0]
    ends = {f"{link}.{end}" for end in of.member.ends}
    for name, joint in of.scene.joints.items():
        if isinstance(joint, Revolute) and ends & set(joint.connect):
            yield name, joint


def pinned(of: Loaded, name: str, pin: Pin | None) -> Check:
    """Judge one pin and the member's eye."""
    given = pin or _usual(of)
    material, label = of.material, of.faces[0].material if of.faces else ""
    if given is None:
        return unknown(MODE, "state `pin` of the joints")
    if material is None or (known := yield_of(label, material)) is None:
        return unknown(MODE, f"state materials.{label}.yield")
    forces = _forces(of, name)
    force, theta = of.largest(np.linalg.norm(forces, axis=-1)[:, None], "joint_force", signs=(1,))
    borne = {where: (load, known[1]) for where, load in static_loads(given, known[0]).items()}
    if len(of.theta) > 1 and (by_fatigue := _fatigue_load(given, label, material)) is not None:
        borne["eye in fatigue"] = by_fatigue
    if given.bush_pv is not None and (most := _pressure_times_speed(of, name, given, forces)) > 0:
        borne["bush by its speed"] = force * given.bush_pv / most, ""  # the largest force, if all grow alike
    weakest = min(borne, key=lambda where: borne[where][0])
    least, rests = borne[weakest]
    on = tuple(filter(None, (rests, "" if pin else ASSUMED)))
    wanted_factor = wanted(of.scene.design, MODE)
    check = Check(MODE, force, least, "force", wanted_factor, theta, f"{weakest}, {name}", on)
    by_speed = "" if given.bush_pv is not None else "bushes that bear their speed"
    return check.also_assumed("pins in double shear, of their members' materials", by_speed)


def static_loads(pin: Pin, strength: float) -> dict[str, float]:
    """Give the forces (N) that a pin and an eye of one material bear, by what fails."""
    # strength: yield strength (Pa)
    d, w, t = pin.diameter, pin.eye, pin.thickness
    edge = (w - d) / 2  # from the hole to the end of a round eye
    # shear planes: a + d/2 (1 - cos phi), less what the round end cuts off (ASME BTH-1, eq. (3-51), commentary C-3)
    cut = w / 2 - math.sqrt((w / 2) ** 2 - (d / 2 * math.sin(LOCKING)) ** 2)
    plane = edge + d / 2 * (1 - math.cos(LOCKING)) - cut
    loads = {
        "net section": (w - d) * t * strength,
        "tear-out": 2 * plane * t * SHEAR * strength,
        "bearing": BEARING * d * t * strength,
        "pin in shear": 2 * math.pi * d**2 / 4 * SHEAR * strength,
    }
    return loads if pin.bush is None else loads | {"bush": pin.bush * d * t}


def eye_concentration(ratio: float) -> float:
    """Give Kt of a plate that a close pin draws, on the net section."""
    # Pilkey, Formulas for Stress, Strain and Structural Matrices, table 6-1: a fit to Frocht and Hill, for ``0.15 <=
    # d/w <= 0.75``.
    x = min(max(ratio, NARROW), BROAD)
    return 12.882 - 52.714 * x + 89.762 * x**2 - 51.667 * x**3


def _fatigue_load(pin: Pin, label: str, material: Material) -> tuple[float, str] | None:
    """Force (N), from none to the largest in every cycle, that the eye endures, and on what that rests."""
    known = ultimate_of(label, material)
    limit = endurance(material, known[0]) if known else None
    if known is None or limit is None:
        return None
    raised = CLEARANCE * eye_concentration(pin.diameter / pin.eye) / ((pin.eye - pin.diameter) * pin.thickness)
    return 2 / (raised * (1 / (AXIAL * limit) + 1 / known[0])), known[1]  # Goodman, sigma_a = sigma_m = half


def _usual(of: Loaded) -> Pin | None:
    """Give the pin that is assumed: half as thick as the member is high; None where the member is a flat strip."""
    section = of.section
    if isinstance(section, RoundSection | TubeSection):
        return Pin(diameter=section.diameter / 2, eye=section.diameter, thickness=section.diameter)
    if isinstance(section, RectangleSection) and section.height >= section.width:
        return Pin(diameter=section.height / 2, eye=section.height, thickness=section.width)
    return None


def _pressure_times_speed(of: Loaded, name: str, pin: Pin, forces: Array) -> float:
    """Give the mean p v of a bush (Pa m/s): p = F/(d t), and v = d/2 times the rate at which its bodies turn."""
    # It is the mean over the cycle, as it stands for the heat of friction (Shigley's Mechanical Engineering Design,
    # 9th ed., section 12-15). Of several bodies that of the fastest counts.
    data = of.result.data
    if "link_omega" not in data:  # nothing moves
        return 0.0
    own = of.scene.members()[of.label][0]
    rates = {str(link): data["link_omega"].sel(link=link).to_numpy() for link in data["link"].to_numpy()}
    bodies = {point.split(".")[0] for point in of.scene.joints[name].connect} - {own}
    here = rates.get(own, np.zeros(len(of.theta)))
    relative = np.max([np.abs(here - rates.get(body, 0.0)) for body in bodies], axis=0)
    products = np.linalg.norm(forces, axis=-1) / (pin.diameter * pin.thickness) * relative * pin.diameter / 2
    return float((products if of.part is None else products[of.part]).mean())


def _forces(of: Loaded, name: str) -> Array:
    """Force (N) on the member's link at a pin over the positions, ``(angles, 2)``."""
    link = of.scene.members()[of.label][0]
    data = of.result.data["joint_force"].transpose("theta", "joint", "component")
    names = [str(joint) for joint in data["joint"].to_numpy()]
    here = [i for i, joint in enumerate(names) if joint in (name, f"{name}:{link}")]
    here = here or [i for i, joint in enumerate(names) if joint.startswith(f"{name}:")]  # on the first body: all
    vectors: Array = data.to_numpy()[:, here].sum(axis=1)
    return vectors
