"""Errors of a response in time by superposition of modes: of its sub-intervals, and of the modes left out."""

from __future__ import annotations

from fenics_mech.accuracy.corrected_response import ESTIMATES, CorrectedResponse
from fenics_mech.accuracy.sub_interval_errors import ORDERS
from fenics_mech.response.solution import SuperposedSolution
from fenics_mech.response.transient.superposition import finer


def superposition_errors(solution: SuperposedSolution) -> dict[str, CorrectedResponse]:
    """Give a response with sub-intervals of half the length ("time"), and one with twice as many modes ("modes").

    Parameters
    ----------
    solution
        The solution.

    Returns
    -------
    dict
        Responses by source; none by modes where all are kept.
    """
    found = {}
    for source, modes in (("time", False), ("modes", True)):
        if modes and solution.scene.analysis.modes == "all":
            continue
        other = finer(solution, modes=modes)
        found[source] = CorrectedResponse(other.response, ORDERS[source], ESTIMATES.safety)
    return found
