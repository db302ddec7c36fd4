"""The links of a scene as beams, with fewer coordinates where it asks for a reduction."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import replace

import numpy as np

from fenics_mech.beams.element_matrices import Beams, assemble_beams
from fenics_mech.beams.mesh import BeamMesh, mesh_scene
from fenics_mech.beams.reduction import Reduction
from fenics_mech.beams.span import REDUCTION
from fenics_mech.effects import Effect, active, loads_at_nodes, shaped
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import members_under_pins
from fenics_mech.scene.meshing import member_nodes, thinned
from fenics_mech.scene.models import OF_LINKS
from fenics_mech.scene.numbering import order_of


def links(scene: Scene, meshed: Callable[[Scene, bool], BeamMesh] = mesh_scene) -> Beams:
    """Mesh and assemble the links, with fewer coordinates if the scene wants that.

    Parameters
    ----------
    scene
        The scene: its members, mesh, effects and reduction.
    meshed
        Gives the mesh as `mesh_scene` does.
    """
    acting = active(scene)
    at_nodes = loads_at_nodes(acting)
    fine = shaped(scene, assemble_beams(scene, meshed(scene, at_nodes)))
    if scene.analysis.reduction == "none":
        return fine
    members = reducible(scene, fine)
    varies = fine.inertia.density.varies  # then strains are recovered on all elements
    coarse = scene if varies else thinned(scene, [fine.mesh.members[i] for i in members], most_recovered(acting))
    seen = fine if coarse is scene else shaped(coarse, assemble_beams(coarse, meshed(coarse, at_nodes)))
    cutoff = scene.analysis.cutoff
    highest = None if cutoff == "auto" else 2 * math.pi * cutoff
    return replace(seen, reduction=Reduction.of(fine, seen, members, highest, _nonlinear(acting)))


def links_depend_on(scene: Scene) -> tuple[object, ...]:
    """Give what the links of a scene depend on: equal for scenes that have them in common.

    Parameters
    ----------
    scene
        The scene.
    """
    acting = active(scene)
    nodes = [member_nodes(scene, label, loads_at_nodes(acting)).tolist() for label in scene.members()]
    shapes = [effect.name for effect in acting if effect.beams is not None]
    parts = [order_of(scene), *(getattr(scene, key) for key in OF_LINKS)]
    if scene.analysis.reduction == "none":
        return parts, nodes, shapes
    return parts, nodes, shapes, scene.analysis.cutoff, _nonlinear(acting), most_recovered(acting)


def _nonlinear(acting: Iterable[Effect]) -> bool:
    """Whether the strain of the links is nonlinear."""
    return any(effect.nonlinear for effect in acting)


def most_recovered(acting: Collection[Effect]) -> int:
    """Elements of a reduced member on which it is recovered, at most.

    Parameters
    ----------
    acting
        The effects that act.
    """
    given = any(effect.stress_stiffening for effect in acting) and not _nonlinear(acting)
    return REDUCTION.recovered_stiffened if given else REDUCTION.recovered


def reducible(scene: Scene, beams: Beams) -> list[int]:
    """Members that have inner nodes, and no need of them: no pin travels along them.

    Parameters
    ----------
    scene
        The scene.
    beams
        Its links, with all nodes.
    """
    members = scene.members()
    guides = set(members_under_pins(scene.joints, members).values())
    owners = beams.mesh.cell_member
    needed = np.flatnonzero(np.bincount(owners) == 1)
    return [i for i, label in enumerate(members) if label not in guides and i not in needed]
