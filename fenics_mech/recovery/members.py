"""Section forces and deflection along the members, from equilibrium.

The curvature of a Hermite element is a poor one (4 % off at mid-span with 3 elements). The forces at an element's ends
are as good as the displacements, so the section forces follow from them and from the distributed inertia by statics.
This is the same as adding the clamped-clamped particular solution to the Hermite displacement.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from fenics_mech.beams import Beams
from fenics_mech.beams.assembly import element_dofs, member_rotation, shape_functions
from fenics_mech.mechanism import System
from fenics_mech.response import History

Array = NDArray[np.float64]
LINEAR = (Polynomial([1, -1]), Polynomial([0, 1]))  # (4.5), (4.8) on the unit element
CUBIC = (  # (4.6), (4.7), (4.9), (4.10)
    Polynomial([1, 0, -3, 2]),
    Polynomial([0, 1, -2, 1]),
    Polynomial([0, 0, 3, -2]),
    Polynomial([0, 0, -1, 1]),
)
AXIAL, NORMAL = [0, 3], [1, 2, 4, 5]  # an element's dofs along its axis, and normal to it


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


def recover_members(system: System, history: History, s: Array) -> MemberState:
    """Recover the members' state at stations `s`, the same on all members.

    Parameters
    ----------
    system
        The mechanism at the angles of the history.
    history
        Displacement and the inertia that balances it.
    s
        Places along the members, 0..1, shape ``(stations,)``.
    """
    beams = system.beams
    dofs, rotation = element_dofs(beams.mesh), member_rotation(beams.mesh)
    displacement = np.einsum("eij,tej->tei", rotation, system.to_links(history.displacement)[:, dofs])
    inertia = np.einsum("eij,tej->tei", rotation, history.inertia[:, dofs])
    ends = np.einsum("eij,tej->tei", beams.element_stiffness, displacement)
    ends += np.einsum("eij,tej->tei", beams.element_mass, inertia)  # forces on the element at its two nodes
    element, xi = locate(beams, s)
    h, rho_a = beams.mesh.cell_length[element], beams.line_density[element]
    along, normal = inertia[:, element][..., AXIAL], _scaled(inertia[:, element][..., NORMAL], h)
    first, second = (_integral(CUBIC, xi, times) for times in (1, 2))
    end = ends[:, element]
    shape = (len(end), len(beams.mesh.members), len(s))
    return MemberState(
        s=s,
        axial_force=(-end[..., 0] + rho_a * h * np.sum(along * _integral(LINEAR, xi, 1), -1)).reshape(shape),
        shear_force=(end[..., 1] - rho_a * h * np.sum(normal * first, -1)).reshape(shape),
        moment=(-end[..., 2] + end[..., 1] * xi * h - rho_a * h**2 * np.sum(normal * second, -1)).reshape(shape),
        deflection=_deflection(system, displacement[:, element], inertia[:, element], element, xi).reshape(*shape, 2),
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


def _deflection(system: System, displacement: Array, inertia: Array, element: NDArray[np.int64], xi: Array) -> Array:
    """Hermite displacement plus the particular solution of the inertia, in the fixed frame."""
    beams, mesh = system.beams, system.beams.mesh
    h, rho_a = mesh.cell_length[element], beams.line_density[element]
    linear, cubic = shape_functions(xi)
    u = np.sum(displacement[..., AXIAL] * linear, -1)
    u += rho_a * h**2 / beams.axial_rigidity[element] * np.sum(inertia[..., AXIAL] * _between_fixed_ends(xi), -1)
    w = np.sum(_scaled(displacement[..., NORMAL], h) * cubic, -1)
    particular = np.sum(_scaled(inertia[..., NORMAL], h) * _between_clamped_ends(xi), -1)
    w -= rho_a * h**4 / beams.bending_rigidity[element] * particular
    member = mesh.cell_member[element]
    angle = system.motion.angle[:, mesh.member_link[member]] + mesh.member_angle[member]
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * u - s * w, s * u + c * w], axis=-1)


def _scaled(dofs: Array, h: Array) -> Array:
    """Displacements and rotations of elements as those of unit elements: rotations times h."""
    return dofs * np.stack([np.ones_like(h), h, np.ones_like(h), h], axis=-1)


def _integral(functions: tuple[Polynomial, ...], xi: Array, times: int) -> Array:
    """Integrals from 0 of the functions, ``(points, functions)``."""
    return np.stack([f.integ(times)(xi) for f in functions], axis=-1)


def _between_fixed_ends(xi: Array) -> Array:
    """Answers of ``u'' = N_j`` with u = 0 at both ends of the unit element."""
    at_end = _integral(LINEAR, np.ones(1), 2)
    return _integral(LINEAR, xi, 2) - at_end * xi[:, None]


def _between_clamped_ends(xi: Array) -> Array:
    """Answers of ``w'''' = N_j`` with w = w' = 0 at both ends of the unit element."""
    value, slope = (_integral(CUBIC, np.ones(1), times) for times in (4, 3))
    x = xi[:, None]
    return _integral(CUBIC, xi, 4) - (3 * value - slope) * x**2 - (slope - 2 * value) * x**3
