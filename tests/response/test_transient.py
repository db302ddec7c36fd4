"""The response in time against closed forms and the periodic solvers."""

import numpy as np
import pytest
from synthetic import arm

from fenics_mech import analyse
from fenics_mech.building import mechanism, system_at
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism.equation import Equation
from fenics_mech.recovery.viscous import delayed
from fenics_mech.response.transient import Coefficients, Span, integrate
from fenics_mech.scene.factories import seed_four_bar

BDF = {"transient_ts_type": "bdf", "transient_ts_bdf_order": 5}
SPAN = Span(cycle=2 * np.pi, samples=40, cycles=1, settled=0, steady_after=0, tolerance=1e-4)


class Oscillator:
    """``z'' + 4 z = cos t``: from rest ``z = (cos t - cos 2t)/3``."""

    law = dofs = None
    error, weight = 0.0, np.ones(1)

    def at(self, time):
        return [np.eye(1), np.zeros((1, 1)), 4 * np.eye(1), np.array([np.cos(time)])]


def error(tolerance, **options):
    span = Span(**(vars(SPAN) | {"tolerance": tolerance}))
    found = integrate(Oscillator(), span, 0.0, np.zeros(1), np.zeros(1), options)
    exact = (np.cos(found.time) - np.cos(2 * found.time)) / 3, (2 * np.sin(2 * found.time) - np.sin(found.time)) / 3
    return max(np.abs(found.displacement[:, 0] - exact[0]).max(), np.abs(found.velocity[:, 0] - exact[1]).max() / 2)


def test_oscillator_from_rest():
    """The error is in proportion to the tolerance of a step: twice as much, after all steps of three swings."""
    for tolerance in (1e-4, 1e-5):
        assert error(tolerance) == pytest.approx(1.9 * tolerance, rel=0.05)
    assert error(1e-8, **BDF) < 1e-5


def test_orders_with_equal_steps():
    """alpha2 without numerical damping, as its first acceleration is only of order 1; BDF begins at low order, too."""
    for options, order in (({"transient_ts_alpha_radius": 1.0}, 2), (BDF | {"transient_ts_bdf_order": 2}, 2)):
        found = [error(1e-4, transient_ts_adapt_type="none", transient_ts_dt=h, **options) for h in (0.08, 0.04, 0.02)]
        assert np.log2(np.divide(found[:-1], found[1:])) == pytest.approx([order] * 2, abs=0.1)


def test_steps_that_fail_are_told():
    with pytest.raises(SolverError, match=r"time steps failed at .* \(CONVERGED_ITS\)"):
        error(1e-4, transient_ts_max_steps=7)


def test_matrices_between_nodes():
    """Interpolation of degree 7 in 30 windows of a cycle, at times that are not those it checks itself by."""
    scene = seed_four_bar(effects=("coupling",), drive__run_up=0.3, analysis={"sub_intervals": 24})
    system = mechanism(scene)
    here = Coefficients(
        lambda t: Equation(system_at(scene, system.beams, solve_motion_in_time(scene, t))), scene.period, 30, 0.3
    )
    for time in (0.0123, 0.2789, 0.4321, 0.4321 + 5 * scene.period):
        exact = here.equation_at(np.array([time])).linear
        found, weight = here.at(time), here.weight
        for part, matrix in zip(found, (exact.mass, exact.damping, exact.stiffness)):
            scaled = matrix[0] / np.outer(weight, weight)
            assert np.abs(part - scaled).max() < 1e-6 * np.abs(scaled).max()
        assert np.abs(found[3] - exact.load[0] / weight).max() < 1e-6 * np.abs(exact.load[0] / weight).max()
    assert here.error < 1e-6


def test_matrices_that_change_too_fast_are_refused():
    scene = seed_four_bar(effects=("coupling",), analysis={"sub_intervals": 4, "method": "transient", "cycles": 1})
    with pytest.raises(SolverError, match="change too fast to be interpolated"):
        analyse(scene)


@pytest.fixture(scope="module")
def shaft():
    """An arm under its weight, of 2 elements, with bending that shortens it."""
    rest = {"mesh": {"elements": 2}, "damping": {"material": 4e-3}, "effects": ("coupling", "moderate-rotations")}
    return arm(20.0, **rest, analysis={"sub_intervals": 64, "stability": False, "time_tolerance": 1e-6}, petsc=BDF)


