"""The UFL forms of a beam in its member's axes, one a file: u along the member, w along its normal."""

from fenics_mech.beams.forms.axial import axial
from fenics_mech.beams.forms.bending import bending
from fenics_mech.beams.forms.bowing import bowing
from fenics_mech.beams.forms.mass import mass, offset_mass
from fenics_mech.beams.forms.rotary import rotary
from fenics_mech.beams.forms.shear_flexibility import shear

__all__ = ["axial", "bending", "bowing", "mass", "offset_mass", "rotary", "shear"]
