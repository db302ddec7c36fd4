"""Torsional springs that are too stiff for the elements beside them."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech.errors import UnresolvedError
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import member_nodes
from fenics_mech.scene.springs_dampers import HingeSpring

STIFFEST = 30  # of the rotational stiffness of an element's end, 4EI/h, for a torsional spring: measured


def too_stiff(scene: Scene) -> dict[str, float]:
    """Give torsional springs whose own vibration is one of the mesh, and damped by a ratio, with what they may have."""
    # Its frequency is about the root of stiffness over the inertia of an element's end, and the drag of modal damping
    # on the rotation goes with it, whatever the slow motion is. The bound (N m/rad) is as good as rigid beside the
    # elements.
    if not np.any(scene.damping.ratio) or scene.analysis.method not in ("periodic", "transient"):
        return {}
    bounds = {name: _bound(scene, spring) for name, spring in scene.springs.items() if isinstance(spring, HingeSpring)}
    return {name: bound for name, bound in bounds.items() if scene.springs[name].stiffness > bound}


def _bound(scene: Scene, spring: HingeSpring) -> float:
    """Give the largest stiffness of a torsional spring beside the elements that end at its joint (N m/rad)."""
    points = [point.split(".") for point in scene.joints[spring.joint].connect]
    ends, held = [], {(body, scene.links[body].end_at(point)) for body, point in points if body != "ground"}
    for label, (link, member) in scene.members().items():
        for end in (0, 1):
            if (link, member.ends[end]) in held:
                share = np.diff(member_nodes(scene, label, True))[-end]
                h = share * math.dist(*scene.member_ends(label))
                ends.append(4 * float(scene.rigidity(label, np.array([float(end)])).bending[0]) / h)
    return STIFFEST * min(ends, default=math.inf)


def refuse_too_stiff(scene: Scene) -> None:
    """Raise `UnresolvedError` for a torsional spring that is `too_stiff`, unless the scene lets it pass."""
    for name, bound in ({} if scene.analysis.allow_coarse else too_stiff(scene)).items():
        raise UnresolvedError(
            f"springs.{name}: with damping.ratio the drag on a torsional spring so much stiffer than the elements "
            f"beside it depends on the mesh. Take up to {bound:.2g} N m/rad, which is as good as rigid there, or "
            "damping.material instead of the ratio; analysis.allow_coarse lets it pass"
        ).finer_by(elements=1.01 * scene.springs[name].stiffness / bound)  # which goes with one over their lengths
