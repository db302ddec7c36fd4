"""Mass of elements, lumped at their nodes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech.beams.distributions import Distribution
from fenics_mech.beams.element_dofs import element_dofs
from fenics_mech.beams.offset_pins import refuse_offsets
from fenics_mech.scene import RigidBody, Scene

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams

SCALED_DIAGONAL = 1 / 39  # of a lump's moment of inertia over its mass and the square of the element's length


def lumped(scene: Scene, links: Beams) -> Beams:
    """Give the beams' mass to bodies at the nodes: ``int rho A N dx`` with the linear functions N."""
    # A body without a moment of inertia would leave the mass singular. Each has what the scaled diagonal of the
    # consistent mass gives it, rho A h^3/78 from each uniform element: Hinton, Rock and Zienkiewicz, Earthquake Eng.
    # Struct. Dyn. 4 (1976) 245. Between the nodes the beams have no mass: bending moments run straight there.
    refuse_offsets(scene.rigidity, scene.members(), "lumped-mass")
    mesh = links.mesh
    mass = np.stack([links.element_mass[:, i, [0, 3]].sum(axis=1) for i in (0, 3)], axis=1)  # (elements, 2)
    nodes = element_dofs(mesh)[:, [0, 3]] // 3
    size = len(mesh.node_name)
    lumps = np.bincount(nodes.ravel(), mass.ravel(), size)
    turning = np.bincount(nodes.ravel(), (SCALED_DIAGONAL * mass * mesh.cell_length[:, None] ** 2).ravel(), size)
    bodies = tuple((int(i), RigidBody(mass=lumps[i], inertia=turning[i])) for i in np.flatnonzero(lumps))
    density = Distribution.constant(links.layout, np.zeros(len(mesh.cell)))
    spread = links.inertia
    return replace(links, inertia=replace(spread, density=density, bodies=(*spread.bodies, *bodies), spread=spread))
