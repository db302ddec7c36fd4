"""Numbers of cross-sections in space: closed forms of plain shapes, and a finite-element solution of the others."""

from fenics_mech.sections.shapes import SectionNumbers, from_sectionproperties, numbers_of
from fenics_mech.sections.torsion import polygon_numbers

__all__ = ["SectionNumbers", "from_sectionproperties", "numbers_of", "polygon_numbers"]
