"""What the user states: links, members, sections, materials, joints, drive, analysis."""

from fenics_mech.scene.applied_loads import Impulse, LineLoad, Load
from fenics_mech.scene.drives import Drive, Expression, Harmonics, Table
from fenics_mech.scene.factories import four_bar
from fenics_mech.scene.files import load, parse, schema
from fenics_mech.scene.joints import Prismatic, Revolute, Slot, Weld
from fenics_mech.scene.meshing import refined
from fenics_mech.scene.models import (
    Analysis,
    Damping,
    Ground,
    Link,
    Material,
    Measurement,
    Member,
    Mesh,
    PointMass,
    RigidBody,
    Scene,
)
from fenics_mech.scene.sections import CustomSection, RectangleSection, Section
from fenics_mech.scene.tolerance import stated as stated_tolerance

__all__ = [
    "Analysis",
    "CustomSection",
    "Damping",
    "Drive",
    "Expression",
    "Ground",
    "Harmonics",
    "Impulse",
    "LineLoad",
    "Link",
    "Load",
    "Material",
    "Measurement",
    "Member",
    "Mesh",
    "PointMass",
    "Prismatic",
    "RectangleSection",
    "Revolute",
    "RigidBody",
    "Scene",
    "Section",
    "Slot",
    "Table",
    "Weld",
    "four_bar",
    "load",
    "parse",
    "refined",
    "schema",
    "stated_tolerance",
]
