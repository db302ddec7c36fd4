"""The dissertation's own programs, hand-coded in NumPy and independent of the rest of the package.

`mecqbar` is chapter 6, the rigid four-bar; `NineElementModel` with `periodic_response` is the finite-element model of
chapters 4, 5 and 7. `SliderCrankModel` and `ManipulatorModel` do the same for two other machines.
The rest of the package is compared with them and shares no code with them.
"""

from .gauss_legendre import CollocationResponse, gauss_legendre_periodic
from .manipulator_arm import ManipulatorModel, ManipulatorParameters
from .mecqbar import AppendixComparison, Disagreement, compare_appendix_g, mecqbar
from .nine_element import Coupling, NineElementModel
from .parameters import FourBarParameters
from .periodic_motion import PeriodicResponse, periodic_response, quasi_static_response
from .slider_crank_linkage import SliderCrankModel, SliderCrankParameters
from .strain import LinkStrain, link_strain

__all__ = [
    "AppendixComparison",
    "CollocationResponse",
    "Coupling",
    "Disagreement",
    "FourBarParameters",
    "LinkStrain",
    "ManipulatorModel",
    "ManipulatorParameters",
    "NineElementModel",
    "PeriodicResponse",
    "SliderCrankModel",
    "SliderCrankParameters",
    "compare_appendix_g",
    "gauss_legendre_periodic",
    "link_strain",
    "mecqbar",
    "periodic_response",
    "quasi_static_response",
]
