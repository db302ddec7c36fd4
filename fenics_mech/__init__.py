"""fenics_mech: dynamics of planar linkages whose links bend."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from fenics_mech._version import __version__

if TYPE_CHECKING:
    from fenics_mech.analysis import analyse
    from fenics_mech.recovery import Result
    from fenics_mech.scene import Scene, four_bar, load
    from fenics_mech.studies.follow import follow

__all__ = ["Result", "Scene", "__version__", "analyse", "follow", "four_bar", "load"]
PLACES = {
    "Result": "recovery",
    "Scene": "scene",
    "analyse": "analysis",
    "follow": "studies.follow",
    "four_bar": "scene",
    "load": "scene",
}


def __getattr__(name: str) -> Any:
    """Import what is asked for, and no more: dolfinx takes a second, and the command must be able to be interrupted."""
    if name in PLACES:
        return getattr(import_module(f"{__name__}.{PLACES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
