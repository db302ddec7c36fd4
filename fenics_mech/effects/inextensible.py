"""Members that cannot stretch: they bend only, and carry axial forces without a strain."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech.beams.offset_pins import refuse_offsets
from fenics_mech.effects.effect import Effect
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams


def beams(scene: Scene, links: Beams) -> Beams:
    """Make EA infinite: the mechanism ties the nodes of each member along its axis (`mechanism.inextensibility`)."""
    refuse_offsets(scene.rigidity, scene.members(), EFFECT.name, neutral_only=True)
    none = np.zeros(len(links.mesh.cell))
    axial = replace(links.rigidity.axial, coefficient=links.layout.coefficient(none), mean=none + np.inf)
    return replace(links, rigidity=replace(links.rigidity, axial=axial))


def with_stretching(scene: Scene) -> Scene:
    """Give the scene with members that can stretch.

    Parameters
    ----------
    scene
        A scene with the effect.
    """
    return scene.changed(effects=tuple(name for name in scene.named_effects if name != EFFECT.name))


EFFECT = Effect(
    name="inextensible",
    meaning="members that bend but do not stretch",
    source="(7.2) with EA without bound",
    beams=beams,
    refuses=("large-rotations",),
    loads_at_nodes=True,
)
