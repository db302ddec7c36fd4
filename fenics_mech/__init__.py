"""fenics_mech: dynamics of planar linkages whose links bend."""

from typing import TYPE_CHECKING, Any

from fenics_mech._version import __version__
from fenics_mech.scene import Scene, four_bar, load

if TYPE_CHECKING:
    from fenics_mech.analysis import analyse
    from fenics_mech.recovery import Result

__all__ = ["Result", "Scene", "__version__", "analyse", "four_bar", "load"]


def __getattr__(name: str) -> Any:
    """Import what needs dolfinx only when it is asked for: it takes a second."""
    if name == "analyse":
        from fenics_mech.analysis import analyse  # noqa: PLC0415

        return analyse
    if name == "Result":
        from fenics_mech.recovery import Result  # noqa: PLC0415

        return Result
    raise AttributeError(f"module 'fenics_mech' has no attribute {name!r}")
