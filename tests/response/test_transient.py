"""The response in time against closed forms and the periodic solvers."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import make_interp_spline

from fenics_mech import analyse
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.forces.viscous import delayed
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import mechanism, moved
from fenics_mech.response.transient import coefficients
from fenics_mech.response.transient.coefficients import Coefficients
from fenics_mech.response.transient.course import Schedule, VelocityJumps
from fenics_mech.response.transient.integration import integrate
from fenics_mech.response.velocity_jumps import impulses_between
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.start_state import StartState
from tests.common import response_of
from tests.response.synthetic import arm

BDF = {"transient_ts_type": "bdf", "transient_ts_bdf_order": 5}
ALPHA2 = {"transient_ts_type": "alpha2"}
RADAU, GAUSS = Tableau.of("radau", 5), Tableau.of("gauss", 3)
SPAN = Schedule(cycle=2 * np.pi, samples=40, cycles=1, settled=0, steady_after=0, tolerance=1e-4, tableau=RADAU)


class Oscillator:
    """``z'' + 2 zeta 2 z' + 4 z = f(t)``."""

    law = dofs = spin = None
    between = -np.inf, np.inf
    error, weight, start, cycle, largest, energy, growth = 0.0, np.ones(1), 0.0, 2 * np.pi, 1 / 4, 1 / 2, 0.0

    def __init__(self, load=np.cos, jumps=()):
        self.load, self.jump = load, np.array(jumps)

    def at(self, time):
        time = min(max(time, self.between[0]), self.between[1])
        return [np.eye(1), np.zeros((1, 1)), 4 * np.eye(1), np.array([self.load(time)])]

    def look(self, start, end):
        self.between = start + 1e-9, end - 1e-9

    def repeats(self, cycle):
        return True

    def jumps(self, cycle):
        return cycle * self.cycle + self.jump


def solved(oscillator, options=None, blows=None, **schedule):
    schedule = Schedule(**(vars(SPAN) | schedule))
    return integrate(oscillator, schedule, StartState(0.0, np.zeros(1), np.zeros(1)), options or {}, blows)


def error(tolerance, tableau=RADAU, **options):
    """Largest error of displacement and velocity: from rest ``z = (cos t - cos 2t)/3``."""
    found = solved(Oscillator(), options, tolerance=tolerance, tableau=tableau)
    exact = (np.cos(found.time) - np.cos(2 * found.time)) / 3, (2 * np.sin(2 * found.time) - np.sin(found.time)) / 3
    return max(np.abs(found.displacement[:, 0] - exact[0]).max(), np.abs(found.velocity[:, 0] - exact[1]).max() / 2)


@pytest.mark.parametrize("tableau", [RADAU, GAUSS])
def test_oscillator_from_rest(tableau):
    """Between the steps, too; errors are smaller than what is asked for, as the embedded method's order is lower."""
    for tolerance in (1e-4, 1e-6, 1e-8):
        assert error(tolerance, tableau) < tolerance


def test_oscillator_by_other_types():
    """The error of alpha2 is in proportion to the tolerance of a step: twice as much, after all steps."""
    for tolerance in (1e-4, 1e-5):
        assert error(tolerance, **ALPHA2) == pytest.approx(1.9 * tolerance, rel=0.05)
    assert error(1e-8, **BDF) < 1e-5


def test_orders_with_equal_steps():
    """alpha2 without numerical damping, as its first acceleration is only of order 1; BDF begins at low order, too."""
    for options in (ALPHA2 | {"transient_ts_alpha_radius": 1.0}, BDF | {"transient_ts_bdf_order": 2}):
        found = [error(1e-4, transient_ts_adapt_type="none", transient_ts_dt=h, **options) for h in (0.08, 0.04, 0.02)]
        assert np.log2(np.divide(found[:-1], found[1:])) == pytest.approx([2, 2], abs=0.1)


@pytest.mark.parametrize(("scheme", "stages", "order"), [("radau", 2, 3), ("radau", 3, 5), ("gauss", 2, 4)])
def test_orders_of_collocation(scheme, stages, order):
    """At the ends of equal steps, as a tolerance that stops nothing leaves the longest."""
    found = []
    for parts in (20, 40, 80):
        tableau = Tableau.of(scheme, stages)
        course = solved(Oscillator(), tolerance=0.99, samples=10, tableau=tableau, longest=1 / parts)
        assert course.steps == parts
        found.append(np.abs(course.displacement[:, 0] - (np.cos(course.time) - np.cos(2 * course.time)) / 3).max())
    assert np.log2(np.divide(found[:-1], found[1:])) == pytest.approx([order] * 2, abs=0.25)


