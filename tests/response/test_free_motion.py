"""Motions with freedoms against closed forms, a tight rigid solution, and motions that a drive leads."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

import fenics_mech as fm
from fenics_mech.machine.stated_freedoms import with_freedoms

STILL_MOTOR = {"kind": "dc-motor", "stall_torque": 1, "no_load_speed": 0}
G, LENGTH, STIFF = 9.81, 1.0, 2e16  # m/s^2, m, Pa: bars as good as rigid


def bars(count: int, **analysis) -> fm.Scene:
    """Give a chain of equal bars that hangs on the ground and starts along X."""
    bar = fm.Link(
        points={"O": (0, 0), "A": (LENGTH, 0)},
        members={"bar": fm.Member(ends=("O", "A"), section="bar", material="stiff")},
    )
    joints = {"P0": fm.Revolute(connect=("ground.O", "b0.O"))}
    joints |= {f"P{i}": fm.Revolute(connect=(f"b{i - 1}.A", f"b{i}.O")) for i in range(1, count)}
    return fm.Scene(
        name="bars",
        materials={"stiff": fm.Material(modulus=STIFF, density=7850)},
        sections={"bar": fm.RectangleSection(width="20 mm", height="10 mm")},
        ground=fm.Ground(points={"O": (0, 0)}),
        links={f"b{i}": bar for i in range(count)},
        joints=joints,
        gravity=(0, -G),
        effects=("coupling", "gravity"),
        mesh=fm.Mesh(elements=1),
        analysis=fm.Analysis(method="transient", start="smooth", **analysis),
    )


def test_pendulum_against_its_elliptic_integral():
    quarter = ellipk(0.5) * np.sqrt(2 * LENGTH / (3 * G))  # from horizontal to the bottom (s)
    scene = bars(1, duration=quarter, sub_intervals=8, time_tolerance=1e-8)
    result = fm.analyse(scene)
    assert float(result.data["freedom_place"][-1, 0]) == pytest.approx(-np.pi / 2, abs=1e-7)
    assert float(result.data["freedom_rate"][-1, 0]) == pytest.approx(-np.sqrt(3 * G / LENGTH), rel=1e-7)
    assert abs(result.data["input_torque"]).max() < 1e-6  # nothing turns the pin; its weight has a torque of 7.7 N m


@pytest.mark.long
@pytest.mark.slow  # a chaotic motion over 3 s: 80 steps
def test_double_pendulum_against_a_tight_solution():
    # two equal bars from horizontal at rest, by an explicit rule of order 8 at 1e-13
    result = fm.analyse(bars(2, duration=3.0, sub_intervals=12, time_tolerance=1e-6))
    first, second = result.data["freedom_place"].to_numpy()[-1]
    assert first == pytest.approx(-0.54571031, abs=1e-7)
    assert first + second == pytest.approx(-1.07506168, abs=1e-7)


def test_spin_up_by_a_motor_in_closed_form():
    torque, speed, rotor = 3.0, 40.0, 0.2
    motor = {"kind": "dc-motor", "stall_torque": torque, "no_load_speed": speed}
    scene = bars(1, duration=1.0, sub_intervals=10, time_tolerance=1e-7)
    scene = scene.changed(
        {"freedoms": {"P0": {"effort": motor, "inertia": rotor}}, "effects": ("coupling",), "gravity": (0, 0)}
    )
    result = fm.analyse(scene)
    inertia = 7850 * 2e-4 * LENGTH**3 / 3 + rotor
    expected = speed * (1 - np.exp(-torque / (inertia * speed) * result.data["time"].to_numpy()))
    np.testing.assert_allclose(result.data["freedom_rate"].to_numpy()[:, 0], expected, rtol=1e-7, atol=1e-7)
    effort = torque * (1 - expected / speed) - rotor * torque / inertia * (1 - expected / speed)
    np.testing.assert_allclose(result.data["input_torque"].to_numpy(), effort, rtol=1e-6)


def test_a_load_that_begins_late_moves_links_at_rest():
    push = {"kind": "formula", "formula": "2 * t"}
    scene = bars(1, duration=0.1, sub_intervals=4, error_estimates=False).changed(
        {"gravity": (0, 0), "effects": ("coupling",), "freedoms": {"P0": {"effort": push}}}
    )
    data = fm.analyse(scene.changed({"materials.stiff.modulus": 2e11})).data
    inertia, time = 7850 * 2e-4 * LENGTH**3 / 3, data["time"].to_numpy()
    np.testing.assert_allclose(data["freedom_rate"][:, 0], time**2 / inertia, rtol=1e-6, atol=1e-12)
    assert data.attrs["time_steps"] <= 25  # 20 of the longest there are, after short ones from the start


@pytest.mark.long
@pytest.mark.slow  # free motions of bending links take a second of processor time a step
@pytest.mark.parametrize(("strains", "near"), [((), 2e-5), (("large-rotations",), 2e-3)])
def test_a_heavy_flywheel_leads_as_a_drive_does(strains, near):
    led = fm.load("demos/four_bar.toml").changed(
        {
            "effects": ("coupling", *strains),
            "damping": {},
            "mesh.elements": 2,
            "analysis": {"method": "transient", "cycles": 1, "sub_intervals": 240, "time_tolerance": 1e-6},
        }
    )
    short = {"duration": led.period / 40, "sub_intervals": 6, "cycles": 1, "allow_coarse": True}
    wheel = {"start": 0.0, "speed": led.drive.speed, "inertia": 1e6}
    free = led.changed({"drive": (), "freedoms": {"O": wheel}, **{f"analysis.{k}": v for k, v in short.items()}})
    by_drive = fm.analyse(led.changed({"analysis.allow_coarse": True})).data.isel(theta=slice(0, 7))
    by_wheel = fm.analyse(free).data
    # joint forces hold axial vibration of the straight start, which is too fast for the steps of either; bending moves
    # the mass of elements along their axes in a led motion alone, which falls with h^2
    for name, limit in {"strain": near, "deflection": near, "joint_force": max(near, 1e-3)}.items():
        values, wanted = by_wheel[name].to_numpy(), by_drive[name].to_numpy()
        assert np.abs(values - wanted).max() < limit * np.abs(wanted).max(), name


def test_energy_of_a_bending_pendulum_is_balanced():
    scene = bars(1, duration=0.4, sub_intervals=200, time_tolerance=1e-6)
    scene = scene.changed(
        {"materials.stiff.modulus": 2e9, "effects": ("coupling", "gravity", "large-rotations"), "mesh.elements": 2}
    )
    data = fm.analyse(scene).data
    assert data.attrs["power_balance_error"] < 1e-6
    assert float(abs(data["deflection"]).max()) > 1e-3  # it does bend (m)


@pytest.mark.slow
def test_drag_of_the_air_on_a_falling_bar_against_an_independent_program():
    density, coefficient, line = 300.0, 2.0, 7850 * 2e-4
    scene = bars(1, duration=1.0, sub_intervals=5, time_tolerance=1e-7, error_estimates=False)
    scene = scene.changed(
        {
            "damping.air": {"density": density, "coefficient": coefficient},
            "effects": ("coupling", "gravity", "air-drag"),
        }
    )
    data = fm.analyse(scene).data
    drag = density * coefficient * 0.02 / 2 * LENGTH**4 / 4

    def rates(_, y):
        return [y[1], (-line * G * LENGTH**2 / 2 * np.cos(y[0]) - drag * abs(y[1]) * y[1]) / (line * LENGTH**3 / 3)]

    expected = solve_ivp(rates, (0, 1), [0, 0], "DOP853", data["time"], rtol=1e-12, atol=1e-12).y
    np.testing.assert_allclose(data["freedom_place"][:, 0], expected[0], atol=1e-7)
    np.testing.assert_allclose(data["freedom_rate"][:, 0], expected[1], atol=1e-7)
    assert data.attrs["power_balance_error"] < 1e-9


@pytest.mark.long
@pytest.mark.slow
def test_an_impulse_beside_a_heavy_flywheel_is_that_beside_a_drive():
    scene = bars(1, duration=0.02, sub_intervals=10, time_tolerance=1e-5, error_estimates=False)
    blow = {"impulses": {"blow": {"at": "b0.A", "impulse": (0, 0.05), "time": 0.005}}, "materials.stiff.modulus": 2e11}
    wheel = {"P0": {"start": 0.0, "speed": 4.0, "inertia": 1e7}}
    free = scene.changed(blow | {"freedoms": wheel, "effects": ("coupling",), "gravity": (0, 0), "mesh.elements": 2})
    struck = {"at": "b0.A", "impulse": (0, 0.05), "angle": 0.02}
    led = free.changed(
        {"freedoms": {}, "impulses": {"blow": struck}, "drive": {"joint": "P0", "speed": 4.0}, "analysis.cycles": 1}
    ).changed({"analysis.sub_intervals": 785, "analysis.start": "rigid"})  # 2 ms each, but for 0.05 %
    by_wheel, by_drive = fm.analyse(free).data, fm.analyse(led).data
    time, found = by_wheel["time"].to_numpy(), by_wheel["deflection"].isel(s=-1).to_numpy()[:, 0]
    theirs = by_drive["deflection"].isel(s=-1, theta=slice(0, 14)).to_numpy()[:, 0]
    wanted = np.stack([np.interp(time, by_drive["time"][:14], part) for part in theirs.T], axis=1)
    assert np.abs(wanted).max() > 1e-3  # m
    np.testing.assert_allclose(found, wanted, atol=0.02 * np.abs(wanted).max())


def test_freedoms_are_found_at_joints_that_state_them():
    scene = with_freedoms(bars(3, duration=1.0))
    assert list(scene.freedoms) == ["P0", "P1", "P2"]
    assert all(freedom.start == pytest.approx(0.0, abs=1e-12) for freedom in scene.freedoms.values())


def test_freedoms_keep_what_is_stated_of_them():
    links = bars(2, duration=1.0).changed({"links.b0.angle": -0.3, "links.b1.angle": -0.1})
    scene = with_freedoms(links.changed(freedoms={"P1": fm.Freedom(speed=2.0), "P0": fm.Freedom(start=-0.5)}))
    assert scene.freedoms["P1"].speed == 2.0
    assert scene.freedoms["P0"].start == -0.5


@pytest.mark.parametrize(
    ("changes", "place"),
    [
        ({"freedoms": {"X": {}}}, "freedoms.X"),
        ({"analysis.duration": None, "freedoms": {"P0": {}}}, "analysis.duration"),
        ({"analysis.method": "periodic", "freedoms": {"P0": {}}}, "analysis.method"),
        ({"tolerance": 0.01, "freedoms": {"P0": {}}}, "tolerance"),
        (
            {"freedoms": {"P0": {"effort": STILL_MOTOR}}},
            "no_load_speed",
        ),
        ({"freedoms": {"P0": {"effort": "2 kg"}}}, "effort"),
        ({"freedoms": {"P0": {"effort": {"kind": "formula", "formula": "open('x')"}}}}, "formula"),
    ],
)
def test_what_a_free_motion_has_not_is_refused(changes, place):
    with pytest.raises(fm.SceneError, match=place):
        bars(1, duration=1.0).changed(changes)


def test_a_motion_that_nothing_drives_needs_a_duration():
    with pytest.raises(fm.SceneError, match="duration"):
        fm.analyse(bars(1))
