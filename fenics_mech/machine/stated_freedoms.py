"""Freedoms of a scene, stated for all that its drives leave free."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.joints.link_states import LinkStates
from fenics_mech.kinematics import Motion, coordinates
from fenics_mech.machine.assembly import left_open, rates_of, units_of
from fenics_mech.machine.drawn_from_scene import bodies_of, drawn_bodies, put_together
from fenics_mech.machine.free_motions import describe, free_motions
from fenics_mech.machine.led_from_scene import led_motion, refuse_singular
from fenics_mech.machine.linkage import as_motion
from fenics_mech.machine.load_factors import joint_motion
from fenics_mech.scene import Cam, Prismatic, Scene, Slot
from fenics_mech.scene.freedoms import Freedom
from fenics_mech.scene.joints import Joint

MUCH = 0.1  # of a joint in a free motion, from which on one on the ground is as good as any other
LEAST = 1e-6  # of a joint in a free motion, from which on it may be the one that states it


def with_freedoms(scene: Scene) -> Scene:
    """Give a scene with a freedom stated for all that its drives leave free, each with the place where it starts."""
    return _on_cams(scene, _with_all(scene))


def _on_cams(scene: Scene, starting: Scene) -> Scene:
    """Let followers whose start a scene does not state begin on their cams, as these move."""
    given = {drive.joint: drive.jet(np.zeros(1), scene.cycle_rate) for drive in scene.drives}
    rate = float(scene.coordinate(np.zeros(1)).first[0]) if given else 0.0
    moving = {name: (float(jet.value[0]), rate * float(jet.first[0])) for name, jet in given.items()}
    moving |= {name: (part.start or 0.0, part.rate_at_start) for name, part in starting.freedoms.items()}
    found = dict(starting.freedoms)
    for law in scene.joint_laws.values():
        if not isinstance(law, Cam) or law.drives not in found or law.joint not in moving:
            continue
        stated, (angle, speed) = scene.freedoms.get(law.drives, Freedom()), moving[law.joint]
        lift = law.lift_at(np.array([angle]))
        if stated.start is None:
            begin = {"start": float(lift.value[0])}
            begin |= {"speed": speed * float(lift.first[0])} if stated.speed is None else {}
            found[law.drives] = found[law.drives].model_copy(update=begin)
    return starting.model_copy(update={"freedoms": found})


def _with_all(scene: Scene) -> Scene:
    """Give a scene with a freedom for all that is free, with tight pins where it moves so."""
    whole = all(part.start is not None for part in scene.freedoms.values())
    if scene.open_joints and whole:
        machine = drawn_bodies(scene, scene.constraints, scene.freedoms).machine
        whole = len(machine.rows) >= machine.n
    if not scene.open_joints or whole:
        return _with_chosen(scene, None)
    try:
        pinned, start = _pinned(scene)
    except (SceneError, AssemblyError):  # with tight pins it is held more often than it can move
        return _with_chosen(scene, None)
    kept = {name: part for name, part in pinned.freedoms.items() if name not in scene.open_joints}
    return _with_chosen(scene.model_copy(update={"freedoms": kept | scene.freedoms}), start)


def _pinned(scene: Scene) -> tuple[Scene, Motion]:
    """Give a scene whose pins have no clearance, and how it starts: journals in the middle move as it does."""
    pinned = with_freedoms(scene.model_copy(update={"joint_laws": {}}))
    bodies, t, rates = bodies_of(pinned), np.zeros(1), np.zeros(len(pinned.drives))
    machine, q = bodies.machine, bodies.q[None]
    if pinned.drives and pinned.analysis.method == "static":  # which holds them at a position
        t = np.array([pinned.analysis.position / pinned.cycle_rate])
        q = led_motion(bodies, min(t[0], 0.0), max(t[0], 0.0)).at(t)[0]
    elif pinned.drives:
        theta = pinned.coordinate(t)
        rates = np.array([drive.jet(theta.value, pinned.cycle_rate).first[0] for drive in pinned.drives])
        rates = rates * theta.first[0]
    J = left_open(machine, t, q)[1]
    refuse_singular(bodies, t, J)
    first = np.zeros((1, len(machine.rows)))
    moved = [*rates, *(part.rate_at_start for part in pinned.freedoms.values())]
    first[0, len(machine.rows) - len(moved) :] = moved
    return pinned, as_motion(bodies, t, t, q, *rates_of(machine, t, q, first, 0 * first, J))


def _with_chosen(scene: Scene, start: Motion | None) -> Scene:
    """Give a scene with a freedom for all that is free, from the links' rough angles or from a start."""
    stated = {name: part for name, part in scene.freedoms.items() if part.start is not None}
    if start is None:
        bodies = put_together(scene, scene.constraints, stated)
    else:
        bodies = drawn_bodies(scene, scene.constraints, stated).at_links(coordinates(start.position, start.angle)[0])
    motions, q, n = free_motions(bodies), bodies.links, bodies.machine.n
    wanted = [name for name in scene.freedoms if name not in stated]
    if not len(motions) and not wanted:
        return scene
    others = [
        name
        for name, joint in scene.constraints.items()
        if name not in scene.moved_joints and len(joint.connect) == 2 and joint.kind != "weld"
    ]
    velocity = np.zeros(n) if start is None else coordinates(start.velocity, start.omega)[0]
    unit = np.reshape(motions, (-1, n)) / units_of(bodies.machine)
    unit *= units_of(bodies.machine) / np.maximum(np.linalg.norm(unit, axis=1, keepdims=True), TINY)
    states = LinkStates.of(np.tile(q, (1 + len(unit), 1)), np.vstack([velocity, unit]))
    moved = {name: joint_motion(scene, name, states) for name in wanted + others}
    sizes = {name: bodies.machine.arm if isinstance(scene.joints[name], Slot | Prismatic) else 1.0 for name in moved}
    rates = {name: rate[1:] / sizes[name] for name, (_, rate) in moved.items()}
    chosen = _chosen(scene.joints, rates, wanted, others)
    if len(chosen) != len(motions):
        raise SceneError(
            f"the angles and strokes of joints do not state what is free: {'; '.join(describe(scene, q, motions))}",
            place="freedoms",
            hint="Give free links a joint of two bodies, and no freedom at a joint that cannot move",
        )
    starting = {}
    for name in chosen:
        part, (place, rate) = scene.freedoms.get(name, Freedom()), moved[name]
        speed = float(rate[0]) if part.speed is None else part.speed
        starting[name] = part.model_copy(update={"start": float(place[0]), "speed": speed})
    return scene.changed(freedoms=scene.freedoms | starting)


def _chosen(joints: Mapping[str, Joint], rates: Mapping[str, Array], wanted: list[str], others: list[str]) -> list[str]:
    """Give joints that state free motions by their rates in them: those wanted, then what moves most beside."""
    # Joints on the ground come first among those that move much.
    on_ground = {name: any(at.startswith("ground.") for at in joints[name].connect) for name in others}
    found = list(wanted)
    left = np.eye(len(next(iter(rates.values()), ())))  # free motions that no joint found so far states
    for name in wanted:
        left = _without(left, rates[name])
    while len(found) < len(left) and others:
        sizes = {name: float(np.linalg.norm(left @ rates[name])) for name in others}
        much = {name: size > MUCH for name, size in sizes.items()}
        best = max(others, key=lambda name: (on_ground[name], 1.0) if much[name] else (False, sizes[name]))
        if sizes[best] < LEAST:
            break
        found.append(best)
        left = _without(left, rates[best])
    return found


def _without(left: Array, rate: Array) -> Array:
    """Take the direction of a joint's rates out of a projection."""
    direction = left @ rate
    size = np.linalg.norm(direction)
    if size < LEAST:
        return left
    direction = direction / size
    return np.asarray(left - np.outer(direction, direction) @ left)
