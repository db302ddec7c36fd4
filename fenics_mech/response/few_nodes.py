"""The same mechanism with few of its nodes, where a mesh is far finer than estimates of errors need.

What the steps do to a motion, and what its theory leaves out, are found there in a small part of the time and memory.
They are taken where the two motions differ little. Stability is judged with all nodes: natural frequencies that differ
by a thousandth may lie on other sides of the edge of a resonance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, each
from fenics_mech._constants import TINY
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.other_mesh import nodal_on
from fenics_mech.beams.shapes import AXIAL, NORMAL
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System
from fenics_mech.mechanism.beam_links import links
from fenics_mech.response.axial_forces import settles
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.setup import system_at
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import thinned


@dataclass(frozen=True)
class FewNodesLimits:
    """When fewer nodes are enough."""

    from_elements: int = 24  # in a member, beyond which others are left out: with fewer that takes as long
    kept: int = 12  # elements of such a member
    largest_difference: float = 0.01  # of the root of a member's strain energy: estimates have two digits
    least: float = 1e-6  # of the largest energy of a member, below which another's difference does not count


FEW_NODES = FewNodesLimits()


def on_few_nodes(scene: Scene, system: System) -> tuple[Scene, System] | None:
    """Give a scene with few of its nodes, and its mechanism at the same positions; None where it needs them all.

    Pins that travel pass from element to element, and loads that jump excite modes beyond any mesh.

    Parameters
    ----------
    scene, system
        The scene, and its mechanism at the positions of a cycle.
    """
    mesh, analysis = system.beams.mesh, scene.analysis
    fine = np.flatnonzero(np.bincount(mesh.cell_member) > FEW_NODES.from_elements)
    if not len(fine) or not analysis.error_estimates:
        return None
    needs_all = system.transformation.constraints.contacts or settles(analysis.tension, system.terms)
    if needs_all or Steps.of(scene).disturbed:
        return None
    few = thinned(scene, [mesh.members[i] for i in fine], FEW_NODES.kept).changed(analysis__stability=False)
    return few, system_at(few, links(few), system.motion)


def difference(few: tuple[System, ElasticResponse], whole: tuple[System, ElasticResponse]) -> float:
    """Give by how much two responses differ at the few nodes, as a share of the root of a member's strain energy.

    The largest share of all members counts. Bending is compared with bending, as axial displacements of large
    rotations hold energy that is none of strains.

    Parameters
    ----------
    few, whole
        Mechanism and response on few nodes, and on all.
    """
    mesh = few[0].beams.mesh
    here, there = (system.to_links(response.displacement) for system, response in (few, whole))
    apart = (nodal_on(mesh, whole[0].beams.mesh) @ there.T).T - here
    bending, stretching = (_energy(few[0], here, dofs) for dofs in (NORMAL, AXIAL))
    shares = [
        _energy(few[0], apart, dofs) / np.maximum(size, max(FEW_NODES.least * size.max(), TINY))
        for dofs, size in ((NORMAL, bending), (AXIAL, bending + stretching))
    ]
    return float(np.sqrt(np.max(shares)))


def _energy(system: System, v: Array, dofs: list[int]) -> Array:
    """Give twice the largest strain energy of each member (J) in some dofs of its elements, ``(members,)``.

    Parameters
    ----------
    system
        The mechanism.
    v
        Displacements of its nodes in link axes, ``(angles, 3 nodes)``.
    dofs
        Those along the elements, or across.
    """
    mesh = system.beams.mesh
    moved = in_member_axes(mesh, v)[..., dofs]
    of_elements = np.sum(moved * each(system.beams.element_stiffness[:, dofs][..., dofs], moved), axis=-1)
    return np.array([np.bincount(mesh.cell_member, row) for row in of_elements]).max(axis=0)
