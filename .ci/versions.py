"""Print the versions that the matrix shows, and the largest strain of a result, whose digits show what it computes."""

import platform
import sys

import numpy
import scipy

from fenics_mech import Result
from fenics_mech._fenicsx import dolfinx
from fenics_mech._petsc import PETSc

strain = abs(Result.load(sys.argv[1]).data["largest_strain"]).max().item()
petsc = ".".join(map(str, PETSc.Sys.getVersion()))
versions = (platform.python_version(), numpy.__version__, scipy.__version__, dolfinx.__version__, petsc)
print("versions", ",".join([*versions, f"{1e6 * strain:.6f}"]))
