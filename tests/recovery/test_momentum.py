"""Forces with modal damping against the motion itself: momentum of the mechanism and of its links, and energy.

The accelerations are second time derivatives of the places that the results give to points of the links, the momentum
is their integral. Nothing of it shares the recovery's inertia, or knows of damping.
"""

import numpy as np
import pytest
from scipy.integrate import simpson

from fenics_mech import analyse, load
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import DEMOS, modes_of, response_of

WAVES = 100  # harmonics of the drive that the accelerations are made of; above them there is rounding alone
SHAFT = {"stiffness": 60.0, "damping": 0.05, "inertia": 2e-3}
RETURN = {"return": {"between": ("follower.B", "ground.O"), "stiffness": 40.0, "length": 0.0}}
IN_TIME = {"analysis__method": "transient", "analysis__cycles": 1, "analysis__time_tolerance": 1e-4}


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def accelerations(data, place):
    """Second derivatives in time: by Fourier series of a cycle, or by differences of the eighth order."""
    step = float(data["time"][1] - data["time"][0])
    if "state" not in data:
        spectrum = np.fft.rfft(place, axis=0)
        n = np.arange(len(spectrum)).reshape(-1, *(1,) * (place.ndim - 1))
        spectrum[WAVES:] = 0
        return np.fft.irfft(-((2 * np.pi * n / (step * len(place))) ** 2) * spectrum, n=len(place), axis=0)
    weights = np.array([-1 / 560, 8 / 315, -1 / 5, 8 / 5, -205 / 72, 8 / 5, -1 / 5, 8 / 315, -1 / 560])
    found = np.full_like(place, np.nan)
    found[4:-4] = sum(w * place[i : len(place) - 8 + i] for i, w in enumerate(weights)) / step**2
    return found


def motion_of(scene, data):
    """The rigid motion that the results' deflections are from."""
    if scene.analysis.method == "transient":
        return solve_motion(scene, scene.coordinate(data["time"].to_numpy()).value)
    twist = data["drive_twist"].to_numpy() if "drive_twist" in data else 0.0
    return solve_motion(scene, data["theta"].to_numpy() + twist)


def momenta(scene, data):
    """Rate of momentum, and of moment of momentum about the origin, of each link: ``(angles, 2)`` and ``(angles,)``.

    The arms are those of the undeformed links, on which forces are balanced.
    """
    motion, rates = motion_of(scene, data), {}
    for name, link in scene.links.items():
        force, moment = 0.0, 0.0
        for label, member in link.members.items():
            ends = [np.array(link.points[end]) for end in member.ends]
            s = data["s"].to_numpy()
            rigid = np.stack([motion.of_point(name, tuple((1 - x) * ends[0] + x * ends[1]))[0] for x in s], axis=1)
            key = name if len(link.members) == 1 else f"{name}.{label}"
            acceleration = accelerations(data, rigid + data["deflection"].sel(member=key).to_numpy())
            line = scene.materials[member.material].density * scene.sections[member.section].area
            length = np.linalg.norm(ends[1] - ends[0])
            force = force + line * length * simpson(acceleration, x=s, axis=1)
            moment = moment + line * length * simpson(cross(rigid, acceleration), x=s, axis=1)
            for mass in scene.masses.values():
                assert mass.inertia == 0
                for k, end in ((0, ends[0]), (-1, ends[1])):
                    body, point = scene.point(mass.at)
                    if body == name and np.allclose(point, end):
                        force = force + mass.mass * acceleration[:, k]
                        moment = moment + mass.mass * cross(rigid[:, k], acceleration[:, k])
        rates[name] = force, moment
    return rates


