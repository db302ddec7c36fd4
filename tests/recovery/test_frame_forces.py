"""Forces on the frame against the rate of momentum, closed forms of rigid links, and a force-balanced four-bar."""

import numpy as np
import pytest
from scipy.integrate import simpson

from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import response_of
from tests.recovery.test_momentum import RETURN, SHAFT, accelerations, arm, cross, demo, momenta, motion_of
from tests.validation.reference.mecqbar import mecqbar
from tests.validation.reference.parameters import FourBarParameters

RIGID = {"method": "quasi-static", "sub_intervals": 72}
STEEL = {"steel": {"modulus": 206e9, "density": 7850.0}}
LINE = 7850 * 0.02 * 0.005  # kg/m


def rate_of_moment_of_momentum(scene, data):
    """That of all links on bent members about the origin, and of the rotor (N m)."""
    motion, total = motion_of(scene, data), 0.0
    for name, link in scene.links.items():
        (member,) = link.members.values()
        ends = [np.array(link.points[end]) for end in member.ends]
        s = data["s"].to_numpy()
        rigid = np.stack([motion.of_point(name, tuple((1 - x) * ends[0] + x * ends[1]))[0] for x in s], axis=1)
        place = rigid + data["deflection"].sel(member=name).to_numpy()
        turning = cross(place, accelerations(data, place))
        line = scene.materials[member.material].density * scene.sections[member.section].area
        total = total + line * np.linalg.norm(ends[1] - ends[0]) * simpson(turning, x=s, axis=1)
        for mass in scene.masses.values():
            if mass.at.split(".")[0] == name:
                total = total + mass.mass * turning[:, 0 if mass.at.split(".")[1] == member.ends[0] else -1]
    for drive in scene.drives:
        if drive.motor is not None:
            total = total + drive.motor.inertia * accelerations(data, data["drive_twist"].to_numpy()[:, None])[:, 0]
    return total


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes", "supports", "moment"),
    [  # moments of closed loops balance on straight links: to second order in the deflection
        ("manipulator", {}, ["shoulder"], 5e-3),  # a linear theory is of first order
        ("slider_crank", {}, ["O", "B"], 0.01),
        ("four_bar", {"drive__speed": 15.0}, ["O", "C"], 0.01),
        ("four_bar", {"drive__speed": 15.0, "springs": RETURN}, ["O", "C", "spring return"], 0.03),
        (
            "four_bar",
            {"drive__speed": 15.0, "springs": RETURN, "motor": SHAFT, "analysis__sub_intervals": 960},
            ["O", "C", "spring return"],
            0.03,
        ),
    ],
)
def test_frame_takes_the_rate_of_the_momentum_of_bent_links(name, changes, supports, moment):
    scene = demo(name, **changes)
    data = response_of(scene).data
    force, turning = -sum(rate for rate, _ in momenta(scene, data).values()), -rate_of_moment_of_momentum(scene, data)
    assert list(data["support"].to_numpy()) == supports
    assert data["shaking_force"].to_numpy() == pytest.approx(force, abs=2e-4 * np.abs(force).max())
    assert data["shaking_moment"].to_numpy() == pytest.approx(turning, abs=moment * np.abs(turning).max())


def crank(**rest):
    """A crank of 0.5 m with 50 g at its end, which turns at 40 rad/s."""
    changes = {"drive": {"joint": "O", "speed": 40.0}, "analysis": RIGID}
    return arm(**changes | rest)


def test_crank_pulls_by_its_centrifugal_force_and_its_weight_turns_the_frame():
    scene = crank(gravity=(0.0, -9.81))
    data = response_of(scene).data
    theta = data["theta"].to_numpy()
    length = 0.5
    mass = LINE * length
    outward = (mass * length / 2 + 0.05 * length) * 40**2 * np.stack([np.cos(theta), np.sin(theta)], axis=1)
    weight = -9.81 * (mass + 0.05)
    assert data["shaking_force"].to_numpy() == pytest.approx(outward + [0.0, weight], rel=1e-9, abs=1e-10)
    turning = -9.81 * (mass * length / 2 + 0.05 * length) * np.cos(theta)
    assert data["shaking_moment"].to_numpy() == pytest.approx(turning, abs=1e-9 * np.abs(turning).max())
    assert float(data["drive_effort_rms"][0]) == pytest.approx(np.abs(turning).max() / np.sqrt(2), rel=1e-9)
    lifted = 2 * np.abs(turning).max()  # by the weight, between its lowest and its highest place
    assert data.attrs["energy_fluctuation"] == pytest.approx(lifted, rel=1e-3)  # by the trapezoidal rule of 72 angles


