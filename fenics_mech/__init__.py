"""fenics_mech: dynamics of linkages whose links bend, in the plane and in space.

Everything that a user needs stands here: ``import fenics_mech as fm``, and then ``fm.load``, ``fm.analyse``,
``fm.Scene`` and so on. The command is `fenics-mech`.

Numerical libraries that are loaded after it use one thread, unless the user has set their number. The matrices are
small, and one thread is fastest.
"""

import ast
import logging
import os
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from fenics_mech._version import __version__ as __version__

logging.getLogger(__name__).addHandler(logging.NullHandler())  # quiet, unless a program asks for the log
os.environ.setdefault("OMP_NUM_THREADS", "1")  # OpenBLAS and MKL follow it, unless their own variables are set
os.environ.setdefault("NUMPY_MADVISE_HUGEPAGE", "0")  # clearing huge pages takes a fifth of the time of large models

MODULES = {  # by name, as the stub beside this file states them
    alias.name: str(imported.module)
    for imported in ast.parse(Path(__file__).with_suffix(".pyi").read_text(encoding="utf-8")).body
    if isinstance(imported, ast.ImportFrom)
    for alias in imported.names
}
__all__ = sorted(MODULES)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Import what is asked for, and no more: dolfinx takes a second, and the command must be able to be interrupted."""
    if name in MODULES:
        return getattr(import_module(MODULES[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__


def _html(shown: Any) -> str:
    """Write a scene or a result as HTML."""
    return str(import_module(f"{__name__}.views.notebook").html(shown))


OF_NOTEBOOKS = {
    "scene.models": "Scene",
    "scene.in_space": "SpatialScene",
    "recovery.result": "Result",
    "recovery.spatial_result": "SpatialResult",
}


def _show_in_notebooks() -> None:
    """Let notebooks show scenes and results as tables; neither class need know of views, which come after them."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        formatter = shell.display_formatter.formatters["text/html"]
        for module, name in OF_NOTEBOOKS.items():
            formatter.for_type_by_name(f"{__name__}.{module}", name, _html)


_show_in_notebooks()
