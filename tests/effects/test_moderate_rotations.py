"""Moderate rotations against textbook answers of beams that stretch as they bend."""

import numpy as np
import pandas as pd
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from fenics_mech.analysis import analyse
from fenics_mech.scene.build import build

LENGTH, WIDTH, HEIGHT, MODULUS = 1.0, 0.02, 0.002, 70e9
EA, EI = MODULUS * WIDTH * HEIGHT, MODULUS * WIDTH * HEIGHT**3 / 12


def between_pins(force, elements=16, effects=("moderate-rotations",)):
    """A strip between two pins on the ground, with a force across its middle."""
    half = {"section": "strip", "material": "metal"}
    return build(
        {
            "materials": {"metal": {"modulus": MODULUS, "density": 2700}},
            "sections": {"strip": {"shape": "rectangle", "width": WIDTH, "height": HEIGHT}},
            "ground": {"points": {"A": [0, 0], "B": [LENGTH, 0]}},
            "links": {
                "beam": {
                    "points": {"A": [0, 0], "M": [LENGTH / 2, 0], "B": [LENGTH, 0]},
                    "members": {"left": {"ends": ["A", "M"], **half}, "right": {"ends": ["M", "B"], **half}},
                }
            },
            "joints": {"A": {"connect": ["ground.A", "beam.A"]}, "B": {"connect": ["ground.B", "beam.B"]}},
            "loads": {"push": {"at": "beam.M", "force": [0, force]}},
            "mesh": {"elements": elements},
            "effects": effects,
            "analysis": {"method": "static"},
        }
    )


def tension_of(force):
    """Tension and middle deflection of the strip: Timoshenko and Woinowsky-Krieger, section on beams that stretch."""

    def slope(x, n):
        k = np.sqrt(n / EI)
        return force / (2 * n) * (1 - np.cosh(k * x) / np.cosh(k * LENGTH / 2))

    def lack(n):
        return EA / LENGTH * quad(lambda x: slope(x, n) ** 2, 0, LENGTH / 2, epsabs=1e-13)[0] - n

    n = brentq(lack, 1e-9 * EA, 1e-2 * EA, xtol=1e-10)
    return n, quad(slope, 0, LENGTH / 2, args=(n,), epsabs=1e-13)[0]


@pytest.mark.parametrize("force", [0.05, 1.0, 20.0])  # from a beam (deflection a tenth of the height) to a cable
def test_strip_between_pins_becomes_a_cable(force):
    tension, deflection = tension_of(force)
    result = analyse(between_pins(force))
    found = result.data["deflection"].sel(member="beam.left", component="y").isel(theta=0, s=-1).item()
    assert found == pytest.approx(deflection, rel=2e-4)  # 32 elements, mean strain in each: h^2
    axial = result.data["axial_force"].sel(member="beam.left").isel(theta=0).to_numpy()
    assert axial == pytest.approx(tension, rel=4e-4)
    # moment at the middle: half the force at the distance to the pin, less the tension on its arm
    moment = result.data["moment"].sel(member="beam.left").isel(theta=0, s=-1).item()
    assert moment == pytest.approx(-force * LENGTH / 4 + tension * deflection, rel=2e-3)


def test_error_of_the_strip_falls_with_the_square_of_the_element_length():
    _, deflection = tension_of(5.0)
    errors = []
    for elements in (4, 8, 16):
        data = analyse(between_pins(5.0, elements)).data
        errors.append(abs(data["deflection"].sel(member="beam.left", component="y").isel(theta=0, s=-1) - deflection))
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert (rates > 1.8).all()


def test_small_loads_leave_the_linear_answer():
    small = 1e-6
    linear, bent = (
        analyse(between_pins(small, effects=effects)).data["deflection"].to_numpy()
        for effects in ((), ("moderate-rotations",))
    )
    assert np.abs(bent - linear).max() < 1e-8 * np.abs(linear).max()


@pytest.mark.parametrize(("elements", "bound"), [(3, 0.02), (4, 0.005), (6, 0.004)])
def test_seed_mechanism_agrees_with_geometrically_exact_beams(seed, elements, bound):
    exact = pd.read_csv("tests/data/seed_exact.csv", comment="#")
    scene = seed.changed(
        effects=("coupling", "moderate-rotations"),
        damping__ratio=0.0,
        damping__material=1.339e-4,
        mesh__elements=elements,
        analysis__sub_intervals=120,
    )
    result = analyse(scene)
    for member in ("coupler", "follower"):
        for fibre, name in (("+", "plus"), ("-", "minus")):
            curve = exact[f"{member}_{name}"].to_numpy()
            found = result.strain_at(member, fibre=fibre)
            assert np.abs(found - curve[::3]).max() < bound * np.abs(curve).max()
