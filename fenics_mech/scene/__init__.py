"""What the user states: links, members, sections, materials, joints, drive, analysis."""

from fenics_mech.scene.factories import four_bar
from fenics_mech.scene.files import load, parse, schema
from fenics_mech.scene.models import (
    Analysis,
    Damping,
    Drive,
    Ground,
    Joint,
    Link,
    Material,
    Measurement,
    Member,
    Mesh,
    PointMass,
    Scene,
)
from fenics_mech.scene.sections import CustomSection, RectangleSection, Section

__all__ = [
    "Analysis",
    "CustomSection",
    "Damping",
    "Drive",
    "Ground",
    "Joint",
    "Link",
    "Material",
    "Measurement",
    "Member",
    "Mesh",
    "PointMass",
    "RectangleSection",
    "Scene",
    "Section",
    "four_bar",
    "load",
    "parse",
    "schema",
]
