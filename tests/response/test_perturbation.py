"""Vibration that positions in time are too few for, of one oscillator beside a stiff one that moves by statics."""

import numpy as np
import pytest

from fenics_mech.mechanism.equation import Matrices
from fenics_mech.response.perturbation import too_fast

TIME = np.linspace(0, 1, 401)
SLOW, FAST = 2 * np.pi * 10, 2 * np.pi * 500


def found(ratio=0.0, vibration=1.0, every=1):
    """What is too fast in a vibration at 10 Hz and a motion at 1 Hz of coordinates of 10 and 500 Hz."""
    time = TIME[::every]
    mass, stiffness = np.eye(2), np.diag([SLOW, FAST]) ** 2
    matrices = (np.repeat(part[None], len(time), axis=0) for part in (mass, 2 * ratio * np.sqrt(stiffness), stiffness))
    waves = [(vibration * np.exp(1j * SLOW * time), 1j * SLOW), (SLOW / FAST * np.exp(2j * np.pi * time), 2j * np.pi)]
    q, rate = (np.stack([(factor * wave).real for wave, factor in part], axis=1) for part in _both(waves))
    return too_fast(Matrices(*matrices, load=q), (q, rate), float(time[1]), 1.0)


def _both(waves):
    return [(wave, 1.0) for wave, _ in waves], waves


def test_vibration_that_lags_behind():
    """40 positions in a period lag by 0.13 rad in 10 periods, 8 by 3.2 rad; damped, they end before."""
    assert found() is None
    assert found(every=5) == pytest.approx(10)
    assert found(every=5, ratio=0.1) is None


def test_small_vibration_and_statics_do_not_count():
    assert found(every=5, vibration=0.01) is None