@pytest.mark.parametrize("options", [{}, BDF])
def test_load_that_jumps(options):
    """Pushed from 1 on: ``z = (1 - cos 2(t - 1))/4``; a step ends there, so that none has to be short."""
    push = Oscillator(lambda time: float(time > 1), jumps=[1.0])
    found = solved(push, options, tolerance=1e-6)
    exact = np.where(found.time > 1, (1 - np.cos(2 * (found.time - 1))) / 4, 0)
    assert np.abs(found.displacement[:, 0] - exact).max() < (1e-4 if options else 1e-6)
    assert options or found.steps <= 42  # 40 of the longest would do for the whole cycle


@pytest.mark.parametrize("options", [{}, ALPHA2])
def test_impulse(options):
    """Struck by 2 at 0 and by 1 at pi/2: ``sin 2t`` and then ``sin 2t + sin 2(t - pi/2)/2 = sin(2t)/2``."""
    blows = VelocityJumps(np.array([0.0, np.pi / 2]), np.array([0, 1]), np.array([[2.0], [1.0]]))
    found = solved(Oscillator(lambda time: 0.0), options, blows, tolerance=1e-6)
    late = found.time > np.pi / 2 - 1e-9
    assert found.displacement[:, 0] == pytest.approx(np.sin(2 * found.time) * np.where(late, 0.5, 1), abs=1e-4)
    assert found.velocity[:, 0] == pytest.approx(np.cos(2 * found.time) * np.where(late, 1, 2), abs=2e-4)


def test_steps_that_fail_are_told():
    with pytest.raises(SolverError, match="PETSc has no steps of the transient_ts_type 'nonsense'"):
        error(1e-4, transient_ts_type="nonsense")
    with pytest.raises(SolverError, match=r"time steps failed at .* \(more than transient_ts_max_steps\)"):
        error(1e-4, transient_ts_max_steps=7, **ALPHA2)
    with pytest.raises(SolverError, match="time steps failed at 1 s, where they have become"):
        solved(Oscillator(lambda time: np.inf if time > 1 else 1.0))


@pytest.mark.parametrize(("tableau", "most"), [(GAUSS, 1e-12), (RADAU, 1e-6)])
def test_energy_after_many_cycles(tableau, most):
    """Undamped, 80 swings from a blow: Gauss points keep the energy, Radau points lose less than is asked for."""
    blow = VelocityJumps(np.zeros(1), np.zeros(1, np.int64), np.array([[2.0]]))
    found = solved(Oscillator(lambda time: 0.0), {}, blow, tolerance=1e-6, cycles=40, samples=4, tableau=tableau)
    energy = found.velocity[-1, 0] ** 2 / 2 + 2 * found.displacement[-1, 0] ** 2
    assert abs(energy / 2 - 1) < most


def interpolated(scene, tolerance):
    system = mechanism(scene)

    def equation_at(time):
        return Equation(moved(scene, system, solve_motion_in_time(scene, time)))

    return Coefficients(equation_at, scene.period, 0.0, scene.drives[0].run_up or 0.0, tolerance)


def test_matrices_between_nodes():
    """Interpolation of degree 7, at times that have nothing to do with the windows."""
    scene = seed_four_bar(effects=("coupling",), drive__run_up=0.3, analysis={"sub_intervals": 24})
    here = interpolated(scene, 1e-7)
    for time in (0.0123, 0.2789, 0.4321, 0.4321 + 5 * scene.period):
        exact = here.equation_at(np.array([time])).linear
        found, weight = here.at(time), here.weight
        for part, matrix in zip(found, exact.full):
            scaled = matrix[0] / np.outer(weight, weight)
            assert np.abs(part - scaled).max() < 1e-7 * np.abs(scaled).max()
        assert np.abs(found[3] - exact.load[0] / weight).max() < 1e-6 * np.abs(exact.load[0] / weight).max()
    assert here.error < 1e-7


