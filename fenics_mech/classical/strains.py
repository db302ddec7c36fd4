"""Strains and deflections inside the elements by their equilibrium.

The forces on an element's ends are as good as its displacements. From them and from the inertia along the element
follow N and M by statics. The curvature of the cubic shape would miss what the inertia bends.
"""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array, Index, each
from fenics_mech._petsc import to_scipy
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
from fenics_mech.classical.linkage import Motion, turns
from fenics_mech.classical.links import Links


def stations(mesh: BeamMesh, s: Array) -> tuple[Index, Array]:
    """Element and place 0..1 in it of each station `s` (0..1) of each member, both ``(members x stations,)``."""
    elements, places = [], []
    for member, length in enumerate(mesh.member_length):
        cells = np.flatnonzero(mesh.cell_member == member)
        here = cells[np.clip(np.searchsorted(mesh.cell_start[cells], s * length, side="right") - 1, 0, None)]
        elements.append(here)
        places.append((s * length - mesh.cell_start[here]) / mesh.cell_length[here])
    return np.concatenate(elements), np.clip(np.concatenate(places), 0, 1)


def recovered(links: Links, motion: Motion, v: Array, inertia: Array, s: Array) -> tuple[Array, Array]:
    """Give strains of both outer fibres (6.38), and deflections in the fixed frame.

    Parameters
    ----------
    links, motion
        The links and their rigid motion.
    v
        Elastic displacements of the nodal dofs in link axes, ``(positions, nodal dofs)``.
    inertia
        Their acceleration, of the rigid and the elastic motion, in balance with the elastic forces.
    s
        Places along the members, 0..1.

    Returns
    -------
    tuple
        Strains, ``(positions, members, stations, 2)``, and deflections (m), the same with X and Y last.
    """
    mesh, (element, xi) = links.mesh, stations(links.mesh, s)
    h, ea, ei, rho = (part[element] for part in (mesh.cell_length, links.axial, links.bending, links.density))
    stiffness, mass = (links.layout.of_elements(to_scipy(matrix)) for matrix in (links.stiffness, links.mass))
    moved, accelerated = in_member_axes(mesh, v), in_member_axes(mesh, inertia)
    ends = (each(stiffness, moved) + each(mass, accelerated))[:, element]
    unit = np.stack([np.ones_like(h), h, np.ones_like(h), h], axis=-1)  # cubics of a unit element
    u, w = moved[:, element][..., AXIAL], moved[:, element][..., NORMAL] * unit
    along, across = accelerated[:, element][..., AXIAL], accelerated[:, element][..., NORMAL] * unit

    def summed(values: Array, functions: Array) -> Array:
        return np.einsum("kpi,pi->kp", values, functions)

    axial = -ends[..., 0] + rho * h * summed(along, integral(LINEAR, xi))
    moment = -ends[..., 2] + ends[..., 1] * xi * h - rho * h**2 * summed(across, integral(CUBIC, xi, 2))
    u_here = summed(u, evaluate(LINEAR, xi)) + rho * h**2 / ea * summed(along, between_fixed_ends(LINEAR, xi))
    bent = summed(across, between_clamped_ends(CUBIC, xi, np.zeros_like(xi)))
    w_here = summed(w, evaluate(CUBIC, xi)) - rho * h**4 / ei * bent
    shape = (len(v), len(mesh.members), len(s))
    fibre = np.array([np.broadcast_to(section.fibre, (len(s), 2)) for section in links.scene.rigidities(s)])
    bending = -(moment / ei).reshape(shape)[..., None] * fibre
    turned = turns(motion.pose[:, mesh.member_link, 2] + mesh.member_angle)[:, :, None]
    local = np.stack([u_here, w_here], axis=-1).reshape(*shape, 2)
    return (axial / ea).reshape(shape)[..., None] + bending, (turned @ local[..., None])[..., 0]