def forces_on(scene, data):
    """Force, and its moment about the origin, of all joints, drives and springs on each link."""
    motion = motion_of(scene, data)
    total = {name: [np.zeros((len(data["theta"]), 2)), np.zeros(len(data["theta"]))] for name in scene.links}

    def add(body, force, moment):
        if body != "ground":
            total[body][0] += force
            total[body][1] += moment

    def where(at):
        return motion.of_point(*scene.point(at))[0] if not at.startswith("ground") else np.array(scene.point(at)[1])

    for name, joint in scene.joints.items():
        force, at = data["joint_force"].sel(joint=name).to_numpy(), where(joint.connect[1])
        for point, sign in zip(joint.connect, (-1, 1)):
            add(point.split(".")[0], sign * force, sign * cross(at, force))
    for drive in scene.drives:
        effort = data["drive_effort"].sel(drive=drive.joint).to_numpy()
        for point, sign in zip(scene.joints[drive.joint].connect, (-1, 1)):
            add(point.split(".")[0], 0, sign * effort)
    for spring in scene.springs.values():  # of no free length, from the end of a link to the ground
        first, second = (where(at) for at in spring.between)
        link = spring.between[0].split(".")[0]
        force = spring.stiffness * (second - first - data["deflection"].sel(member=link, s=1).to_numpy())
        add(link, force, cross(first, force))
    return total


def gaps(scene, data):
    """Largest gaps of the balances of force of each link and of all, and of moment of each, of the largest rate.

    The effort of a drive is of the bent mechanism; its links are left to the balance of energy.
    """
    rates, found = momenta(scene, data), forces_on(scene, data)
    driven = {at.split(".")[0] for drive in scene.drives for at in scene.joints[drive.joint].connect}
    worst = []
    for i, free in ((0, set(scene.links)), (1, set(scene.links) - driven)):
        each = {name: found[name][i] - rates[name][i] for name in scene.links}
        scale = max(np.nanmax(np.abs(rates[name][i])) for name in scene.links)
        worst.append(max((np.nanmax(np.abs(each[name])) for name in free), default=0.0) / scale)
        if i == 0:
            worst.append(np.nanmax(np.abs(sum(each.values()))) / scale)
    return worst


def demo(name, motor=None, springs=(), **changes):
    """A demo with the coupling and all modes damped, whose point masses have no inertia: results give no rotation.

    A motor whose shaft twists has exact strains.
    """
    data = load(DEMOS / f"{name}.toml").model_dump()
    for mass in data["masses"].values():
        mass["inertia"] = 0.0
    if motor:
        data["drive"]["motor"] = motor
    effects = ("coupling", "large-rotations") if motor else ("coupling",)
    changes = {"effects": effects, "damping__ratio": 0.05, "analysis__sub_intervals": 240} | changes
    return Scene.read(data | {"springs": dict(springs)}).changed(
        analysis__stability=False, analysis__stations=41, **changes
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes", "largest"),
    [  # what the solvers' steps and harmonics leave; up to 0.7 if the forces of damping came from outside
        ("manipulator", {}, 3e-4),  # linear theories are of first order
        ("manipulator", {"analysis__solver": "harmonic-balance", "analysis__harmonics": 50}, 3e-4),
        ("four_bar", {"drive__speed": 15.0}, 2e-4),
        ("four_bar", {"drive__speed": 15.0, "damping__material": 1e-4}, 2e-4),
        ("four_bar", {"drive__speed": 15.0, "springs": RETURN}, 2e-4),
        ("slider_crank", {}, 5e-5),
    ],
)
def test_joint_forces_make_the_momentum(name, changes, largest):
    scene = demo(name, **changes)
    assert gaps(scene, response_of(scene).data) == pytest.approx([0] * 3, abs=largest)


@pytest.mark.slow
def test_joint_forces_make_the_momentum_under_a_motor():
    """Forces alone: strains are exact under a motor, and the moments of `gaps` are about places of rigid links."""
    scene = demo("four_bar", motor=SHAFT, springs=RETURN, drive__speed=15.0, analysis__sub_intervals=960)
    assert gaps(scene, response_of(scene).data)[:2] == pytest.approx([0] * 2, abs=5e-4)


