"""Fixtures that all tests share.

Nothing here imports the package before a test asks for it: MPI, once it has begun, marks the environment of the
processes that pytest-xdist starts, and none of these could start `mpirun`. Nor does it import NumPy, before the number
of threads is set.
"""

import os
import shutil
import sys
import tempfile

import pytest
from hypothesis import settings

from tests.common import DEMOS

settings.register_profile("repeatable", derandomize=True, deadline=None, max_examples=40)
settings.load_profile("repeatable")

OF_WORKER = "PYTEST_XDIST_WORKER" in os.environ


def pytest_configure():
    """Give the tests a compile cache of their own: a broken one of the user's must not fail them, nor they break it.

    The processes of pytest-xdist inherit that of the process that started them, so that no form is compiled twice. And
    let Python keep its bytecode: the tests start some 60 processes. Modules of tests import NumPy before the package.
    """
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    if not OF_WORKER:
        os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="fenics-mech-tests-")
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    sys.dont_write_bytecode = False


def pytest_unconfigure():
    """Remove the compile cache once all processes have ended."""
    if not OF_WORKER:
        shutil.rmtree(os.environ["XDG_CACHE_HOME"], ignore_errors=True)


@pytest.fixture(scope="session")
def seed():
    """The seed four-bar with 24 sub-intervals."""
    from fenics_mech.scene.factories import seed_four_bar

    return seed_four_bar(analysis={"sub_intervals": 24})


@pytest.fixture
def rng():
    """Random numbers that are the same in every run."""
    import numpy as np

    return np.random.default_rng(1989)


@pytest.fixture(scope="session")
def demo_text():
    """Text of the seed scene file."""
    return (DEMOS / "four_bar.toml").read_text()
