"""Strain at the middle (or any point) of the hand-coded links, recovered from equilibrium.

The curvature of a cubic element is linear, so EI w'' misses the part of the bending moment that the inertia inside the
element makes. The forces at the element's ends are right, and statics from there to the wanted point brings in the
inertia on the way. In the quasi-static limit that is exact for any number of elements.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from .nine_element import Array, NineElementModel, element_mass, element_stiffness


@dataclass(frozen=True)
class LinkStrain:
    """Strain of the links (crank, coupler, follower) at the "+" fibre, that of the w side, shape ``(angles, links)``.

    Parameters
    ----------
    axial
        N/EA.
    bending
        -n M/EI, with M = EI w''.
    """

    axial: Array
    bending: Array

    @property
    def total(self) -> Array:
        """Axial plus bending strain, shape ``(angles, 3)``."""
        return self.axial + self.bending


def link_strain(
    model: NineElementModel,
    theta: ArrayLike,
    displacement: Array,
    acceleration: Array | None = None,
    s: float = 0.5,
) -> LinkStrain:
    """Strain at position `s` of each link from the forces at the ends of the element that holds it.

    Parameters
    ----------
    model
        The linkage.
    theta
        Crank angles (rad), shape ``(angles,)``.
    displacement
        Elastic displacement q (m, rad), shape ``(angles, dofs)``.
    acceleration
        Elastic acceleration with the damping's share, M^-1 (f - K q) or its modal part (m/s^2, rad/s^2), shape
        ``(angles, dofs)``; zero when left out.
    s
        Place along the link, 0 to 1. At a node the element that begins there is taken.

    Returns
    -------
    LinkStrain
        Axial and bending strain, shape ``(angles, 3)``.
    """
    p = model.parameters
    element = min(int(s * model.elements + 1e-9), model.elements - 1)
    dofs = slice(3 * element, 3 * element + 6)
    xi = s * model.elements - element
    strains = []
    for link, (tr, rigid) in enumerate(zip(model.transformations(theta), model.rigid_acceleration(theta), strict=True)):
        line_density, length = p.rho * p.area[link], model.element_lengths[link]
        u = np.einsum("tij,tj->ti", tr.value[:, dofs], displacement)
        a = rigid[:, dofs].copy()
        if acceleration is not None:
            a += np.einsum("tij,tj->ti", tr.value[:, dofs], acceleration)
        stiffness = element_stiffness(p.E, p.area[link], p.inertia[link], length)
        end = u @ stiffness + a @ element_mass(line_density, length)  # (4.31), both matrices symmetric
        axial_inertia, moment_inertia = _inertia_before(a, xi, length)
        force = -end[:, 0] + line_density * axial_inertia
        moment = -end[:, 2] + xi * length * end[:, 1] - line_density * moment_inertia
        strains.append((force / (p.E * p.area[link]), -p.fibre[link] * moment / (p.E * p.inertia[link])))
    axial, bending = np.moveaxis(np.array(strains), 0, 2)
    return LinkStrain(axial, bending)


def _inertia_before(acceleration: Array, xi: float, length: float) -> tuple[Array, Array]:
    """Integrals of the acceleration from an element's first node to xi times its length h (m), ``(angles,)`` each.

    They are those of the axial acceleration (m^2/s^2), and of (xi h - x) times the transverse one (m^3/s^2). Nodal
    accelerations are ``(angles, 6)``, with u linear and w cubic in between.
    """
    axial = length * np.array([xi - xi**2 / 2, xi**2 / 2])  # of N1 (4.5) and N4 (4.8)
    moment = length**2 * np.array(
        [
            xi**2 / 2 - xi**4 / 4 + xi**5 / 10,  # of N2 (4.6)
            length * (xi**3 / 6 - xi**4 / 6 + xi**5 / 20),  # of N3 (4.7)
            xi**4 / 4 - xi**5 / 10,  # of N5 (4.9)
            length * (-(xi**4) / 12 + xi**5 / 20),  # of N6 (4.10)
        ]
    )
    return acceleration[:, [0, 3]] @ axial, acceleration[:, [1, 2, 4, 5]] @ moment