def arm(steps=120, **rest):
    """An arm that swings to and fro, 0.5 m long, with the modes of a cantilever: they do not change with its angle."""
    data = {
        "materials": {"steel": {"modulus": 206e9, "density": 7850}},
        "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.005}},
        "ground": {"points": {"O": (0, 0)}},
        "links": {
            "arm": {
                "points": {"O": (0, 0), "B": (0.5, 0)},
                "members": {"beam": {"ends": ("O", "B"), "section": "strip", "material": "steel"}},
            }
        },
        "joints": {"O": {"connect": ("ground.O", "arm.O")}},
        "masses": {"B": {"at": "arm.B", "mass": 0.05}},
        "drive": {"joint": "O", "law": {"kind": "harmonics", "sine": [0.3]}, "period": 0.1},
        "mesh": {"elements": 2},
        "analysis": {"sub_intervals": steps, "modes": "all", "stations": 41, "allow_ringing": True, "stability": False},
    }
    return Scene.read(data | rest)


@pytest.mark.parametrize("effects", [(), ("coupling",)])
def test_ratios_that_rise_with_the_frequency_are_damping_by_the_material(effects):
    # stress E (strain + tau rate) gives C = tau K, which is M Phi 2 zeta omega Phi^T M with 2 zeta = tau omega
    tau = 3e-5
    scene = arm(effects=effects)
    omega = modes_of(scene).modes.omega[0]
    ratios = response_of(
        arm(effects=effects, damping={"ratio": tuple(tau * omega / 2)}).changed(analysis__solver="collocation")
    )
    material = response_of(arm(effects=effects, damping={"material": tau}))
    assert tau * omega.max() > 1
    for name in (
        "strain",
        "stress",
        "moment",
        "axial_force",
        "shear_force",
        "joint_force",
        "input_torque",
        "deflection",
    ):
        a, b = (found.data[name].to_numpy() for found in (ratios, material))
        # ratios damp what nodes do, and the material what is within elements too
        assert a == pytest.approx(b, abs=3e-4 * np.abs(b).max()), name


def test_forces_of_chapter_5_are_those_of_its_motion():
    # (5.1) takes the accelerations in the links' axes; a motion of one harmonic, and steps of its 480th part
    scene = arm(damping={"ratio": 0.1}, steps=480)
    data = analyse(scene).data
    motion, s = solve_motion(scene, data["theta"].to_numpy()), data["s"].to_numpy()
    c, sine = np.cos(motion.angle), np.sin(motion.angle)
    in_link = np.array([[c, sine], [-sine, c]])[..., 0]  # (2, 2, angles)
    deflection = np.einsum("ijt,tsj->tsi", in_link, data["deflection"].sel(member="arm").to_numpy())
    rigid = np.stack([-(motion.omega**2), motion.alpha], axis=-1) * 0.5 * s[:, None]
    acceleration = rigid + accelerations(data, deflection)
    line = 7850 * 1e-4
    force = 0.5 * line * simpson(acceleration, x=s, axis=1) + 0.05 * acceleration[:, -1]
    torque = 0.5 * line * simpson(0.5 * s * acceleration[..., 1], x=s, axis=1) + 0.05 * 0.5 * acceleration[:, -1, 1]
    found = np.einsum("ijt,tj->ti", in_link, data["joint_force"].sel(joint="O").to_numpy())
    assert found == pytest.approx(force, abs=1e-3 * np.abs(force).max())
    assert data["input_torque"].to_numpy() == pytest.approx(torque, abs=1e-3 * np.abs(torque).max())


def test_forces_of_few_modes_are_those_of_the_whole_equation():
    # 5 modes of chapter 5 leave 0.6 % of the axial forces; 10 % if the forces of damping came from outside
    analysis = {"sub_intervals": 384, "modes": 5, "stability": False}
    scene = seed_four_bar(drive__speed=15.0, effects=(), damping={"ratio": 0.05}, analysis=analysis)
    few, whole = (
        response_of(scene.changed(analysis__solver=solver)).data for solver in ("sub-intervals", "collocation")
    )
    for name in ("joint_force", "axial_force", "stress"):
        expected = whole[name].to_numpy()
        assert few[name].to_numpy() == pytest.approx(expected, abs=0.01 * np.abs(expected).max()), name
