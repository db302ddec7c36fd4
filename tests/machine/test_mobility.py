"""Mobility by the rank of rows and strains: linkages of textbooks, also those that Gruebler's formula misses."""

import numpy as np
import pytest

from fenics_mech.errors import SolverError
from fenics_mech.geometry import PLANE, SPACE
from fenics_mech.machine import Machine, hold_idle, loosen, mobility
from fenics_mech.solve import equilibrium, rigid_cycle
from tests.machine.builders import seed
from tests.machine.linkages import Bennett, Rssr, bricard


def four_bar(places):
    """Build a four-bar of rigid bodies between four pins, as drawn."""
    machine = Machine(PLANE)
    bodies = [machine.ground, *[machine.add_pose(place) for place in places[:3]], machine.ground]
    for place, one, other in zip(places, bodies, bodies[1:]):
        machine.join("revolute", (machine.end(one, place), machine.end(other, place)))
    return machine, bodies


@pytest.mark.parametrize("places", [[[0, 0], [0.1, 0.05], [0.3, 0.2], [0.3, 0]], [[0, 0], [1, 0], [3, 0], [2, 0.0]]],
                         ids=["anywhere", "parallelogram on its line"])  # fmt: skip
def test_a_four_bar_has_one_freedom_in_every_drawn_position(places):
    machine, bodies = four_bar(np.array(places, dtype=float))
    found = mobility(machine)
    assert (found.freedoms, len(found.idle)) == (1, 1)
    ends = machine.at_ground(), machine.end(bodies[1])
    machine, bodies = four_bar(np.array(places, dtype=float))
    machine.drive("revolute", "angle", ends, lambda t: t)
    found = mobility(machine)
    assert (found.freedoms, len(found.idle), found.surplus, found.redundant) == (1, 0, 0, [])


def test_members_that_bend_count_as_rigid():
    assert mobility(seed(2)).freedoms == 0  # its crank is led


def test_a_third_rocker_of_a_parallelogram_says_nothing_new():
    """Gruebler counts no freedom: 3 x 4 less 2 x 6."""
    machine = Machine(PLANE)
    coupler = machine.add_pose(np.array([0.0, 0.5]))
    for x in (0.0, 0.4, 1.0):
        rocker = machine.add_pose(np.array([x, 0.0]), fixed="place")
        top = np.array([x + 0.2, 0.5])
        machine.join("revolute", (machine.end(rocker, top), machine.end(coupler, top)))
    found = mobility(machine)
    assert (machine.n, len(machine.rows), found.freedoms, found.surplus) == (6, 6, 1, 1)


def test_a_shaky_frame_does_not_move():
    """Two bars in one line between two pins have a first-order motion in that line, and none beside it."""
    machine = Machine(PLANE)
    first, last = machine.add_pose(np.zeros(2), fixed="place"), machine.add_pose(np.array([2.0, 0]), fixed="place")
    middle = np.array([1.0, 0])
    machine.join("revolute", (machine.end(first, middle), machine.end(last, middle)))
    assert mobility(machine).freedoms == 0


def test_an_rssr_has_two_freedoms_of_which_its_coupler_idles():
    machine, _, coupler, rocker = Rssr.machine()
    found = mobility(machine)
    assert (found.freedoms, len(found.idle), found.surplus) == (2, 1, 0)
    idle = np.append(found.idle[0], 0.0)[machine.places]
    moved = np.append(found.at, 0.0)[machine.places]
    turned = SPACE.turn(moved[:, 3:]) @ np.array(machine.R)
    ball = lambda pose, end: machine.r[pose] + moved[pose, :3] + turned[pose] @ end.offset  # noqa: E731
    second = next(row for row in machine.rows if row.name == "second")
    line = ball(rocker, second.pair[1]) - machine.r[coupler] - moved[coupler, :3]
    spin = SPACE.spin(moved[coupler, 3:], idle[coupler, 3:])
    assert np.linalg.norm(np.cross(spin, line)) < 1e-9 * np.linalg.norm(spin) * np.linalg.norm(line)
    idle[coupler] = 0.0
    assert np.abs(idle).max() < 1e-9


def test_an_idle_freedom_is_held_by_a_row_and_the_cycle_closes():
    machine, _, coupler, _ = Rssr.machine()
    with pytest.raises(SolverError, match="singular"):
        rigid_cycle(machine, 1.0, 4)
    machine = Rssr.machine()[0]
    assert len(hold_idle(machine, mobility(machine))) == 1
    assert len(mobility(machine).idle) == 0
    chart = rigid_cycle(machine, 1.0, 32)
    ends = chart.at(np.array([0.0, 1.0])).R[:, coupler]
    np.testing.assert_allclose(ends[0], ends[1], atol=1e-12)


def test_a_universal_joint_leaves_the_coupler_no_spin():
    found = mobility(Rssr.machine("universal")[0])
    assert (found.freedoms, len(found.idle), found.surplus) == (1, 0, 0)


def test_a_bricard_mechanism_moves_although_six_revolutes_leave_no_freedom():
    machine, _ = bricard()
    found = mobility(machine)
    assert (machine.n, len(machine.rows), found.freedoms, found.surplus) == (30, 30, 1, 1)


def test_bennetts_linkage_moves_and_with_an_axis_off_does_not():
    machine, *_ = Bennett.machine(1.0)
    found = mobility(machine)
    assert (machine.n, len(machine.rows), found.freedoms, found.surplus) == (18, 20, 1, 3)  # of rank 17
    machine, *_ = Bennett.machine(1.0, np.radians(1))
    assert mobility(machine).freedoms == 0


def test_bennetts_linkage_is_forced_by_what_its_axis_is_off():
    """The gap after 0.2 rad: 3e-4 m in an own least-squares program, whose rows are of another size."""
    for off, bounds in ((0.0, (0.0, 1e-13)), (np.radians(1), (1e-4, 1e-3))):
        machine, *_ = Bennett.machine(1.0, off)
        ends = machine.rows[0].pair
        machine.drive("revolute", "angle", ends, lambda t: np.full(len(t), 0.2))
        loosen(machine, list(range(len(machine.rows))))
        q, a = equilibrium(machine, loads=0.0)
        gaps = machine.residual(np.zeros(1), q[None], 0 * q[None], a[None]).force[0, machine.n :]
        slack = np.array([row.slack for row in machine.rows])
        missed = np.abs(slack * a[machine.n :])[: len(slack) - 1]
        assert bounds[0] <= missed.max() <= bounds[1]
        assert np.abs(gaps).max() < 1e-12
