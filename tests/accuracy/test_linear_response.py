"""What a load changes in time, and vibration that positions are too few for, beside a stiff coordinate."""

import numpy as np
import pytest

from fenics_mech.accuracy.linear_response import change_in_time, too_fast
from fenics_mech.mechanism.matrices import Matrices

TIME = np.linspace(0, 1, 401)
SLOW, FAST = 2 * np.pi * 10, 2 * np.pi * 500


def found(ratio=0.0, vibration=1.0, every=1):
    """What is too fast in a vibration at 10 Hz and a motion at 1 Hz of coordinates of 10 and 500 Hz."""
    time = TIME[::every]
    mass, stiffness = np.eye(2), np.diag([SLOW, FAST]) ** 2
    matrices = (np.repeat(part[None], len(time), axis=0) for part in (mass, 2 * ratio * np.sqrt(stiffness), stiffness))
    waves = [(vibration * np.exp(1j * SLOW * time), 1j * SLOW), (SLOW / FAST * np.exp(2j * np.pi * time), 2j * np.pi)]
    q, rate = (np.stack([(factor * wave).real for wave, factor in part], axis=1) for part in _both(waves))
    return too_fast(Matrices.of_full(*matrices, load=q), (q, rate), float(time[1]), 1.0)


def _both(waves):
    return [(wave, 1.0) for wave, _ in waves], waves


def test_vibration_that_lags_behind():
    """40 positions in a period lag by 0.13 rad in 10 periods, 8 by 3.2 rad; damped, they end before."""
    assert found() is None
    assert found(every=5) == pytest.approx(10)
    assert found(every=5, ratio=0.1) is None


def test_small_vibration_and_statics_do_not_count():
    assert found(every=5, vibration=0.01) is None


def changed(duration, steps, turning=0.0):
    """Changes of q and q' by a unit load along a soft axis, of 1 rad/s, that turns beside a stiff one; and times."""
    time = duration / steps * np.arange(1, steps + 1)
    axes = np.stack([np.exp(1j * turning * time), 1j * np.exp(1j * turning * time)], axis=-1)
    axes = np.stack([axes.real, axes.imag], axis=1)
    stiffness = axes @ np.diag([1.0, 1e10]) @ axes.transpose(0, 2, 1)
    mass = np.repeat(np.eye(2)[None], steps, axis=0)
    matrices = Matrices.of_full(mass, 0 * mass, stiffness, load=axes[..., 0])
    found = change_in_time(axes[..., 0], matrices, duration / steps, np.zeros((4, 2)))
    return np.einsum("dki,kij->dkj", found[:2], axes), time


def test_change_by_matrices_that_turn():
    """By the soft axis' own equation ``x'' + (1 - turning^2) x = 1``; nothing grows along the stiff one."""
    (along, _), time = changed(duration=60.0, steps=2000, turning=0.6)
    assert along[:, 0] == pytest.approx((1 - np.cos(0.8 * time)) / 0.64, abs=0.1)
    assert np.abs(along[:, 1]).max() < 1e-8


def test_change_that_vibrates_on():
    """About the static answer, 1, after 10 periods of 8 positions the vibration is as high as it was."""
    (q, rate), _ = changed(duration=20 * np.pi, steps=80)
    assert np.hypot(q[-1, 0] - 1, rate[-1, 0]) == pytest.approx(1, rel=0.1)
