"""Python in processes of its own, several of them under `mpirun`."""

import os
import shutil
import subprocess
import sys

# That of the wheel of MPI, where this is one, and not one of the system that belongs to another MPI.
MPIRUN = shutil.which("mpirun", path=f"{os.path.dirname(sys.executable)}{os.pathsep}{os.environ.get('PATH', '')}")
OVERSUBSCRIBED = [] if MPIRUN and os.path.dirname(MPIRUN) == os.path.dirname(sys.executable) else ["--oversubscribe"]


def command(*arguments, ranks=0):
    """The arguments that start Python, on several processes if asked to."""
    start = [MPIRUN, *OVERSUBSCRIBED, "-n", str(ranks)] if ranks else []
    return [*start, sys.executable, *map(str, arguments)]


OF_MPI = ("OMPI_", "ORTE_", "PMIX_")  # marks of a process that MPI has begun in, from which no `mpirun` can start
ENVIRONMENT = {name: value for name, value in os.environ.items() if not name.startswith(OF_MPI)} | {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_mpi_yield_when_idle": "1",  # a process that waits leaves its core to others
}


def finished(*arguments, ranks=0):
    """Run Python to its end."""
    arguments = command(*arguments, ranks=ranks)
    return subprocess.run(arguments, env=ENVIRONMENT, capture_output=True, text=True, timeout=120, check=False)
