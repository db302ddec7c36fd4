"""fenics_mech: dynamics of planar linkages whose links bend."""

from fenics_mech._version import __version__
from fenics_mech.analysis import analyse
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene, four_bar, load

__all__ = ["Result", "Scene", "__version__", "analyse", "four_bar", "load"]
