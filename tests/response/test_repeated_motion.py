"""Motions with freedoms that repeat, and Lyapunov exponents of those that do not, against independent truths."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import fenics_mech as fm
from fenics_mech.solve.repeated import ANGLE, STROKE, sizes_of
from tests.joints.scenes import G, block
from tests.response.rigid_programs import SliderCrank
from tests.response.test_rigid_motion import slider_crank

TURN = 2 * np.pi
AS_PENDULUM = {
    "gravity": (0, -1.0),
    "links.block.rigid.centre": (1.0, 0),
    "joints.G": fm.Revolute(connect=("ground.O", "block.B")),
}


def oscillator(formula: str, **analysis) -> fm.Scene:
    """Give a block of 1 kg that a force by formula moves along X, from 1 m at rest."""
    return fm.Scene(
        name="oscillator",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"block": fm.Link(points={"B": (0, 0)}, rigid=fm.RigidBody(mass=1.0))},
        joints={"G": fm.Prismatic(connect=("ground.O", "block.B"))},
        freedoms={"G": fm.Freedom(start=1.0, effort=fm.FormulaEffort(formula=formula))},
        analysis=fm.Analysis(method="transient", **{"time_tolerance": 1e-9, "sub_intervals": 24} | analysis),
    )


def pendulum(drive: float, **analysis) -> fm.Scene:
    """Give the damped pendulum of Baker and Gollub, Chaotic Dynamics (1996), q = 2, driven at 2/3 of its frequency."""
    scene = oscillator(f"{drive}*cos(2*t/3) - omega/2", duration=3 * np.pi, **analysis)
    return scene.changed(AS_PENDULUM | {"freedoms.G.start": -1.37})


def multipliers(data) -> np.ndarray:
    return data["multiplier"].transpose("disturbance", "part").to_numpy() @ [1, 1j]


def test_a_cycle_closes_in_each_kind_of_coordinates():
    time = np.linspace(0, 2 * np.pi, 41)[:, None]
    ways, kinds = np.array([1e-4, 2e-4, 3.0, 0.05, 0.0]), np.array([2, 2, ANGLE, STROKE, 7])
    place, rate = ways * np.sin(time), ways * np.cos(time)
    wanted = np.array([2e-4, 2e-4, 3.0, 0.05, 3e-6])  # what does not move counts by a part of what moves most
    np.testing.assert_allclose(sizes_of(place, rate, kinds), np.append(2 * wanted, wanted), rtol=1e-12)


@pytest.mark.slow
def test_a_forced_oscillator_against_its_closed_form():
    damping, stiffness, rate = 0.2, 4.0, 1.5
    scene = oscillator("cos(1.5*t) - 0.2*omega - 4*theta", start="periodic", duration=TURN / rate, cycles=1)
    data = fm.analyse(scene).data
    expected = np.exp(1j * rate * data["time"].to_numpy()) / (stiffness - rate**2 + 1j * damping * rate)
    np.testing.assert_allclose(data["freedom_place"][:, 0], expected.real, atol=1e-9)
    root = np.exp((-damping / 2 + 1j * np.sqrt(stiffness - damping**2 / 4)) * TURN / rate)
    np.testing.assert_allclose(sorted(multipliers(data), key=np.imag), [root.conj(), root], atol=1e-8)
    assert data.attrs["repeats_after"] == pytest.approx(TURN / rate)


@pytest.mark.long
@pytest.mark.slow
def test_a_forced_block_with_dry_friction_repeats_as_its_closed_form():
    # Den Hartog (1931): X k/P = (V^2 - f^2 U^2)^(1/2) where the block never sticks; P = 1 N, k = 100 N/m, m = 1 kg
    share, dry = 0.8, 0.3  # of the natural frequency, and of the force
    rubs = {"kind": "friction", "coefficient": dry / G, "width": 1e-5}
    push = {"kind": "formula", "formula": f"cos({10 * share}*t)"}
    scene = block(rubs, freedoms={"G": {"start": 0.0, "effort": push}})
    changes = {
        "start": "periodic",
        "duration": 2 * np.pi / (10 * share),
        "cycles": 6,
        "sub_intervals": 400,
        "error_estimates": False,
    }
    data = fm.analyse(scene.changed({f"analysis.{key}": value for key, value in changes.items()})).data
    u = np.sin(np.pi / share) / (share * (1 + np.cos(np.pi / share)))
    wanted = np.sqrt(1 / (1 - share**2) ** 2 - (dry * u) ** 2) / 100
    amplitude = np.ptp(data["freedom_place"].to_numpy()) / 2  # positions miss the peaks by 3e-5 of it at most
    assert amplitude == pytest.approx(wanted, rel=1e-4)
    assert data.attrs["closing_error"] < 1e-5  # ten times the tolerance of a step


@pytest.mark.slow
def test_an_oscillator_with_a_period_of_its_own():
    # van der Pol's with mu = 1: its period is published to many digits; the other multiplier is exp(-7.0587)
    scene = oscillator("(1 - theta**2)*omega - theta", start="periodic", duration=6.0, cycles=5, sub_intervals=60)
    result = fm.analyse(scene)
    assert result.data.attrs["repeats_after"] == pytest.approx(6.66328685932313, rel=1e-9)
    assert multipliers(result.data)[0] == pytest.approx(1.0, abs=1e-6)
    assert abs(multipliers(result.data)[1]) == pytest.approx(np.exp(-7.0587), rel=1e-3)
    assert "a period of its own" in str(fm.summary(result))


@pytest.mark.slow
def test_a_pendulum_that_nothing_damps_is_one_of_a_family():
    scene = oscillator("0", start="periodic", duration=10.0, cycles=2, sub_intervals=100, allow_unstable=True)
    data = fm.analyse(scene.changed(AS_PENDULUM | {"freedoms.G": {"start": 0.0}})).data
    place, rate = (float(data[f"freedom_{what}"][0, 0]) for what in ("place", "rate"))
    energy = rate**2 / 2 + np.sin(place)  # J, from the height of the pin
    assert energy == pytest.approx(0.0, abs=0.05)  # it was let go from horizontal
    assert data.attrs["repeats_after"] == pytest.approx(4 * ellipk((1 + energy) / 2), rel=1e-8)


@pytest.mark.long
@pytest.mark.slow
def test_a_driven_pendulum_doubles_its_period():
    # the periods double at 1.066 (Baker and Gollub, figure 3.5)
    once = fm.analyse(pendulum(0.9, start="periodic", cycles=8)).data
    assert np.prod(multipliers(once)).real == pytest.approx(np.exp(-3 * np.pi / 2), rel=1e-6)  # Liouville's formula
    with pytest.raises(fm.SolverError, match=r"multiplied by -1\.\d+ in each.*analysis.repeats = 2"):
        fm.analyse(pendulum(1.07, start="periodic", cycles=20, settled=0.0))
    twice = fm.analyse(pendulum(1.07, start="periodic", cycles=20, repeats=2)).data
    assert abs(multipliers(twice)).max() < 1
    halves = twice["freedom_rate"].to_numpy()[:, 0].reshape(-1)
    assert abs(halves[0] - halves[12]) > 1e-3  # rad/s: it does not repeat after one period
    turning = fm.analyse(pendulum(1.35, start="periodic", cycles=20)).data["freedom_place"].to_numpy()[:, 0]
    assert abs(turning[-1] - turning[0]) == pytest.approx(TURN, abs=1e-6)


@pytest.mark.long
@pytest.mark.slow
def test_exponents_against_the_variational_equation_of_an_independent_program():
    # Ueda's oscillator is chaotic, so that motions agree for some periods only
    end = 10 * TURN
    scene = oscillator(
        "7.5*cos(t) - 0.05*omega - theta**3", duration=end, lyapunov=True, time_tolerance=1e-11, error_estimates=False
    )
    result = fm.analyse(scene.changed({"analysis.poincare": {"every": TURN}}))

    def rates(t, y):
        jacobian = np.array([[0, 1], [-3 * y[0] ** 2, -0.05]])
        return np.concatenate(
            [[y[1], 7.5 * np.cos(t) - 0.05 * y[1] - y[0] ** 3], (jacobian @ y[2:].reshape(2, 2)).ravel()]
        )

    start = np.concatenate([[1.0, 0.0], np.eye(2).ravel()])
    found = solve_ivp(rates, (0, end), start, "DOP853", TURN * np.arange(11), rtol=1e-12, atol=1e-12).y
    growth = result.data["disturbance_growth"].to_numpy()[-1]
    first = np.log(np.linalg.norm(found[[2, 4], -1]))  # of the disturbance of the place alone
    assert growth.max() == pytest.approx(first, abs=1e-3)
    assert growth.sum() == pytest.approx(-0.05 * end, abs=1e-8)
    np.testing.assert_allclose(result.data["section_place"][:, 0], found[0, 1:], atol=1e-5)
    np.testing.assert_allclose(result.data["section_rate"][:, 0], found[1, 1:], atol=1e-5)


def test_a_section_where_a_freedom_passes_a_place():
    scene = oscillator("-theta", duration=20.0)
    scene = scene.changed({"analysis.poincare": {"joint": "G", "at": 0.5, "direction": "+"}})
    data = fm.analyse(scene).data
    expected = 5 * np.pi / 3 + TURN * np.arange(3)  # cos t = 1/2, upwards
    np.testing.assert_allclose(data["section_time"], expected, atol=1e-8)
    np.testing.assert_allclose(data["section_rate"][:, 0], np.sqrt(0.75), atol=1e-8)


@pytest.mark.parametrize("turns", [True, False])
def test_a_section_of_a_fast_freedom_misses_no_passage(turns):
    scene = oscillator("0", duration=10.0, poincare={"joint": "G", "at": 0.0})  # at 100 rad/s or m/s steps are long
    scene = scene.changed({"freedoms.G.start": -50.0, "freedoms.G.speed": 100.0})
    if turns:
        pin = fm.Revolute(connect=("ground.O", "block.B"))
        scene = scene.changed({"gravity": (0, 0), "joints.G": pin, "links.block.rigid.inertia": 1.0})
    first = np.ceil(-50 / TURN) * TURN if turns else 0.0
    expected = np.arange(first, 950.0, TURN if turns else 1e6)
    np.testing.assert_allclose(fm.analyse(scene).data["section_time"], (expected + 50) / 100, atol=1e-9)


def test_the_spectrum_of_a_harmonic_motion():
    data = fm.analyse(oscillator("-theta", duration=8 * TURN, sub_intervals=256))
    spectrum = data.derived("freedom_spectrum")
    assert float(spectrum["spectrum_frequency"][spectrum[:, 0].argmax("spectrum_frequency")]) == pytest.approx(1 / TURN)
    assert float(spectrum.max()) == pytest.approx(1.0, rel=1e-6)
    assert spectrum.attrs["units"] == "rad/s"


@pytest.mark.slow
def test_the_speed_of_a_press_over_its_own_cycle_against_an_independent_program():
    torque, no_load, machine = 12.0, 100.0, SliderCrank()

    def effort(angle, omega):
        return torque * (1 - omega / no_load) - 4 * (1 - np.cos(angle))

    motor = {"kind": "formula", "formula": f"{torque}*(1 - omega/{no_load}) - 4*(1 - cos(theta))"}
    scene = slider_crank(freedoms={"O": {"start": 0.3, "speed": 60.0, "effort": motor}})
    scene = scene.changed(
        {
            "analysis.start": "periodic",
            "analysis.duration": TURN / 60,
            "analysis.cycles": 8,
            "analysis.sub_intervals": 40,
            "analysis.time_tolerance": 1e-9,
        }
    )
    data = fm.analyse(scene).data
    angle, rate = (data[f"freedom_{what}"].to_numpy()[:, 0] for what in ("place", "rate"))
    assert angle[-1] - angle[0] == pytest.approx(TURN, abs=1e-8)
    time = data["time"].to_numpy() - float(data["time"][0])
    expected = machine.course(effort, [angle[0], rate[0]], time)
    np.testing.assert_allclose(rate, expected[1], rtol=1e-7)
    assert expected[1, -1] == pytest.approx(rate[0], rel=1e-7)  # the other program comes back too
    assert np.ptp(rate) > 1.0  # rad/s: it does fluctuate


@pytest.mark.slow  # a step of links that bend takes half a second
def test_a_hinged_beam_under_a_torque_against_its_closed_form():
    # w'''' = b^4 w with w = 0 and E I w'' = (k + i f c) w' - M at the hinge, w'' = w''' = 0 at the free end
    length, stiffness, line, rate, hinge, damping, moment = (
        1.0,
        2e11 * 20e-3 * 5e-3**3 / 12,
        0.785,
        70.0,
        60.0,
        0.4,
        0.05,
    )
    b = (line * rate**2 / stiffness) ** 0.25
    place, slope = np.array([1, 0, 1, 0]), b * np.array([0, 1, 0, 1])  # at the hinge, of cos, sin, cosh, sinh of b x
    c, s, ch, sh = np.cos(b * length), np.sin(b * length), np.cosh(b * length), np.sinh(b * length)
    held = stiffness * b**2 * np.array([-1, 0, 1, 0]) - (hinge + 1j * rate * damping) * slope
    ends = np.array([place, held, [-c, -s, ch, sh], [s, -c, sh, ch]])
    found = np.linalg.solve(ends, [0, -moment, 0, 0])
    turn, tip = slope @ found, np.array([c, s, ch, sh]) @ found
    bar = fm.Member(ends=("O", "A"), section="bar", material="steel")
    scene = fm.Scene(
        name="beam",
        materials={"steel": fm.Material(modulus=2e11, density=7850)},
        sections={"bar": fm.RectangleSection(width="20 mm", height="5 mm")},
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"bar": fm.Link(points={"O": (0, 0), "A": (length, 0)}, members={"bar": bar})},
        joints={"O": fm.Revolute(connect=("ground.O", "bar.O"))},
        springs={"s": {"joint": "O", "stiffness": hinge, "angle": 0.0}},
        dampers={"d": {"joint": "O", "damping": damping}},
        freedoms={"O": fm.Freedom(effort=fm.FormulaEffort(formula=f"{moment}*cos({rate}*t)"))},
        effects=("coupling", "vibration"),
        mesh=fm.Mesh(elements=3),
        analysis=fm.Analysis(
            method="transient",
            start="periodic",
            duration=TURN / rate,
            cycles=1,
            sub_intervals=16,
            error_estimates=False,
        ),
    )
    data = fm.analyse(scene).data
    turning = np.exp(1j * rate * data["time"].to_numpy())
    np.testing.assert_allclose(data["freedom_place"][:, 0], (turn * turning).real, atol=2e-3 * abs(turn))
    moved = data["point_position_bent"].sel(point="bar.A", component="y")
    np.testing.assert_allclose(moved, (tip * turning).real, atol=2e-3 * abs(tip))
    assert abs(multipliers(data)[0]) < 1


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"method": "static", "start": "periodic"}, "start = 'periodic' is of motions in time"),
        ({"repeats": 0}, "analysis.repeats"),
        ({"start_time": 0.5}, "begins at time 0"),
        ({"repeats": 2}, "only a motion that repeats"),
        ({"start": "periodic", "lyapunov": True}, "too short for Lyapunov exponents"),
        ({"poincare": {"every": "1 s", "joint": "G"}}, "give one"),
        ({"poincare": {"joint": "H"}}, "no freedom 'H'"),
        ({"poincare": {}}, "neither a period nor a place"),
        ({"poincare": {"every": "0 s"}}, "every"),
    ],
)
def test_what_is_asked_wrongly_is_refused(changes, message):
    scene = oscillator("-theta", duration=1.0)
    with pytest.raises(fm.SceneError, match=message):
        scene.changed({f"analysis.{key}": value for key, value in changes.items()})


def test_what_only_freedoms_have_is_refused_where_drives_lead_all():
    for changes in ({"start": "periodic"}, {"lyapunov": True}):
        with pytest.raises(fm.SceneError, match="states none"):
            slider_crank(drive={"joint": "O", "speed": 60.0}).changed({f"analysis.{k}": v for k, v in changes.items()})


def test_cycles_of_a_motion_with_a_period_of_its_own_are_refused():
    scene = oscillator("(1 - theta**2)*omega - theta", start="periodic", duration=6.0, repeats=3)
    with pytest.raises(fm.SceneError, match="own period"):
        fm.analyse(scene)


def test_a_motion_that_comes_back_nowhere_is_refused():
    scene = oscillator("1 - 0.1*omega", start="periodic", duration=2.0, cycles=2)
    with pytest.raises(fm.SolverError, match="does not come back"):
        fm.analyse(scene)
