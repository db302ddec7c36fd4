"""Section forces and deflection along the members, from equilibrium.

The curvature of a Hermite element is a poor one (4 % off at mid-span with 3 elements). The forces at an element's ends
are as good as the displacements, so the section forces follow from them and from the distributed inertia by statics.
This is the same as adding the clamped-clamped particular solution to the Hermite displacement.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech.beams import Beams
from fenics_mech.beams.layout import element_dofs, member_rotation
from fenics_mech.beams.shapes import AXIAL, CUBIC, LINEAR, NORMAL, evaluate, integral
from fenics_mech.mechanism import System
from fenics_mech.recovery.contacts import PointLoad
from fenics_mech.response import History

Array = NDArray[np.float64]


@dataclass(frozen=True)
class MemberState:
    """State of all members at the stations `s` (0..1), arrays of shape ``(angles, members, stations)``.

    Parameters
    ----------
    s
        Stations along every member, 0..1.
    axial_force, shear_force, moment
        N (N, tension positive), dM/ds (N), and M = EI w'' (N m).
    deflection
        Elastic displacement in the fixed frame (m), ``(angles, members, stations, 2)``.
    """

    s: Array
    axial_force: Array
    shear_force: Array
    moment: Array
    deflection: Array


def recover_members(system: System, history: History, s: Array, loads: Sequence[PointLoad] = ()) -> MemberState:
    """Recover the members' state at stations `s`, the same on all members.

    Parameters
    ----------
    system
        The mechanism at the angles of the history.
    history
        Displacement and the inertia that balances it.
    s
        Places along the members, 0..1, shape ``(stations,)``.
    loads
        Point loads on the members, beside those at their ends.
    """
    beams = system.beams
    dofs, rotation = element_dofs(beams.mesh), member_rotation(beams.mesh)
    displacement = np.einsum("eij,tej->tei", rotation, system.to_links(history.displacement)[:, dofs])
    inertia = np.einsum("eij,tej->tei", rotation, history.inertia[:, dofs])
    ends = np.einsum("eij,tej->tei", beams.element_stiffness, displacement)
    ends += np.einsum("eij,tej->tei", beams.element_mass, inertia)  # forces on the element at its two nodes
    for load in loads:
        h = beams.mesh.cell_length[load.element]
        ends[np.arange(len(ends)), load.element] -= load.at_ends(h)
    element, xi = locate(beams, s)
    h = beams.mesh.cell_length[element]
    along, normal = inertia[:, element][..., AXIAL], _scaled(inertia[:, element][..., NORMAL], h)
    linear, first, second = _mass_up_to(beams, element, xi)
    end = ends[:, element]
    axial = -end[..., 0] + h * np.sum(along * linear, -1)
    shear = end[..., 1] - h * np.sum(normal * first, -1)
    moment = -end[..., 2] + end[..., 1] * xi * h - h**2 * np.sum(normal * second, -1)
    u, w = _in_member(beams, displacement[:, element], inertia[:, element], element, xi)
    for load in loads:
        axial, shear, moment = (a + b for a, b in zip((axial, shear, moment), load.beyond(element, xi, h)))
        extra_u, extra_w = load.displacement(element, xi, h)
        u, w = u + extra_u / beams.axial_rigidity[element], w + extra_w / beams.bending_rigidity[element]
    shape = (len(end), len(beams.mesh.members), len(s))
    return MemberState(
        s=s,
        axial_force=axial.reshape(shape),
        shear_force=shear.reshape(shape),
        moment=moment.reshape(shape),
        deflection=_in_fixed_frame(system, u, w, element).reshape(*shape, 2),
    )


def locate(beams: Beams, s: Array) -> tuple[NDArray[np.int64], Array]:
    """Element and place 0..1 in it of each station of each member, both ``(members x stations,)``."""
    mesh = beams.mesh
    elements, places = [], []
    for i, length in enumerate(mesh.member_length):
        cells = np.flatnonzero(mesh.cell_member == i)
        inside = np.clip(np.searchsorted(mesh.cell_start[cells], s * length, side="right") - 1, 0, None)
        elements.append(cells[inside])
        places.append(np.clip((s * length - mesh.cell_start[cells[inside]]) / mesh.cell_length[cells[inside]], 0, 1))
    return np.concatenate(elements), np.concatenate(places)


def _mass_up_to(beams: Beams, element: NDArray[np.int64], xi: Array) -> tuple[Array, Array, Array]:
    """Integrals of rho A times shape functions from an element's start to places xi in it (kg/m).

    Returns
    -------
    tuple
        Of the linear functions ``(places, 2)``, of the cubic ones ``(places, 4)``, and twice of the cubic ones.
    """
    if beams.density_powers is None:
        rho_a = beams.line_density[element, None]
        return rho_a * integral(LINEAR, xi), rho_a * integral(CUBIC, xi), rho_a * integral(CUBIC, xi, 2)
    powers = beams.density_powers[element]
    points, weights = np.polynomial.legendre.leggauss(
        (powers.shape[-1] + 5) // 2
    )  # exact to twice the number, less one
    places = xi[:, None] * (1 + points) / 2
    share = weights / 2 * xi[:, None]
    share = share * np.einsum("sgp,sp->sg", places[..., None] ** np.arange(powers.shape[-1]), powers)
    linear, cubic = evaluate(LINEAR, places), evaluate(CUBIC, places)
    arm = xi[:, None] - places  # twice the integral of f up to xi is once that of (xi - t) f(t)
    return tuple(np.einsum("sg,sgj->sj", w, f) for w, f in ((share, linear), (share, cubic), (share * arm, cubic)))


def _in_member(
    beams: Beams, displacement: Array, inertia: Array, element: NDArray[np.int64], xi: Array
) -> tuple[Array, Array]:
    """Displacements u and w: those of the shape functions, and the particular solution of the inertia."""
    h, rho_a = beams.mesh.cell_length[element], beams.line_density[element]
    u = np.sum(displacement[..., AXIAL] * evaluate(LINEAR, xi), -1)
    u += rho_a * h**2 / beams.axial_rigidity[element] * np.sum(inertia[..., AXIAL] * _between_fixed_ends(xi), -1)
    w = np.sum(_scaled(displacement[..., NORMAL], h) * evaluate(CUBIC, xi), -1)
    particular = np.sum(_scaled(inertia[..., NORMAL], h) * _between_clamped_ends(xi), -1)
    return u, w - rho_a * h**4 / beams.bending_rigidity[element] * particular


def _in_fixed_frame(system: System, u: Array, w: Array, element: NDArray[np.int64]) -> Array:
    mesh = system.beams.mesh
    member = mesh.cell_member[element]
    angle = system.motion.angle[:, mesh.member_link[member]] + mesh.member_angle[member]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * u - s * w, s * u + c * w], axis=-1)


def _scaled(dofs: Array, h: Array) -> Array:
    """Displacements and rotations of elements as those of unit elements: rotations times h."""
    return dofs * np.stack([np.ones_like(h), h, np.ones_like(h), h], axis=-1)


def _between_fixed_ends(xi: Array) -> Array:
    """Answers of ``u'' = N_j`` with u = 0 at both ends of the unit element."""
    at_end = integral(LINEAR, np.ones(1), 2)
    return integral(LINEAR, xi, 2) - at_end * xi[:, None]


def _between_clamped_ends(xi: Array) -> Array:
    """Answers of ``w'''' = N_j`` with w = w' = 0 at both ends of the unit element."""
    value, slope = (integral(CUBIC, np.ones(1), times) for times in (4, 3))
    x = xi[:, None]
    return integral(CUBIC, xi, 4) - (3 * value - slope) * x**2 - (slope - 2 * value) * x**3
