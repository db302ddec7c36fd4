"""The same mechanism with few of its nodes, where a mesh is far finer than steps, theory and stability need.

A dozen elements a member have the motion to 1e-4 of it or better. What the steps do to it, what its theory leaves out,
and whether it is stable, are found there in a small part of the time and memory. How far the two motions differ is
checked.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import each
from fenics_mech._constants import TINY
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.mesh import BeamMesh
from fenics_mech.beams.other_mesh import nodal_on
from fenics_mech.beams.shapes import NORMAL
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System
from fenics_mech.mechanism.beam_links import links
from fenics_mech.response.axial_forces import settles
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.setup import system_at
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import thinned


@dataclass(frozen=True)
class FewNodesLimits:
    """When fewer nodes are enough."""

    from_elements: int = 24  # in a member, beyond which others are left out: with fewer that takes as long
    kept: int = 12  # elements of such a member
    largest_difference: float = 0.01  # of the root of a member's energy of bending: estimates have two digits
    border: float = 0.01  # of a multiplier's magnitude from 1, within which all nodes judge: few move it by 0.0015
    rounding: float = 64.0  # times that of numbers and the fourth power of elements: measured, 5 to 25 with 100, 300
    least: float = 1e-6  # of the largest energy of a member, below which another's difference does not count


FEW_NODES = FewNodesLimits()


def on_few_nodes(scene: Scene, system: System) -> tuple[Scene, System] | None:
    """Give a scene with few of its nodes, and its mechanism at the same positions; None where it needs them all.

    Pins that travel pass from element to element, loads that jump excite modes beyond any mesh, and reduced members
    have few coordinates.

    Parameters
    ----------
    scene, system
        The scene, and its mechanism at the positions of a cycle.
    """
    mesh, analysis = system.beams.mesh, scene.analysis
    fine = np.flatnonzero(np.bincount(mesh.cell_member) > FEW_NODES.from_elements)
    if not len(fine) or not (analysis.stability or analysis.error_estimates):
        return None
    needs_all = system.transformation.constraints.contacts or settles(analysis.tension, system.terms)
    if needs_all or analysis.reduction != "none" or Steps.of(scene).disturbed:
        return None
    few = thinned(scene, [mesh.members[i] for i in fine], FEW_NODES.kept)
    return few, system_at(few, links(few), system.motion)


def difference(few: tuple[System, ElasticResponse], whole: tuple[System, ElasticResponse]) -> float:
    """Give by how much two responses differ, as the largest share of the root of a member's energy of bending.

    Parameters
    ----------
    few, whole
        Mechanism and response on few nodes, and on all.
    """
    mesh = few[0].beams.mesh
    places = nodal_on(mesh, whole[0].beams.mesh)
    here, there = (system.to_links(response.displacement) for system, response in (few, whole))
    stiffness, energies = few[0].beams.element_stiffness[:, NORMAL][..., NORMAL], []
    for v in (here, (places @ there.T).T - here):
        bent = in_member_axes(mesh, v)[..., NORMAL]
        of_elements = np.sum(bent * each(stiffness, bent), axis=-1)
        energies.append(np.array([np.bincount(mesh.cell_member, row) for row in of_elements]).max(axis=0))
    size = np.maximum(energies[0], FEW_NODES.least * energies[0].max())
    return float(np.sqrt((energies[1] / np.maximum(size, TINY)).max()))


def near_border(stability: Stability | None) -> bool:
    """Whether a multiplier is so near the unit circle that few nodes do not tell on which side it is.

    Parameters
    ----------
    stability
        The multipliers with few nodes, where they were looked for.
    """
    if stability is None:
        return False
    return bool((np.abs(np.abs(stability.multipliers) - 1) < FEW_NODES.border).any())


def rounding(mesh: BeamMesh) -> float:
    """Give the share of a strain that rounding makes on a fine mesh: beside 12 EI/h^3 all else loses digits.

    Parameters
    ----------
    mesh
        The mesh.
    """
    most = float(np.bincount(mesh.cell_member).max())
    return FEW_NODES.rounding * float(np.finfo(float).eps) * most**4