def test_beam_on_a_weld_gives_its_moment_to_the_frame():
    joints = {"O": {"kind": "weld", "connect": ("ground.O", "arm.O")}}
    data = response_of(arm(joints=joints, drive=(), gravity=(0, -9.81), analysis={"method": "static"})).data
    mass = LINE * 0.5
    moment = -9.81 * (mass * 0.25 + 0.05 * 0.5)
    assert float(data["support_moment"].sel(support="O")[0]) == pytest.approx(moment)
    assert float(data["shaking_moment"][0]) == pytest.approx(moment)
    assert float(data["joint_moment"].sel(held="O")[0]) == pytest.approx(-moment)
    turned = response_of(
        arm(
            joints={"O": {"kind": "weld", "connect": ("arm.O", "ground.O")}},
            drive=(), gravity=(0, -9.81), analysis={"method": "static"},
        )
    ).data  # fmt: skip
    assert float(turned["support_moment"].sel(support="O")[0]) == pytest.approx(moment)
    assert float(turned["joint_moment"].sel(held="O")[0]) == pytest.approx(moment)


def test_seed_shakes_by_the_accelerations_of_appendix_g():
    data = response_of(seed_four_bar(analysis={"method": "quasi-static", "sub_intervals": 24})).data
    found, parameters = mecqbar(data["theta"].to_numpy()), FourBarParameters()
    m1, m2, m3 = parameters.masses
    force = -np.stack(
        [
            (m1 / 2 + parameters.mass_A) * found[f"aA{x}_m_s2"]
            + m2 * found[f"aG2{x}_m_s2"]
            + (m3 / 2 + parameters.mass_B) * found[f"aB{x}_m_s2"]
            for x in "xy"
        ],
        axis=1,
    )
    assert data["shaking_force"].to_numpy() == pytest.approx(force, abs=1e-9 * np.abs(force).max())


def balanced_four_bar(share):
    """A four-bar whose crank and follower carry a share of the counterweights of Berkof and Lowen behind their pins."""
    a, b, c, ground, behind = 0.1, 0.3, 0.25, 0.28, 0.06
    coupler = LINE * b
    # mass times distance of crank and follower: minus those of the parts of the coupler that stand at A and B
    wanted = {"crank": coupler / 2 * a, "follower": coupler / 2 * c}
    arms = {"crank": a, "follower": c}
    weights = {link: share * (wanted[link] + LINE * (arms[link] ** 2 - behind**2) / 2) / behind for link in wanted}
    part = {"section": "strip", "material": "steel"}

    def link(length, angle):
        return {
            "points": {"P": (0, 0), "Q": (length, 0), "W": (-behind, 0)},
            "members": {"front": {"ends": ("P", "Q"), **part}, "back": {"ends": ("P", "W"), **part}},
            "angle": angle,
        }

    coupled = {"points": {"A": (0, 0), "B": (b, 0)}, "members": {"AB": {"ends": ("A", "B"), **part}}, "angle": 1.0}
    return Scene.read(
        {
            "materials": STEEL,
            "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.005}},
            "ground": {"points": {"O": (0, 0), "C": (ground, 0)}},
            "links": {"crank": link(a, 0.0), "coupler": coupled, "follower": link(c, 1.7)},
            "joints": {
                "O": {"connect": ("ground.O", "crank.P")},
                "A": {"connect": ("crank.Q", "coupler.A")},
                "B": {"connect": ("coupler.B", "follower.Q")},
                "C": {"connect": ("ground.C", "follower.P")},
            },
            "masses": {link: {"at": f"{link}.W", "mass": weight} for link, weight in weights.items() if weight},
            "drive": {"joint": "O", "speed": 30.0},
            "analysis": RIGID,
        }
    )


def test_balanced_four_bar_does_not_shake_its_frame():
    bare, balanced = (np.abs(response_of(balanced_four_bar(share)).data["shaking_force"]).max() for share in (0, 1))
    assert float(bare) > 10
    assert float(balanced / bare) < 1e-10
