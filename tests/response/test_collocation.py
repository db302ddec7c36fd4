"""Collocation: its orders, its points between, a nonlinear motion, resonance."""

import re

import numpy as np
import pytest
from fenics_mech.accuracy.periodic_errors import corrected
from fenics_mech.response.periodic.collocation import between, solve_collocation
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.tableau import Tableau

from fenics_mech import analyse
from fenics_mech.errors import SolverError
from fenics_mech.planning.cycle_steps import Steps
from fenics_mech.response.periodic import newton
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of, too_coarse
from tests.response.synthetic import PERIOD, Duffing, Manufactured, arm, oscillators, places, plain


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
    analysis = {"sub_intervals": 96, "modes": 3, "solver": solver, "harmonics": 10, "allow_large": True}
    scene = arm(2 * np.pi * frequency / harmonic, analysis=analysis)
    with pytest.raises(SolverError, match="resonance") as found:
        analyse(scene)
    text = re.search(r"mode (\d+) \((\S+) Hz\), .* harmonic (\d+) of the drive", str(found.value))
    assert text is not None
    assert (int(text[1]), int(text[3])) == (mode, harmonic)
    assert float(text[2]) == pytest.approx(frequency, rel=1e-5)  # six digits are printed
    assert analyse(scene.changed(drive__speed=1.01 * scene.drives[0].speed)).data["deflection"].notnull().all()


@pytest.mark.parametrize(
    ("scheme", "stages", "count"),
    [("gauss", 2, 40), ("gauss", 3, 24), ("radau", 1, 80), ("radau", 2, 40), ("radau", 3, 24)],
)
def test_better_steps_tell_the_error(scheme, stages, count):
    """The other scheme is one order better: the difference is the error, but for the first order of one Radau point."""
    orbit, _ = solved(scheme, stages, count)
    better = Tableau.of(*(("gauss", stages) if scheme == "radau" else ("radau", stages + 1)))
    flow = Flow(Manufactured().matrices(places(better.points, count)), better, PERIOD / count)
    exact = Manufactured().motion(places(np.zeros(1), count))[0]
    error, estimate = (np.abs(orbit.start - other).max() for other in (exact, corrected(orbit, flow)[0]))
    assert estimate == pytest.approx(error, rel=0.6 if stages == 1 else 0.25)


