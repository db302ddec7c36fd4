"""A gear pair between two rotors against its closed form."""

import numpy as np
import pytest
from scipy.linalg import eigh

import fenics_mech as fm

RATIO, STIFFNESS, TORQUE = -2.5, 200.0, 3.0
FIRST, SECOND = 0.02, 0.05  # kg m^2


def rotors(**changes) -> fm.Scene:
    """Give two rotors; a torque turns the first, and a gear pair the second."""
    scene = fm.Scene(
        name="gears",
        ground=fm.Ground(points={"O": (0, 0), "C": (0.2, 0)}),
        links={
            "pinion": fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(inertia=FIRST)),
            "wheel": fm.Link(points={"C": (0, 0)}, rigid=fm.RigidBody(inertia=SECOND), angle="40 deg"),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "pinion.O")),
            "C": fm.Revolute(connect=("ground.C", "wheel.C")),
        },
        joint_laws={"teeth": fm.GearPair(joint="O", drives="C", ratio=RATIO, stiffness=STIFFNESS)},
        freedoms={"O": fm.Freedom(effort=TORQUE)},
        analysis=fm.Analysis(method="transient", duration=0.5, sub_intervals=40, time_tolerance=1e-9),
    )
    return scene.changed(changes)


def test_two_rotors_turn_and_vibrate_as_their_closed_form():
    # e = b - i a swings about where it drives the wheel, and J1 a + i J2 b moves by the torque alone
    data = fm.analyse(rotors()).data
    time, place = data["time"].to_numpy(), data["freedom_place"]
    square = STIFFNESS * (1 / SECOND + RATIO**2 / FIRST)
    behind = -RATIO * TORQUE / FIRST / square * (1 - np.cos(np.sqrt(square) * time))
    together = TORQUE * time**2 / 2
    first = (together - RATIO * SECOND * behind) / (FIRST + RATIO**2 * SECOND)
    np.testing.assert_allclose(place.sel(freedom="O"), first, atol=1e-9)
    turned = place.sel(freedom="C").to_numpy() - np.radians(40)
    np.testing.assert_allclose(turned, behind + RATIO * first, atol=1e-9)
    np.testing.assert_allclose(data["law_effort"].sel(law="teeth:C"), -STIFFNESS * behind, atol=1e-6)
    np.testing.assert_allclose(data["law_effort"].sel(law="teeth"), RATIO * STIFFNESS * behind, atol=1e-6)
    assert data.attrs["power_balance_error"] < 1e-9
    assert "teeth:C" in str(fm.summary(fm.analyse(rotors())))


def test_damped_teeth_lead_to_the_rigid_ratio():
    data = fm.analyse(rotors(**{"joint_laws.teeth.damping": 2.0, "analysis.time_tolerance": 1e-6})).data
    rate = data["freedom_rate"].isel(theta=-1)
    assert float(rate.sel(freedom="C") / rate.sel(freedom="O")) == pytest.approx(RATIO, rel=1e-4)
    assert float(rate.sel(freedom="O")) == pytest.approx(TORQUE * 0.5 / (FIRST + RATIO**2 * SECOND), rel=1e-3)


@pytest.mark.parametrize(("ratio", "arm", "sense"), [(RATIO, 0.2 * 2.5 / 3.5, -1), (0.4, -0.2 * 0.4 / 0.6, 1)])
def test_bearings_bear_the_force_of_the_teeth(ratio, arm, sense):
    # arm: from the pinion's pin to where the pitch circles touch; teeth push the pinion away from there
    pressed = {"joint_laws.teeth.ratio": ratio, "joint_laws.teeth.pressure_angle": "20 deg"}
    held = {"held": {"joint": "C", "stiffness": 50.0}}
    data = fm.analyse(rotors(**pressed, springs=held, **{"analysis.method": "static"})).data
    along = -TORQUE / arm  # on the pinion, whose moment balances the torque
    wanted = np.array([sense * abs(along) * np.tan(np.radians(20)), along])
    found = {name: data["joint_force"].sel(joint=name).to_numpy().ravel() for name in "OC"}
    sign = 1 if np.dot(found["O"], wanted) > 0 else -1
    np.testing.assert_allclose(found["O"], sign * wanted, rtol=1e-9)
    np.testing.assert_allclose(found["C"], -found["O"], rtol=1e-9)
    np.testing.assert_allclose(data["shaking_force"].to_numpy().ravel(), 0, atol=1e-9)


