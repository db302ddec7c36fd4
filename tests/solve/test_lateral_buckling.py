"""Lateral buckling of strips against closed forms: Timoshenko and Gere, Theory of Elastic Stability, chapter 6."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import jv

from fenics_mech.geometry import SPACE
from fenics_mech.machine import Machine, Row
from fenics_mech.terms import Look, Measure
from tests.machine.builders import Bar, Members, chain, load
from tests.solve.test_statics import softest

# The closed forms leave out the bending before: the stiff plane is 1e6 times as stiff. EI GJ = 1, length 1.
STRIP = Bar(1e9, [1e6, 1.0], 1.0, 1.0)
TIP = brentq(lambda force: jv(-1 / 4, force / 2), 3, 5)  # 4.013 sqrt(EI GJ)/L^2: section 6.3
MIDDLE = 16 * brentq(lambda x: jv(-3 / 4, x), 0.5, 2)  # 16.94 sqrt(EI GJ)/L^2: section 6.3


def clamped(count, force):
    """Load a clamped strip at its tip."""
    machine, tip = chain(np.linspace([0, 0, 0], [1.0, 0, 0], count + 1), STRIP, np.array([0, 1.0, 0]))
    load(machine, machine.end(tip), 1, force)
    return machine


def on_forks(count, force):
    """Load the middle of a strip whose ends neither twist nor move across, on balls."""
    machine = Machine(SPACE)
    ends = [machine.add_pose(np.zeros(3), fixed="place"), machine.add_pose(np.array([1.0, 0, 0]))]
    members = Members(machine)
    middle = members.add(*ends, count, STRIP, np.array([0, 1.0, 0]))[count // 2 - 1]
    members.done()
    ground = machine.at_ground()
    machine.rows += [Row((ground, machine.end(end)), Measure(Look.ALIGNED, 2, 1)) for end in ends]  # y' stays across z
    machine.rows += [Row((ground, machine.end(ends[1])), Measure(Look.PLACE, axis)) for axis in (1, 2)]
    load(machine, machine.end(middle), 1, force)
    return machine


def critical(build, count, exact):
    return brentq(lambda force: softest(build(count, force)), 0.7 * exact, 1.2 * exact, xtol=1e-9) / exact - 1


@pytest.mark.parametrize(("build", "exact", "bounds"), [(clamped, TIP, (8e-3, 7e-4)), (on_forks, MIDDLE, (4e-2, 4e-3))])
def test_a_strip_buckles_sideways_at_its_load_with_order_4(build, exact, bounds):
    errors = np.array([critical(build, count, exact) for count in (2, 4, 8)])
    assert (errors[:2] > 0).all()
    assert (errors[:2] < bounds).all()
    assert np.log2(errors[1] / errors[2]) > 3.7
