"""The links of a scene as beams."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fenics_mech.beams.element_matrices import Beams, assemble_beams
from fenics_mech.beams.mesh import BeamMesh, mesh_scene
from fenics_mech.effects import active, loads_at_nodes, shaped
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import members_under_pins
from fenics_mech.scene.meshing import member_nodes
from fenics_mech.scene.models import OF_LINKS
from fenics_mech.scene.numbering import order_of


def links(scene: Scene, meshed: Callable[[Scene, bool], BeamMesh] = mesh_scene) -> Beams:
    """Mesh and assemble the links.

    Parameters
    ----------
    scene
        The scene: its members, mesh and effects.
    meshed
        Gives the mesh as `mesh_scene` does.
    """
    return shaped(scene, assemble_beams(scene, meshed(scene, loads_at_nodes(active(scene)))))


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
    return parts, nodes, shapes


def reducible(scene: Scene, beams: Beams) -> list[int]:
    """Members that have inner nodes, and no need of them: no pin travels along them, and they can stretch.

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
    needed = np.append(owners[np.isinf(beams.rigidity.axial.mean)], np.flatnonzero(np.bincount(owners) == 1))
    return [i for i, label in enumerate(members) if label not in guides and i not in needed]
