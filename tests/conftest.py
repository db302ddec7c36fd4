"""Fixtures that all tests share."""

import os
import shutil
import tempfile

# A compile cache of the tests' own: a broken cache of the user's must not fail them, nor they break it.
os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="fenics-mech-tests-")

from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from fenics_mech.response.setup import mechanism
from fenics_mech.scene.factories import seed_four_bar

settings.register_profile("repeatable", derandomize=True, deadline=None)
settings.load_profile("repeatable")

DEMOS = Path(__file__).parent.parent / "demos"


@pytest.fixture(scope="session", autouse=True)
def _own_cache():
    yield
    shutil.rmtree(os.environ["XDG_CACHE_HOME"], ignore_errors=True)


@pytest.fixture(scope="session")
def seed():
    """The seed four-bar with 24 sub-intervals."""
    return seed_four_bar(analysis={"sub_intervals": 24})


@pytest.fixture(scope="session")
def seed_system(seed):
    """Its mechanism at 24 angles."""
    return mechanism(seed)


@pytest.fixture
def rng():
    """Random numbers that are the same in every run."""
    return np.random.default_rng(1989)


@pytest.fixture(scope="session")
def demo_text():
    """Text of the seed scene file."""
    return (DEMOS / "four_bar.toml").read_text()
