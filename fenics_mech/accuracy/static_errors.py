"""Errors of a static or quasi-static response: that of its mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.corrected_response import ESTIMATES, MESH_SAFETY, CorrectedResponse, corrected_for_mesh
from fenics_mech.accuracy.mesh_residual import neglected, order_of
from fenics_mech.effects import UNLOADED
from fenics_mech.errors import UnresolvedError
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.solution import StaticSolution
from fenics_mech.response.static.quasi_static import held_still, yielding_to


def static_errors(solution: StaticSolution) -> dict[str, CorrectedResponse]:
    """Give the response without the error of the mesh.

    There is none without axial forces, if no section varies and no pin travels along a member.

    Parameters
    ----------
    solution
        The solution.

    Returns
    -------
    dict
        Responses by source, which is "mesh" alone.

    Raises
    ------
    UnresolvedError
        When the mesh changes so much, as next to a buckling load, that its first order does not estimate its error.
    """
    scene, system, response = solution.scene, solution.system, solution.response
    missing = neglected(system, response, None)
    if missing is UNLOADED:
        return {"mesh": CorrectedResponse(response, order_of(system))}
    law, load = system.terms.law, system.on_coordinates_by(missing)
    if law is None:
        q = yielding_to(system, load)
    else:
        equation, still = Equation(held_still(system)), np.zeros_like(response.displacement)
        q = equation.about(response.displacement, still).stiffness.solve(load)
    if (law is not None or system.terms.stiffening is not None) and not scene.analysis.allow_coarse:
        _refuse_large(system, response.displacement, q)
    found = replace(response, displacement=response.displacement + q)
    return {"mesh": corrected_for_mesh(system, found, missing, least=MESH_SAFETY.no_inertia)}


def _refuse_large(system: System, q: Array, change: Array) -> None:
    """Raise where the error of the mesh is so large a share of an answer that its first order does not estimate it.

    So it is next to a buckling load, which elements that are too long put too high.
    """
    share = np.abs(change).max(axis=1) / np.maximum(np.abs(q).max(axis=1), np.finfo(float).tiny)
    k = int(share.argmax())
    if share[k] > ESTIMATES.largest_change and np.abs(q[k]).max() > ESTIMATES.least * np.abs(q).max():
        theta = np.degrees(system.motion.theta[k])
        raise UnresolvedError(
            f"the elements are too long under axial forces at drive angle {theta:.6g} deg: shorter ones may change the "
            f"deflection by a share of {share[k]:.2g} or more, as near a buckling load. Take more elements; "
            "analysis.allow_coarse lets it pass"
        ).finer_by(elements=2.0)
