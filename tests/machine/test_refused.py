"""What a builder of machines may get wrong is refused, and small or rigid motion is right."""

from importlib import reload
from itertools import pairwise

import numpy as np
import pytest

from fenics_mech import _kernels
from fenics_mech.errors import SolverError
from fenics_mech.geometry import PLANE, SPACE
from fenics_mech.machine import Machine, Row, loosen, mobility
from fenics_mech.solve import equilibrium, frequencies, held_modes, march, periodic, rigid_cycle, tangents_at
from fenics_mech.terms import Element, Look, Measure, Spring
from tests.machine.builders import double_pendulum, load, pin, seed


def cantilever():
    machine, axes = Machine(PLANE), np.eye(2)
    root, tip = (
        machine.add_pose(np.zeros(2), axes, fixed="place and turn"),
        machine.add_pose(np.array([1.0, 0.0]), axes),
    )
    ends = machine.end(root), machine.end(tip)
    machine.add_beams([ends], [Element.uniform(1.0, 1e6, [10.0], line_mass=1.0)])
    load(machine, machine.end(tip), 1, 0.1)
    return machine, tip


@pytest.mark.parametrize("late", ["term", "row", "mass"])
def test_what_is_appended_after_an_evaluation_is_not_left_out_in_silence(late):
    machine, tip = cantilever()
    stiff = equilibrium(machine)[0]
    pair = machine.at_ground(np.array([1.0, 1.0])), machine.end(tip)
    if late == "term":
        machine.terms.append(Spring([pair], 100.0, 1.0))
    elif late == "row":
        machine.rows.append(Row(pair, Measure(Look.PLACE, 1), -1.0))
    else:
        machine.masses.add_body(pair[1], 1.0, np.zeros((2, 2)))
    with pytest.raises(ValueError, match="after it was evaluated"):
        equilibrium(machine)
    machine.forget_plan()
    held = equilibrium(machine)[0]
    assert late == "mass" or abs(held[machine.places[tip, 1]]) < 0.5 * abs(stiff[machine.places[tip, 1]])


def test_beams_that_are_added_one_by_one_are_those_that_are_added_at_once():
    """The tip of two elements, P L^3/(3 E I)."""
    machine, axes = Machine(PLANE), np.eye(2)
    poses = [machine.add_pose(np.array([x, 0.0]), axes, fixed="" if x else "place and turn") for x in (0.0, 0.5, 1.0)]
    for one, other in pairwise(poses):
        pair = machine.end(one), machine.end(other)
        machine.add_beams([pair], [Element.uniform(0.5, 1e9, [10.0])], 1e-3 * one)
    load(machine, machine.end(poses[2]), 1, 1e-3)
    assert len(machine.terms) == 2
    assert machine.terms[0].damping.tolist() == [1e-3 * pose for pose in poses[:2]]
    assert equilibrium(machine)[0][machine.places[poses[2], 1]] == pytest.approx(1e-3 / 30, rel=1e-6)


@pytest.mark.parametrize(("geometry", "axis"), [(PLANE, 2), (SPACE, 3), (SPACE, -1)])
def test_an_axis_that_is_not_there_is_refused(geometry, axis):
    machine = Machine(geometry)
    pose = machine.add_pose(np.zeros(geometry.d))
    load(machine, machine.end(pose), axis, 1.0)
    with pytest.raises(ValueError, match="an axis that is not there"):
        equilibrium(machine)


def test_names_that_are_not_there_are_refused():
    machine = Machine(PLANE)
    with pytest.raises(ValueError, match="'cylinder' is no kind of joint in plane: expected one of revolute, ball"):
        machine.join("cylinder", (machine.at_ground(), machine.at_ground()))
    with pytest.raises(ValueError, match="fixed by 'rotation': expected one of '', 'place'"):
        machine.add_pose(np.zeros(2), fixed="rotation")


def test_another_period_than_that_of_the_rigid_motion_is_refused():
    machine, period = seed(1), 2 * np.pi / 32.3
    machine.chart = rigid_cycle(machine, period)
    with pytest.raises(SolverError, match="no multiple of that of the rigid motion"):
        periodic(machine, period / 2, 12)


def turned(laws, slack=0.0):
    """A body on a pin, driven by laws of the angle."""
    machine = Machine(PLANE)
    bar = machine.add_pose(np.zeros(2), np.eye(2), fixed="place")
    machine.masses.add_body(machine.end(bar, np.array([1.0, 0.0])), 2.0, np.zeros((2, 2)))
    for k, law in enumerate(laws):
        machine.rows.append(Row((machine.at_ground(), machine.end(bar)), Measure(Look.ANGLE), law, slack, f"drive {k}"))
    return machine


def test_a_drive_that_does_not_come_back_is_refused():
    with pytest.raises(SolverError, match="not where it began: its drives have another period"):
        rigid_cycle(turned([lambda t: np.pi * t]), 1.0)


def test_drives_that_contradict_each_other_are_refused():
    """With slack they could be met, by gaps in the joints."""
    machine = turned([lambda t: 2 * np.pi * t, lambda t: 2 * np.pi * t + 0.1 * np.sin(2 * np.pi * t)])
    loosen(machine, mobility(machine).redundant)
    with pytest.raises(SolverError, match=r"joint 'drive \d' has a gap of"):
        rigid_cycle(machine, 1.0)


