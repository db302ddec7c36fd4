"""Every kind of joint in space against a closed form, and what holds in the plane as well."""

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

from fenics_mech.geometry import PLANE, SPACE
from fenics_mech.joints import IN_SPACE, KINDS, kind_of
from fenics_mech.machine import Machine
from fenics_mech.solve import equilibrium, march, rigid_cycle
from fenics_mech.terms import Look
from tests.machine.builders import Bar, Members, load

G = np.array([0.3, -0.5, -9.81])  # m/s^2, along no axis
TILTED = SPACE.axes(np.array([1.0, 2.0, -0.5]), np.array([0.3, 0.2, 1.0]))  # axes of the joints


def hinge(axis):
    """Give axes whose last is the given one."""
    return SPACE.axes(np.asarray(axis))[:, [1, 2, 0]]


def body(machine, place, axes=None, tensor=1.0, mass=2.0):
    """Add a rigid body with its centre at a place; its tensor is that of a ball, or a diagonal one."""
    pose = machine.add_pose(place, axes)
    machine.masses.add_body(machine.end(pose), mass, np.diag(np.broadcast_to(tensor, 3)))
    return pose


def rates(machine, pose, velocity, spin):
    v = np.zeros(machine.size)
    v[machine.places[pose]] = [*velocity, *spin]
    return v


# Kinds that slide: along free axes a body falls, about free ones it keeps its spin, and the rest holds its weight.
SLIDING = {"slider": ([0], []), "slot": ([0], [0, 1, 2]), "cylinder": ([2], [2]), "plane": ([0, 1], [2])}


@pytest.mark.parametrize("kind", SLIDING)
def test_a_body_slides_by_gravity_along_what_its_joint_leaves_free(kind):
    ways, turns = (TILTED[:, axes] for axes in SLIDING[kind])
    machine, place, mass = Machine(SPACE, G), np.array([0.2, 0.1, 0.4]), 2.0
    pose = body(machine, place, TILTED, mass=mass)
    machine.join(kind, (machine.at_ground(place, TILTED), machine.end(pose)))
    assert machine.n - len(machine.rows) == ways.shape[1] + turns.shape[1]
    velocity, spin = ways.sum(axis=1), 3.0 * turns.sum(axis=1)
    course = march(machine, rates(machine, pose, velocity, spin), 0.4, h=0.05)
    falling = ways @ ways.T @ G
    for t, motion in zip(course.t, course.motion):
        np.testing.assert_allclose(motion.r[pose], place + velocity * t + falling * t * t / 2, atol=1e-12)
        np.testing.assert_allclose(motion.w[pose], spin, atol=2e-6)  # of steps of 0.26 rad
        if turns.shape[1]:
            turned = SPACE.about(spin, np.linalg.norm(spin) * t) @ TILTED
            np.testing.assert_allclose(motion.R[pose], turned, atol=1e-6)
    held = [m.axis for m in kind_of(kind, SPACE).held if m.look is Look.ALONG]
    forces = course.multipliers[-1, : len(held)]
    np.testing.assert_allclose(forces, mass * (TILTED.T @ G)[held], rtol=1e-9)  # a row's force is on the left


def test_a_body_on_a_revolute_about_a_tilted_axis_is_a_pendulum():
    """Gravity's part across the axis drives it; sin(a/2) = k sn(K - w t) (Landau and Lifshitz, Mechanics, 11)."""
    axis, start, tensor, mass = TILTED[:, 2], 2.0, np.array([0.3, 0.2, 0.4]), 2.0
    across = G - axis * (axis @ G)
    down = SPACE.axes(axis, across)[:, [1, 2, 0]]  # hanging at rest: its first axis goes down
    first = SPACE.about(axis, start) @ down
    machine, pivot, arm = Machine(SPACE, G), np.array([0.1, 0.0, 0.2]), 0.6
    pose = body(machine, pivot + arm * first[:, 0], first, tensor, mass)
    machine.join("revolute", (machine.at_ground(pivot, first), machine.end(pose, pivot, first)))
    course = march(machine, np.zeros(machine.size), 1.5, h=0.01)
    inertia = tensor[0] + tensor[1] + mass * arm**2
    rate, k2 = np.sqrt(mass * np.linalg.norm(across) * arm / inertia), np.sin(start / 2) ** 2
    exact = 2 * np.arcsin(np.sqrt(k2) * ellipj(ellipk(k2) - rate * course.t, k2)[0])
    turned = np.array([down.T @ motion.R[pose] for motion in course.motion])
    found = np.arctan2(turned[:, 1, 0], turned[:, 0, 0])
    np.testing.assert_allclose(found, exact, atol=1e-8)
    assert np.abs(turned[:, 2, 2] - 1).max() < 1e-12


