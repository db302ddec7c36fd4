"""Torsional springs as scenes state them: too stiff for the elements beside them, and wound at the start."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech._constants import TURN
from fenics_mech.errors import UnresolvedError
from fenics_mech.kinematics import solve_motion
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


def wound_at_start(stated: Scene, scene: Scene) -> tuple[str, ...]:
    """Tell of torsional springs that begin more than half a turn away from a free angle within one turn."""
    # An angle read off a sketch may be a whole turn away from that of the joint. Where the scene states the joint's
    # start or a free angle of a turn and more, turns are meant.
    chosen = {name for name, freedom in stated.freedoms.items() if freedom.start is not None}
    chosen |= {drive.joint for drive in stated.drives}
    found = []
    for name, spring in stated.springs.items():
        if not isinstance(spring, HingeSpring) or spring.angle is None or spring.joint in chosen:
            continue
        here = _angle_between(scene, spring)
        turns = round((here - spring.angle) / TURN)
        if turns and abs(spring.angle) < TURN:
            angles = here, spring.angle, spring.angle + turns * TURN
            begins, free, nearer = (f"{math.degrees(angle):.6g} deg" for angle in angles)
            found.append(
                f"springs.{name}.angle: the joint begins at {begins} and the spring is free at {free}, so that it is "
                f'wound up at the start. Whole turns count: "{nearer}" is less'
            )
    return tuple(found)


def _angle_between(scene: Scene, hinge: HingeSpring) -> float:
    """Angle of a hinge's second body against its first at drive angle 0 (rad)."""
    bodies = hinge.bodies or tuple(point.split(".")[0] for point in scene.joints[hinge.joint].connect)
    angles = dict(zip(scene.links, solve_motion(scene, np.zeros(1)).angle[0].tolist())) | {"ground": 0.0}
    return angles[bodies[1]] - angles[bodies[0]]
