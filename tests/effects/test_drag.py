"""Drag of the surroundings in closed form: spinning arms, and a rotor with external and internal damping."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene import Scene

LENGTH, LINE = 0.5, 7850 * 1e-4  # of the arm: m, kg/m
ROTOR_MASS, RADIUS = 2.0, 0.1


def arm(speed=20.0, **rest):
    """An arm of steel that spins about its end."""
    data = {
        "materials": {"steel": {"modulus": 206e9, "density": 7850}},
        "sections": {"strip": {"shape": "rectangle", "width": 0.02, "height": 0.005}},
        "ground": {"points": {"O": (0, 0)}},
        "links": {
            "arm": {
                "points": {"O": (0, 0), "B": (LENGTH, 0)},
                "members": {"beam": {"ends": ("O", "B"), "section": "strip", "material": "steel"}},
            }
        },
        "joints": {"O": {"connect": ("ground.O", "arm.O")}},
        "drive": {"joint": "O", "speed": speed},
        "mesh": {"elements": 2},
        "effects": ("coupling", "large-rotations"),
        "analysis": {"sub_intervals": 12, "stations": 5, "stability": False},
    }
    return Scene.read(data | rest)


def rotor(speed, damping):
    """A mass in the middle of three spokes of a stiff wheel that is driven: the same stiffness in all directions."""
    angles = 2 * np.pi * np.arange(3) / 3
    rim = {f"R{i}": (RADIUS * np.cos(a), RADIUS * np.sin(a)) for i, a in enumerate(angles)}
    spokes = {f"M{name}": {"ends": ("M", name), "section": "spoke", "material": "soft"} for name in rim}
    wheel = {f"O{name}": {"ends": ("O", name), "section": "spoke", "material": "stiff"} for name in rim}
    data = {
        "materials": {"soft": {"modulus": 1e7, "density": 10}, "stiff": {"modulus": 1e12, "density": 1e3}},
        "sections": {"spoke": {"shape": "rectangle", "width": 0.01, "height": 0.01}},
        "ground": {"points": {"O": (0, 0)}},
        "links": {"wheel": {"points": {"O": (0, 0), "M": (0, 0), **rim}, "members": spokes | wheel}},
        "joints": {"O": {"connect": ("ground.O", "wheel.O")}},
        "masses": {"M": {"at": "wheel.M", "mass": ROTOR_MASS, "inertia": 1e-6}},
        "drive": {"joint": "O", "speed": speed},
        "damping": damping,
        "mesh": {"elements": 1},
        "effects": ("coupling",),
        "analysis": {"sub_intervals": 48, "stations": 3, "allow_unstable": True, "allow_coarse": True},
    }
    return Scene.read(data)


def test_spinning_arm_needs_the_torque_of_its_drag():
    # dM = c x^2 Omega dm, and all of it goes into the air; the arm stretches by 4e-5 of its length
    data = analyse(arm(damping={"external": 3.0})).data
    torque = 3.0 * LINE * LENGTH**3 * 20.0 / 3
    assert data["input_torque"].to_numpy() == pytest.approx(torque, rel=1e-4)
    power = data["mean_power"].sel(cause="external drag")
    assert float(power) == pytest.approx(-torque * 20.0, rel=1e-4)
    assert data.attrs["power_balance_error"] < 1e-7  # Newton's method ends there


def test_masses_are_dragged_as_well():
    scene = arm(damping={"external": 3.0}, masses={"B": {"at": "arm.B", "mass": 0.1, "inertia": 0.02}})
    scene = scene.changed(analysis__method="quasi-static", effects=())
    torque = 3.0 * 20.0 * (LINE * LENGTH**3 / 3 + 0.1 * LENGTH**2 + 0.02)
    assert analyse(scene).data["input_torque"].to_numpy() == pytest.approx(torque, rel=1e-10)


def test_air_that_turns_with_the_link_drags_no_rigid_motion():
    data = analyse(arm(damping={"relative": 3.0})).data
    assert np.abs(data["input_torque"].to_numpy()).max() < 1e-7  # Newton's method ends there


@pytest.mark.parametrize(
    ("damping", "speed"), [("external", 0.5), ("external", 1.6), ("relative", 1.6), ("material", 0.9), ("both", 1.6)]
)
def test_whirl_of_a_rotor_grows_as_external_and_internal_damping_say(damping, speed):
    # z in axes that turn: z'' + (2 i Omega + c + d) z' + (omega^2 - Omega^2 + i c Omega) z = 0, with c of the
    # surroundings and d of the material or of air that turns along (Genta, Dynamics of Rotating Systems, ch. 4)
    area, second = 1e-4, 1e-8 / 12
    omega = np.sqrt(1.5 * 1e7 * (area / RADIUS + 12 * second / RADIUS**3) / ROTOR_MASS)
    spin, c, d = speed * omega, 0.0, 0.0
    stated = {}
    if damping in ("external", "both"):
        c = stated["external"] = 0.02 * omega
    if damping == "relative":
        d = stated["relative"] = 0.02 * omega
    if damping in ("material", "both"):
        stated["material"] = 0.02 / omega
        d = 0.02 * omega
    roots = np.roots([1, 2j * spin + c + d, omega**2 - spin**2 + 1j * c * spin])
    data = analyse(rotor(spin, stated)).data
    # the slowest disturbances; material damping takes a trifle from the rotation of the mass
    found = np.sort(data["growth_rate"].to_numpy())[::-1]
    assert found[0] == pytest.approx(roots.real.max(), abs=2e-3 * 0.01 * omega)
    if damping == "external":
        assert found[:4] == pytest.approx([-c / 2] * 4, rel=1e-3)
