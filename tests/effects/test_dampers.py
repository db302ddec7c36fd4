"""Viscous dampers: their linearisation, an oscillator on a moving base, and the power that they take."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar

DAMPERS = {
    "line": {"between": ("coupler.B", "crank.O"), "damping": 3.0},
    "hinge": {"joint": "B", "damping": 2e-3},
}


def stiff(scale, **rest):
    """The seed four-bar with a modulus so many times higher."""
    return seed_four_bar(materials={"material": {"modulus": 71e9 * scale, "density": 2714}}, **rest)


def spans(scene, system, after, v, rate):
    """Length of the line damper and rotation at B a time `after` each angle, ``(2, angles)``, v growing at `rate`."""
    motion = solve_motion(scene, system.motion.theta + scene.cycle_rate * after, near=system.motion)
    v, node = v + after * rate, system.beams.mesh.node

    def place(at):
        body, point = scene.point(at)
        i, dof = motion.links.index(body), 3 * node(at)
        c, s = np.cos(motion.angle[:, i]), np.sin(motion.angle[:, i])
        return motion.of_point(body, point)[0] + np.stack(
            [c * v[:, dof] - s * v[:, dof + 1], s * v[:, dof] + c * v[:, dof + 1]], axis=-1
        )

    length = np.linalg.norm(place("coupler.B") - place("crank.O"), axis=1)
    turned = [motion.angle[:, i] + v[:, 3 * node(at) + 2] for i, at in ((1, "coupler.B"), (2, "follower.B"))]
    return np.stack([length, turned[1] - turned[0]])


def virtual_power(scene, system, v, rate, virtual):
    """Power of the dampers' forces in a virtual velocity in link axes, ``(angles,)``; no formula of the program's."""
    h = 1e-5
    speeds = (spans(scene, system, h, v, rate) - spans(scene, system, -h, v, rate)) / (2 * h)
    still = (spans(scene, system, 0, v + h * virtual, rate) - spans(scene, system, 0, v - h * virtual, rate)) / (2 * h)
    return -np.array([3.0, 2e-3]) @ (speeds * still)


def shaken(mass=0.8, stiffness=400.0, damping=2.0, shake=1e-3, speed=20.0):
    """A mass on a weak cantilever, shaken through a spring and a damper by a piston at shake cos(speed t)."""
    return Scene.read(
        {
            "materials": {"light": {"modulus": 1e9, "density": 1e-6}},
            "sections": {"strip": {"area": 1e-3, "inertia": 3e-9, "fibre": 1e-3}},
            "ground": {"points": {"O": (0, 0), "P": (-0.2, 0.5)}},
            "links": {
                "beam": {
                    "points": {"O": (0, 0), "B": (0, 0.5)},
                    "members": {"OB": {"ends": ("O", "B"), "section": "strip", "material": "light"}},
                },
                "piston": {"points": {"P": (0, 0)}, "rigid": {"mass": 0.1, "inertia": 1e-4}},
            },
            "joints": {
                "O": {"kind": "weld", "connect": ("ground.O", "beam.O")},
                "P": {"kind": "prismatic", "connect": ("ground.P", "piston.P")},
            },
            "masses": {"B": {"at": "beam.B", "mass": mass}},
            "springs": {"s": {"between": ("piston.P", "beam.B"), "stiffness": stiffness, "length": 0.2}},
            "dampers": {"d": {"between": ("piston.P", "beam.B"), "damping": damping}},
            "drive": {"joint": "P", "law": {"kind": "harmonics", "cosine": [shake]}, "period": 2 * np.pi / speed},
            "analysis": {"sub_intervals": 36, "stability": False},
        }
    )


def test_oscillator_on_a_moving_base():
    scene = shaken()
    data = analyse(scene).data
    bending, at = 3 * 3.0 / 0.5**3, np.exp(1j * data["theta"].to_numpy())
    link = 400 + 2j * 20.0  # spring and damper
    x = link * 1e-3 / (bending + link - 0.8 * 20.0**2)  # complex amplitude
    accuracy = 1e-6 * abs(x)  # of 36 steps of order 5, and of the beam's own mass
    found = data["deflection"].sel(member="beam", s=1, component="x")
    assert np.abs(found - (x * at).real).max() < accuracy
    pull = (x - 1e-3) * at
    assert np.abs(data["spring_force"].sel(spring="s") - 400 * pull.real).max() < 400 * accuracy
    assert np.abs(data["damper_force"].sel(damper="d") - (40j * pull).real).max() < 40 * accuracy
    push = -(0.1 * 20.0**2 * 1e-3 * at + link * pull).real  # the drive moves the piston against both
    assert np.abs(data["input_torque"] - push).max() < 400 * accuracy


def test_drive_pays_for_the_dampers_in_quasi_static_motion():
    analysis = {"method": "quasi-static", "sub_intervals": 24}
    plain, damped = (analyse(seed_four_bar(analysis=analysis, dampers=some)).data for some in ({}, DAMPERS))
    power = 32.3 * (damped["input_torque"] - plain["input_torque"])
    taken = damped["damper_force"].to_numpy() ** 2 @ (1 / np.array([3.0, 2e-3]))
    assert np.abs(power - taken).max() < 4e-3 * taken.max()  # forces of the rigid motion turn as the links bend


def test_mean_power_of_the_drive_is_what_the_dampers_take():
    scene = stiff(
        1e1,
        dampers=DAMPERS,
        springs={"s": {"between": ("coupler.B", "ground.O"), "stiffness": 20.0}},
        effects=("coupling", "large-rotations"),
        damping={"material": 1e-6},
        analysis={"sub_intervals": 48, "stability": False},
    )
    data = analyse(scene).data
    taken = float((data["damper_force"].to_numpy() ** 2 @ (1 / np.array([3.0, 2e-3]))).mean())
    assert 32.3 * float(data["input_torque"].mean()) == pytest.approx(taken, rel=1e-4)
    assert float(data["mean_power"].sel(cause="dampers")) == pytest.approx(-taken, rel=1e-4)


def test_dampers_call_for_the_equation_of_poses():
    scene = seed_four_bar(dampers=DAMPERS, analysis={"sub_intervals": 24, "allow_coarse": True})
    assert analyse(scene).data.attrs["solver"] == "poses"
    with pytest.raises(SceneError, match="dampers"):
        analyse(scene.changed(analysis__solver="sub-intervals"))


def test_dampers_leave_natural_frequencies_alone():
    scene = seed_four_bar(
        effects=("coupling",), analysis={"sub_intervals": 24, "allow_coarse": True, "stability": False}
    )
    plain, damped = (analyse(scene.changed(dampers=some)).data["frequency"] for some in ({}, DAMPERS))
    assert np.allclose(plain, damped, rtol=1e-12)


def test_damper_without_a_direction_is_refused():
    damper = {"d": {"between": ("crank.A", "ground.P"), "damping": 1.0}}
    ground = {"points": {"O": (0, 0), "C": (0.254, 0), "P": (0.10795, 0)}}
    scene = seed_four_bar(dampers=damper, ground=ground, analysis={"method": "quasi-static", "sub_intervals": 4})
    with pytest.raises(AssemblyError, match=r"ends of dampers\.d meet at drive angle 0 deg"):
        analyse(scene)


def test_bodies_must_be_named_where_a_pin_holds_three():
    data = seed_four_bar().model_dump()
    data["links"]["rod"] = {"points": {"B": (0, 0)}, "rigid": {"mass": 0.1, "inertia": 1e-4}}
    data["joints"]["B"]["connect"] = ("coupler.B", "follower.B", "rod.B")
    data["dampers"] = {"d": {"joint": "B", "damping": 1.0}}
    with pytest.raises(SceneError, match="bodies coupler, follower, rod"):
        Scene.read(data)


def test_creeping_hinge_is_no_resonance():
    """A hinge that is nearly blocked creeps back in ``c/k``: its multiplier is next to 1, and it does not vibrate."""
    analysis = {"sub_intervals": 120, "solver": "collocation"}
    strong = seed_four_bar(dampers={"h": {"joint": "C", "damping": 1e6}}, effects=("coupling",), analysis=analysis)
    found = analyse(strong).data
    assert float(found["multiplier"][0, 0]) == pytest.approx(1, abs=1e-5)
    stronger = analyse(strong.changed(dampers={"h": {"joint": "C", "damping": 1e7}})).data
    assert np.abs(found["strain"] - stronger["strain"]).max() < 1e-5 * np.abs(found["strain"]).max()