@pytest.mark.parametrize(
    ("factor", "jumps"),
    [
        ({"kind": "pulse", "start": "0 deg", "end": "100 deg"}, [0, 100]),
        ({"kind": "table", "angles": ["10 deg", "90 deg", "90 deg", "300 deg"], "values": [0, 1, 2, 0]}, [90]),
        ({"kind": "expression", "formula": "theta"}, [0]),
    ],
)
def test_jumps_of_loads_are_found(factor, jumps):
    """Also where a jump is at the cycle's start; beside it, the load is that of its side."""
    here = interpolated(arm(20.0, loads={"tip": {"at": "arm.A", "force": (0.0, -1.0), "factor": factor}}), 1e-7)
    assert here.jumps(3) == pytest.approx(3 * here.cycle + here.cycle / 360 * np.array(jumps), abs=1e-8 * here.cycle)
    for jump in here.jumps(1):
        for end, side in ((jump, -1), (jump + 0.1 * here.cycle, 1)):
            here.look(end - 0.1 * here.cycle, end)
            beside = here.equation_at(np.array([jump + side * 1e-6 * here.cycle])).linear.load[0] / here.weight
            assert np.abs(here.at(jump)[3] - beside).max() < 1e-3 * np.abs(beside).max()


def test_loads_that_change_too_fast_are_refused(monkeypatch):
    monkeypatch.setattr(coefficients, "TABLE", replace(coefficients.TABLE, most_windows=300))
    factor = {"kind": "expression", "formula": "sin(2000*theta)"}
    with pytest.raises(SolverError, match="change too fast to be interpolated"):
        interpolated(arm(20.0, loads={"tip": {"at": "arm.A", "force": (0.0, -1.0), "factor": factor}}), 1e-7).at(0.0)


@pytest.fixture(scope="module")
def shaft():
    """An arm under its weight, of 2 elements, with bending that shortens it."""
    rest = {"mesh": {"elements": 2}, "damping": {"material": 1e-2}, "effects": ("coupling", "large-rotations")}
    analysis = {"sub_intervals": 64, "stability": False, "time_tolerance": 1e-6, "allow_coarse": True}
    return arm(20.0, **rest, analysis=analysis)


def in_time(scene, **analysis):
    return response_of(
        scene.changed(analysis__method="transient", **{f"analysis__{k}": v for k, v in analysis.items()})
    )


@pytest.mark.slow
@pytest.mark.parametrize("run_up", [None, 0.5])
def test_becomes_the_periodic_motion(shaft, run_up):
    """From rest at full speed, and through a run-up, which ends in the same motion at other drive angles."""
    periodic = response_of(shaft.changed(analysis__solver="collocation", analysis__stages=5)).data
    started = in_time(shaft.changed(drive__run_up=run_up), cycles=20, settled=1e-7).data
    assert started.attrs["cycle_change"] < 1e-7
    assert started.sizes["theta"] < 20 * 64
    peak = float(np.abs(periodic["stress"]).max())
    theta = started["theta"].to_numpy()[-64:]
    tip = np.interp(theta % (2 * np.pi), *_closed(periodic, periodic["stress"][:, 0, 0, 0].to_numpy()))
    assert np.abs(started["stress"][-64:, 0, 0, 0].to_numpy() - tip).max() < 5e-3 * peak  # linear between 64 angles
    if run_up is None:
        for name, tolerance in (
            ("deflection", 2e-3),
            ("stress", 2e-3),
            ("strain", 2e-3),
        ):  # one element in two linear theories
            last, exact = started[name].to_numpy()[-65:-1], periodic[name].to_numpy()
            assert np.abs(last - exact).max() < tolerance * np.abs(exact).max()


@pytest.mark.slow
def test_four_bar_becomes_periodic():
    """All that turns and bends, with damping: two linear theories, with one element a member."""
    scene = seed_four_bar(
        mesh={"elements": 1},
        effects=("coupling",),
        damping__ratio=0.1,
        analysis={"sub_intervals": 240, "stages": 5, "allow_coarse": True},
    )
    exact = response_of(scene.changed(analysis__solver="collocation", analysis__stability=False)).data["strain"]
    found = in_time(scene, cycles=6, settled=1e-7, time_tolerance=1e-7).data["strain"].to_numpy()[-241:-1]
    assert np.abs(found - exact.to_numpy()).max() < 1e-4 * np.abs(exact).max()


