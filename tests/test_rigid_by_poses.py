"""Rigid links that drives lead: closed forms, and positions in which they cannot go on."""

import math

import numpy as np
import pytest

from fenics_mech import AssemblyError, Result, RigidBody, Scene, analyse


def loop(crank, coupler, follower, ground, **rest):
    """Give a four-bar of rigid links, with a drive of 10 rad/s."""
    lengths = {"crank": ("OA", crank), "coupler": ("AB", coupler), "follower": ("CB", follower)}
    angles = rest.pop("angles", {})
    links = {
        name: {
            "points": {ends[0]: (0, 0), ends[1]: (length, 0)},
            "rigid": {"mass": 1.0, "inertia": 0.01, "centre": (length / 2, 0)},
        }
        | ({"angle": angles[name]} if name in angles else {})
        for name, (ends, length) in lengths.items()
    }
    joints = {
        "O": "ground.O crank.O",
        "A": "crank.A coupler.A",
        "B": "coupler.B follower.B",
        "C": "ground.C follower.C",
    }
    return Scene.read(
        {
            "ground": {"points": {"O": (0, 0), "C": (ground, 0)}},
            "links": links,
            "joints": {name: {"connect": points.split()} for name, points in joints.items()},
            "drive": {"joint": "O", "speed": 10.0},
            "analysis": {"method": "quasi-static", "sub_intervals": 24},
        }
        | rest
    )


def test_a_drive_that_locks_is_refused_where_it_locks():
    a, b, c, d = 0.3, 0.2, 0.25, 0.4
    limit = math.degrees(math.acos((a**2 + d**2 - (b + c) ** 2) / (2 * a * d)))
    with pytest.raises(AssemblyError, match=r"cannot turn beyond .* deg: the linkage locks there") as found:
        analyse(loop(a, b, c, d, angles={"coupler": 0.5, "follower": 2.0}))
    assert float(str(found.value).split("beyond ")[1].split(" deg")[0]) == pytest.approx(limit, abs=1e-3)


@pytest.mark.parametrize("start", [0.3, 1.0, 2.0, 4.5])
def test_a_parallelogram_is_refused_at_its_change_point(start):
    angles = {"coupler": 1e-9, "follower": start}
    where = np.degrees(np.ceil(start / np.pi) * np.pi - start)
    scene = loop(0.2, 0.5, 0.2, 0.5, angles=angles, drive={"joint": "O", "speed": 10.0, "start": start})
    with pytest.raises(AssemblyError, match=r"change point at drive angle \S+ deg.*slot along it") as found:
        analyse(scene)
    assert float(str(found.value).split("angle ")[1].split(" deg")[0]) == pytest.approx(where, abs=2e-3)


def test_a_parallelogram_that_starts_in_line_is_refused():
    with pytest.raises(AssemblyError, match=r"at drive angle 0 deg .* follower, coupler"):
        analyse(loop(0.2, 0.5, 0.2, 0.5))


def turning_arm(**rest):
    """Give a body of 2 kg that is welded to a turning hub of 1 kg, 0.3 m beside its pin."""
    scene = {
        "ground": {"points": {"O": (0, 0)}},
        "links": {
            "hub": {"points": {"O": (0, 0), "W": (0.2, 0)}, "rigid": {"mass": 1.0, "inertia": 0.02}},
            "body": {
                "points": {"W": (0, 0)},
                "angle": "30 deg",
                "rigid": {"mass": 2.0, "inertia": 0.05, "centre": (0.1 * math.cos(0.5), 0.1 * math.sin(0.5))},
            },
        },
        "joints": {
            "O": {"connect": ["ground.O", "hub.O"]},
            "W": {"kind": "weld", "connect": ["hub.W", "body.W"], "angle": "30 deg"},
        },
        "drive": {"joint": "O", "speed": 7.0},
        "gravity": (0, -10.0),
    }
    return Scene.read(scene | rest)


def test_what_a_weld_of_rigid_links_holds():
    """Force and moment that turn a mass about the pin against its weight, in closed form."""
    data = analyse(turning_arm(analysis={"method": "quasi-static", "sub_intervals": 12})).data
    arm = 0.1 * np.exp(1j * (math.radians(30) + 0.5))
    turn = np.exp(1j * data["theta"].to_numpy())
    force = 2.0 * (-(7.0**2) * (0.2 + arm) * turn + 10j)  # of the hub on the body at the weld
    found = data["joint_force"].sel(joint="W").to_numpy() @ [1, 1j]
    assert found == pytest.approx(force, rel=1e-12)
    moment = (np.conj(arm * turn) * force).imag  # about the centre of mass the moment of all is 0
    assert data["joint_moment"].sel(held="W").to_numpy() == pytest.approx(moment, rel=1e-12, abs=1e-12)
    weight = ((0.2 + arm) * turn).real * 2.0 * 10.0
    assert data["input_torque"].to_numpy() == pytest.approx(weight, rel=1e-12)


def test_links_at_rest_have_no_inertia():
    data = analyse(turning_arm(analysis={"method": "static", "position": "40 deg"})).data
    assert data["joint_force"].sel(joint="O").to_numpy()[0] == pytest.approx([0, 30.0], abs=1e-12)
    assert not data["point_velocity"].any()
    assert not data["point_acceleration"].any()


def test_a_spring_about_the_axis_of_a_crank_counts_its_turns():
    springs = {"s": {"joint": "O", "stiffness": 3.0, "angle": 0.0}}
    analysis = {"method": "transient", "cycles": 3, "sub_intervals": 8}
    data = analyse(turning_arm(springs=springs, gravity=(0, 0), analysis=analysis)).data
    assert data["input_torque"].to_numpy() == pytest.approx(3.0 * data["theta"].to_numpy())
    assert data["theta"][-1] == pytest.approx(6 * np.pi)


def test_links_that_come_back_after_two_turns_are_followed_through_both():
    """The pin of a wheel of twice the size returns after two turns of the crank: a law of half the speed leads it."""
    body = RigidBody(mass=1.0, inertia=0.01).model_dump()
    scene = Scene.read(
        {
            "ground": {"points": {"O": (0, 0), "C": (0.5, 0)}},
            "links": {
                "fast": {"points": {"O": (0, 0)}, "rigid": body},
                "slow": {"points": {"C": (0, 0), "P": (0.1, 0)}, "rigid": body},
            },
            "joints": {"O": {"connect": ["ground.O", "fast.O"]}, "C": {"connect": ["ground.C", "slow.C"]}},
            "drive": [{"joint": "O", "speed": 10.0}, {"joint": "C", "speed": 5.0}],
            "analysis": {"method": "transient", "cycles": 2, "sub_intervals": 16},
        }
    )
    data = analyse(scene).data
    angle = data["link_angle"].to_numpy()
    assert angle[:, 0] == pytest.approx(10 * data["time"].to_numpy())
    assert angle[:, 1] == pytest.approx(5 * data["time"].to_numpy())


def test_a_result_with_a_law_on_the_ground_is_read_back(tmp_path):
    """A support is named after the law: of a scene without drives no key is named so."""
    law = {"kind": "joint-effort", "joint": "O", "effort": {"kind": "formula", "formula": "-0.2 * omega"}}
    analysis = {"method": "transient", "duration": 0.2, "sub_intervals": 4}
    scene = turning_arm(joint_laws={"drag": law}, analysis=analysis, drive=[])
    result = analyse(scene)
    assert "joint law drag" in result.data["support"]
    assert "joint law drag" in Result.load(result.save(tmp_path / "arm.nc")).data["support"]
