"""Strains and deflections inside the elements by their equilibrium.

The forces on an element's ends are as good as its displacements. From them and from the inertia along the element
follow N and M by statics. The curvature of the cubic shape would miss what the inertia bends.
"""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array, Index, each
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.shapes import (
    AXIAL,
    CUBIC,
    LINEAR,
    NORMAL,
    between_clamped_ends,
    between_fixed_ends,
    evaluate,
    integral,
)
from fenics_mech.classical.joints import turns
from fenics_mech.classical.mechanism import Transformation


def stations(mesh: BeamMesh, s: Array) -> tuple[Index, Array]:
    """Element and place 0..1 in it of each station `s` (0..1) of each member, both ``(members x stations,)``."""
    elements, places = [], []
    for member, length in enumerate(mesh.member_length):
        cells = np.flatnonzero(mesh.cell_member == member)
        here = cells[np.clip(np.searchsorted(mesh.cell_start[cells], s * length, side="right") - 1, 0, None)]
        elements.append(here)
        places.append((s * length - mesh.cell_start[here]) / mesh.cell_length[here])
    return np.concatenate(elements), np.clip(np.concatenate(places), 0, 1)


def end_forces(P: Transformation, strained: Array, inertia: Array) -> Array:
    """Give forces and moments on the ends of the elements in their members' axes, ``(positions, elements, 6)``."""
    # strained (positions, nodal dofs)
    links = P.made.links
    assert links is not None
    return links.elastic_ends(strained) + each(links.element_mass, in_member_axes(links.mesh, inertia))


def section_forces(P: Transformation, strained: Array, inertia: Array, s: Array) -> tuple[Array, Array, Array]:
    """Give axial forces, shear forces (N) and moments (N m) in sections, ``(positions, members, stations)`` each."""
    links = P.made.links
    assert links is not None
    mesh, (element, xi) = links.mesh, stations(links.mesh, s)
    h, rho = mesh.cell_length[element], links.inertia.density.mean[element]
    ends, accelerated = end_forces(P, strained, inertia)[:, element], in_member_axes(mesh, inertia)[:, element]
    along, across = accelerated[..., AXIAL], accelerated[..., NORMAL] * _of_unit(h)
    axial = -ends[..., 0] + rho * h * _summed(along, integral(LINEAR, xi))
    shear = ends[..., 1] - rho * h * _summed(across, integral(CUBIC, xi))
    moment = -ends[..., 2] + ends[..., 1] * xi * h - rho * h**2 * _summed(across, integral(CUBIC, xi, 2))
    shape = (len(ends), len(mesh.members), len(s))
    return axial.reshape(shape), shear.reshape(shape), moment.reshape(shape)


def deflection(P: Transformation, v: Array, inertia: Array, s: Array) -> Array:
    """Give deflections of the members' axes in the fixed frame (m), ``(positions, members, stations, 2)``."""
    # v (positions, nodal dofs)
    links = P.made.links
    assert links is not None
    mesh, (element, xi) = links.mesh, stations(links.mesh, s)
    properties = mesh.cell_length, links.rigidity.axial.mean, links.rigidity.bending.mean, links.inertia.density.mean
    h, ea, ei, rho = (part[element] for part in properties)
    moved, accelerated = (in_member_axes(mesh, part)[:, element] for part in (v, inertia))
    u, w = moved[..., AXIAL], moved[..., NORMAL] * _of_unit(h)
    along, across = accelerated[..., AXIAL], accelerated[..., NORMAL] * _of_unit(h)
    bent = _summed(across, between_clamped_ends(CUBIC, xi))
    u_here = _summed(u, evaluate(LINEAR, xi)) + rho * h**2 / ea * _summed(along, between_fixed_ends(LINEAR, xi))
    w_here = _summed(w, evaluate(CUBIC, xi)) - rho * h**4 / ei * bent
    turned = turns(P.motion.angle[:, mesh.member_link] + mesh.member_angle)[:, :, None]
    local = np.stack([u_here, w_here], axis=-1).reshape(len(v), len(mesh.members), len(s), 2)
    return np.asarray((turned @ local[..., None])[..., 0])


def _of_unit(h: Array) -> Array:
    """What turns w and phi of both nodes into those of a unit element, ``(places, 4)``."""
    return np.stack([np.ones_like(h), h, np.ones_like(h), h], axis=-1)


def _summed(values: Array, functions: Array) -> Array:
    return np.einsum("kpi,pi->kp", values, functions)
