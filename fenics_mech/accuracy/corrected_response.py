"""A response without one of its sources of error: the difference is the error, to its first order."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech.accuracy.mesh_residual import order_of
from fenics_mech.effects import UNLOADED, Loads
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class EstimateLimits:
    """Convergence orders of the estimates of errors, and factors on them."""

    of_steps: float = 1.25  # factor: differences of steps are 0.97 to 1.2 of the true error of 13 motions
    of_blows: float = 2.0  # the same where impulses and jumps disturb the motion: 0.4 to 1.35
    little: float = 1e-4  # of a motion, that a vibration which is taken as linear is
    harmonic_order: int = 8  # the series falls faster than any power; this asks for harmonics enough
    mode_order: float = 2.0  # in the cutoff, of the answer of the modes left out
    rougher: float = 10.0  # tolerance of the steps that estimate the error of others, over that of those
    rough_share: float = 0.5  # factor on the difference by them
    finer: float = 0.5  # the same tolerance where contacts open, of which rough steps lose some
    finer_share: float = 4.0  # factor on the difference by them
    longer: float = 1.3  # longest of those steps over that of others, which bounds them whatever the tolerance
    largest_change: float = 0.3  # share of an answer at one position
    least: float = 1e-3  # share of the largest answer over the cycle, that such an answer must be to count


ESTIMATES = EstimateLimits()


@dataclass(frozen=True)
class MeshSafety:
    """Factors by which differences by the mesh are raised, where their first order is less than the error."""

    varying_section: float = 1.25  # or lumped mass: the difference is 0.57 of the error or more
    travelling_pin: float = 1.25  # the difference is 0.75 to 1.4 of the error
    one_element: float = 2.5  # whose section varies: the error is 0.8 to 5 times its first order
    no_inertia: float = 1.25  # the difference is 0.76 to 1.1 of the error, with one element a member too
    constant: float = 1e-9  # change of a section along an element, of its mean, that is rounding


MESH_SAFETY = MeshSafety()


@dataclass(frozen=True)
class CorrectedResponse:
    """A response without one source of error.

    Parameters
    ----------
    response
        The response without it.
    order
        Convergence order of the error: in the number of steps, elements, modes or harmonics.
    safety
        Factor by which differences are raised, as they are less than the true error.
    loads
        Loads that act beside those of the system.
    remark
        What the difference leaves unknown of the error.
    """

    response: ElasticResponse
    order: float
    safety: float = 1.0
    loads: Loads = UNLOADED
    remark: str = ""


@dataclass(frozen=True)
class WithoutMesh(CorrectedResponse):
    """A response without the error by the mesh, to its first order.

    Parameters
    ----------
    share
        How much of the error it is without: little, where the response is linear for little only.
    near
        Whether a resonance is so near that the first order does not tell the error.
    """

    share: float = 1.0
    near: bool = False


def corrected_for_mesh(
    system: System,
    response: ElasticResponse,
    loads: Loads,
    *,
    least: float = 1.0,
    share: float = 1.0,
    near: bool = False,
) -> WithoutMesh:
    """Say how the error by the mesh falls, and raise it by its safety factor, `least` or more.

    Parameters
    ----------
    system
        The mechanism.
    response
        The response without the error.
    loads
        What the elements neglect.
    least
        Smallest factor.
    share, near
        As of `WithoutMesh`.
    """
    safety = max(least, _safety_of(system))
    return WithoutMesh(response, order_of(system), safety, loads, share=share, near=near)


def _safety_of(system: System) -> float:
    """Factor by which the error of a mesh is raised."""
    beams = system.beams
    least = MESH_SAFETY.travelling_pin if system.transformation.constraints.contacts else 1.0
    if not beams.rigidity.varies:
        return least if beams.inertia.spread is None else max(least, MESH_SAFETY.varying_section)
    powers = np.abs(beams.rigidity.powers)
    varies = (powers[..., 1:].max(axis=-1, initial=0.0) > MESH_SAFETY.constant * powers[..., 0]).any(axis=1)
    members = beams.mesh.cell_member
    alone = np.bincount(members)[members] == 1
    return MESH_SAFETY.one_element if alone[varies].any() else max(least, MESH_SAFETY.varying_section)
