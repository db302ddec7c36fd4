"""Members that are tapered, deep, laminated or beside their axis, against linkages in link frames."""

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.geometry import PLANE
from fenics_mech.machine import Machine
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.machine.section_forces import end_forces
from fenics_mech.solve import equilibrium, periodic, rigid_cycle
from tests.common import DEMOS
from tests.machine.builders import load

STEPS, FINE = 120, 240  # of the machine, and positions of the linkage
RECTANGLE = {"shape": "rectangle", "width": "25 mm"}
PLIES = [{"thickness": "0.8 mm", "material": name} for name in ("aluminium", "heavy")]
SECTIONS = [f"links.{member}.section" for member in ("crank.members.OA", "coupler.members.AB", "follower.members.CB")]
CASES = {
    "taper": {
        "sections.thick": RECTANGLE | {"height": "2.4 mm"},
        "sections.thin": RECTANGLE | {"height": "1.4 mm"},
        "sections.cone": {"shape": "taper", "from": "thick", "to": "thin"},
        "links.coupler.members.AB.section": "cone",
    },
    "deep": {
        "sections.deep": {"shape": "rectangle", "width": "8 mm", "height": "60 mm"},
        **dict.fromkeys(SECTIONS, "deep"),
        "effects": ("coupling", "large-rotations", "shear", "rotary-inertia"),
    },
    "beside its axis": {"links.coupler.members.AB.offset": "2 mm", "drive.speed": "20 rad/s"},
    "mass and stiffness beside each other": {
        "materials.heavy": {"modulus": "10 GPa", "density": "7000 kg/m^3"},
        "sections.two": {"shape": "laminate", "width": "25 mm", "plies": PLIES},
        "links.coupler.members.AB": {"ends": ["A", "B"], "section": "two"},
        "drive.speed": "14 rad/s",
    },
}


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
def test_moments_of_other_sections_are_those_of_link_frames(case):
    """0.2 % of the largest: 3 elements a member differ by it without any of these, and each moves it by 5 % or more."""
    numbers = {"analysis.sub_intervals": FINE, "analysis.stations": 21}
    exact = {"effects": ("coupling", "large-rotations"), "damping": {"material": 1e-4}}
    scene = fm.load(DEMOS / "four_bar.toml").changed(exact | numbers | CASES[case])
    made = machine_of(scene)
    machine, mesh = made.machine, made.links.mesh
    machine.chart = rigid_cycle(machine, scene.period)
    cycle = periodic(machine, scene.period, STEPS)
    ends = end_forces(machine.terms[0], machine.groups[0], cycle.evaluation.terms[0], cycle.evaluation.at)
    result = fm.analyse(scene).data
    positions = (np.arange(STEPS) + 1) * (FINE // STEPS) % FINE
    for number, member in enumerate(mesh.members):
        node = np.nonzero(mesh.cell_member == number)[0][0]
        place = float(mesh.cell_length[node]) / float(mesh.member_length[number])
        there = result["moment"].sel(member=member).interp(s=place).to_numpy()[positions]
        found = ends.moment[2::3, node, 1, 0]
        assert np.abs(found - there).max() < 3e-3 * np.abs(there).max(), member


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
