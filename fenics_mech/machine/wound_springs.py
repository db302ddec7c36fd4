"""Torsional springs that are wound up at the start."""

from __future__ import annotations

import math

import numpy as np

from fenics_mech._constants import TURN
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.springs_dampers import HingeSpring


def wound_at_start(stated: Scene, scene: Scene) -> tuple[str, ...]:
    """Tell of torsional springs that begin more than half a turn away from a free angle within one turn."""
    # An angle read off a sketch may be a whole turn away from that of the joint. Where the scene states the joint's
    # start or a free angle of a turn and more, turns are meant.
    chosen = {name for name, freedom in stated.freedoms.items() if freedom.start is not None}
    chosen |= {drive.joint for drive in stated.drives}
    found, angles = [], None
    for name, spring in stated.springs.items():
        if not isinstance(spring, HingeSpring) or spring.angle is None or spring.joint in chosen:
            continue
        angles = angles or dict(zip(scene.links, solve_motion(scene, np.zeros(1)).angle[0].tolist())) | {"ground": 0.0}
        first, second = spring.bodies or (point.split(".")[0] for point in scene.joints[spring.joint].connect)
        here = angles[second] - angles[first]
        turns = round((here - spring.angle) / TURN)
        if turns and abs(spring.angle) < TURN:
            told = here, spring.angle, spring.angle + turns * TURN
            begins, free, nearer = (f"{math.degrees(angle):.6g} deg" for angle in told)
            found.append(
                f"springs.{name}.angle: the joint begins at {begins} and the spring is free at {free}, so that it is "
                f'wound up at the start. Whole turns count: "{nearer}" is less'
            )
    return tuple(found)