def test_teeth_with_a_pressure_angle_move_gears_as_moments_do():
    short = {"analysis.duration": 0.05, "analysis.sub_intervals": 4}
    plain, pressed = (
        fm.analyse(rotors(**short, **{"joint_laws.teeth.pressure_angle": angle})).data for angle in (None, 0.35)
    )
    np.testing.assert_allclose(pressed["freedom_place"], plain["freedom_place"], atol=1e-12)
    np.testing.assert_allclose(pressed["law_effort"], plain["law_effort"], atol=1e-9)
    assert pressed.attrs["power_balance_error"] < 1e-9
    assert abs(plain["joint_force"]).max() < 1e-9


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"joint_laws.teeth.pressure_angle": "95 deg"}, "less than"),
        ({"joint_laws.teeth.pressure_angle": 0.3, "joint_laws.teeth.ratio": 1.0}, "do not mesh"),
        (
            {"joint_laws.teeth.pressure_angle": 0.3, "joints.C.connect": ("wheel.C", "ground.C")},
            "turn on pins of one body",
        ),
        ({"joint_laws.teeth.ratio": 0.0}, "must not be 0"),
        ({"joint_laws.teeth.drives": "X"}, "no joint 'X'"),
        ({"joint_laws.teeth.drives": "O"}, "another pin"),
        ({"joint_laws.teeth.stiffness": -1.0}, "stiffness"),
    ],
)
def test_gears_that_turn_nothing_are_refused(changes, message):
    with pytest.raises(fm.SceneError, match=message):
        rotors(**changes)


def test_drive_train_on_elastic_shafts_moves_by_its_modes():
    # motor, shaft, pinion, teeth, wheel, shaft, load: what twists is a pair each, of ratio 1 for a shaft
    inertia = {"motor": 0.02, "pinion": 0.005, "wheel": 0.04, "load": 0.1}  # kg m^2
    twisting = {"first": ("motor", "pinion", 1.0, 300.0), "teeth": ("pinion", "wheel", RATIO, 5e3)}
    twisting["second"] = ("wheel", "load", 1.0, 800.0)
    scene = fm.Scene(
        name="drive train",
        ground=fm.Ground(points={name: (0.1 * i, 0) for i, name in enumerate(inertia)}),
        links={name: fm.Link(points={"O": (0, 0)}, rigid=fm.RigidBody(inertia=j)) for name, j in inertia.items()},
        joints={name: fm.Revolute(connect=(f"ground.{name}", f"{name}.O")) for name in inertia},
        joint_laws={
            name: fm.GearPair(joint=a, drives=b, ratio=i, stiffness=k) for name, (a, b, i, k) in twisting.items()
        },
        freedoms={"motor": fm.Freedom(effort=TORQUE)},
        analysis=fm.Analysis(method="transient", duration=0.3, sub_intervals=60, time_tolerance=1e-9),
    )
    data = fm.analyse(scene).data
    names, stiffness = list(inertia), np.zeros((4, 4))
    for a, b, i, k in twisting.values():
        error = np.zeros(4)
        error[names.index(b)], error[names.index(a)] = 1.0, -i
        stiffness += k * np.outer(error, error)
    square, shape = eigh(stiffness, np.diag(list(inertia.values())))
    assert square[0] == pytest.approx(0, abs=1e-9 * square[-1])  # all turn together
    omega, time = np.sqrt(square[1:]), data["time"].to_numpy()
    share = TORQUE * shape[0]
    of_modes = np.column_stack([time**2 / 2, (1 - np.cos(omega * time[:, None])) / omega**2]) * share
    wanted = of_modes @ shape.T
    for name, angle in zip(names, wanted.T):
        np.testing.assert_allclose(data["freedom_place"].sel(freedom=name), angle, atol=1e-9)
    of_load = wanted[:, names.index("load")] - wanted[:, names.index("wheel")]
    np.testing.assert_allclose(data["law_effort"].sel(law="second:load"), -800.0 * of_load, atol=1e-6)
