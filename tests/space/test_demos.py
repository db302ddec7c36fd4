"""The demos in space, each with a number that a closed form or a balance gives."""

import numpy as np
import pytest

import fenics_mech as fm
from tests.common import DEMOS

COARSE = {"analysis.error_estimates": False, "analysis.positions": 36, "analysis.modes": 0, "mesh.elements": 2}


def demo(name, **changes):
    return fm.analyse(fm.load(DEMOS / "space" / f"{name}.toml").changed(COARSE | changes)).data


def test_the_block_of_the_slider_crank_is_where_its_rigid_links_put_it():
    """X = r cos(theta) + sqrt(L^2 - (r sin(theta) - 30 mm)^2 - (40 mm)^2), as nothing loads it."""
    data = demo("slider_crank", **{"drive.speed": 0.01, "gravity": (0, 0, 0)})
    theta = data["theta"].values
    x = 0.05 * np.cos(theta) + np.sqrt(0.2**2 - (0.05 * np.sin(theta) - 0.03) ** 2 - 0.04**2)
    assert np.abs(data["joint_place"].sel(joint="G", component="x").values - x).max() < 1e-11


def test_the_drive_line_takes_what_its_load_brakes():
    """The output turns at cos b/(1 - sin(b)^2 cos(theta)^2) of the speed; the damper takes the square of that."""
    data, bend, theta = demo("drive_line"), np.radians(30), np.linspace(0, 2 * np.pi, 720, endpoint=False)
    speed = 600 * np.pi / 30
    ratio = np.cos(bend) / (1 - (np.sin(bend) * np.cos(theta)) ** 2)
    assert data["input_torque"].mean().item() == pytest.approx(0.5 * speed * np.mean(ratio**2), rel=2e-3)


def test_bennett_moves_without_strain_where_it_is_slow():
    """Its links are made to 1e-9, and three times overconstrained."""
    data = demo("bennett", **{"drive.speed": 0.01})
    assert data.attrs["mobility"] == 1
    assert np.abs(data["stress"]).max() < 2e3  # Pa, of 16 MPa at the demo's speed


def test_the_arm_takes_no_energy_over_its_cycle_but_its_damping():
    """The drives' work over a cycle, by their angles' rates, is small beside what they give and take."""
    data = demo("arm", **{"analysis.positions": 72})
    phase = data["theta"].values
    swing = np.radians(60) * np.sin(phase), np.radians(15) * np.sin(phase) + 2 * np.radians(10) * np.sin(2 * phase)
    powers = [data["input_torque"].values[:, k] * rate for k, rate in enumerate(swing)]
    assert abs(sum(p.mean() for p in powers)) < 0.02 * max(np.abs(p).max() for p in powers)


def test_the_actuator_of_the_landing_gear_holds_the_leg_at_rest():
    """Its force times its arm about the hinge is the weights' moment: virtual work by two near positions."""
    slow = {"analysis.method": "quasi-static", "analysis.positions": 180, "drive.period": 4000.0}
    data = demo("landing_gear", **slow)
    stroke = -0.11 + 0.11 * np.cos(data["theta"].values)
    heights = [35.0 * data["place"].sel(member="leg.lower", component="z").isel(s=-1).values]
    tubes = {"leg.upper": (0.08, 0.006), "leg.lower": (0.08, 0.006), "cylinder": (0.05, 0.005), "rod": (0.028, 0.014)}
    for name, (diameter, wall) in tubes.items():
        place = data["place"].sel(member=name)
        ends = place.isel(s=[0, -1]).values
        mass = 7850 * np.pi * wall * (diameter - wall) * np.linalg.norm(ends[0, 1] - ends[0, 0])
        heights.append(mass * place.sel(component="z").mean("s").values)
    energy = 9.81 * sum(heights)
    k = slice(20, 70)
    force = np.gradient(energy, stroke)[k]
    assert data["input_torque"].values[k, 0] == pytest.approx(force, rel=5e-3)
