"""The error by the mesh: its first order where that tells it, and else the difference from finer meshes.

The first order does not tell the error where a harmonic lies between the frequencies of a mode on the mesh and of the
linkage. Vibration on modes that the mesh has far off is bounded, and the bound may be many times too large. The motion
on halved elements has that vibration. By the triangle inequality the error is at most the difference from it, and the
error of that motion. So elements are halved until the first order tells the error that is left.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from fenics_mech._arrays import Array
from fenics_mech.accuracy.base_response import Compared
from fenics_mech.accuracy.corrected_response import CorrectedResponse, WithoutMesh
from fenics_mech.accuracy.feedback import without_mesh
from fenics_mech.accuracy.finer_mesh import on_finer_mesh
from fenics_mech.accuracy.periodic_errors import answer_of
from fenics_mech.accuracy.quantities import Quantities, stations_of
from fenics_mech.forces.air import drag_known
from fenics_mech.response.solution import CollocationSolution, HarmonicSolution, PeriodicSolution

NOT_RESOLVED = "what the mesh does next to a resonance, as halved elements do not settle it"


@dataclass(frozen=True)
class HalvingLimits:
    """When elements are halved to know an error."""

    believed: float = 0.01  # of the largest of a quantity: errors up to it are what their first order tells
    worth: float = 1e-4  # the same: a bound up to which is not asked whether it is too large
    of_change: float = 0.5  # of the difference by halved elements, to the same end: it is then 1.5 times the error
    most: int = 3  # times: a frequency that one element has 58 % too high is 0.04 % off by then


HALVING = HalvingLimits()


def error_of_mesh(whole: Compared, without: CorrectedResponse) -> tuple[dict[str, Array], str]:
    """Give the error of each quantity by the mesh, and what is not known of it.

    Parameters
    ----------
    whole
        The response.
    without
        The response without the first order of the error.

    Returns
    -------
    tuple
        By quantity, ``(members, joints or drives,)``, and words, which are empty where all is known.
    """
    first, missed = _first_order(whole, without), whole.missed.get("mesh", {})
    largest = {name: float(size.max(initial=0.0)) for name, size in whole.base.largest.items()}
    bounded = _bounded(missed, {name: max(HALVING.worth * largest[name], _most(first, name)) for name in missed})
    believed = all(_most(first, name) <= HALVING.believed * largest[name] for name in first)
    if not isinstance(whole.solution, PeriodicSolution) or (bounded and believed and not _near(without)):
        found, remark = _sum(first, missed), ""
    else:
        found, remark = _by_halves(whole, _sum(first, missed), HALVING.most)
    return found, remark


def _by_halves(whole: Compared, known: dict[str, Array], times: int) -> tuple[dict[str, Array], str]:
    """Give the error by motions on halved elements, so many times or less; `known` is told where there are none."""
    solution = whole.solution
    assert isinstance(solution, PeriodicSolution)
    if not times or (finer := on_finer_mesh(solution)) is None:
        return known, NOT_RESOLVED
    system, response = drag_known(finer.scene, finer.system, finer.response), finer.response.undamped
    there = Quantities.of(finer.scene, system, response, s=stations_of(whole.system))
    change, halved, without = (there - whole.base).largest, Compared.of(finer, system), _without_mesh(finer)
    first, missed = _first_order(halved, without), halved.missed.get("mesh", {})
    enough = {name: max(HALVING.of_change * _most(change, name), _most(first, name)) for name in missed}
    left, remark = _sum(first, missed), ""
    if _near(without) or not _bounded(missed, enough):
        left, remark = _by_halves(halved, left, times - 1)
    return _sum(change, left), remark


def _first_order(whole: Compared, without: CorrectedResponse) -> dict[str, Array]:
    return {name: without.safety * part for name, part in whole.change("mesh", without).items()}


def _near(without: CorrectedResponse) -> bool:
    return isinstance(without, WithoutMesh) and without.near


def _most(errors: Mapping[str, Array], name: str) -> float:
    return float(errors[name].max(initial=0.0)) if name in errors else 0.0


def _bounded(missed: Mapping[str, Array], enough: Mapping[str, float]) -> bool:
    """Whether what vibrations that the mesh may miss change of no quantity is more than enough."""
    return all(_most(missed, name) <= enough[name] for name in missed)


def _sum(first: Mapping[str, Array], second: Mapping[str, Array]) -> dict[str, Array]:
    return {**second, **{name: part + second.get(name, 0.0) for name, part in first.items()}}


def _without_mesh(solution: PeriodicSolution) -> WithoutMesh:
    """Give a response without the first order of its error by the mesh."""
    assert isinstance(solution, CollocationSolution | HarmonicSolution)
    return without_mesh(answer_of(solution), solution.response)
