"""Parametric instability: a column under a pulsating axial force, against Mathieu's equation and Bolotin's formulas.

All operators of a uniform column on two pins have the half-wave as an eigenfunction: its height follows
``y'' + c y' + w^2 (1 - 2 mu cos(rate t)) y = 0`` with ``w^2 = w_1^2 (1 - P_0/P_E)`` and ``mu = P_t/(2 (P_E - P_0))``.
Bolotin, The Dynamic Stability of Elastic Systems (1964), sections 1, 2 and 5.
"""

import numpy as np
import pytest
from matplotlib.collections import QuadMesh
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fenics_mech.scene import load
from fenics_mech.studies.sweep import run_sweep
from fenics_mech.studies.sweep_axes import parse_axes
from fenics_mech.views.sweep_maps import stability_map
from tests.common import DEMOS, response_of

LENGTH, WIDTH, HEIGHT, DENSITY, MODULUS, DAMPING, DEAD = 0.5, 0.02, 0.002, 7850.0, 206e9, 3.0, 32.5
EI = MODULUS * WIDTH * HEIGHT**3 / 12
EULER = np.pi**2 * EI / LENGTH**2
OMEGA = np.pi**2 / LENGTH**2 * np.sqrt(EI / (DENSITY * WIDTH * HEIGHT) * (1 - DEAD / EULER))  # w
MU = DEAD / 2 / (EULER - DEAD)  # for a factor of 1


@pytest.fixture(scope="module")
def column():
    """The demo."""
    return load(DEMOS / "pulsating_column.toml").changed(analysis__modes=2, mesh__elements=8)


def leading(column, speed, factor=1.0, **changes):
    """The largest multiplier, and the rate at which its disturbance grows."""
    scene = column.changed(drive__speed=speed, loads__pulse__factor__cosine=(factor,), **changes)
    data = response_of(scene).data.isel(disturbance=0)
    real, imaginary = data["multiplier"].to_numpy()
    return complex(real, imaginary), data["growth_rate"].item()


def mathieu(speed, mu):
    """Multipliers of Mathieu's equation by integration in time."""

    def rates(t, y):
        stiffness = OMEGA**2 * (1 - 2 * mu * np.cos(speed * t))
        return np.stack([y[1::2], -DAMPING * y[1::2] - stiffness * y[::2]], axis=1).ravel()

    end = solve_ivp(rates, (0, 2 * np.pi / speed), [1.0, 0.0, 0.0, 1.0], rtol=1e-11, atol=1e-12, method="DOP853")
    return np.linalg.eigvals(end.y[:, -1].reshape(2, 2))


def second_approximation(speed, mu):
    """Determinant of sines and cosines at 1/2 and 3/2 of the rate, which is 0 on a border: Bolotin, section 5."""
    matrix = np.zeros((4, 4))
    for i, order in enumerate((0.5, 1.5)):
        rate = order * speed
        matrix[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [
            [OMEGA**2 - rate**2, -DAMPING * rate],
            [DAMPING * rate, OMEGA**2 - rate**2],
        ]
    matrix[0, 0] += mu * OMEGA**2
    matrix[1, 1] -= mu * OMEGA**2
    matrix[[0, 1, 2, 3], [2, 3, 0, 1]] = -mu * OMEGA**2
    return np.linalg.det(matrix / OMEGA**2)


@pytest.mark.parametrize(("speed", "factor"), [(180.0, 1.0), (195.0, 1.0), (212.0, 1.0), (95.0, 2.0)])
def test_multiplier_in_an_unstable_region_is_mathieus(column, speed, factor):
    expected = max(mathieu(speed, factor * MU), key=abs)
    assert abs(expected) > 1.03  # about twice the frequency, and about the frequency itself
    # eight elements make the Euler load 5e-5 too large, by the fourth power of their number
    assert leading(column, speed, factor)[0] == pytest.approx(expected, rel=1e-3)


@pytest.mark.slow
def test_borders_of_the_principal_region_are_bolotins(column):
    for sign in (-1, 1):
        first = 2 * OMEGA * np.sqrt(1 + sign * MU)
        around = first * 0.97, first * 1.03
        expected = brentq(lambda speed: second_approximation(speed, MU), *around)
        found = brentq(lambda speed: leading(column, speed)[1], 0.998 * expected, 1.002 * expected, xtol=0.01)
        # the harmonic 5/2 that the formula leaves out moves them by less than mu^4/24
        assert found == pytest.approx(expected, rel=3e-4)
        assert abs(found - expected) < abs(found - first) / 3  # the first approximation


def test_damping_cuts_the_tip_of_the_region(column):
    # Bolotin, section 6: no instability while mu is less than the logarithmic decrement over pi
    least = DAMPING / OMEGA / MU
    assert leading(column, 2 * OMEGA, 0.98 * least)[1] < 0 < leading(column, 2 * OMEGA, 1.02 * least)[1]


@pytest.mark.slow
def test_a_motion_in_time_grows_at_the_rate_of_the_multiplier(column):
    few = column.changed(mesh__elements=2, analysis__allow_coarse=True, analysis__allow_large=True)
    scene = few.changed(drive__speed=195.0, analysis__method="transient", analysis__start="static")
    scene = scene.changed(analysis__settled=0.0, analysis__time_tolerance=1e-2)
    bent = np.abs(response_of(scene.changed(analysis__cycles=32)).data["deflection"].sel(component="x"))
    peaks = [bent.isel(theta=slice(cycles * scene.analysis.sub_intervals + 1)).max().item() for cycles in (24, 32)]
    multiplier, rate = leading(few, 195.0)
    assert multiplier.real < -1  # it changes sides in every cycle: its period is twice that of the force
    assert rate == pytest.approx(np.log(abs(multiplier)) * 195.0 / (2 * np.pi), rel=1e-9)
    # the forced part, of the small load across, is 0.5 % of the first of the two peaks
    assert np.log(peaks[1] / peaks[0]) / 8 == pytest.approx(np.log(abs(multiplier)), rel=5e-3)


@pytest.mark.slow
def test_map_shows_the_regions(column, tmp_path):
    axes = parse_axes(column, ["drive.speed=160:240:5", "loads.pulse.factor.cosine.0=0:2:3"])
    sweep = run_sweep(column.changed(analysis__sub_intervals=40, mesh__elements=2), axes, tmp_path)
    unstable = (sweep.data["multiplier"].max("disturbance") > 1).transpose(..., "drive.speed").to_numpy()
    speeds = sweep.data["drive.speed"].to_numpy()
    assert not unstable[0].any()
    for row, factor in ((1, 1.0), (2, 2.0)):
        inside = [abs(max(mathieu(speed, factor * MU), key=abs)) > 1 for speed in speeds]
        assert unstable[row].tolist() == inside
    (cells,) = (each for each in stability_map(sweep).axes[0].collections if isinstance(each, QuadMesh))
    cells.update_scalarmappable()
    red, _, blue, _ = cells.get_facecolors().T
    assert (red > blue).tolist() == unstable.ravel().tolist()
