"""Rigid-body motion of a linkage with freedoms: positions, velocities and accelerations from those of the freedoms.

The angles and strokes of the drives are functions of time, and those of the freedoms are unknowns of the motion. They
take the place of drives in the loop equations.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY, TURN
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.kinematics.assembly import newton, side
from fenics_mech.kinematics.conditioning import CONDITION, links_moved, refuse_singular, singular_values
from fenics_mech.kinematics.freedom import describe, free_motions
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.motion import Motion, as_motion, coordinates, rates_by_drives
from fenics_mech.kinematics.start import assemble
from fenics_mech.scene import Cam, Prismatic, Scene, Slot
from fenics_mech.scene.formulas.expression import Jet
from fenics_mech.scene.freedoms import Freedom
from fenics_mech.scene.joints import Joint


@dataclass(frozen=True)
class FreeMotionLimits:
    """Limits of the choice of joints, and of steps along a free motion."""

    much: float = 0.1  # of a joint in a free motion, from which on one on the ground is as good as any other
    least_share: float = 1e-6  # of a joint in a free motion, from which on it may be the one that states it
    longest_lead: float = 0.1  # rad, by which drives are led at once to where they are held
    longest_turn: float = 0.5  # rad, of a link from where the tangent leads to where the loops close
    longest_way: float = TURN  # rad, or sizes of the linkage, of a freedom: no polynomial of a step follows more


FREE_MOTION = FreeMotionLimits()


class FreeLinkage:
    """The links of a scene at any angles and strokes of its freedoms, near to positions that are known."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.loops = scene, Loops.of(scene)

    @cached_property
    def start(self) -> Array:
        """Coordinates of the links at time 0, ``(3 links,)``."""
        scene, q = self.scene, assemble(self.loops)
        if len(self.loops.names) < len(q):
            left = describe(scene.links, scene.joints, q, free_motions(self.loops, q))
            raise SceneError(
                f"the drives and freedoms of the linkage leave more to move: {'; '.join(left)}",
                place="freedoms",
                hint="State a freedom for each, or none: what is not stated starts at the links' rough angles",
            )
        if self._held and scene.drives:
            q = self._led_to(scene.analysis.position, q)
        refuse_singular(self.loops, np.zeros(1), q[None])
        return q

    @property
    def _held(self) -> bool:
        """Whether the drives are held at `analysis.position`."""
        return self.scene.analysis.method == "static"

    def _led_to(self, position: float, q: Array) -> Array:
        """Coordinates of the links where the drives are led to an angle from angle 0, where they are q."""
        angles = np.linspace(0, position, 1 + math.ceil(abs(position) / FREE_MOTION.longest_lead))
        for theta in angles[1:]:
            q = self.pose(np.zeros(1), self.loops.drive(np.array([theta])).value, q[None])[0]
        return q

    def at_start(self) -> Motion:
        """Give the links at time 0, at rest."""
        freedoms = self.scene.freedoms.values()
        still = np.zeros((1, len(freedoms)))
        places = np.array([[freedom.start for freedom in freedoms]], dtype=float)
        return self.motion(np.zeros(1), places, still, still, self.start[None])

    def motion(self, time: Array, places: Array, rates: Array, seconds: Array, near: Array) -> Motion:
        """Give the motion of the links."""
        # time (times,) (s); places, rates, seconds (times, freedoms) each; near (times, 3 links)
        loops, (value, first, second) = self.loops, self.given(time, (places, rates, seconds))
        q = self.pose(time, value, near)
        try:
            velocity, acceleration = rates_by_drives(loops, q, first, second)
        except np.linalg.LinAlgError as error:
            raise AssemblyError(f"the linkage is at a dead centre of its freedoms at {time[0]:.6g} s") from error
        return as_motion(loops, self.theta(time, places), time, q, velocity, acceleration)

    def given(self, time: Array, freedoms: tuple[Array, ...]) -> tuple[Array, ...]:
        """Angles and strokes of the drives and the freedoms, and their derivatives, ``(times, drives)`` each."""
        # time (times,) (s); freedoms (times, freedoms)
        return tuple(np.hstack(pair) for pair in zip(self._driven(time), freedoms))

    def pose(self, time: Array, given: Array, near: Array) -> Array:
        """Give the coordinates of the links, ``(times, 3 links)``."""
        # time (times,) (s); given (times, drives); near (times, 3 links)
        ahead, _ = newton(self.loops, near, given, iterations=1)
        q, closed = newton(self.loops, ahead, given)
        turned = np.abs((q - ahead)[:, 2::3]).max(axis=1, initial=0.0)
        far = ~closed | (turned > FREE_MOTION.longest_turn) | (side(self.loops, q) != side(self.loops, near))
        if far.any():
            time, given, near = time[far], given[far], near[far]
            q[far] = self.pose(time, given, self.pose(time, self._half_way(time, given, near), near))
        return q

    def _half_way(self, time: Array, given: Array, near: Array) -> Array:
        """Angles and strokes half way from known positions, ``(times, drives)``; raise as `pose` where none is left."""
        loops, half = self.loops, given.copy()
        way = loops.residual(near, given)[:, -loops.drives :]
        longest = np.abs(way / loops.scale[-loops.drives :]).max(axis=1)
        if not (longest < FREE_MOTION.longest_way).all():
            raise AssemblyError(
                f"the links move by more than a turn at once, and cannot be followed, at {time[0]:.6g} s"
            )
        if (ends := longest < CONDITION.singular).any():
            raise self._dead_centre(float(time[ends][0]), near[ends][0])
        half[:, loops.drive_order] += way / 2
        return half

    def _dead_centre(self, time: float, q: Array) -> AssemblyError:
        """Say at which time links, ``(3 links,)``, can move by themselves, and what helps."""
        # Where the joints' own equations are singular, those with a freedom at any joint are too.
        loops, names = self.loops, ", ".join(self.scene.moved_joints)
        moved = ", ".join(links_moved(loops, singular_values(loops, q[None])[1][0, -1]))
        joints = np.linalg.svd(loops.without_units(q[None])[0, : -loops.drives], compute_uv=False)
        kind, advice = "dead centre", "State the freedom at another joint, such as that of a link that can turn fully"
        if joints.min(initial=1.0) < CONDITION.in_two_ways:
            kind = "change point"
            advice = (
                "No other joint says it either, as the links can go on in two ways. Take other lengths, or stops that "
                "keep the links away from it"
            )
        return AssemblyError(
            f"at {time:.6g} s the linkage comes to a {kind}: the motion of joint {names} does not say how {moved} "
            f"moves. {advice}"
        )

    def _driven(self, time: Array) -> tuple[Array, Array, Array]:
        """Angles and strokes of the drives and two derivatives by time, ``(times, drives)`` each."""
        if not self.scene.drives:
            return (np.zeros((len(time), 0)),) * 3
        theta = self._phase(time)
        jet, count = self.loops.drive(theta.value), len(self.scene.drives)
        value, first, second = (part[:, :count] for part in (jet.value, jet.first, jet.second))
        rate, change = theta.first[:, None], theta.second[:, None]
        acceleration: Array = np.asarray(second * rate**2 + first * change, dtype=float)  # chain rule
        return value, first * rate, acceleration

    def _phase(self, time: Array) -> Jet:
        """Drive angle (rad) and two derivatives by time, ``(times,)`` each."""
        if not self._held:
            return self.scene.coordinate(time)
        still = np.zeros_like(time)
        return Jet(np.full_like(time, self.scene.analysis.position), still, still)

    def theta(self, time: Array, places: Array) -> Array:
        """Drive angle (rad), ``(times,)``: that of the drives; of the first freedom, where it turns; or the phase."""
        # time (times,) (s); places (times, freedoms)
        scene = self.scene
        if scene.drives or self._held:
            return np.asarray(self._phase(time).value)
        first = next(iter(scene.freedoms))
        return time * scene.cycle_rate if isinstance(scene.joints[first], Slot | Prismatic) else places[:, 0]


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
    if not scene.open_joints or _wholly_stated(scene):
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
    linkage = FreeLinkage(pinned)
    rates = np.array([[part.rate_at_start for part in pinned.freedoms.values()]])
    places = np.array([[part.start for part in pinned.freedoms.values()]], dtype=float)
    return pinned, linkage.motion(np.zeros(1), places, rates, np.zeros_like(rates), linkage.start[None])