@pytest.mark.long
@pytest.mark.slow
def test_error_estimate_of_the_seed_four_bar():
    """Within a factor of 3 of the true one, which spans four powers of ten; too long steps are refused."""
    scene = seed_four_bar(effects=("coupling",), analysis={"solver": "collocation", "stability": False})
    finest = response_of(scene.changed(analysis__sub_intervals=720)).data
    fine = finest["strain"]
    peak = np.abs(fine).max(dim=("theta", "s", "fibre"))
    for scheme, stages, count in (("radau", 2, 120), ("radau", 3, 72), ("radau", 3, 360), ("gauss", 3, 120)):
        steps = {"sub_intervals": count, "stages": stages, "scheme": scheme, "allow_coarse": True}
        data = analyse(scene.changed(analysis=scene.analysis.model_copy(update=steps))).data
        error = np.abs(data["strain"] - fine[:: 720 // count].to_numpy()).max(dim=("theta", "s", "fibre"))
        assert (data["strain_error"].sel(source="time") < 3 * error).all()
        assert (data["strain_error"].sel(source="time") > error / 3).all()
        force = np.hypot(
            *np.moveaxis((data["joint_force"] - finest["joint_force"][:: 720 // count].to_numpy()).to_numpy(), 2, 0)
        )
        assert (data["joint_force_error"].sel(source="time") > force.max(axis=0) / 3).all()
        assert (data["joint_force_error"].sel(source="time") < 4 * force.max(axis=0)).all()
        whole = float((data["strain_error"].sum("source") / peak).max())
        assert data.attrs["error_estimate"] == pytest.approx(whole, rel=0.05)
    told = too_coarse(scene.changed(analysis__sub_intervals=24))
    assert re.match(r"the sub-intervals are too long: .* Take at least \d+ sub_intervals", told)


@pytest.mark.parametrize("scheme", ["radau", "gauss"])
@pytest.mark.parametrize("speed", [3.0, -3.0])
def test_steps_are_cut_where_a_load_jumps(scheme, speed):
    """So that the impulse of a load over a cycle is right to rounding, although it jumps inside sub-intervals."""
    pulse = {"kind": "pulse", "start": 0.5, "end": 2.3}
    table = {"kind": "table", "angles": [0.0, 1.0, 1.0, 2 * np.pi], "values": [0.0, 1.0, 3.0, 5.0]}
    scene = arm(
        speed, loads={name: {"at": "arm.A", "force": (0, 1), "factor": f} for name, f in (("p", pulse), ("t", table))}
    )
    scene = scene.changed(analysis__sub_intervals=7)
    steps, tableau = Steps.of(scene), Tableau.of(scheme, 3)
    assert steps.regular.sum() == 7
    assert len(steps.start) == 10
    assert steps.duration.sum() == pytest.approx(scene.period)
    angles = steps.angles(tableau.points)
    for name, mean in (("p", 1.8 / (2 * np.pi)), ("t", (0.5 + 4 * (2 * np.pi - 1)) / (2 * np.pi))):
        values = scene.loads[name].factor_at(angles).reshape(-1, 3) @ tableau.weights
        assert values @ steps.duration / scene.period == pytest.approx(mean, rel=1e-8)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("method", ["periodic", "transient"])
def test_strain_of_a_viscous_material_between_few_positions_counts_as_error(method):
    """It is filtered out of the stress at the positions: 24 of them are too few, whatever the steps."""
    scene = seed_four_bar(effects=("coupling",), damping={"material": 5e-3}, mesh={"elements": 2})
    fine = response_of(scene.changed(analysis__stability=False, analysis__allow_coarse=True)).data["strain"]
    analysis = {"sub_intervals": 24, "stability": False, "allow_coarse": True, "method": method, "settled": 1e-6}
    found = analyse(scene.changed(analysis=scene.analysis.model_copy(update=analysis))).data
    turn = np.round(np.degrees(found["theta"].to_numpy()[-24:])).astype(int) % 360
    error = np.abs(found["strain"][-24:] - fine[turn].to_numpy()).max(dim=("theta", "s", "fibre"))
    assert float(error.max()) > 0.02 * np.abs(fine).max()  # measured 2 and 3 %
    assert (found["strain_error"].sel(source="time") > error / 4).all()
    stated = scene.changed(analysis=scene.analysis.model_copy(update=analysis | {"allow_coarse": False}))
    assert "sub-intervals are too long" in too_coarse(stated)


@pytest.mark.long
@pytest.mark.slow
def test_error_after_a_blow_is_estimated():
    """Blows excite vibrations faster than the steps follow: the estimate is at least a third of the true error."""
    blow = {"h": {"at": "B", "angle": np.radians(91.3), "impulse": (0, 0.002)}}
    scene = seed_four_bar(effects=("coupling",), impulses=blow, analysis={"stability": False, "allow_coarse": True})
    fine = response_of(scene.changed(analysis__sub_intervals=1440)).data
    coarse = analyse(scene.changed(analysis__sub_intervals=240)).data
    error = np.abs(coarse["strain"] - fine["strain"][::6].to_numpy()).max(dim=("theta", "s", "fibre"))
    assert (coarse["strain_error"].sel(source="time") > error / 3).all()


def test_iterates_that_overflow_take_less_load(monkeypatch):
    shares = []

    def at_load(equation, solve, guess, factor, orbit, tension):
        shares.append(factor)
        if factor - (shares[-2] if len(shares) > 2 else 0.0) > 0.5:
            raise FloatingPointError("overflow encountered in multiply")
        return "motion", tension

    monkeypatch.setattr(newton, "_at_load", at_load)
    assert newton.solve_nonlinear(None, None, np.zeros(1)) == "motion"
    assert shares == [1.0, 0.5, 1.0]
