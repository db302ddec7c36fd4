"""Frequencies beside a periodic motion, named by the held modes that they move in."""

import numpy as np
import pytest

from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import periodic, rigid_cycle, running_modes
from tests.cases.test_rigid_arms import turning
from tests.machine.builders import seed


@pytest.mark.slow
@pytest.mark.parametrize(("speed", "right"), [(20.0, 26.371), (60.0, 33.407), (120.0, 43.985)])
@pytest.mark.parametrize("steps", [60, 120])
def test_frequency_of_a_turning_beam_with_a_rigid_tip(speed, right, steps):
    """Ritz's method with cubic functions for the beam and an exact rigid body; beside 60 steps, at 20 to 120 rad/s.

    The principal values are within half of the speed, 10 to 60 rad/s.
    """
    scene = turning(speed)
    machine = machine_of(scene).machine
    machine.chart = rigid_cycle(machine, scene.period, 16)
    rates = running_modes(periodic(machine, scene.period, steps), 4).rates
    assert rates[0].imag == pytest.approx(right, rel=2e-4)


@pytest.mark.slow
def test_frequencies_of_the_seed_are_near_the_means_of_its_held_modes():
    """Held modes swing between 43.3 and 46.7, 48.7 and 50.2, 62 and 112 Hz over the cycle, 192 and 195 Hz.

    An own program in link frames has 46.92, 49.33, 89.14 and 192.8 Hz beside the linear motion.
    """
    machine, period = seed(4), 2 * np.pi / 32.3
    machine.chart = rigid_cycle(machine, period)
    values, rates, _ = running_modes(periodic(machine, period, 120), 8)
    np.testing.assert_allclose(rates.imag / (2 * np.pi), [46.92, 49.33, 89.14], rtol=5e-3)
    once = np.exp(rates * period)  # a rate stands for its conjugate, too
    np.testing.assert_allclose(np.minimum(np.abs(once - values), np.abs(once - values.conj())), 0, atol=1e-12)