def _wholly_stated(scene: Scene) -> bool:
    """Whether a scene states the places of all that is free."""
    loops = Loops.of(scene)
    return len(loops.names) >= 3 * len(loops.links) and all(part.start is not None for part in scene.freedoms.values())


def _with_chosen(scene: Scene, start: Motion | None) -> Scene:
    """Give a scene with a freedom for all that is free, from the links' rough angles or from a start."""
    stated = {name: part for name, part in scene.freedoms.items() if part.start is not None}
    loops = Loops.of(scene.model_copy(update={"freedoms": stated}))
    q = assemble(loops) if start is None else coordinates(start.position, start.angle)[0]
    motions = free_motions(loops, q)
    wanted = [name for name in scene.freedoms if name not in stated]
    if not len(motions) and not wanted:
        return scene
    others = [name for name in scene.constraints if name not in scene.moved_joints and _may_state(scene.joints[name])]
    measured = dict.fromkeys(wanted + others, Freedom())  # more than can move at once
    velocity = np.zeros_like(q) if start is None else coordinates(start.velocity, start.omega)[0]
    of_joints = Loops.of(scene.model_copy(update={"drive": (), "freedoms": measured}))
    places, rates, speeds = _of_joints(of_joints, q, velocity, motions)
    chosen = _chosen(scene.joints, rates, wanted, others)
    if len(chosen) != len(motions):
        words = "; ".join(describe(scene.links, scene.joints, q, motions))
        raise SceneError(
            f"the angles and strokes of joints do not state what is free: {words}",
            place="freedoms",
            hint="Give free links a joint of two bodies, and no freedom at a joint that cannot move",
        )
    starting = {}
    for name in chosen:
        part = scene.freedoms.get(name, Freedom())
        speed = speeds[name] if part.speed is None else part.speed
        starting[name] = part.model_copy(update={"start": places[name], "speed": speed})
    return scene.changed(freedoms=scene.freedoms | starting)


