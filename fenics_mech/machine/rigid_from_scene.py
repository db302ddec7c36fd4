"""The motion of a scene's links where they do not bend, as a chart of its machine, near to a motion that is known."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.errors import AssemblyError
from fenics_mech.geometry import PLANE, Given, PoseMotion
from fenics_mech.joints import Riding
from fenics_mech.machine.assembly import COARSELY_MET, closed, rates_of
from fenics_mech.machine.drawn_from_scene import Law
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.machine import Machine
from fenics_mech.machine.motion import coordinates
from fenics_mech.scene.formulas.expression import Jet
from fenics_mech.scene.joints import Prismatic, Slot
from fenics_mech.terms import Beams

Places = tuple[Array, Array, Array]  # of freedoms, and two derivatives by time ``(instants, freedoms)`` each


def rigid_motion(made: SceneMachine, t: Array, near: Array, freedoms: Places, drives: Places | None = None) -> Given:
    """Give the motion of all poses as if each were fixed to its link, and links did not bend."""
    return Given(t, poses_of_links(made, *motion_of_bodies(made, t, near, freedoms, drives)))


def motion_of_bodies(
    made: SceneMachine, t: Array, near: Array, freedoms: Places, drives: Places | None = None
) -> Places:
    """Give coordinates, rates and accelerations of the links as bodies ``(instants, size)`` each."""
    # near (instants, size)
    value, first, second = (np.hstack(pair) for pair in zip(drives or driven(made, t), freedoms))
    machine = leading(made, t, value)
    q, gaps = closed(machine, t, near)
    if (gaps > COARSELY_MET).any():
        raise AssemblyError(f"the links, which do not bend, do not come together at {t[int(gaps.argmax())]:.6g} s")
    rates = (np.pad(x, ((0, 0), (len(machine.rows) - value.shape[1], 0))) for x in (first, second))
    return q, *rates_of(machine, t, q, *rates)


def leading(made: SceneMachine, t: Array, values: Array) -> Machine:
    """Give the links as bodies, led to values of drives and freedoms at some instants ``(instants, drives)``."""
    machine, loose = copy(made.bodies.machine), made.scene.open_joints
    still = [row for row in machine.rows if not row.leads and row.name not in loose]
    led = [row for row in machine.rows if row.leads]
    machine.rows = [*still, *(replace(row, value=values_at(t, values[:, k])) for k, row in enumerate(led))]
    machine.forget_plan()
    return machine


def values_at(t: Array, values: Array) -> Law:
    """Give a law by its values at some instants ``(instants,)``, which it knows alone."""
    return lambda at: values[np.searchsorted(t, at)]


def coordinates_of_links(made: SceneMachine, links: Array) -> Array:
    """Give the coordinates of poses that are fixed to links ``(instants, n)``."""
    # links (instants, 3 links)
    return coordinates_of_bodies(made, near_motion(made, links))


def coordinates_of_bodies(made: SceneMachine, near: Array) -> Array:
    """Give coordinates of poses ``(instants, n)`` that are fixed to links, by those of the links as bodies."""
    machine, motion = made.machine, poses_of_links(made, near, 0 * near, 0 * near)
    count = 3 * len(made.scene.links)
    turned = np.pad((near[:, :count] - made.bodies.q[:count])[:, 2::3], ((0, 0), (0, 1)))
    turns = turned[:, links_of_poses(made)][..., None]
    return coordinates(machine, motion.r - np.array(machine.r), turns)[:, : machine.n]


def near_motion(made: SceneMachine, links: Array) -> Array:
    """Give the coordinates of the links as bodies by places (m) and angles (rad) of all ``(instants, 3 links)``."""
    return np.asarray(links - made.bodies.drawn)


def driven(made: SceneMachine, t: Array) -> Places:
    """Give angles and strokes of the drives, and two derivatives by time ``(instants, drives)`` each."""
    scene = made.scene
    if not scene.drives:
        return (np.zeros((len(t), 0)),) * 3
    theta = scene.coordinate(t)
    jets = [drive.jet(theta.value, scene.cycle_rate) for drive in scene.drives]
    chained = [
        Jet(jet.value, jet.first * theta.first, jet.second * theta.first**2 + jet.first * theta.second) for jet in jets
    ]
    return tuple(np.stack(part, axis=1) for part in zip(*((x.value, x.first, x.second) for x in chained)))  # type: ignore[return-value]


def links_of_poses(made: SceneMachine) -> Index:
    """Give the link that every pose of a machine is fixed to where links do not bend, -1 for the ground."""
    names, machine = list(made.scene.links), made.machine
    found = np.full(len(machine.r), -1)
    for number, name in enumerate(names):
        for point in made.scene.links[name].points:
            found[made.end(f"{name}.{point}").pose] = number
    if made.links is not None:
        mesh = made.links.mesh
        found[made.node_pose] = mesh.node_link
        for term in machine.terms:
            if isinstance(term, Beams):
                for inside, member in zip(term.inside, mesh.cell_member):
                    found[list(inside)] = mesh.member_link[member]
    found[machine.ground] = -1
    return found


def poses_of_links(made: SceneMachine, q: Array, v: Array, a: Array) -> PoseMotion:
    """Give the motion of all poses, as if each were fixed to its link."""
    bodies, machine = made.bodies, made.machine
    count, drawn = len(made.scene.links), made.bodies.frames()
    of_links = [x[:, : 3 * count].reshape(len(x), count, 3) for x in (q, v, a)]
    place = np.array(bodies.machine.r)[1:] + of_links[0][..., :2]
    axes = PLANE.turn(bodies.angles[:, None] + of_links[0][..., 2:])
    whole = [np.zeros((len(q), len(machine.r), *shape)) for shape in ((2,), (2, 2), (2,), (1,), (2,), (1,))]
    r, R, velocity, w, acceleration, al = whole
    r[:], R[:] = np.array(machine.r), np.array(machine.R)
    for pose, link in enumerate(links_of_poses(made)):
        if link < 0:
            continue
        origin, own = drawn[list(made.scene.links)[link]]
        arm = axes[:, link] @ (own.T @ (machine.r[pose] - origin))
        across = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        _, rates, seconds = (x[:, link] for x in of_links)
        r[:, pose], R[:, pose] = place[:, link] + arm, axes[:, link] @ (own.T @ machine.R[pose])
        w[:, pose], al[:, pose] = rates[:, 2:], seconds[:, 2:]
        velocity[:, pose] = rates[:, :2] + rates[:, 2:] * across
        acceleration[:, pose] = seconds[:, :2] + seconds[:, 2:] * across - rates[:, 2:] ** 2 * arm
    motion = PoseMotion(r, R, velocity, w, acceleration, al)
    for ride in machine.rides:
        if ride.look == Riding.STROKE:
            for part, shown in zip((r, velocity, acceleration), _stroke(made, ride.name, motion)):
                part[:, ride.scale, 0] = shown
    return motion


def _stroke(made: SceneMachine, name: str, motion: PoseMotion) -> tuple[Array, Array, Array]:
    """Give the stroke along a member that does not bend, and two derivatives by time ``(instants,)`` each."""
    joint = made.scene.joints[name]
    assert isinstance(joint, Slot | Prismatic)
    ends = [made.end(point, made.scene.guide_angle(joint)) for point in joint.connect]
    moved = []
    for end in ends:
        arm, w, al = motion.R[:, end.pose] @ end.offset, motion.w[:, end.pose], motion.al[:, end.pose]
        across = np.stack([-arm[:, 1], arm[:, 0]], axis=1)
        velocity, acceleration = motion.v[:, end.pose] + w * across, motion.a[:, end.pose] + al * across - w**2 * arm
        moved.append((motion.r[:, end.pose] + arm, velocity, acceleration))
    axes = motion.R[:, ends[0].pose] @ ends[0].turn
    (x, y), (x1, y1), (x2, _) = (np.einsum("tia,ti->at", axes, one - first) for first, one in zip(*moved))
    w, al = motion.w[:, ends[0].pose, 0], motion.al[:, ends[0].pose, 0]
    return x, x1 + w * y, x2 + 2 * w * y1 + al * y - w**2 * x


def near_links(made: SceneMachine, motion: PoseMotion) -> Array:
    """Give coordinates of the links as bodies where the first point of each is in a motion ``(instants, size)``."""
    bodies, scene = made.bodies, made.scene
    q = np.zeros((len(motion.r), bodies.machine.size))
    for k, (name, link) in enumerate(scene.links.items()):
        point, at = next(iter(link.points.items()))
        end = made.end(f"{name}.{point}")
        axes = motion.R[:, end.pose] @ end.turn
        place = motion.r[:, end.pose] + motion.R[:, end.pose] @ end.offset - axes @ np.array(at)
        q[:, 3 * k : 3 * k + 2] = place - bodies.machine.r[k + 1]
        q[:, 3 * k + 2] = PLANE.vector(axes)[:, 0] - bodies.angles[k]
    return q
