"""Viscous dampers between points, and viscous friction of joints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.effect import Effect
from fenics_mech.effects.separations import Separation, across
from fenics_mech.effects.terms import NOTHING, AddedMatrices, Loads, Situation, Terms
from fenics_mech.kinematics import Motion
from fenics_mech.scene import Scene

if TYPE_CHECKING:
    from fenics_mech.beams.mesh import BeamMesh


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
        pull = c * rate[:, None] * n
        found.append(
            Terms(
                loads=Loads(force=separation.force(pull, size)),
                matrices=AddedMatrices(
                    damping=(separation.entries(along),),
                    convective=(
                        separation.entries(along, separation.turning),
                        separation.entries(c * carried / separation.length[:, None, None]),
                    ),
                ),
                rotation_forces=separation.couples(pull, damping=along),
            )
        )
    return sum(found, NOTHING)


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
            turning = separation.turned(n, separation.rate)
            speed = speed + np.sum(n * separation.elastic_rate(v, rate) + turning * separation.elastic(v), axis=1)
        forces[name] = damper.damping * speed
    return forces


def damper_power(
    scene: Scene, mesh: BeamMesh, motions: tuple[Motion, Motion], v: tuple[Array, Array], deformation: Array
) -> Array:
    """Power of all dampers on the bent mechanism (W), ``(angles,)``.

    Their force does work on the rigid motion to second order, and to first order on the elastic one, as in `terms`.

    Parameters
    ----------
    scene, mesh
        The scene and its mesh.
    motions
        The rigid motion, and one of the same positions with other rates in which the forces do work.
    v
        Elastic displacement in link axes and its velocity, ``(angles, nodal dofs)``.
    deformation
        Rate of the displacement in which the forces do work, ``(angles, nodal dofs)``.
    """
    power = np.zeros(len(deformation))
    for c, n, true, virtual in _pairs(scene, mesh, motions):
        e, rate = true.elastic(v[0]), true.rate
        bent, speed, turned = true.value + e, rate + true.elastic_rate(*v), true.turned(n, e)
        whole = speed  # of a rotation
        if n.shape[1] > 1:
            whole = (np.sum(bent * speed, axis=1) / np.sum(bent**2, axis=1))[:, None] * bent
        linear = _along(n, speed, turned, rate)
        power -= c * np.sum(whole * virtual.rate + linear * virtual.elastic_rate(v[0], deformation), axis=1)
    return power


def shortening_power(
    scene: Scene, mesh: BeamMesh, motions: tuple[Motion, Motion], v: tuple[Array, Array], deformation: Array
) -> Array:
    """Of `damper_power`, the part that is linear in a displacement (W), ``(angles,)``.

    Parameters are those of `damper_power`.
    """
    power = np.zeros(len(deformation))
    for c, n, true, virtual in _pairs(scene, mesh, motions):
        turned = true.turned(n, true.elastic(v[0]))
        pull = np.sum(n * true.rate, axis=1)[:, None] * n
        change = _along(n, true.elastic_rate(*v), turned, true.rate)
        power -= c * np.sum(pull * virtual.elastic_rate(v[0], deformation) + change * virtual.rate, axis=1)
    return power


def _pairs(
    scene: Scene, mesh: BeamMesh, motions: tuple[Motion, Motion]
) -> Iterator[tuple[float, Array, Separation, Separation]]:
    """Give each damper's coefficient, its direction, and its separation in two motions of the same positions."""
    for name, damper in scene.dampers.items():
        true, virtual = (Separation.of(scene, mesh, motion, damper) for motion in motions)
        yield damper.damping, true.direction(motions[0], f"dampers.{name}"), true, virtual


def _along(n: Array, speed: Array, turned: Array, rate: Array) -> Array:
    """Force of a damper of coefficient 1 by a rate of its separation, and by the turning of its direction at `rate`."""
    drift = np.sum(n * speed + turned * rate, axis=1)
    return drift[:, None] * n + np.sum(n * rate, axis=1)[:, None] * turned


EFFECT = Effect(
    name="dampers",
    meaning="viscous dampers between points, and viscous friction of joints",
    source="the rate of a line between two moving points, linearised",
    work="own",
    terms=terms,
    stated=lambda scene: bool(scene.dampers),
    stated_by="[dampers]",
)
