"""Collocation: its orders, its points between, a nonlinear motion, resonance."""

import re

import numpy as np
import pytest
from synthetic import PERIOD, Duffing, Manufactured, arm, oscillators, places, plain

from fenics_mech import analyse
from fenics_mech.errors import SolverError
from fenics_mech.response.collocation import between, solve_collocation
from fenics_mech.response.tableau import Tableau


def solved(scheme, stages, count):
    case, tableau = Manufactured(), Tableau.of(scheme, stages)
    equation = plain(case.matrices(places(tableau.points, count)))
    return solve_collocation(equation, tableau, PERIOD / count, {}), tableau


@pytest.mark.parametrize(
    ("scheme", "stages", "count"),
    [("gauss", 1, 40), ("gauss", 2, 40), ("gauss", 3, 24), ("radau", 1, 80), ("radau", 2, 40), ("radau", 3, 24)],
)
def test_order_at_the_starts(scheme, stages, count):
    """Hairer and Wanner II, theorems IV.5.2 and IV.5.3: 2s for Gauss, 2s - 1 for Radau IIA."""
    errors = []
    for n in (count, 2 * count):
        orbit, _ = solved(scheme, stages, n)
        errors.append(np.abs(orbit.start - Manufactured().motion(places(np.zeros(1), n))[0]).max())
    order = 2 * stages - (scheme == "radau")
    assert np.log2(errors[0] / errors[1]) == pytest.approx(
        order, abs=0.12
    )  # measured within 0.1, the first order method last


@pytest.mark.parametrize("scheme", ["gauss", "radau"])
def test_points_between_are_of_order_s_plus_1(scheme):
    """Both q' and q'' are polynomials through s points: their integrals are good to order s + 1 at any place."""
    inside, errors = np.array([0.3, 0.8]), []
    for n in (24, 48):
        orbit, tableau = solved(scheme, 3, n)
        exact = Manufactured().motion(places(inside, n))
        found = between(orbit, tableau, PERIOD / n, inside)
        errors.append([np.abs(a - b).max() for a, b in zip(found, exact)])
    assert np.log2(np.divide(*errors)) == pytest.approx([4, 4], abs=0.15)
    assert np.allclose(between(orbit, tableau, PERIOD / n, tableau.points)[0], orbit.displacement, atol=1e-12)


def test_resonance_of_a_damped_mode():
    """At resonance the amplitude is ``f/(2 zeta omega^2)``."""
    omega, zeta, count = 5 * 2 * np.pi / PERIOD, 0.01, 200
    tableau = Tableau.of("gauss", 3)
    time = places(tableau.points, count)
    matrices = oscillators(time, np.array([omega]), np.array([2 * zeta * omega]), 7 * np.cos(omega * time)[:, None])
    orbit = solve_collocation(plain(matrices), tableau, PERIOD / count, {})
    amplitude = np.hypot(orbit.start, orbit.start_velocity / omega)
    assert amplitude == pytest.approx(7 / (2 * zeta * omega**2), rel=1e-6)  # phase error (omega h)^7/100800 a step


def test_nonlinear_motion():
    tableau = Tableau.of("gauss", 3)
    time = places(tableau.points, 40)
    duffing = Duffing(time)
    orbit = solve_collocation(duffing, tableau, PERIOD / 40, {}, duffing.tension)
    exact = duffing.motion(places(np.zeros(1), 40))[0]
    assert np.abs(orbit.start - exact).max() < 1e-8  # of order 6; measured 4e-10


@pytest.mark.parametrize("solver", ["collocation", "harmonic-balance"])
@pytest.mark.parametrize(("harmonic", "mode"), [(1, 1), (3, 1), (6, 2)])
def test_undamped_resonance_is_named(solver, harmonic, mode):
    modes = analyse(arm(1.0, analysis={"sub_intervals": 24, "modes": 3, "solver": "sub-intervals"}))
    frequency = float(modes.data["frequency"][0, mode - 1])
    analysis = {"sub_intervals": 96, "modes": 3, "solver": solver, "harmonics": 10}
    scene = arm(2 * np.pi * frequency / harmonic, analysis=analysis)
    with pytest.raises(SolverError, match="resonance") as found:
        analyse(scene)
    text = re.search(r"mode (\d+) \((\S+) Hz\), .* harmonic (\d+) of the drive", str(found.value))
    assert text is not None
    assert (int(text[1]), int(text[3])) == (mode, harmonic)
    assert float(text[2]) == pytest.approx(frequency, rel=1e-5)  # six digits are printed
    assert analyse(scene.changed(drive__speed=1.01 * scene.drives[0].speed)).data["deflection"].notnull().all()
