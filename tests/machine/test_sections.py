"""Members that are deep."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import equilibrium
from tests.common import DEMOS
from tests.machine.builders import load

STEPS, FINE = 120, 240  # of the machine, and positions of the linkage
RECTANGLE = {"shape": "rectangle", "width": "25 mm"}
PLIES = [{"thickness": "0.8 mm", "material": name} for name in ("aluminium", "heavy")]
SECTIONS = [f"links.{member}.section" for member in ("crank.members.OA", "coupler.members.AB", "follower.members.CB")]


def test_shear_bends_a_deep_cantilever():
    """P L^3/(3 E I) + P L/(kappa G A), kappa of Cowper: the element's numbers come from the UFL form of shear."""
    deep = {
        "sections.deep": {"shape": "rectangle", "width": "8 mm", "height": "60 mm"},
        **dict.fromkeys(SECTIONS, "deep"),
    }
    made = machine_of(fm.load(DEMOS / "four_bar.toml").changed(deep | {"effects": ("shear",)}))
    element = made.machine.terms[0].elements[3]
    machine, axes, force = Machine(PLANE), np.eye(2), 10.0
    root = machine.add_pose(np.zeros(2), axes, fixed="place and turn")
    tip = machine.add_pose(np.array([element.length, 0.0]), axes)
    machine.add_beams([(machine.end(root, np.zeros(2), axes), machine.end(tip, machine.r[tip], axes))], [element])
    load(machine, machine.end(tip), 1, force)
    q, _ = equilibrium(machine)
    E, b, h, nu, L = 71e9, 8e-3, 60e-3, 0.3, element.length
    shear = L / (10 * (1 + nu) / (12 + 11 * nu) * E / (2 * (1 + nu)) * b * h)
    bending = L**3 / (3 * E * b * h**3 / 12)
    assert shear > 0.2 * bending
    assert q[machine.places[tip, 1]] == pytest.approx(force * (bending + shear), rel=1e-6)
