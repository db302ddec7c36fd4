"""Motions in time by the equation of poses against closed forms and Exudyn."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import fenics_mech as fm
from fenics_mech.answers.in_time_by_poses import InTime, times_of
from fenics_mech.errors import SceneError
from tests.common import DEMOS
from tests.solve.test_flexible_pendulum import JOINT, TIP

QUICK = {"method": "transient", "error_estimates": False, "allow_coarse": True, "allow_large": True}
STEEL = fm.Material(modulus=210e9, density=7850.0)
LENGTH, WIDTH, HEIGHT = 0.5, 0.01, 0.003
MASS = 7850.0 * WIDTH * HEIGHT * LENGTH  # of a bar (kg)


def bars(count=1, elements=2, kind="revolute", **changes):
    """Give bars in a row, each free to turn, or to slide, on the one before."""
    links, joints, before = {}, {}, "ground.O"
    for k in range(count):
        name = f"bar{k}"
        points = {"O": (0, 0), "A": (LENGTH, 0)}
        links[name] = {"points": points, "members": {name: {"ends": ("O", "A"), "section": "s", "material": "m"}}}
        joints[f"J{k}"] = {"kind": kind, "connect": (before, f"{name}.O")}
        before = f"{name}.A"
    scene = fm.Scene(
        name="bars",
        materials={"m": STEEL},
        sections={"s": fm.RectangleSection(width=WIDTH, height=HEIGHT)},
        ground={"points": {"O": (0, 0)}},
        links=links,
        joints=joints,
        freedoms={name: {"start": 0.0} for name in joints},
        mesh={"elements": elements},
        effects=("coupling", "large-rotations"),
        analysis={**QUICK, "duration": 1.0, "sub_intervals": 20},
    )
    return scene.changed(changes)


def at(data, name, **place):
    return data[name].sel(**place).to_numpy()


@pytest.mark.slow
def test_a_double_pendulum_that_bends_falls_as_in_exudyn():
    """Exudyn with 1000 and 2000 steps differs by 6e-5 m, and with 8 elements by 1e-3 m."""
    data = fm.analyse(bars(2, 4, gravity=(0, -9.81))).data
    np.testing.assert_allclose(at(data, "point_position_bent", point="bar1.A")[-1], TIP, atol=3e-4)
    np.testing.assert_allclose(at(data, "point_position_bent", point="bar0.A")[-1], JOINT, atol=3e-4)
    assert data.attrs["power_balance_error"] < 2e-5  # what 375 steps damp of the fast waves
    turned = data["freedom_place"].to_numpy()[-1]  # the rigid links are where those of the bent ones are
    rigid = LENGTH * np.exp(1j * turned[0]) * (1 + np.exp(1j * turned[1]))
    np.testing.assert_allclose(at(data, "point_position", point="bar1.A")[-1], [rigid.real, rigid.imag], atol=1e-9)


def test_a_spring_about_a_pin_counts_whole_turns():
    """A bar swings from 10 rad, past 3 pi: J theta'' = -k theta, with J = m l^2/3. It bends by 1e-3 rad."""
    rate, place = 0.5, 10.0
    changes = {"springs": {"s": {"joint": "J0", "stiffness": MASS * LENGTH**2 / 3 * rate**2, "angle": 0.0}}}
    changes |= {"freedoms": {"J0": {"start": place}}, "analysis.start": "smooth", "analysis.time_tolerance": 1e-3}
    data = fm.analyse(bars(elements=1, **changes)).data
    t = data["time"].to_numpy()
    np.testing.assert_allclose(at(data, "freedom_place", freedom="J0"), place * np.cos(rate * t), atol=3e-4)
    np.testing.assert_allclose(at(data, "freedom_rate", freedom="J0"), -place * rate * np.sin(rate * t), atol=2e-3)
    assert data.attrs["power_balance_error"] < 1e-6


def test_a_load_over_time_pushes_a_bar_along_its_guide():
    """M x'' = F sin(w t): x = F/(m w) (t - sin(w t)/w)."""
    force, w = 0.3, 7.0
    load = {"at": "bar0.O", "force": (force, 0), "factor": {"kind": "formula", "formula": f"sin({w} * t)"}}
    data = fm.analyse(bars(1, 1, "prismatic", loads={"push": load}, **{"analysis.time_tolerance": 1e-3})).data
    t = data["time"].to_numpy()
    x = force / (MASS * w) * (t - np.sin(w * t) / w)
    np.testing.assert_allclose(at(data, "freedom_place", freedom="J0"), x, atol=1e-6)
    given = float(data["mean_power"].sel(cause="loads")) * t[-1]
    speed = force / (MASS * w) * (1 - np.cos(w * t[-1]))
    np.testing.assert_allclose(given, MASS * speed**2 / 2, rtol=1e-4)


@pytest.mark.parametrize("start", ["static", "smooth"])
def test_a_bar_that_is_let_go_bent_has_the_acceleration_of_a_rigid_one(start):
    """The tip of a uniform bar on a pin begins to fall with 3 g/2, and bends by its weight less its inertia."""
    changes = {"analysis.start": start, "analysis.duration": 2e-3, "analysis.sub_intervals": 4}
    data = fm.analyse(bars(elements=4, gravity=(0, -9.81), **changes)).data
    if start == "static":  # what a smooth start leaves of fast modes is felt in accelerations
        falling = at(data, "point_acceleration", point="bar0.A")[0]
        np.testing.assert_allclose(falling, [0, -1.5 * 9.81], rtol=2e-4, atol=2e-3)  # bent by 1e-3 of its length
    s, weight = data["s"].to_numpy(), MASS * 9.81
    moment = weight * LENGTH * s * (1 - s) ** 2 / 4  # of a load w (1 - 3 s/2) along the bar
    found = np.abs(data["moment"].isel(member=0).to_numpy())  # 2 ms are a tenth of the slowest vibration
    np.testing.assert_allclose(found, np.broadcast_to(moment, found.shape), atol=1e-2 * moment.max())


def test_a_soft_bar_is_let_go_without_vibration():
    """The tip of a bar on a pin leads its tangent by w l^4/(80 E I) = 0.023 m; its weight would hold it back."""
    soft = {"gravity": (0, -9.81), "materials.m.modulus": 210e9 / 60, "analysis.start": "smooth"}
    changes = {"analysis.duration": 0.01, "analysis.sub_intervals": 4}
    data = fm.analyse(bars(elements=4, **soft, **changes)).data
    bending = 210e9 / 60 * WIDTH * HEIGHT**3 / 12
    tip = at(data, "point_position_bent", point="bar0.A")[0, 1]
    assert tip == pytest.approx(MASS * 9.81 * LENGTH**3 / (80 * bending), rel=0.05)  # of the linear theory


def test_a_turning_arm_that_starts_in_balance_stays_in_it():
    """Its axial force is rho A w^2 (l^2 - x^2)/2, from the start on."""
    drive = {"freedoms": {}, "drive": [{"joint": "J0", "speed": 60.0}]}
    changes = {"analysis.start": "static", "analysis.cycles": 1, "analysis.settled": 0.0, "analysis.duration": None}
    data = fm.analyse(bars(elements=2, **drive, **changes)).data
    s = data["s"].to_numpy()
    force = MASS / LENGTH * 60.0**2 * LENGTH**2 * (1 - s**2) / 2
    found = data["axial_force"].isel(member=0).to_numpy()
    np.testing.assert_allclose(found, np.broadcast_to(force, found.shape), atol=1e-3 * force[0])
    np.testing.assert_allclose(data["input_torque"], 0.0, atol=2e-5 * force[0] * LENGTH)


@pytest.mark.parametrize("struck", [0.0, 0.3, 0.35])
def test_a_blow_pushes_a_bar_along_its_guide(struck):
    """M v = J at once. What is left beside it are waves along the bar, of 1e-5 m at most."""
    size = 0.02
    blow = {"h": {"at": "bar0.O", "impulse": (size, 0), "time": struck}}
    changes = {"analysis.duration": 0.5, "analysis.sub_intervals": 10, "analysis.time_tolerance": 1e-3}
    data = fm.analyse(bars(1, 1, "prismatic", impulses=blow, **changes)).data
    moved = np.maximum(0, data["time"].to_numpy() - struck) * size / MASS
    np.testing.assert_allclose(at(data, "freedom_place", freedom="J0"), moved, atol=1e-5)
    after = at(data, "freedom_rate", freedom="J0")[np.abs(data["time"].to_numpy() - struck).argmin()]
    assert after > size / MASS  # the pin's end alone moves at first


@pytest.mark.slow
def test_a_blow_beside_a_drive_takes_what_the_drive_gives():
    """A blow across a turning arm gives J v to it, and the drive takes what does not swing."""
    drive = {"freedoms": {}, "drive": [{"joint": "J0", "speed": 20.0}], "analysis.duration": None}
    drive |= {"impulses": {"h": {"at": "bar0.A", "impulse": (0, 0.01), "angle": "360 deg"}}, "damping.material": 1e-3}
    data = fm.analyse(bars(1, 1, **drive, **{"analysis.cycles": 2, "analysis.settled": 0.0})).data
    assert data.attrs["power_balance_error"] < 1e-2  # of what fast waves lose in steps
    given = {str(cause): float(power) for cause, power in zip(data["cause"].to_numpy(), data["mean_power"].to_numpy())}
    assert given["impulses"] > 0 > given["drive"]


@pytest.mark.slow
def test_a_motion_goes_on_from_the_end_of_another(tmp_path):
    changes = {"analysis.duration": 0.4, "analysis.sub_intervals": 10, "analysis.time_tolerance": 1e-6}
    scene = bars(elements=2, gravity=(0, -9.81), **changes)
    whole = fm.analyse(scene).data
    half = scene.changed({"analysis.duration": 0.2, "analysis.sub_intervals": 5})
    fm.analyse(half).save(tmp_path / "half.nc")
    goes_on = {"analysis.start": str(tmp_path / "half.nc"), "analysis.error_estimates": True}
    result = fm.analyse(half.changed(goes_on))
    assert result.scene.freedoms == half.freedoms
    for name, near in {"time": 1e-12, "freedom_place": 1e-6, "strain": 1e-3, "joint_force": 1e-3}.items():
        known = whole[name].transpose("theta", ...).to_numpy()[5:]
        found = result.data[name].transpose("theta", ...).to_numpy()
        np.testing.assert_allclose(found, known, rtol=0, atol=near * np.abs(known).max())
    with pytest.raises(SceneError, match="coordinates, and the scene has"):
        fm.analyse(half.changed(goes_on | {"mesh.elements": 3}))


def crank(**changes):
    stated = {**{f"analysis.{key}": value for key, value in QUICK.items()}}
    stated |= {"effects": ("coupling", "large-rotations"), "analysis.cycles": 1, "analysis.settled": 0.0}
    return fm.load(DEMOS / "slider_crank.toml").changed({**stated, "analysis.sub_intervals": 40, **changes})


@pytest.mark.slow
def test_a_run_up_bends_an_arm_as_its_tip_swings():
    """A mass m at the tip of a light arm: x'' + (k/m + w^2/5) x = -l w'; bends of 7 % of the length change 2e-3 of x.

    The axial force m w^2 l stiffens by 6/5 of it over l, and the frame takes w^2.
    """
    mass = 0.03
    drive = {"freedoms": {}, "drive": [{"joint": "J0", "speed": 20.0, "run_up": 0.2}], "analysis.duration": None}
    drive |= {"materials.m.density": 1.0, "masses": {"tip": {"at": "bar0.A", "mass": mass}}}
    scene = bars(1, 2, **drive, **{"analysis.cycles": 1, "analysis.settled": 0.0, "analysis.sub_intervals": 60})
    data = fm.analyse(scene).data
    assert data.sizes["theta"] > 61  # the run-up comes before the cycle
    time, theta = data["time"].to_numpy(), data["theta"].to_numpy()
    stiffness = 3 * 210e9 * WIDTH * HEIGHT**3 / 12 / LENGTH**3

    def rates(t, y):
        turned = scene.coordinate(np.array([t]))
        square = stiffness / mass + 0.2 * turned.first[0] ** 2
        return y[1], -square * y[0] - LENGTH * turned.second[0]

    x = solve_ivp(rates, (0, time[-1]), [0, 0], t_eval=time, rtol=1e-9, atol=1e-12, max_step=5e-3).y[0]
    tip = data["deflection"].isel(member=0, s=-1)
    across = np.cos(theta) * tip.sel(component="y").to_numpy() - np.sin(theta) * tip.sel(component="x").to_numpy()
    np.testing.assert_allclose(across, x, atol=4e-3 * np.abs(x).max())


@pytest.mark.slow
def test_it_settles_to_the_periodic_motion():
    stated = {
        "analysis.cycles": 12,
        "analysis.settled": 1e-2,
        "damping.material": 3e-3,
        "analysis.time_tolerance": 1e-3,
    }
    data = fm.analyse(crank(**stated)).data
    cycle = fm.analyse(crank(**stated, **{"analysis.method": "periodic", "analysis.stability": False})).data
    assert 81 <= data.sizes["theta"] < 481
    assert data.attrs["cycle_change"] < 1e-2
    for name in ("strain", "joint_force"):
        known = cycle[name].transpose("theta", ...).to_numpy()
        last = data[name].transpose("theta", ...).to_numpy()[-40:]
        assert np.abs(last - np.roll(known, -1, axis=0)).max() < 2e-2 * np.abs(known).max(), name


@pytest.mark.slow
def test_joints_hold_to_rounding():
    """Rows of the guide are met at every position, and rates of points go with their places."""
    scene = crank(**{"analysis.time_tolerance": 1e-3})
    whole = InTime.of(scene, times_of(scene))
    motion = whole.positions.motion
    n, held = motion.machine.n, motion.machine.held
    assert held == 2
    assert np.abs(motion.found.force[:, n : n + held]).max() < 1e-10
    assert np.abs(motion.found.force[1:, :n]).max() < 1e-5 * np.abs(motion.a[:, n : n + held]).max()


@pytest.mark.slow
def test_errors_of_steps_and_mesh_are_told():
    told = fm.analyse(crank(**{"analysis.error_estimates": True, "analysis.time_tolerance": 1e-3})).data
    assert list(told["source"].to_numpy()) == ["time", "mesh", "stations"]
    sharp = fm.analyse(crank(**{"analysis.time_tolerance": 1e-5})).data
    away = np.abs(told["strain"].to_numpy() - sharp["strain"].to_numpy()).max(axis=(0, 2, 3))
    steps = told["strain_error"].sel(source="time").to_numpy()
    largest = np.abs(sharp["strain"].to_numpy()).max()
    assert away.max() < 2 * steps.max() + 1e-6 * largest
    assert steps.max() < 3 * away.max() + 1e-6 * largest


def test_inertia_between_two_links_is_refused():
    freedoms = {"J0": {"start": 0.0}, "J1": {"start": 0.0, "inertia": 1.0}}
    with pytest.raises(SceneError, match="inertia between two links"):
        fm.analyse(bars(2, freedoms=freedoms))
