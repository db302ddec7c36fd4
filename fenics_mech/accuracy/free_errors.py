"""Errors of a motion with freedoms by its time steps: by the difference from a motion with a larger tolerance."""

from __future__ import annotations

from collections.abc import Mapping

from fenics_mech._arrays import Array
from fenics_mech.accuracy.corrected_response import ESTIMATES
from fenics_mech.accuracy.quantities import Quantities
from fenics_mech.response.solution import FreeSolution
from fenics_mech.response.transient.free_motion import course_of, solution_from


def free_errors(solution: FreeSolution, base: Quantities) -> Mapping[str, Array]:
    """Estimate the error of each quantity by the time steps.

    Parameters
    ----------
    solution
        The solution.
    base
        Its quantities.

    Returns
    -------
    mapping
        By quantity, as `Quantities.largest`.

    Raises
    ------
    SolverError
        When the rougher steps fail.
    """
    scene, state, start = solution.scene, solution.state, solution.start
    rough = solution_from(scene, state, start, course_of(scene, state, start, ESTIMATES.rougher))
    change = Quantities.of(scene, rough.system, rough.response.undamped) - base
    return {name: ESTIMATES.rough_share * size for name, size in change.largest.items()}