def test_a_top_on_a_ball_precesses_steadily():
    """A W^2 cos a - C n W + m g l = 0 (Goldstein, Classical Mechanics, section 5.7), A about the pivot."""
    tilt, arm, mass, g, thin, flat = 0.7, 0.3, 2.0, 9.81, 0.01, 0.04
    C, A, W = 2 * flat, thin + flat + mass * arm**2, 1.3
    n = (A * W**2 * np.cos(tilt) + mass * g * arm) / (C * W)
    axis = np.array([np.sin(tilt), 0, np.cos(tilt)])
    axes = SPACE.axes(axis)[:, [1, 2, 0]]
    machine = Machine(SPACE, [0, 0, -g])
    pose = body(machine, arm * axis, axes, [flat, flat, thin], mass)
    machine.join("ball", (machine.at_ground(), machine.end(pose, np.zeros(3))))
    spin = W * np.array([0, 0, 1.0]) + (n - W * np.cos(tilt)) * axis
    course = march(machine, rates(machine, pose, np.cross(spin, arm * axis), spin), 0.5, h=0.0025)
    for t, motion in zip(course.t[::20], course.motion[::20]):
        exact = [np.sin(tilt) * np.cos(W * t), np.sin(tilt) * np.sin(W * t), np.cos(tilt)]
        np.testing.assert_allclose(motion.R[pose][:, 2], exact, atol=1e-7)
        np.testing.assert_allclose(motion.r[pose], arm * motion.R[pose][:, 2], atol=1e-12)


@pytest.mark.parametrize("bend", [0.3, 1.0])
def test_a_universal_joint_turns_unevenly(bend):
    """Tan b = tan a/cos(bend), a counted from where the driving fork lies in the plane of both shafts."""
    shaft, still = np.array([np.sin(bend), 0, np.cos(bend)]), np.zeros(3)
    spin, forks = np.array([0, 0, 2 * np.pi]), (hinge([1.0, 0, 0]), hinge([0, 1.0, 0]))
    machine, out = Machine(SPACE), hinge(shaft)
    drive = machine.add_pose(still, led=lambda t: (still, SPACE.about(spin, 2 * np.pi * t), 0.0, spin, 0.0, 0.0))
    driven = machine.add_pose(still, out, fixed="place")
    machine.join("universal", (machine.end(drive, axes=forks[0]), machine.end(driven, axes=forks[1])))
    machine.join("revolute", (machine.at_ground(axes=out), machine.end(driven, axes=out)))
    chart = rigid_cycle(machine, 1.0, 48)
    turned = out.T @ chart.at(np.arange(48) / 48).R[:, driven]
    a = 2 * np.pi * np.arange(48) / 48
    exact = np.cos(a) * np.cos(bend) + 1j * np.sin(a)
    np.testing.assert_allclose(turned[:, 0, 0] + 1j * turned[:, 1, 0], exact / np.abs(exact), atol=1e-12)


def test_drives_lead_the_angle_and_the_stroke_of_a_cylinder_as_a_screw():
    machine, place, pitch = Machine(SPACE), np.array([0.1, 0.2, 0.3]), 0.05
    pose = machine.add_pose(place + 0.2 * TILTED[:, 0], TILTED)
    pair = machine.at_ground(place, TILTED), machine.end(pose, place, TILTED)
    machine.join("cylinder", pair)
    assert machine.drive("cylinder", "angle", pair, lambda t: 2 * np.pi * t, "screw") == 4
    machine.drive("cylinder", "stroke", pair, lambda t: pitch * np.sin(2 * np.pi * t))
    at = rigid_cycle(machine, 1.0, 16).at(np.arange(16) / 16)
    turn = 2 * np.pi * np.arange(16) / 16
    turned = SPACE.about(TILTED[:, 2], turn) @ TILTED
    exact = place + 0.2 * turned[:, :, 0] + pitch * np.sin(turn)[:, None] * TILTED[:, 2]
    np.testing.assert_allclose(at.R[:, pose], turned, atol=1e-12)
    np.testing.assert_allclose(at.r[:, pose], exact, atol=1e-12)


@pytest.mark.parametrize("g", [PLANE, SPACE], ids=lambda g: g.name)
def test_a_weld_by_rows_is_a_shared_pose(g):
    """A bent cantilever, whole, and cut in two and welded."""
    places = np.array([[0, 0, 0], [0.3, 0.1, 0.05], [0.5, 0.0, 0.2]])[:, : g.d]
    bar = Bar(2e4, [0.7, 0.4][: g.d - 1], 0.1, 0.5)
    tips = []
    for cut in (False, True):
        machine = Machine(g, [0, -9.81, 0.0][: g.d])
        first, middle, last = (machine.add_pose(x, fixed="place and turn" * (k == 0)) for k, x in enumerate(places))
        other = machine.add_pose(places[1], g.about(np.ones(3), 1.0)) if cut else middle
        members = Members(machine)
        members.add(first, middle, 2, bar)
        members.add(other, last, 2, bar)
        members.done()
        load(machine, machine.end(last), g.d - 1, 0.4)
        if cut:
            machine.join("weld", (machine.end(middle), machine.end(other, axes=np.eye(g.d))))
        q, _ = equilibrium(machine)
        tips.append(q[machine.places[last]])
    np.testing.assert_allclose(tips[1], tips[0], atol=1e-10)
    assert np.abs(tips[0]).max() > 0.01


def test_kinds_leave_the_freedoms_that_their_names_say():
    left = {"revolute": 1, "ball": 3, "slider": 1, "prismatic": 1, "slot": 4, "weld": 0} | {
        "universal": 2, "cylinder": 2, "plane": 3}  # fmt: skip
    assert {name: 6 - len(kind_of(name, SPACE).held) for name in KINDS | IN_SPACE} == left
    left = {"revolute": 1, "ball": 1, "slider": 1, "prismatic": 1, "slot": 2, "weld": 0}
    assert {name: 3 - len(kind_of(name, PLANE).held) for name in KINDS} == left
