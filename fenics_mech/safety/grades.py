"""Strengths of materials: those that a scene states, and of steel and aluminium those of the lowest common grade."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_mech.scene import Material


@dataclass(frozen=True)
class Grade:
    """A family of materials, known by its numbers."""

    name: str  # its name, and that of the grade
    modulus: tuple[float, float]  # modulus, density: their least and largest (Pa, kg/m^3)
    density: tuple[float, float]
    yielding: float  # yielding, ultimate: strengths of the lowest common grade (Pa)
    ultimate: float
    # endurance, highest: endurance limit of a polished specimen in rotating bending over the tensile strength, and
    # its ceiling (Pa)
    endurance: float
    highest: float


# S235JR, EN 10025-2; Se' = 0.5 Su, at most 700 MPa: Shigley's Mechanical Engineering Design, 9th ed., eq. (6-8)
STEEL = Grade("steel S235", (185e9, 220e9), (7500.0, 8200.0), 235e6, 360e6, 0.5, 700e6)
# EN AW-6060 T6, EN 1999-1-1, table 3.2b; Se' = 0.4 Su, at most 130 MPa, at 5e8 cycles: Norton, Machine Design, 6.6
ALUMINIUM = Grade("aluminium 6060-T6", (62e9, 80e9), (2550.0, 2900.0), 140e6, 170e6, 0.4, 130e6)


def grade_of(material: Material) -> Grade | None:
    """Give the family that a material belongs to by its modulus and density; None where none is known."""
    for grade in (STEEL, ALUMINIUM):
        stiff = grade.modulus[0] <= material.modulus <= grade.modulus[1]
        if stiff and grade.density[0] <= material.density <= grade.density[1]:
            return grade
    return None


def yield_of(name: str, material: Material) -> tuple[float, str] | None:
    """Give the yield strength (Pa), and on which assumption it rests, if on any; None where nothing tells it."""
    # An allowed stress is not above the yield strength, and stands for it where that is not stated.
    stated = material.yield_ or material.strength
    if stated is not None:
        return stated, ""
    if (grade := grade_of(material)) is None:
        return None
    return grade.yielding, f"{name} yields as {grade.name}"


def ultimate_of(name: str, material: Material) -> tuple[float, str] | None:
    """Give the tensile strength (Pa), and on which assumption it rests, if on any; None where nothing tells it."""
    stated = material.ultimate or (material.fatigue and material.fatigue.ultimate)
    if stated:
        return stated, ""
    if (grade := grade_of(material)) is None:
        return None
    least = max(grade.ultimate, material.yield_ or 0.0)
    return least, f"{name} breaks as {grade.name}"
