"""Weight of beams, bodies and mechanisms against closed forms and virtual work."""

import math

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene.factories import seed_four_bar
from tests.effects import strips
from tests.effects.strips import INERTIA, RHO, A, E, L

G = 9.81
EI, WEIGHT = E * INERTIA, RHO * A * G  # N m^2, N/m
MESHES = [{"elements": 1}, {"stations": (0, 0.1, 0.55, 1)}]


def beam(joints, **rest):
    """The strip under its weight."""
    return strips.beam(joints, **({"gravity": ("0 m/s^2", "-9.81 m/s^2")} | rest))


@pytest.mark.parametrize("mesh", MESHES)
def test_simply_supported_beam_sags_by_its_weight(mesh):
    data = analyse(beam({"O": {}, "B": {"kind": "slot"}}, mesh=mesh)).data.isel(theta=0, member=0)
    x = data["s"].to_numpy() * L
    # Timoshenko, Strength of Materials: uniform load; 1e-9 leaves room for rounding with elements of 4 cm
    sag = -WEIGHT * x * (L**3 - 2 * L * x**2 + x**3) / (24 * EI)
    assert np.allclose(data["deflection"].sel(component="y"), sag, rtol=1e-9, atol=1e-15)
    assert np.allclose(data["moment"], WEIGHT * x * (L - x) / 2, rtol=0, atol=1e-9 * WEIGHT * L**2)
    assert np.allclose(data["shear_force"], WEIGHT * (L / 2 - x), rtol=0, atol=1e-9 * WEIGHT * L)
    assert data["joint_force"].sel(joint="O").to_numpy() == pytest.approx([0, WEIGHT * L / 2], abs=1e-10)


@pytest.mark.parametrize("angle", [0.0, 60.0, 90.0, 200.0])
@pytest.mark.parametrize("mesh", MESHES)
def test_driven_cantilever_held_at_an_angle(angle, mesh):
    phi = math.radians(angle)
    scene = beam(
        {"O": {}},
        mesh=mesh,
        drive={"joint": "O", "speed": 5.0},
        masses={"tip": {"at": "beam.B", "mass": 0.1}},
        analysis={"method": "static", "position": phi},
    )
    data = analyse(scene).data.isel(theta=0, member=0)
    x, across, tip = data["s"].to_numpy() * L, -math.cos(phi), 0.1 * G
    moment = across * (WEIGHT * (L - x) ** 2 / 2 + tip * (L - x))
    assert np.allclose(data["moment"], moment, rtol=0, atol=1e-9 * tip * L)
    along = -math.sin(phi) * (WEIGHT * (L - x) + tip)
    assert np.allclose(data["axial_force"], along, rtol=0, atol=1e-9 * tip)
    bent = across * (WEIGHT * x**2 * (6 * L**2 - 4 * L * x + x**2) / 24 + tip * x**2 * (3 * L - x) / 6) / EI
    stretched = -math.sin(phi) * (WEIGHT * (L * x - x**2 / 2) + tip * x) / (E * A)
    expected = np.outer(stretched, [math.cos(phi), math.sin(phi)]) + np.outer(bent, [-math.sin(phi), math.cos(phi)])
    # deflections are read by differences of a thousandth: rounding of places, and the cube of rotations by 0.1
    assert np.allclose(data["deflection"], expected, rtol=0, atol=1e-9 * L + 3e-8 * np.abs(expected).max())
    assert float(data["input_torque"]) == pytest.approx(math.cos(phi) * (WEIGHT * L**2 / 2 + tip * L), abs=1e-9)


def test_weight_of_a_rigid_link_acts_at_its_centre():
    rigid = {
        "points": {"O": (0, 0), "A": (0.10795, 0)},
        "rigid": {"mass": 2.0, "inertia": 0.01, "centre": (0.03, 0.02)},
    }
    scene = seed_four_bar(masses={}, links__crank=rigid)
    scene = scene.changed(gravity=(0.0, -G), analysis={"method": "static", "position": 0.4})
    still = scene.changed(gravity=(0, 0), loads={"weight": {"at": "crank.O", "force": (0.0, -2 * G)}})
    light = scene.changed(links__crank__rigid__mass=0.0)
    heavy, none, held = (float(analyse(s).data["input_torque"][0]) for s in (scene, light, still))
    arm = 0.03 * math.cos(0.4) - 0.02 * math.sin(0.4)
    assert heavy - none == pytest.approx(2 * G * arm, rel=1e-10)
    assert held == pytest.approx(0, abs=1e-10)  # on the support it needs no torque


def test_torque_of_a_slow_four_bar_lifts_its_weight_and_gets_it_back():
    # at 1e-6 rad/s the inertia is 1e-13 of the weight; the power of the drive is that of the weights
    scene = seed_four_bar(
        gravity=(3.0, -G), drive__speed=1e-6, analysis={"method": "quasi-static", "sub_intervals": 36}
    )
    motion = solve_motion(scene, scene.drive_angles(36))
    power = np.zeros(36)
    for link, (a, b) in ((link, body.points.values()) for link, body in scene.links.items()):
        middle = ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)
        (member,) = scene.links[link].members.values()
        mass = 2714 * scene.sections[member.section].area * math.dist(a, b)
        power -= mass * motion.of_point(link, middle)[1] @ scene.gravity
    for mass in scene.masses.values():
        power -= mass.mass * motion.of_point(*scene.point(mass.at))[1] @ scene.gravity
    torque = analyse(scene).data["input_torque"].to_numpy()
    assert np.allclose(torque, power / scene.drive.speed, rtol=0, atol=1e-10 * np.abs(torque).max())
    assert abs(torque.mean()) < 1e-10 * np.abs(torque).max()


def test_weight_acts_on_the_periodic_response_with_every_solver():
    # harmonics 2 to 4 of 8 rad/s are 1/17 to 1/8.5 of the lowest natural frequency: they differ from statics by 0.3 to
    # 1.4 %; measured 1.3 %
    scene = seed_four_bar(gravity=(0.0, -G), drive__speed=8.0, analysis={"sub_intervals": 240, "modes": 3})
    slow = analyse(scene.changed(analysis__method="quasi-static")).data["strain"]
    for solver in ("sub-intervals", "collocation"):
        strain = analyse(scene.changed(analysis__solver=solver)).data["strain"]
        assert np.abs(strain - slow).max() < 0.02 * float(np.abs(slow).max()), solver
