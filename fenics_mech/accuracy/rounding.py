"""What rounding takes of a response: members far stiffer than others lose digits where their elements are short."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import each
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.errors import UnresolvedError
from fenics_mech.forces.element_ends import elastic_forces
from fenics_mech.response.solution import Solution, StaticSolution


@dataclass(frozen=True)
class RoundingLimits:
    """How the loss by rounding is judged."""

    times: float = 10.0  # the share of the work: measured, strains lose 3 to 8 times as much
    largest: float = 1e-2  # of an answer: what is less is told with the error of the mesh


ROUNDING = RoundingLimits()


def lost_by_rounding(solution: Solution) -> float:
    """Estimate the share of a response that rounding of the stiffness takes.

    The forces f of the elements by their strains and those by their matrices, ``k v``, differ by rounding alone. The
    share is `RoundingLimits.times` the work of this difference over that of f, ``max |v (f - k v)| / max |v f|``.
    Static answers lose nothing, as they are refined.

    Parameters
    ----------
    solution
        The response.

    Raises
    ------
    UnresolvedError
        When it is more than `RoundingLimits.largest`, with the member whose elements are stiffest.
    """
    system, beams = solution.system, solution.system.beams
    if isinstance(solution, StaticSolution) or beams.reduction is not None:
        return 0.0
    v = system.to_links(solution.response.displacement)
    exact, rounded = elastic_forces(system, v), (beams.stiffness @ v.T).T
    if (law := system.terms.law) is not None:
        rounded += system.assembled(law.force(v, np.zeros_like(v)))
    energy = np.abs(np.sum(v * exact, axis=1)).max(initial=0.0)
    if not energy:
        return 0.0
    share = float(ROUNDING.times * np.abs(np.sum(v * (exact - rounded), axis=1)).max() / energy)
    if share > ROUNDING.largest:
        size = np.abs(in_member_axes(beams.mesh, v))
        by_element = np.sum(size * each(np.abs(beams.element_stiffness), size), axis=(0, 2))
        member = beams.mesh.members[beams.mesh.cell_member[int(by_element.argmax())]]
        raise UnresolvedError(
            f"rounding takes an estimated {share:.1e} of the answer, as member {member!r} has many elements for its "
            "stiffness. Take fewer there"
        )
    return share
