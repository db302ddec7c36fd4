"""What acts in a machine: a term measures its ends and answers with stresses, and inertia is one constant mass."""

from fenics_mech.terms.along_beams import AirForce, AlongBeams, Density, LineForce, Spread
from fenics_mech.terms.beams import Beams, Element
from fenics_mech.terms.inertia import Masses, hermite_mass
from fenics_mech.terms.inner_places import Shapes
from fenics_mech.terms.laws import Damper, DeadLoad, Effort, OverState, PointLoad, Shaft, SoftBearing, Spring
from fenics_mech.terms.modal_damping import HeldDamping, ModalDamping
from fenics_mech.terms.term import Look, Measure, Response, Term, rubs

__all__ = [
    "AirForce",
    "AlongBeams",
    "Beams",
    "Damper",
    "DeadLoad",
    "Density",
    "Effort",
    "Element",
    "HeldDamping",
    "LineForce",
    "Look",
    "Masses",
    "Measure",
    "ModalDamping",
    "OverState",
    "PointLoad",
    "Response",
    "Shaft",
    "Shapes",
    "SoftBearing",
    "Spread",
    "Spring",
    "Term",
    "hermite_mass",
    "rubs",
]