def in_time(scene, **analysis):
    return analyse(scene.changed(analysis__method="transient", **{f"analysis__{k}": v for k, v in analysis.items()}))


@pytest.mark.parametrize("run_up", [None, 0.5])
def test_becomes_the_periodic_motion(shaft, run_up):
    """From rest at full speed, and through a run-up, which ends in the same motion at other drive angles."""
    periodic = analyse(shaft.changed(analysis__solver="collocation", analysis__stages=4)).data
    started = in_time(shaft.changed(drive__run_up=run_up), cycles=20, settled=1e-5).data
    assert started.attrs["cycle_change"] < 1e-5
    assert started.sizes["theta"] < 20 * 64
    peak = float(np.abs(periodic["stress"]).max())
    theta = started["theta"].to_numpy()[-64:]
    tip = np.interp(theta % (2 * np.pi), *_closed(periodic, periodic["stress"][:, 0, 0, 0].to_numpy()))
    assert np.abs(started["stress"][-64:, 0, 0, 0].to_numpy() - tip).max() < 5e-3 * peak  # linear between 64 angles
    if run_up is None:
        gap = np.abs(started["stress"].to_numpy()[-65:-1] - periodic["stress"].to_numpy()).max()
        assert gap < 1e-4 * peak
        assert np.abs(started["strain"].to_numpy()[-65:-1] - periodic["strain"].to_numpy()).max() < 1e-3 * float(
            np.abs(periodic["strain"]).max()
        )


def _closed(periodic, values):
    return np.append(periodic["theta"], 2 * np.pi), np.append(values, values[0])


def test_goes_on_from_a_file(shaft, tmp_path):
    whole = in_time(shaft, cycles=4, settled=0)
    first = in_time(shaft, cycles=2, settled=0)
    rest = in_time(shaft, cycles=2, settled=0, start=str(first.save(tmp_path / "first.nc")))
    assert float(rest.data["time"][0]) == pytest.approx(float(first.data["time"][-1]))
    assert float(rest.data["theta"][-1]) == pytest.approx(8 * np.pi)
    old, new = whole.data["deflection"].to_numpy()[128:], rest.data["deflection"].to_numpy()
    assert np.abs(old - new).max() < 1e-4 * np.abs(old).max()  # BDF begins again at order 1
    with pytest.raises(SceneError, match="degrees of freedom, and the scene has"):
        in_time(shaft.changed(mesh__elements=1), start=str(tmp_path / "first.nc"))


def test_starts_straight_or_bent(shaft):
    linear = shaft.changed(effects=())
    still = analyse(linear.changed(analysis__method="quasi-static")).data["deflection"].to_numpy()[0]
    straight, bent = (
        in_time(linear, cycles=1, start=start).data["deflection"].to_numpy() for start in ("rigid", "static")
    )
    assert bent[0] == pytest.approx(still, abs=1e-9 * np.abs(still).max())
    nodes = straight[0, 0, ::10]  # between them bends the particular solution of the inertia
    assert np.abs(nodes).max() < 1e-9 * np.abs(still).max()


def test_alpha2_agrees(shaft):
    by_bdf = in_time(shaft, cycles=1, settled=0).data["deflection"].to_numpy()
    found = in_time(shaft.changed(petsc={}), cycles=1, settled=0, time_tolerance=1e-5).data["deflection"].to_numpy()
    assert np.abs(found - by_bdf).max() < 2e-3 * np.abs(by_bdf).max()


def test_what_is_not_solved_in_time_is_refused(shaft):
    blown = shaft.changed(impulses={"blow": {"at": "arm.A", "impulse": (0.01, 0.0), "angle": "40 deg"}})
    with pytest.raises(SceneError, match="impulses act in the periodic response"):
        in_time(blown)
    with pytest.raises(SceneError, match="more than a result holds"):
        in_time(shaft, cycles=10_000)


def test_strain_behind_a_stress():
    """``e + tau e' = s`` with e = sin t: s = sin t + tau cos t, and what the start lacks dies out."""
    step, tau = 0.05, 0.2
    time = step * np.arange(200)
    found = delayed((np.sin(time) + tau * np.cos(time))[:, None], tau, step)[:, 0]
    lack = tau * np.exp(-time / tau)  # the first strain is taken to be the first stress
    assert found - lack == pytest.approx(np.sin(time), abs=1e-6)  # of a cubic spline: step^4/384 and its ends
