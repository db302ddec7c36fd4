"""The dissertation's own programs, hand-coded in NumPy and independent of the rest of the package.

`mecqbar` is chapter 6, the rigid four-bar; `NineElementModel` with `periodic_response` is the finite-element model of
chapters 4, 5 and 7.
The rest of the package is compared with them and shares no code with them.
"""

from .gauss_legendre import CollocationResponse, gauss_legendre_periodic
from .mecqbar import AppendixComparison, Disagreement, compare_appendix_g, mecqbar
from .nine_element import Coupling, NineElementModel
from .parameters import FourBarParameters
from .periodic_motion import PeriodicResponse, periodic_response, quasi_static_response
from .strain import LinkStrain, link_strain

__all__ = [
    "AppendixComparison",
    "CollocationResponse",
    "Coupling",
    "Disagreement",
    "FourBarParameters",
    "LinkStrain",
    "NineElementModel",
    "PeriodicResponse",
    "compare_appendix_g",
    "gauss_legendre_periodic",
    "link_strain",
    "mecqbar",
    "periodic_response",
    "quasi_static_response",
]