def test_run_up_against_another_integrator():
    """From rest through a run-up into the first cycle: SciPy's Radau, with splines of degree 7 through the matrices."""
    drive = {"joint": "O", "speed": 20.0, "run_up": 0.2}
    scene = arm(20.0, mesh={"elements": 1}, effects=("coupling",), damping={"material": 4e-3}, drive=drive)
    found = in_time(scene, sub_intervals=24, cycles=1, settled=0, time_tolerance=1e-7).data
    end = float(found["time"][-1])
    assert 0.2 + scene.period <= end < 0.2 + scene.period * 25 / 24  # the cycle comes after the run-up
    state = found["state"].transpose("derivative", "dof").to_numpy().ravel()
    system, course = mechanism(scene), np.zeros(len(state))
    for start, stop in ((0, 0.2), (0.2, end)):
        times = np.linspace(start, stop, 80)
        linear = Equation(moved(scene, system, solve_motion_in_time(scene, times))).linear
        parts = [make_interp_spline(times, part, k=7) for part in (*linear.full, linear.load)]

        def slope(time, state, parts=parts):
            mass, damping, stiffness, load = (part(time) for part in parts)
            q, rate = state.reshape(2, -1)
            return np.concatenate([rate, np.linalg.solve(mass, load - damping @ rate - stiffness @ q)])

        course = solve_ivp(slope, (start, stop), course, "Radau", rtol=1e-7, atol=1e-10).y[:, -1]
    assert np.abs(state - course).reshape(2, -1).max(axis=1) == pytest.approx([0, 0], abs=1e-6)
    assert np.abs(state - course).max() < 1e-6 * np.abs(course).max()


def test_cycles_are_counted_after_the_run_up(shaft):
    found = in_time(shaft.changed(effects=(), drive__run_up=1.0), cycles=2, settled=0).data
    assert found["theta"].to_numpy()[-1] - found["theta"].to_numpy()[-129] == pytest.approx(4 * np.pi)
    assert 1.0 <= float(found["time"][-129]) < 1.0 + shaft.period / 64


def _closed(periodic, values):
    return np.append(periodic["theta"], 2 * np.pi), np.append(values, values[0])


@pytest.mark.slow
def test_goes_on_from_a_file(shaft, tmp_path):
    whole = in_time(shaft, cycles=4, settled=0)
    first = in_time(shaft, cycles=2, settled=0)
    rest = in_time(shaft, cycles=2, settled=0, start=str(first.save(tmp_path / "first.nc")))
    assert float(rest.data["time"][0]) == pytest.approx(float(first.data["time"][-1]))
    assert float(rest.data["theta"][-1]) == pytest.approx(8 * np.pi)
    old, new = whole.data["deflection"].to_numpy()[128:], rest.data["deflection"].to_numpy()
    assert np.abs(old - new).max() < 1e-6 * np.abs(old).max()  # the steps are others
    with pytest.raises(SceneError, match="coordinates, and the scene has"):
        in_time(shaft.changed(mesh__elements=1), start=str(tmp_path / "first.nc"))
    with pytest.raises(SceneError, match="at drive angle 720 deg, where the scene's drive is at 1440 deg"):
        in_time(shaft.changed(drive__speed=2 * shaft.drive.speed), start=str(tmp_path / "first.nc"))


def test_bad_starts_are_refused(shaft, tmp_path):
    periodic = analyse(shaft.changed(effects=(), analysis__sub_intervals=8)).save(tmp_path / "periodic.nc")
    (tmp_path / "text.nc").write_text("no NetCDF")
    for name, words in (
        ("nofile.nc", "analysis.start: there is no file"),
        (tmp_path / "text.nc", "analysis.start: .* is not a result of this program"),
        (periodic, "analysis.start: .* holds no state"),
    ):
        with pytest.raises(SceneError, match=words):
            in_time(shaft, start=str(name))


