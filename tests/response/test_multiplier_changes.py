"""Derivatives of Floquet multipliers against closed forms."""

import numpy as np
import pytest

from fenics_mech.errors import DerivativeError
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.stability.floquet import floquet
from fenics_mech.response.stability.multiplier_changes import Disturbances
from tests.response.synthetic import PERIOD, axes_of, modes_of, oscillators, places

ZETA, STEPS = 0.02, 160  # the steps change a multiplier by N (omega h)^7/100800, below 1e-8


def disturbances(omega, zeta=ZETA):
    """Disturbances of damped oscillators that are not coupled, and their multipliers."""
    tableau, omega = Tableau.of("gauss", 3), np.array(omega)
    matrices = oscillators(places(tableau.points, STEPS), omega, 2 * zeta * omega)
    flow = Flow(matrices, tableau, PERIOD / STEPS)
    stability = floquet(flow, matrices, axes_of(matrices, STEPS), modes_of(omega))
    return Disturbances.find(flow, stability), stability


def left_over(found, omega, change):
    """What oscillators of other frequencies leave over of the disturbances."""
    more = [(change * 2 * ZETA) * part.velocity + (2 * omega * change) * part.displacement for part in found.parts]
    assert len(more) == 4  # two pairs, of two parts each
    return more


def test_a_vibration_that_decays_has_the_derivatives_of_the_closed_form():
    omega, change = np.array([2.0, 7.3]), np.array([0.3, -0.2])  # of the frequencies, in a step of any size
    found, stability = disturbances(omega)
    rate = (-ZETA + 1j * np.sqrt(1 - ZETA**2)) * change  # of log(mu) / T
    changes = found.changes(left_over(found, omega, change))
    order = stability.mode
    expected = (
        rate.real[order]
        + 1j * np.where(stability.multipliers.imag * np.sin(omega * PERIOD)[order] > 0, 1, -1) * (rate.imag[order])
    )
    np.testing.assert_allclose(changes / (stability.multipliers * PERIOD), expected, rtol=1e-7)
    step = 1e-6
    beside = found.changed(step * changes, 1 + step)  # by a drive that is faster
    slope = (beside.frequency - stability.frequency) / step
    np.testing.assert_allclose(slope, rate.imag[order] / (2 * np.pi) + stability.frequency, rtol=1e-5)


def test_multipliers_that_are_alike_have_no_derivatives():
    with pytest.raises(DerivativeError, match="one of several that are alike"):
        disturbances([2.0, 2.0])
    with pytest.raises(DerivativeError, match="meets another one"):  # critical damping: two become one
        disturbances([2.0], 1.0)
