"""The exact oscillator against SciPy's integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from fenics_mech.response.periodic.oscillator import Oscillators


@pytest.mark.parametrize("zeta", [0.0, 0.02, 0.6, 0.999])
def test_against_numerical_integration(zeta):
    omega, load, slope, time = 7.3, 2.1, -4.0, 1.7
    start = np.array([0.3, -0.2])  # y and y'/omega
    answer = solve_ivp(
        lambda t, y: [y[1], load + slope * t - 2 * zeta * omega * y[1] - omega**2 * y[0]],
        (0, time),
        [start[0], start[1] * omega],
        rtol=1e-12,
        atol=1e-14,
    ).y[:, -1]
    one = Oscillators(np.array(omega), np.array(zeta))
    found = one.transition(time) @ start + one.forced(np.array(load), np.array(slope), time)
    assert found[0] == pytest.approx(answer[0], abs=1e-10)
    assert found[1] * omega == pytest.approx(answer[1], abs=1e-9)
