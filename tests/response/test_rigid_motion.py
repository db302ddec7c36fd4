"""Motions of rigid links against tight solutions of independent programs, and what such scenes may ask for."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fenics_mech as fm
from fenics_mech.scene.answer_units import AnswerUnits
from tests.response.rigid_programs import G, SliderCrank, chain_of_bars

MACHINE = SliderCrank()


def bars(count: int, tolerance: float, **analysis) -> fm.Scene:
    """Give a chain of equal rigid bars that hangs on the ground and starts along X."""
    body = fm.RigidBody(mass=1.0, inertia=1 / 12, centre=(0.5, 0))
    joints = {"P0": fm.Revolute(connect=("ground.O", "b0.O"))}
    joints |= {f"P{i}": fm.Revolute(connect=(f"b{i - 1}.A", f"b{i}.O")) for i in range(1, count)}
    return fm.Scene(
        name="bars",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={f"b{i}": fm.Link(points={"O": (0, 0), "A": (1.0, 0)}, rigid=body) for i in range(count)},
        joints=joints,
        gravity=(0, -G),
        analysis=fm.Analysis(method="transient", time_tolerance=tolerance, **analysis),
    )


def slider_crank(**changes) -> fm.Scene:
    """Give the linkage of `SliderCrank`: the crank's inertia is about its pin, the rod's centre in its middle."""
    a, rod = MACHINE.a, MACHINE.rod
    scene = fm.Scene(
        name="press",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "crank": fm.Link(points={"O": (0, 0), "A": (a, 0)}, rigid=fm.RigidBody(inertia=MACHINE.crank_inertia)),
            "rod": fm.Link(
                points={"A": (0, 0), "B": (rod, 0)},
                rigid=fm.RigidBody(mass=MACHINE.rod_mass, inertia=MACHINE.rod_inertia, centre=(rod / 2, 0)),
            ),
            "piston": fm.Link(points={"B": (0, 0), "P": (0, 0)}, rigid=fm.RigidBody(mass=MACHINE.slider_mass)),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "crank.O")),
            "A": fm.Revolute(connect=("crank.A", "rod.A")),
            "B": fm.Revolute(connect=("rod.B", "piston.B")),
            "G": fm.Prismatic(connect=("ground.O", "piston.P"), angle=0.0),
        },
        analysis=fm.Analysis(method="transient", duration=1.0, sub_intervals=10, time_tolerance=1e-9),
    )
    return scene.changed(changes)


def test_disturbances_grow_within_steps_as_the_variational_equation_says():
    """Of a bar that falls from near its top: phi'' = -(3 g/2) cos phi, d'' = (3 g/2) sin phi d."""

    def rates(_, y):
        return [y[1], -1.5 * G * np.cos(y[0]), *y[4:6], *(1.5 * G * np.sin(y[0]) * y[2:4])]

    scene = bars(1, 1e-8, duration=2.0, sub_intervals=9)
    data = fm.analyse(scene.changed({"freedoms": {"P0": {"start": 1.2}}, "analysis.lyapunov": True})).data
    times = np.concatenate([data["time"], [1.0]])
    y = solve_ivp(rates, (0, 2), [1.2, 0, 1, 0, 0, 1], "DOP853", np.unique(times), rtol=1e-12, atol=1e-12).y
    triangles = np.linalg.qr(y[2:].T.reshape(-1, 2, 2))[1]
    grown = np.log(np.abs(np.diagonal(triangles, axis1=1, axis2=2)))
    middle = np.unique(times) == 1.0
    np.testing.assert_allclose(np.sort(data["disturbance_growth"]), np.sort(grown[~middle]), rtol=0, atol=1e-6)
    exponents = np.sort(grown[-1] - grown[middle][0])[::-1]
    np.testing.assert_allclose(data["lyapunov_exponent"], exponents, rtol=0, atol=1e-6)


@pytest.mark.slow  # tight tolerances
@pytest.mark.parametrize(("count", "end"), [(2, 3.0), (3, 2.0)])
def test_pendulum_of_bars_against_a_tight_solution(count, end):
    result = fm.analyse(bars(count, 1e-10, duration=end, sub_intervals=6))
    angles = np.cumsum(result.data["freedom_place"].to_numpy()[-1])
    np.testing.assert_allclose(angles, chain_of_bars(count, end), rtol=0, atol=1e-8)
    assert result.data.attrs["power_balance_error"] < 1e-10
    assert 0 < result.data.attrs["freedom_place_error_estimate"] < 1e-8


@pytest.mark.long
@pytest.mark.slow
def test_energy_of_a_double_pendulum_over_a_long_time():
    # it falls by m g L/2 + m g 3 L/2 at most: the energy is kept to 1e-8 of that over 100 s, in which it is chaotic
    scene = bars(2, 1e-9, duration=100.0, sub_intervals=100)
    data = fm.analyse(scene.changed({"analysis.scheme": "gauss"})).data
    power = dict(zip(data["cause"].to_numpy(), data["mean_power"].to_numpy()))
    assert 100 * abs(power["weight"] + power["stored"]) < 1e-8 * 2 * G


@pytest.mark.slow  # a second of a motor's start
def test_press_with_flywheel_under_a_gas_force_against_an_independent_program():
    flywheel, torque, no_load = 0.05, 12.0, 157.0

    def gas(stroke):
        return -120 * ((0.112 / (0.182 - stroke)) ** 1.3 - 1)  # N on the piston

    def effort(angle, omega):
        (place, rate, _), _ = MACHINE.slider(angle)
        return torque * (1 - omega / no_load) + gas(place) * rate

    times, heavier = np.linspace(0, 1, 11), SliderCrank()
    heavier.crank_inertia += flywheel
    expected = heavier.course(effort, [0.3, 20.0], times)
    motor = {"kind": "dc-motor", "stall_torque": torque, "no_load_speed": no_load}
    law = {"kind": "formula", "formula": "-120 * ((0.112 / (0.182 - theta))**1.3 - 1)"}
    data = fm.analyse(
        slider_crank(
            freedoms={"O": {"start": 0.3, "speed": 20.0, "effort": motor, "inertia": flywheel}},
            joint_laws={"gas": {"kind": "joint-effort", "joint": "G", "effort": law}},
        )
    ).data
    np.testing.assert_allclose(data["freedom_place"].to_numpy()[:, 0], expected[0], rtol=1e-7)
    np.testing.assert_allclose(data["freedom_rate"].to_numpy()[:, 0], expected[1], rtol=1e-7)
    assert data.attrs["power_balance_error"] < 1e-9
    strokes = np.array([MACHINE.slider(angle)[0][0] for angle in expected[0]])
    np.testing.assert_allclose(data["law_effort"].to_numpy()[:, 0], gas(strokes), rtol=1e-6)


@pytest.mark.parametrize("method", ["quasi-static", "periodic", "transient"])
def test_torque_of_a_led_crank_against_an_independent_program(method):
    speed = 60.0
    analysis = {"method": method, "sub_intervals": 24, "cycles": 1}
    data = fm.analyse(slider_crank(drive={"joint": "O", "speed": speed}, analysis=analysis)).data
    theta = data["theta"].to_numpy()
    expected = [MACHINE.inertia(angle)[1] * speed**2 for angle in theta]
    np.testing.assert_allclose(data["input_torque"], expected, rtol=1e-9, atol=1e-9)
    # what presses the piston against its guide and drives it is the force of its pin
    guide, pin = (data["joint_force"].sel(joint=name).to_numpy() for name in "GB")
    accelerated = np.array([MACHINE.slider(angle)[0][2] * speed**2 * MACHINE.slider_mass for angle in theta])
    np.testing.assert_allclose(guide[:, 0], 0, atol=1e-9)
    np.testing.assert_allclose((guide + pin)[:, 0], accelerated, rtol=1e-9, atol=1e-9)


def test_springs_dampers_and_loads_act_on_rigid_links():
    # a slider of 2 kg on a spring of 50 N/m that a constant force displaces by 0.04 m, critically damped
    scene = fm.Scene(
        name="oscillator",
        ground=fm.Ground(points={"O": (0, 0), "W": (-0.3, 0)}),
        links={"block": fm.Link(points={"B": (0, 0)}, rigid=fm.RigidBody(mass=2.0))},
        joints={"G": fm.Prismatic(connect=("ground.O", "block.B"))},
        loads={"pull": fm.Load(at="block.B", force=(2.0, 0))},
        springs={"s": fm.LineSpring(between=("ground.W", "block.B"), stiffness=50.0)},
        dampers={"d": fm.LineDamper(between=("ground.W", "block.B"), damping=20.0)},
        analysis=fm.Analysis(method="transient", duration=2.0, sub_intervals=20, time_tolerance=1e-9),
    )
    data = fm.analyse(scene).data
    time = data["time"].to_numpy()
    np.testing.assert_allclose(data["freedom_place"][:, 0], 0.04 * (1 - (1 + 5 * time) * np.exp(-5 * time)), atol=1e-9)
    assert data.attrs["power_balance_error"] < 1e-9


def test_a_torsional_spring_and_damper_swing_a_rigid_bar():
    scene = bars(1, 1e-9, duration=1.0, sub_intervals=10).changed(
        {
            "gravity": (0, 0),
            "springs": {"s": {"joint": "P0", "stiffness": 3.0, "angle": 0.2}},
            "dampers": {"d": {"joint": "P0", "damping": 0.4}},
        }
    )
    data = fm.analyse(scene).data
    decay, rate = 0.6, np.sqrt(9 - 0.36)  # c/(2 J) and the damped frequency, with J = 1/3 kg m^2
    time = data["time"].to_numpy()
    expected = 0.2 - 0.2 * np.exp(-decay * time) * (np.cos(rate * time) + decay / rate * np.sin(rate * time))
    np.testing.assert_allclose(data["freedom_place"][:, 0], expected, atol=1e-9)


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"analysis.method": "periodic"}, "nothing drives"),
        ({"tolerance": 0.01}, "tolerance"),
        ({"damping.air": {"density": 1.2, "coefficient": 1.1}}, "damping.air"),
    ],
)
def test_what_rigid_links_have_not_is_refused(changes, place):
    with pytest.raises(fm.SceneError, match=place):
        bars(1, 1e-5, duration=1.0).changed(changes)


def test_a_freedom_without_inertia_is_refused():
    scene = bars(1, 1e-5, duration=1.0).changed({"links.b0.rigid": {"mass": 0.0}})
    with pytest.raises(fm.SolverError, match="P0 moves no mass"):
        fm.analyse(scene)


def test_more_positions_than_a_result_holds_are_refused():
    with pytest.raises(fm.SceneError, match="more than a result holds"):
        fm.analyse(bars(1, 1e-5, duration=1.0, sub_intervals=200_000))


def test_commands_that_need_bending_links_say_so():
    with pytest.raises(fm.SceneError, match="nothing that bends"):
        fm.modes(bars(1, 1e-5, duration=1.0))
    with pytest.raises(fm.SceneError, match="a sweep compares strains"):
        fm.sweep(bars(1, 1e-5, duration=1.0), {"links.b0.rigid.mass": [1.0, 2.0]})


def test_a_result_of_rigid_links_is_summarised_and_plotted(tmp_path):
    result = fm.analyse(bars(1, 1e-5, duration=0.5, sub_intervals=8))
    text = str(fm.summary(result))
    assert "rigid: no link has a member that bends" in text
    assert "P0" in text
    assert " lbf " not in text
    assert " lbf " in str(fm.summary(result, units=AnswerUnits.of(["lbf"])))
    loaded = fm.Result.load(result.save(tmp_path / "result.nc"))
    names = ["force_paths.png", "freedoms.png", "joint_forces.png", "point_paths.png"]
    assert sorted(path.name for path in fm.plot_all(loaded, tmp_path)) == names
    largest = np.linalg.norm(loaded.data["joint_force"], axis=-1).max()
    assert fm.plot_joint_forces(loaded).get_lines()[-1].get_ydata()[0] == pytest.approx(largest)  # the ring
    assert fm.animate(loaded, tmp_path / "motion.png", size=(240, 180)).exists()
    assert fm.report(loaded, tmp_path / "report.html").exists()


@pytest.mark.parametrize("time", [0.25, 0.0])
def test_an_impulse_on_a_rigid_pendulum(time):
    # it hangs; a blow of 1.2 N s at its end gives it 1.2 N s 1 m/(1/3 kg m^2)
    scene = bars(1, 1e-9, duration=1.0, sub_intervals=8).changed(
        {
            "impulses": {"blow": {"at": "b0.A", "time": time, "impulse": (1.2, 0)}},
            "freedoms": {"P0": {"start": -np.pi / 2}},
        }
    )
    data = fm.analyse(scene).data
    place, rate = (data[f"freedom_{what}"].to_numpy()[:, 0] for what in ("place", "rate"))
    struck = int(8 * time)
    np.testing.assert_allclose(rate[:struck], 0, atol=1e-12)
    assert rate[struck] == pytest.approx(3.6, rel=1e-9)  # of the state just after it
    energy = rate[struck:] ** 2 / 6 + G / 2 * np.sin(place[struck:])
    np.testing.assert_allclose(energy, 3.6**2 / 6 - G / 2, rtol=1e-9)
    assert data.attrs["power_balance_error"] < 1e-9
    power = dict(zip(data["cause"].to_numpy(), data["mean_power"].to_numpy()))
    assert power["impulses"] == pytest.approx(3.6**2 / 6 if time else 0.0, rel=1e-9)  # the start is just after a blow


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"impulses.blow.angle": 0.3}, "by both"),
        ({"impulses.blow": {"at": "b0.A", "impulse": (1.0, 0)}}, "must state when it strikes"),
        ({"impulses.blow": {"at": "b0.A", "impulse": (1.0, 0), "angle": 0.3}}, "nothing is driven"),
        ({"joint_laws": {"rub": {"kind": "friction", "joint": "P0", "coefficient": 0.1, "radius": 0.01}}}, "friction"),
        ({"analysis.lyapunov": True, "freedoms": {"P0": {}}}, "Lyapunov"),
        ({"analysis.start": "periodic", "freedoms": {"P0": {}}}, "made to repeat"),
        ({"analysis.method": "static"}, "impulses"),
        ({"analysis.duration": 0.2}, r"it would strike at 0\.25 s, and the motion ends at 0\.2 s"),
    ],
)
def test_impulses_that_cannot_strike_are_refused(changes, message):
    blow = {"impulses": {"blow": {"at": "b0.A", "time": 0.25, "impulse": (1.2, 0)}}}
    with pytest.raises(fm.SceneError, match=message):
        bars(1, 1e-5, duration=1.0).changed(blow).changed(changes)


def test_an_impulse_on_rigid_links_that_drives_lead_is_refused():
    scene = slider_crank(drive={"joint": "O", "speed": 60.0}, impulses={"b": {"at": "rod.B", "angle": 1.0}})
    with pytest.raises(fm.SceneError, match="drives lead all rigid links"):
        fm.analyse(scene)
