"""The links of a scene as beams, with fewer coordinates where it asks for a reduction."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from fenics_mech.beams.element_matrices import Beams, assemble_beams
from fenics_mech.beams.mesh import mesh_scene
from fenics_mech.beams.reduction import Reduction
from fenics_mech.beams.span import REDUCTION
from fenics_mech.effects import active, shaped
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.meshing import member_nodes, thinned
from fenics_mech.scene.models import OF_LINKS


def links(scene: Scene) -> Beams:
    """Mesh and assemble the links, with fewer coordinates if the scene wants that.

    Parameters
    ----------
    scene
        The scene: its members, mesh, effects and reduction.
    """
    fine = shaped(scene, assemble_beams(scene, mesh_scene(scene)))
    if scene.analysis.reduction == "none":
        return fine
    members = _reducible(scene, fine)
    varies = fine.inertia.density.varies  # then strains are recovered on all elements
    coarse = scene if varies else thinned(scene, [fine.mesh.members[i] for i in members], most_recovered(scene))
    seen = fine if coarse is scene else shaped(coarse, assemble_beams(coarse, mesh_scene(coarse)))
    cutoff = scene.analysis.cutoff
    highest = None if cutoff == "auto" else 2 * math.pi * cutoff
    return replace(seen, reduction=Reduction.of(fine, seen, members, highest, nonlinear(scene)))


def links_depend_on(scene: Scene) -> tuple[object, ...]:
    """Give what the links of a scene depend on: equal for scenes that have them in common.

    Parameters
    ----------
    scene
        The scene.
    """
    nodes = [member_nodes(scene, label).tolist() for label in scene.members()]
    shapes = [effect.name for effect in active(scene) if effect.beams is not None]
    parts = [getattr(scene, key) for key in OF_LINKS]
    if scene.analysis.reduction == "none":
        return parts, nodes, shapes
    return parts, nodes, shapes, scene.analysis.cutoff, nonlinear(scene), most_recovered(scene)


def nonlinear(scene: Scene) -> bool:
    """Whether the strain of the links is nonlinear.

    Parameters
    ----------
    scene
        The scene.
    """
    return any(effect.nonlinear for effect in active(scene))


def most_recovered(scene: Scene) -> int:
    """Elements of a reduced member on which it is recovered, at most.

    Parameters
    ----------
    scene
        The scene.
    """
    given = any(effect.stress_stiffening for effect in active(scene)) and not nonlinear(scene)
    return REDUCTION.recovered_stiffened if given else REDUCTION.recovered


def _reducible(scene: Scene, beams: Beams) -> list[int]:
    """Members that have inner nodes, and no need of them: no pin travels along them, and they can stretch."""
    guides = {
        id(scene.links[joint.connect[0].split(".")[0]].members[joint.member])
        for joint in scene.joints.values()
        if isinstance(joint, Slot | Prismatic) and joint.member is not None
    }
    owners = beams.mesh.cell_member
    needed = np.append(owners[np.isinf(beams.rigidity.axial.mean)], np.flatnonzero(np.bincount(owners) == 1))
    return [i for i, (_, member) in enumerate(scene.members().values()) if id(member) not in guides and i not in needed]
