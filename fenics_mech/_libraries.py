"""How libraries start in processes of the program's own: no search for what one process alone does not use."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import cast

ALONE = {  # settings of Open MPI
    "OMPI_MCA_ess_singleton_isolated": "1",  # no daemon, which only processes that MPI starts from here would need
    "OMPI_MCA_pml": "ob1",  # no search for fast networks
    "OMPI_MCA_btl": "self",
}
LAUNCHED = "OMPI_COMM_", "PMI_", "PMIX_RANK"  # how names of variables begin that `mpirun` sets


def launched() -> bool:
    """Tell whether `mpirun` or the like may have started this process."""
    return any(name.startswith(LAUNCHED) for name in os.environ)


@contextmanager
def alone() -> Iterator[None]:
    """Start MPI in here for this process alone, unless it is `launched`: it waits for 0.03 s then instead of 0.3 s."""
    # Settings of the user win.
    ours = {} if launched() else {name: value for name, value in ALONE.items() if name not in os.environ}
    os.environ.update(ours)
    try:
        yield
    finally:
        for name in ours:  # for programs that are started later
            del os.environ[name]


def leave_pint_out() -> None:
    """Let xarray ask no array whether it is one of pint, for which it would load pint: here none is."""
    if "pint" in sys.modules:
        return
    import xarray as xr  # noqa: PLC0415

    sys.modules["pint"] = cast("ModuleType", None)  # which Python takes for a module that is not there
    try:
        xr.Variable((), 0.0).to_numpy()  # xarray asks once
    finally:
        del sys.modules["pint"]


@contextmanager
def versions_by_python() -> Iterator[None]:
    """Let packages of 2022 ask Python for their versions, for which they would load `pkg_resources` of setuptools."""
    name = "pkg_resources"
    if name in sys.modules:
        yield
        return
    from importlib.metadata import distribution  # noqa: PLC0415  (not for --help)

    asked = ModuleType(name)
    asked.get_distribution = distribution  # type: ignore[attr-defined]
    sys.modules[name] = asked
    try:
        yield
    finally:
        del sys.modules[name]