def test_starts_straight_or_bent(shaft):
    linear = shaft.changed(effects=())
    still = analyse(linear.changed(analysis__method="quasi-static")).data["deflection"].to_numpy()[0]
    straight, bent = (
        in_time(linear, cycles=1, start=start).data["deflection"].to_numpy() for start in ("rigid", "static")
    )
    assert bent[0] == pytest.approx(still, abs=1e-3 * np.abs(still).max())  # stretch within elements, by two theories
    nodes = straight[0, 0, ::10]  # between them bends the particular solution of the inertia
    assert np.abs(nodes).max() < 1e-9 * np.abs(still).max()


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize(("options", "tolerance"), [(ALPHA2, 1e-5), (BDF, 1e-6)])
def test_other_types_agree(shaft, options, tolerance):
    exact = in_time(shaft, cycles=1, settled=0).data["deflection"].to_numpy()
    found = in_time(shaft.changed(petsc=options), cycles=1, settled=0, time_tolerance=tolerance).data["deflection"]
    assert np.abs(found.to_numpy() - exact).max() < 2e-3 * np.abs(exact).max()


def test_impulse_in_a_mechanism(shaft):
    """Once settled, as by collocation of the cycle, whose steps must follow what the blow excites."""
    blow = {"at": "arm.A", "impulse": (0.01, 0.0), "angle": "45 deg"}
    blown = shaft.changed(
        effects=(), mesh__elements=1, impulses={"blow": blow}, analysis__sub_intervals=16, analysis__allow_coarse=True
    )
    fine = blown.changed(analysis__solver="collocation", analysis__stages=5, analysis__sub_intervals=1024)
    exact = response_of(fine).data["deflection"].to_numpy()[::64]
    found = in_time(blown, cycles=10, settled=1e-7).data["deflection"].to_numpy()[-17:-1]
    assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()


@pytest.mark.parametrize("sense", [1, -1])
def test_impulses_strike_in_a_run_up(shaft, sense):
    """Where the drive passes their angle; at the start at time 0 alone, not again after a restart."""
    struck = {"impulse": (0.01, 0.0), "at": "arm.A"}
    blows = {"first": struck | {"angle": 0.0}, "other": struck | {"angle": f"{sense * 90} deg"}}
    scene = shaft.changed(drive__speed=sense * 20.0, drive__run_up=0.4, impulses=blows)
    end = 0.4 + 2 * scene.period
    found = impulses_between(scene, mechanism(scene), 0.0, end)
    turned = sense * scene.drives[0].coordinate(found.time).value
    assert found.time[0] == 0
    assert np.cos(turned - np.pi / 2 * found.which) == pytest.approx(np.ones(len(turned)))
    assert list(found.which) == [k % 2 for k in range(len(turned))]  # one after the other
    assert len(turned) == 2 * np.floor(sense * scene.drives[0].coordinate(np.array([end])).value[0] / (2 * np.pi)) + 2
    again = impulses_between(scene, mechanism(scene), float(found.time[2]), end)
    assert again.time == pytest.approx(found.time[3:])


def test_singular_equations_are_told(shaft):
    with pytest.raises(SolverError, match="lost in rounding beside a far too stiff"):
        in_time(shaft.changed(dampers={"brake": {"between": ("arm.A", "ground.O"), "damping": 1e20}}))
    with pytest.raises(SolverError, match="a matrix of the equations cannot be solved with"):
        in_time(shaft.changed(effects=(), damping={}, materials__steel__density=1e-322))  # rounded to no mass


def test_what_is_not_solved_in_time_is_refused(shaft):
    with pytest.raises(
        SceneError, match=r"drive\.motor: the twist of a motor's shaft comes with the periodic response"
    ):
        in_time(shaft.changed(effects=(), drive__motor={"stiffness": 100.0}))
    with pytest.raises(SceneError, match="more than a result holds"):
        in_time(shaft, cycles=10_000)


def test_axial_forces_that_settle_are_refused(shaft):
    with pytest.raises(SceneError, match=r"analysis\.tension: method = 'transient' does not update axial forces"):
        in_time(shaft.changed(effects=("coupling", "geometric-stiffness")), tension="settled")


def test_strain_behind_a_stress():
    """``e + tau e' = s`` with e = sin t: s = sin t + tau cos t, and what the start lacks dies out."""
    step, tau = 0.05, 0.2
    time = step * np.arange(200)
    found = delayed((np.sin(time) + tau * np.cos(time))[:, None], tau, step)[:, 0]
    lack = tau * np.exp(-time / tau)  # the first strain is taken to be the first stress
    assert found - lack == pytest.approx(np.sin(time), abs=1e-6)  # of a cubic spline: step^4/384 and its ends
