"""Viscous dampers between points, and viscous friction of joints."""

from __future__ import annotations

import numpy as np

from fenics_mech.beams import BeamMesh
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.separations import Separation, across
from fenics_mech.effects.terms import Array, Situation, Terms, total
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene


def terms(situation: Situation) -> Terms:
    """Give the dampers' forces at the rates of the rigid motion, and how these change with v and v'.

    With d from the first point to the second, l its length and n its direction, the force is ``c (n . d') n``. As d'
    changes by the rates of v, seen in the fixed frame, and n by ``(1 - n n^T)/l`` times the change of d,

        n n^T change of d' + (n w^T + r (1 - n n^T))/l change of d,  w = (1 - n n^T) d', r = n . d'.
    """
    scene, mesh, motion = situation.scene, situation.beams.mesh, situation.motion
    size = 3 * len(mesh.node_name)
    found = []
    for name, damper in scene.dampers.items():
        separation = Separation.of(scene, mesh, motion, damper)
        n = separation.direction(motion, f"dampers.{name}")
        c = damper.damping
        rate = np.sum(n * separation.rate, axis=1)
        along, turned = c * n[:, :, None] * n[:, None, :], across(n)
        carried = (
            n[:, :, None] * (turned @ separation.rate[..., None]).transpose(0, 2, 1) + rate[:, None, None] * turned
        )
        found.append(
            Terms(
                force=separation.force(c * rate[:, None] * n, size),
                damping=(separation.entries(along),),
                convective=(
                    separation.entries(along, separation.turning),
                    separation.entries(c * carried / separation.length[:, None, None]),
                ),
            )
        )
    return total(found)


def damper_forces(scene: Scene, mesh: BeamMesh, motion: Motion, v: Array, rate: Array | None) -> dict[str, Array]:
    """Tension of each damper (N), or the moment with which it turns its second body back (N m), ``(angles,)``.

    Parameters
    ----------
    scene, mesh, motion
        The scene, its mesh and its rigid motion.
    v, rate
        Elastic displacement and its velocity in link axes, ``(angles, nodal dofs)``; without a velocity the dampers
        know the rigid motion only.
    """
    forces = {}
    for name, damper in scene.dampers.items():
        separation = Separation.of(scene, mesh, motion, damper)
        n = separation.direction(motion, f"dampers.{name}")
        speed = np.sum(n * separation.rate, axis=1)
        if rate is not None:
            turning = (across(n) @ separation.rate[..., None])[..., 0] / separation.length[:, None]
            speed = speed + np.sum(n * separation.elastic_rate(v, rate) + turning * separation.elastic(v), axis=1)
        forces[name] = damper.damping * speed
    return forces


EFFECT = Effect(
    name="dampers",
    meaning="viscous dampers between points, and viscous friction of joints",
    source="the rate of a line between two moving points, linearised",
    terms=terms,
    stated=lambda scene: bool(scene.dampers),
    stated_by="[dampers]",
)