def _may_state(joint: Joint) -> bool:
    return len(joint.connect) == 2 and joint.kind != "weld"


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
        much = {name: size > FREE_MOTION.much for name, size in sizes.items()}
        best = max(others, key=lambda name: (on_ground[name], 1.0) if much[name] else (False, sizes[name]))
        if sizes[best] < FREE_MOTION.least_share:
            break
        found.append(best)
        left = _without(left, rates[best])
    return found


def _without(left: Array, rate: Array) -> Array:
    """Take the direction of a joint's rates out of a projection."""
    direction = left @ rate
    size = np.linalg.norm(direction)
    if size < FREE_MOTION.least_share:
        return left
    direction = direction / size
    return np.asarray(left - np.outer(direction, direction) @ left)


def _of_joints(
    loops: Loops, q: Array, velocity: Array, motions: Array
) -> tuple[dict[str, float], dict[str, Array], dict[str, float]]:
    """Angle or stroke of each moved joint, its rates in free motions of unit size, ``(motions,)``, and its rate."""
    # They are those at coordinates of the links and their rates, (3 links,) each.
    names = loops.scene.moved_joints
    equations = slice(len(loops.names) - len(names), None)
    given = loops.residual(q[None], np.zeros((1, len(names))))[0, equations]
    rows = loops.without_units(q[None])[0, equations]
    flat = motions.reshape(len(motions), len(q)) / loops.unit
    flat = flat / np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), TINY)
    ordered = [names[i] for i in loops.drive_order]
    speeds = loops.jacobian(q[None])[0, equations] @ velocity
    return dict(zip(ordered, given.tolist())), dict(zip(ordered, rows @ flat.T)), dict(zip(ordered, speeds.tolist()))