def test_periodic_motion_of_a_rigid_machine_has_the_forces_of_its_drive():
    """A mass of 2 kg on 1 m under the law 2 pi t + sin(2 pi t)/2: torque m r^2 times the angular acceleration."""
    law = lambda t: 2 * np.pi * t + np.sin(2 * np.pi * t) / 2  # noqa: E731
    machine = turned([law])
    machine.chart = rigid_cycle(machine, 1.0)
    cycle = periodic(machine, 1.0, 24)
    acceleration = -0.5 * (2 * np.pi) ** 2 * np.sin(2 * np.pi * cycle.t)
    np.testing.assert_allclose(-cycle.a[..., machine.n], 2.0 * acceleration, atol=1e-6)


def test_whole_turns_of_a_spring_count_in_time():
    """A disc on a torsional spring, turned by 10 rad and let go: a cosine; without turns it would be a saw-tooth."""
    machine = Machine(PLANE)
    disc = machine.add_pose(np.zeros(2), fixed="place")
    machine.masses.add_body(machine.end(disc), 1.0, np.eye(2))  # 2 kg m^2
    machine.terms.append(Spring([(machine.at_ground(), machine.end(disc))], 2.0, 0.0, Look.ANGLE))
    course = march(machine, np.array([10.0]), 7.0, h=0.05)
    spins = np.array([motion.w[disc, 0] for motion in course.motion])
    np.testing.assert_allclose(spins, 10 * np.cos(course.t), atol=1e-5)


def test_what_is_free_is_named_where_the_equations_are_singular():
    machine, _ = double_pendulum()
    machine.gravity[:] = 0.0
    with pytest.raises(SolverError, match="singular: something is free to move"):
        equilibrium(machine)


def test_kernels_of_other_sources_are_refused(monkeypatch):
    monkeypatch.setattr(_kernels.sources, "fingerprint", lambda: "another")
    with pytest.raises(ImportError, match=r"other sources than those beside them\. Run `python fenics_mech/_ker"):
        reload(_kernels)
    monkeypatch.undo()
    reload(_kernels)


def test_places_that_are_no_numbers_are_refused():
    machine, (first, second) = double_pendulum()
    machine.rows.append(Row((machine.at_ground(), machine.end(first)), Measure(Look.DISTANCE), 0.0, name="rod"))
    machine.forget_plan()
    with pytest.raises(ValueError, match="a row of joint 'rod' cannot be measured where it is drawn"):
        mobility(machine)  # both ends are at one place
    machine, (first, second) = double_pendulum()
    machine.rows.append(Row((machine.at_ground(), machine.end(second, np.array([np.nan, 0]))), Measure(Look.PLACE)))
    machine.forget_plan()
    with pytest.raises(ValueError, match=f"pose {second}, or what is fixed to it, is drawn at a place that is no numb"):
        mobility(machine)


@pytest.mark.parametrize("mass", [-1.0, np.nan])
def test_masses_that_are_not_0_or_more_are_refused(mass):
    machine, tip = cantilever()
    with pytest.raises(ValueError, match=f"the mass of a body is {mass:g} kg: expected 0 or more"):
        machine.masses.add_body(machine.end(tip), mass, np.zeros((2, 2)))
    with pytest.raises(ValueError, match=f"a second moment of the mass of a body is {mass:g}"):
        machine.masses.add_body(machine.end(tip), 1.0, np.diag([1.0, mass]))
    ends = machine.at_ground(), machine.end(tip)
    with pytest.raises(ValueError, match="the mass of a beam element is "):
        machine.add_beams([ends], [Element.uniform(1.0, 1e6, [10.0], line_mass=mass)])
    with pytest.raises(ValueError, match="the rotary inertia of a beam element is "):
        machine.add_beams([ends], [Element.uniform(1.0, 1e6, [10.0], line_mass=1.0, rotary=[mass])])


def test_modes_of_what_is_free_or_fixed_are_refused():
    machine, (_, second) = double_pendulum()
    with pytest.raises(SolverError, match="modes of the machine held at 0 s: something is free to move without strain"):
        held_modes(machine, 0.0)
    tip = np.array([2.0, 0.0])
    pin(machine, machine.at_ground(tip), machine.end(second, tip))
    machine.forget_plan()
    zero = np.zeros(machine.size)
    with pytest.raises(SolverError, match="none, as its joints and drives leave no coordinate free"):
        held_modes(triangle_of_bars(), 0.0)
    with pytest.raises(SolverError, match=r"there are none\. 4 coordinates have mass, and 4 rows"):
        frequencies(*tangents_at(machine, zero, zero), 3)


def triangle_of_bars():
    """A structure: two bars between two pins on the ground."""
    machine, top = Machine(PLANE), np.array([0.5, 1.0])
    bars = [machine.add_pose(np.array([x, 0.0]), fixed="place") for x in (0.0, 1.0)]
    for bar in bars:
        machine.masses.add_body(machine.end(bar), 1.0, np.eye(2))
    pin(machine, *(machine.end(bar, top) for bar in bars))
    return machine


def test_a_motion_in_time_begins_from_a_chart_at_rest():
    machine = turned([lambda t: 2 * np.pi * t])
    machine.chart = rigid_cycle(machine, 1.0)
    with pytest.raises(ValueError, match=r"the chart of the machine moves.*set chart = None first"):
        march(machine, np.zeros(machine.size), 0.1, h=0.01)


def test_a_machine_without_beams_has_no_modes_to_damp():
    with pytest.raises(ValueError, match="the machine has no beams"):
        double_pendulum()[0].beams  # noqa: B018
