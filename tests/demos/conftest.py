"""The demos and some more machines, each loaded and analysed once."""

from functools import cache

import pytest

from fenics_mech import analyse
from fenics_mech.scene import load
from tests.common import DEMOS
from tests.demos.machines import MACHINES

NAMES = sorted(path.stem for path in DEMOS.glob("*.toml"))


@cache
def _loaded(name):
    return MACHINES[name]() if name in MACHINES else load(DEMOS / f"{name}.toml")


@cache
def _analysed(name, method):
    return analyse(_loaded(name).changed(analysis__method=method))


@pytest.fixture(params=[*NAMES, *MACHINES])
def machine(request):
    """Each demo's and machine's scene in turn."""
    return _loaded(request.param)


@pytest.fixture(params=[name for name in (*NAMES, *MACHINES) if name != "pulsating_column"])
def moving_machine(request):
    """Each of them that moves as a rigid mechanism does: not the column."""
    return _loaded(request.param)


@pytest.fixture(scope="session")
def scene_of():
    """Load a demo by name."""
    return _loaded


@pytest.fixture(scope="session")
def analysed():
    """Analyse a demo by name, "periodic" or "quasi-static"."""
    return lambda name, method="periodic": _analysed(name, method).data
