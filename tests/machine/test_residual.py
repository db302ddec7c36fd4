"""The residual: its tangents against differences, and power against the change of energy."""

import numpy as np
import pytest

from fenics_mech.geometry import PLANE, SPACE, PoseMotion
from fenics_mech.joints import Ride, Riding
from fenics_mech.machine import Machine, Row
from fenics_mech.terms import Damper, Element, Look, Measure, ModalDamping, PointLoad, Spring


class Moving:
    """A chart in which every pose moves and turns."""

    still = False

    def __init__(self, machine, rng):
        g, count = machine.geometry, len(machine.r)
        self.motion = (
            np.array(machine.r), g.turn(rng.normal(size=(count, g.turns))), rng.normal(size=(count, g.d)),
            rng.normal(size=(count, g.turns)), rng.normal(size=(count, g.d)), rng.normal(size=(count, g.turns)),
        )  # fmt: skip

    def at(self, t):
        return PoseMotion(*(np.repeat(x[None], len(t), axis=0) for x in self.motion))


def everything(g, seed):
    """Build a machine of four poses with every term, arms at all ends, and rows of every measure but distances."""
    rng = np.random.default_rng(seed)
    machine = Machine(g, rng.normal(size=g.d))
    places = rng.normal(size=(4, g.d))
    poses = [machine.add_pose(x, g.turn(rng.normal(size=g.turns))) for x in places]
    pairs = []
    for k in range(3):
        arms = 0.1 * rng.normal(size=(2, g.d))
        way = places[k + 1] - places[k]
        axes = [g.axes(way) @ g.turn(0.3 * rng.normal(size=g.turns)) for _ in range(2)]
        pairs.append((machine.end(poses[k], places[k] + arms[0], axes[0]),
                      machine.end(poses[k + 1], places[k + 1] + arms[1], axes[1])))  # fmt: skip
    machine.masses.add_body(pairs[0][1], 2.0, np.diag([0.1, 0.2, 0.3][: g.d]))
    lengths = [float(np.linalg.norm(places[k + 1] - places[k])) for k in range(3)]
    bends = g.d - 1
    bars = [Element.uniform(length, 5.0, [2.0, 3.0][:bends], 1.0, 2.0, [0.3, 0.4][:bends]) for length in lengths]
    machine.add_beams(pairs, bars, 0.1)
    patterns, root = rng.normal(size=(3, 3 * bends, 4)), rng.normal(size=(4, 2))
    machine.terms[0].modal = ModalDamping(patterns, np.zeros(1), (root @ root.T)[None], 2)
    machine.terms += [
        Spring(pairs[:1], 3.0, 0.2),
        Spring(pairs[:1], 3.0, 0.2, Look.ANGLE),
        Damper(pairs[1:2], 2.0),
    ]
    if g is PLANE:
        jet = PointLoad(machine.at_ground(), pairs[1][1], (1.0, 2.0), 0.5, lambda t: np.full(len(t), 3.0), follows=True)
        machine.terms.append(jet)
    measures = [Measure(Look.PLACE, 1), Measure(Look.ALONG, 1), Measure(Look.ALIGNED, 1, 0)]
    machine.rows += [Row(pairs[2], measure, slack=1e-3) for measure in measures]
    machine.rides.append(Ride(pairs[2][1], tuple(pairs[:2]), slack=1e-3, bends=((0.4, 0.3), (0.5, 0.2))))
    machine.rides.append(Ride(pairs[2][1], tuple(pairs[:2]), look=Riding.TURNED, bends=((0.4, 0.3), (0.5, 0.2))))
    marks, scale = (0.2, 0.5, 1.1), machine.add_scale(0.3)
    machine.rides.append(Ride(pairs[2][1], tuple(pairs[:2]), look=Riding.STROKE, marks=marks, scale=scale))
    machine.chart = Moving(machine, rng)
    return machine, rng


@pytest.mark.parametrize("g", [PLANE, SPACE], ids=lambda g: g.name)
@pytest.mark.parametrize("unknown", range(3), ids=["K", "C", "M"])
def test_tangents_are_the_differences_of_the_residual(g, unknown):
    machine, rng = everything(g, 0)
    state = [0.2 * rng.normal(size=(1, machine.size)) for _ in range(3)]
    found = machine.residual(np.zeros(1), *state)
    tangent = machine.pattern.matrix((found.K, found.C, found.M)[unknown][0]).toarray()
    step, differences = 1e-6, np.empty((machine.size, machine.size))
    for j in range(machine.size):
        sides = []
        for sign in (1, -1):
            moved = [x.copy() for x in state]
            moved[unknown][0, j] += sign * step
            sides.append(machine.residual(np.zeros(1), *moved, tangents=False).force[0])
        differences[:, j] = (sides[0] - sides[1]) / (2 * step)
    # central differences lose 1e-16/1e-6 to rounding, and 1e-12 times third derivatives
    np.testing.assert_allclose(tangent, differences, atol=3e-9 * np.abs(differences).max())


@pytest.mark.parametrize("g", [PLANE, SPACE], ids=lambda g: g.name)
def test_forces_of_terms_do_the_power_that_they_take(g):
    machine, rng = everything(g, 1)
    machine.chart = None
    machine.masses.entries.clear()
    machine.gravity[:] = 0.0
    q, v = (0.2 * rng.normal(size=(1, machine.size)) for _ in range(2))
    q[:, machine.n :] = v[:, machine.n :] = 0.0
    found = machine.residual(np.zeros(1), q, v, np.zeros_like(q), tangents=False)
    taken = sum(float(term.power.sum()) for term in found.terms)
    np.testing.assert_allclose(found.force[0, : machine.n] @ v[0, : machine.n], taken, rtol=1e-12)


def test_an_angle_counts_whole_turns():
    machine = Machine(PLANE)
    pose = machine.add_pose(np.zeros(2), fixed="place")
    spring = Spring([(machine.at_ground(), machine.end(pose))], 2.0, 0.0, Look.ANGLE)
    machine.terms.append(spring)
    angle = 5 * np.pi + 0.3
    near = [np.array([[[angle + 1.0]]])]
    zero = np.zeros((1, 1))
    found = machine.residual(np.zeros(1), np.array([[angle]]), zero, zero, angles=near)
    np.testing.assert_allclose(found.force, [[2 * angle]], rtol=1e-14)
