"""Stops, clearances and bushings against closed forms and an independent program."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.joints.contact_force import damping_of
from fenics_mech.scene.factories import seed_four_bar
from tests.joints import clearance_program as program
from tests.joints.scenes import G, bar, block

FLOOR = {"kind": "stop", "lower": 0.0, "contact": {"stiffness": 1e9, "restitution": 0.7}}


def ball(law: dict, **changes) -> fm.Scene:
    """Give a ball of 0.5 kg that falls from 1 m on a floor."""
    scene = block(law, mass=0.5, spring=None, gravity=(-G, 0.0), freedoms={"G": {"start": 1.0}})
    return scene.changed(changes)


@pytest.mark.slow  # four contacts and their flights
def test_a_ball_bounces_as_its_closed_form():
    # contacts last 2.94 d/v, 1e-4 s at 4 m/s: the closed form has none
    data = fm.analyse(ball(FLOOR, **{"analysis.duration": 2.0})).data
    place, time = data["freedom_place"][:, 0].to_numpy(), data["time"].to_numpy()
    expected, at, speed = np.where(time < np.sqrt(2 / G), 1 - G * time**2 / 2, 0.0), np.sqrt(2 / G), np.sqrt(2 * G)
    for _ in range(8):
        speed *= 0.7
        inside = (time >= at) & (time < at + 2 * speed / G)
        expected[inside] = (speed - G * (time[inside] - at) / 2) * (time[inside] - at)
        at += 2 * speed / G
    np.testing.assert_allclose(place, expected, atol=2e-3)
    assert data.attrs["contacts_closed"] == 4
    assert data.attrs["power_balance_error"] < 1e-6


@pytest.mark.long
@pytest.mark.slow  # some twenty bounces
def test_a_ball_comes_to_rest_after_its_last_bounce():
    data = fm.analyse(ball(FLOOR, **{"analysis.duration": 3.0})).data
    rests = np.sqrt(2 / G) * (1 + 0.7) / (1 - 0.7)  # of the closed form, 2.56 s
    after = data["time"].to_numpy() > rests + 0.1
    sunk = -((0.5 * G / 1e9) ** (2 / 3))
    np.testing.assert_allclose(data["freedom_place"][after, 0], sunk, rtol=0.01)
    assert float(data["law_effort"][-1, 0]) == pytest.approx(0.5 * G, rel=1e-3)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])  # at 1e-5 a step ends short of the place where the contact opens
def test_error_of_steps_after_a_bounce_is_estimated_where_it_is_asked_for(tolerance):
    soft = FLOOR | {"contact": {"stiffness": 1e6, "restitution": 0.8}}
    steps = {"analysis.time_tolerance": tolerance, "analysis.sub_intervals": 50}
    data = fm.analyse(ball(soft, **steps, **{"analysis.error_estimates": "contacts"})).data
    exact = fm.analyse(ball(soft, **steps | {"analysis.time_tolerance": 1e-10})).data
    assert "freedom_place_error" not in exact  # it is not asked for
    assert "contacts may make as large as the motion" in exact.attrs["not_estimated"]
    true = float(np.abs(data["freedom_place"] - exact["freedom_place"]).max())
    assert true < 0.1 * tolerance
    assert 0.3 * true < float(data["freedom_place_error"].max()) < 5 * true
    assert "a tenth of their tolerance" in data.attrs["not_estimated"]


@pytest.mark.parametrize(("restitution", "exponent"), [(0.9, 1.5), (0.5, 1.5), (0.2, 1.0), (1.0, 2.0)])
def test_restitution_is_as_stated(restitution, exponent):
    contact = {"stiffness": 1e7, "restitution": restitution, "exponent": exponent}
    scene = ball(FLOOR | {"contact": contact}, gravity=(0, 0), freedoms={"G": {"start": 0.1, "speed": -1.0}})
    data = fm.analyse(scene.changed({"analysis.duration": 0.3})).data
    assert float(data["freedom_rate"][-1, 0]) == pytest.approx(restitution, rel=1e-5)


def test_the_printed_formula_has_more_than_its_nominal_restitution():
    # c (1 + e) = ln[(1 + c)/(1 - c e)] with c = 3 (1 - 0.9^2)/4 has e = 0.913
    contact = {"stiffness": 1e7, "restitution": 0.9, "law": "lankarani-nikravesh"}
    scene = ball(FLOOR | {"contact": contact}, gravity=(0, 0), freedoms={"G": {"start": 0.1, "speed": -1.0}})
    data = fm.analyse(scene.changed({"analysis.duration": 0.3})).data
    found = float(data["freedom_rate"][-1, 0])
    c = damping_of(fm.Contact(**contact))
    assert c * (1 + found) == pytest.approx(np.log((1 + c) / (1 - c * found)), rel=1e-4)
    assert found == pytest.approx(0.913, abs=5e-4)


def test_a_contact_of_hertz_lasts_and_peaks_as_its_closed_form():
    # elastic: d = (5 m v^2/(4 K))^0.4, and it lasts 2.9432 d/v
    scene = ball(
        FLOOR | {"contact": {"stiffness": 1e7}}, gravity=(0, 0), freedoms={"G": {"start": 0.01, "speed": -2.0}}
    ).changed({"analysis.duration": 0.02, "analysis.sub_intervals": 2000})
    data = fm.analyse(scene).data
    depth = (5 * 0.5 * 2.0**2 / (4 * 1e7)) ** 0.4
    assert float(data["largest_law_effort"][0]) == pytest.approx(1e7 * depth**1.5, rel=1e-3)
    again = 0.01 / 2.0 + 2.9432 * depth / 2.0  # time at which it leaves
    last = data["time"].to_numpy()[-1]
    assert float(data["freedom_place"][-1, 0]) == pytest.approx(2.0 * (last - again), rel=1e-4)


def test_a_pendulum_against_a_stop_keeps_its_energy():
    # it falls from horizontal by 60 deg, on an elastic stop, and comes back to where it started
    law = {"kind": "stop", "lower": "-60 deg", "contact": {"stiffness": 1e6, "exponent": 1.0}}
    data = fm.analyse(bar(law, freedoms={"O": {"start": 0.0}}, **{"analysis.duration": 1.0})).data
    place = data["freedom_place"][:, 0].to_numpy()
    assert data.attrs["contacts_closed"] == 1
    assert place[20:].max() == pytest.approx(0.0, abs=1e-4)
    speed = np.sqrt(3 * G * np.sin(np.pi / 3))
    assert float(data["largest_law_effort"][0]) == pytest.approx(speed * np.sqrt(1e6 / 3), rel=5e-3)


def rattling(friction: float, **changes) -> fm.Scene:
    """Give the slider-crank of the independent program."""
    law = {
        "kind": "clearance",
        "joint": "B",
        "radial": program.CLEARANCE,
        "radius": program.BEARING,
        "contact": {"stiffness": program.STIFFNESS, "restitution": 0.9, "law": "lankarani-nikravesh"},
        "friction": friction,
    }
    rod = fm.RigidBody(mass=program.ROD_MASS, inertia=program.ROD_INERTIA, centre=(program.ROD / 2, 0))
    scene = fm.Scene(
        name="slider-crank with clearance",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={
            "crank": fm.Link(points={"O": (0, 0), "A": (program.CRANK, 0)}, rigid=fm.RigidBody(mass=0.3, inertia=1e-4)),
            "rod": fm.Link(points={"A": (0, 0), "B": (program.ROD, 0)}, rigid=rod),
            "piston": fm.Link(points={"B": (0, 0), "P": (0, 0)}, rigid=fm.RigidBody(mass=program.PISTON_MASS)),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "crank.O")),
            "A": fm.Revolute(connect=("crank.A", "rod.A")),
            "B": fm.Revolute(connect=("rod.B", "piston.B")),
            "G": fm.Prismatic(connect=("ground.O", "piston.P")),
        },
        drive=fm.Drive(joint="O", speed=program.SPEED),
        joint_laws={"rattle": law},
        analysis=fm.Analysis(method="transient", cycles=1, sub_intervals=40, time_tolerance=1e-8),
    )
    return scene.changed(changes)


@pytest.mark.long
@pytest.mark.slow  # 28 contacts, and a step for each part of them
@pytest.mark.parametrize("friction", [0.0, 0.03])
def test_clearance_slider_crank_against_an_independent_program(friction):
    data = fm.analyse(rattling(friction)).data
    other = program.ClearanceSliderCrank(friction=friction)
    expected = other.course(data["time"].to_numpy())
    place = data["freedom_place"].sel(freedom="G").to_numpy()
    # the motion is chaotic: errors grow by e^6 in a turn. With 1e-6 they are 1e-5 m, and fall with the tolerance
    np.testing.assert_allclose(place, expected[:, 1], atol=3e-7)
    assert data.attrs["contacts_closed"] == other.contacts
    assert float(data["largest_law_effort"][0]) == pytest.approx(other.peak, rel=1e-3)
    assert data.attrs["power_balance_error"] < 1e-6


def loose_slider(at: float, **changes) -> fm.Scene:
    """Give a slider of 0.5 kg between the walls of a loose guide, at `at` from its middle on a cross of two slides."""
    law = {"kind": "guide-clearance", "joint": "G", "play": 0.001, "length": 0.04, "contact": {"stiffness": 1e10}}
    scene = fm.Scene(
        name="loose slider",
        ground=fm.Ground(points={"O": (0, 0), "Q": (0, 0)}),
        links={
            "along": fm.Link(points={"Q": (0, 0), "R": (0, 0)}, rigid=fm.RigidBody()),
            "across": fm.Link(points={"R": (0, 0), "S": (0, 0)}, rigid=fm.RigidBody()),
            "slider": fm.Link(points={"B": (0, 0), "S": (at, 0)}, rigid=fm.RigidBody(mass=0.5, inertia=1e-4)),
        },
        joints={
            "X": fm.Prismatic(connect=("ground.Q", "along.Q")),
            "Y": fm.Prismatic(connect=("along.R", "across.R"), angle="90 deg"),
            "S": fm.Revolute(connect=("across.S", "slider.S")),
            "G": fm.Prismatic(connect=("ground.O", "slider.B")),
        },
        joint_laws={"loose": law},
        freedoms={"X": {"start": at}, "Y": {"start": 0.0, "speed": 1.0}, "S": {"start": 0.0}},
        analysis=fm.Analysis(method="transient", duration=0.0015, sub_intervals=30, time_tolerance=1e-7),
    )
    return scene.changed(changes)


def test_a_loose_slider_meets_a_wall_with_both_ends():
    # two contacts of Hertz together: 2 K d^2.5/2.5 = m v^2/2; it comes back elastically, without turning
    data = fm.analyse(loose_slider(0.0)).data
    depth = (2.5 * 0.5 / (4 * 1e10)) ** 0.4
    assert float(data["largest_law_effort"][0]) == pytest.approx(2e10 * depth**1.5, rel=1e-3)
    assert float(data["freedom_rate"].sel(freedom="Y")[-1]) == pytest.approx(-1.0, rel=1e-6)
    assert abs(data["freedom_rate"].sel(freedom="S")).max() < 1e-6
    assert data.attrs["contacts_closed"] == 2
    assert data.attrs["power_balance_error"] < 1e-7


def test_one_end_of_a_turning_slider_meets_a_wall():
    # the blow at an end 20 mm from the centre meets a mass 1/(1/m + a^2/J); the end comes back at its speed
    mass = 1 / (1 / 0.5 + 0.02**2 / 1e-4)
    turning = {"Y": {"start": 0.0, "speed": 1.0}, "S": {"start": 0.01, "speed": 5.0}, "X": {"start": 0.0}}
    data = fm.analyse(loose_slider(0.0, freedoms=turning, **{"analysis.duration": 9.5e-4})).data
    speed = 1.0 + 5.0 * 0.02  # of the end, to 1e-4: the slider has turned by 0.01 rad
    depth = (5 * mass * speed**2 / (4 * 1e10)) ** 0.4
    assert data.attrs["contacts_closed"] == 1
    assert float(data["largest_law_effort"][0]) == pytest.approx(1e10 * depth**1.5, rel=2e-3)
    after = data["freedom_rate"].isel(theta=-1)
    blow = 2 * mass * speed
    assert float(after.sel(freedom="Y")) == pytest.approx(1.0 - blow / 0.5, rel=2e-3)
    assert float(after.sel(freedom="S")) == pytest.approx(5.0 - blow * 0.02 / 1e-4, rel=2e-3)


def test_a_loose_guide_is_at_a_prismatic_joint():
    with pytest.raises(fm.SceneError, match="is at a joint of kind prismatic"):
        loose_slider(0.0, **{"joint_laws.loose.joint": "S"})


def test_a_bushing_holds_a_bar_as_a_spring_and_a_damper():
    # a slider of 2 kg in a bushing of 1 kN/m and 20 N s/m along X: decay 5/s, and the rate of the damped motion
    scene = fm.Scene(
        name="bushing",
        ground=fm.Ground(points={"O": (0, 0)}),
        links={"block": fm.Link(points={"B": (0, 0), "C": (0, 0)}, rigid=fm.RigidBody(mass=2.0))},
        joints={
            "G": fm.Prismatic(connect=("ground.O", "block.B")),
            "S": fm.Revolute(connect=("ground.O", "block.C")),
        },
        joint_laws={"soft": fm.Bushing(joint="S", stiffness=(1000.0, 5000.0), damping=(20.0, 0.0))},
        freedoms={"G": fm.Freedom(start=0.01)},
        analysis=fm.Analysis(method="transient", duration=0.5, sub_intervals=20, time_tolerance=1e-9),
    )
    data = fm.analyse(scene).data
    time, rate = data["time"].to_numpy(), np.sqrt(500 - 25)
    expected = 0.01 * np.exp(-5 * time) * (np.cos(rate * time) + 5 / rate * np.sin(rate * time))
    np.testing.assert_allclose(data["freedom_place"][:, 0], expected, atol=1e-10)
    assert data.attrs["power_balance_error"] < 1e-8


def test_a_bushing_between_two_bars_keeps_their_angular_momentum():
    # both turn about one place, and the bushing is open by a tenth of their length
    body = fm.RigidBody(mass=1.0, inertia=0.02, centre=(0.2, 0))
    scene = fm.Scene(
        name="two bars",
        ground=fm.Ground(points={"O": (0, 0), "Q": (0, 0)}),
        links={
            "first": fm.Link(points={"O": (0, 0), "A": (0.4, 0)}, rigid=body),
            "second": fm.Link(points={"Q": (0, 0), "A": (0.44, 0)}, rigid=body),
        },
        joints={
            "O": fm.Revolute(connect=("ground.O", "first.O")),
            "Q": fm.Revolute(connect=("ground.Q", "second.Q")),
            "A": fm.Revolute(connect=("first.A", "second.A")),
        },
        joint_laws={"soft": fm.Bushing(joint="A", stiffness=(300.0, 200.0), damping=(3.0, 2.0), turning_stiffness=2.0)},
        freedoms={"O": fm.Freedom(start=0.0, speed=3.0), "Q": fm.Freedom(start=0.3, speed=-1.0)},
        analysis=fm.Analysis(method="transient", duration=0.5, sub_intervals=20, time_tolerance=1e-8),
    )
    rates = fm.analyse(scene).data["freedom_rate"].to_numpy()
    np.testing.assert_allclose(rates.sum(axis=1), 2.0, atol=1e-8)
    assert np.ptp(rates[:, 0]) > 1


def test_a_bar_in_a_bushing_hangs_as_its_statics_say():
    # a horizontal bar of 2 kg slides up and down at its end; the bushing carries all of it and its moment
    law = fm.Bushing(
        joint="A", stiffness=(1e5, 2e4), damping=(400.0, 400.0), turning_stiffness=500.0, turning_damping=20.0
    )
    scene = fm.Scene(
        name="soft pin",
        ground=fm.Ground(points={"O": (0, 0), "P": (0.4, 0)}),
        links={
            "carriage": fm.Link(points={"P": (0, 0), "Q": (0, 0)}, rigid=fm.RigidBody(mass=0.5)),
            "bar": fm.Link(
                points={"A": (0, 0), "Q": (0.4, 0)}, rigid=fm.RigidBody(mass=2.0, inertia=0.05, centre=(0.1, 0))
            ),
        },
        joints={
            "G": fm.Prismatic(connect=("ground.P", "carriage.P"), angle="90 deg"),
            "Q": fm.Revolute(connect=("carriage.Q", "bar.Q")),
            "A": fm.Revolute(connect=("ground.O", "bar.A")),
        },
        gravity=(0, -G),
        joint_laws={"soft": law},
        analysis=fm.Analysis(method="transient", duration=3.0, sub_intervals=10),
    )
    data = fm.analyse(scene).data
    turned = float(data["freedom_place"].sel(freedom="Q")[-1])
    sunk = float(data["freedom_place"].sel(freedom="G")[-1]) - 0.4 * np.sin(turned)  # of the bar's end in the bushing
    down = 2.5 * G  # all weight hangs on the bushing
    aside = 0.4 * (1 - np.cos(turned))
    assert -2e4 * sunk == pytest.approx(down, rel=1e-4)
    carried = data["joint_force"].sel(joint="A").to_numpy()[-1]
    np.testing.assert_allclose(carried, [-1e5 * aside, down], rtol=1e-3, atol=1e-3)
    # moments about the pin Q: weight of the bar, force of the bushing, and its moment against rotation
    moment = 2 * G * 0.3 * np.cos(turned) - down * 0.4 * np.cos(turned) - carried[0] * -0.4 * np.sin(turned)
    assert 500 * turned == pytest.approx(moment, rel=2e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"joint_laws.rattle.radial": "-0.1 mm"}, "radial: must be greater"),
        ({"joint_laws.rattle.radial": "20 mm"}, "not less than the radius"),
        ({"joint_laws.rattle.contact.restitution": 1.2}, "restitution"),
        ({"joint_laws.rattle.contact.stiffness": -1.0}, "stiffness"),
        ({"joint_laws.rattle.joint": "G"}, "is at a joint of kind revolute"),
        ({"joint_laws.rattle.joint": "O"}, "has no constraint: nothing drives it"),
        (
            {"joint_laws.soft": {"kind": "bushing", "joint": "B", "stiffness": (1.0, 1.0)}},
            "has a clearance or bushing already",
        ),
        (
            {"joint_laws.rub": {"kind": "friction", "joint": "B", "coefficient": 0.1, "radius": 0.01}},
            "no constraint whose force could rub",
        ),
        ({"analysis.method": "periodic"}, "move in time"),
    ],
)
def test_contradictory_contacts_are_refused(changes, message):
    with pytest.raises(fm.SceneError, match=message):
        rattling(0.0, **changes)


def test_stops_that_leave_no_room_are_refused():
    with pytest.raises(fm.SceneError, match="needs `lower`, `upper` or both"):
        ball({"kind": "stop", "contact": {"stiffness": 1e9}})
    with pytest.raises(fm.SceneError, match="not below the upper one"):
        ball(FLOOR | {"upper": -1.0})


def test_a_contact_that_begins_overlapped_is_refused():
    with pytest.raises(fm.SceneError, match=r"bodies of joint 'G' overlap by 0\.1"):
        fm.analyse(ball(FLOOR, freedoms={"G": {"start": -0.1}}))
    started = {"A": {"start": 0.0}, "G": {"start": 0.175}}
    with pytest.raises(fm.SceneError, match=r"overlap by 0\.0045"):
        fm.analyse(rattling(0.0, freedoms=started))


def test_contacts_where_drives_lead_all_are_refused():
    law = {"kind": "stop", "lower": "-60 deg", "contact": {"stiffness": 1e6}}
    led = bar(law, drive={"joint": "O", "speed": 1.0})
    with pytest.raises(fm.SceneError, match="drives lead all links"):
        fm.analyse(led)


def test_a_body_that_only_a_bushing_holds_is_refused():
    soft = {"kind": "bushing", "stiffness": (1e4, 1e4)}
    with pytest.raises(fm.SceneError, match="do not state what is free: link bar"):
        fm.analyse(bar(soft))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"clearance": 3e-4}, r"joint_laws\.loose\.contact: this key is missing"),
        (
            {"contact": {"stiffness": "1e10 N/m"}},
            r"joint_laws\.loose\.contact\.stiffness: must be a number without a unit",
        ),
    ],
)
def test_the_key_of_a_law_that_is_wrong_is_named(changes, message):
    """A key that has the name of its law's kind is no part of the place of the others."""
    law = {"kind": "clearance", "joint": "B"} | changes
    with pytest.raises(fm.SceneError, match=message):
        seed_four_bar(joint_laws={"loose": law})
