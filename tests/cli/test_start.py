"""What the program loads as it starts, and with how many threads; each in a process of its own."""

import os
import subprocess
import sys

import pytest

THREADS = "import fenics_mech, os; print(os.environ['OMP_NUM_THREADS'])"


def printed(code, **environment):
    """What a new Python prints."""
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=60, check=True
    )
    return done.stdout.strip()


@pytest.mark.parametrize(("stated", "threads"), [({}, "1"), ({"OMP_NUM_THREADS": "3"}, "3")])
def test_libraries_use_one_thread_unless_the_user_says_otherwise(stated, threads):
    environment = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"}
    assert printed(THREADS, **environment, **stated) == threads


def test_numerical_libraries_start_no_thread():
    environment = {name: value for name, value in os.environ.items() if name != "OMP_NUM_THREADS"}
    work = "import fenics_mech, numpy as np, os; np.ones((400, 400)) @ np.ones((400, 400)); "
    assert printed(work + "print(len(os.listdir('/proc/self/task')))", **environment) == "1"
