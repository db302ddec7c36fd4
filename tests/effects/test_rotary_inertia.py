"""Rotary inertia: Rayleigh's beam, its load and its place in the coupling, and recovery beside shear."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import bending, modes_of

E, RHO, LENGTH, SLENDERNESS = 210e9, 7850.0, 0.8, 12.0
HEIGHT = np.sqrt(12) * LENGTH / SLENDERNESS
WIDTH = HEIGHT / 2
THICK = {"shape": "rectangle", "width": WIDTH, "height": HEIGHT}
RHO_A, RHO_I = RHO * WIDTH * HEIGHT, RHO * WIDTH * HEIGHT**3 / 12
STEEL = {"modulus": E, "density": RHO, "poisson": 0.3}
SIMPLY = {"A": {"connect": ("ground.A", "beam.A")}, "C": {"kind": "slot", "connect": ("ground.C", "beam.C")}}
MOTOR = {"A": {"connect": ("ground.A", "beam.A")}}
SWING = {"joint": "A", "law": {"kind": "harmonics", "sine": [0.3]}, "period": 0.25}


def beam(elements, joints, *, section=THICK, effects=("rotary-inertia",), **rest):
    """Make a straight beam A-C."""
    analysis = {"method": "quasi-static", "modes": 3, "stations": 9, "sub_intervals": 8}
    return Scene.read(
        {
            "materials": {"steel": STEEL, "light": {"modulus": E / 4, "density": RHO / 3}},
            "sections": {"it": section},
            "ground": {"points": {"A": (0, 0), "C": (LENGTH, 0)}},
            "links": {
                "beam": {
                    "points": {"A": (0, 0), "C": (LENGTH, 0)},
                    "members": {"AC": {"ends": ("A", "C"), "section": "it", "material": "steel"}},
                }
            },
            "joints": joints,
            "mesh": {"elements": elements},
            "analysis": analysis | rest.pop("analysis", {}),
            "effects": effects,
        }
        | rest
    )


@pytest.mark.parametrize(("slenderness", "power", "largest"), [(10, 2, 2e-2), (1e3, 4, 5e-4)])
def test_frequencies_are_rayleighs_and_converge_by_how_slender_members_are(slenderness, power, largest):
    """Sections between nodes turn linearly by poses: of thick members that leaves the square of an element's length."""
    height = np.sqrt(12) * LENGTH / slenderness
    section = {"shape": "rectangle", "width": height, "height": height}
    r2, q = (LENGTH / slenderness) ** 2, np.arange(1, 4) * np.pi / LENGTH
    truth = q**2 * np.sqrt(E / RHO * r2 / (1 + r2 * q**2))  # w = sin q x in EI w'''' + rho A w.. - rho I w''.. = 0

    def omega(elements):  # without axial displacement, whose frequencies lie between those of a thick beam
        scene = beam(elements, SIMPLY, section=section, effects=("rotary-inertia",)).changed(analysis__modes="all")
        return np.array(bending(modes_of(scene))[:3])

    coarse, fine = (omega(n) / truth - 1 for n in (6, 12))
    assert np.all(fine > 0)
    assert np.all(fine < largest)
    assert np.all(np.abs(np.log2(coarse / fine) - power) < 0.2)


@pytest.mark.parametrize("effects", [("rotary-inertia",), ("rotary-inertia", "shear")])
@pytest.mark.parametrize("elements", [1, 3])
def test_an_arm_needs_the_torque_that_turns_its_sections_too(elements, effects):
    # the rigid motion alone: the moment of inertia about A is rho A L^3/3 + rho I L
    scene = beam(elements, MOTOR, effects=effects, drive=SWING)
    data = analyse(scene).data.sel(member="beam")
    alpha = -0.3 * (2 * np.pi / 0.25) ** 2 * np.sin(data["theta"].to_numpy())
    torque = (RHO_A * LENGTH**3 / 3 + RHO_I * LENGTH) * alpha
    assert np.allclose(data["input_torque"], torque, rtol=0, atol=1e-11 * np.abs(torque).max())
    x = data["s"].to_numpy() * LENGTH
    arm = RHO_A * (LENGTH**3 / 3 - x * LENGTH**2 / 2 + x**3 / 6) + RHO_I * (LENGTH - x)
    moment = -alpha[:, None] * arm
    assert np.allclose(data["moment"], moment, rtol=0, atol=1e-11 * np.abs(moment).max())
    shear = alpha[:, None] * RHO_A * (LENGTH**2 - x**2) / 2
    assert np.allclose(data["shear_force"], shear, rtol=0, atol=1e-11 * np.abs(shear).max())


@pytest.mark.parametrize("effects", [("rotary-inertia",), ("rotary-inertia", "shear")])
def test_deflection_inside_an_element_is_that_of_many_elements(effects):
    # sections turn linearly between the ends of an element: its error is of order 2, and is told
    one, two, many = (analyse(beam(n, MOTOR, effects=effects, drive=SWING)).data for n in (1, 2, 16))
    off = [float(np.abs(some["deflection"] - many["deflection"]).max()) for some in (one, two)]
    assert off[0] / off[1] == pytest.approx(4, rel=0.1)
    assert 0.8 < float(one["deflection_error"].max()) / off[0] < 1.3


@pytest.mark.long
def test_section_forces_go_on_from_element_to_element():
    # with all coupling terms in thick links: N, V and M on both sides of a node, and none at the pins. What is left out
    # of the inertia inside the elements would show as jumps.
    analysis = {"sub_intervals": 24, "solver": "collocation", "stations": 2001, "stability": False}
    effects = ("coupling", "rotary-inertia", "shear")
    scene = seed_four_bar(analysis=analysis, effects=effects, damping={"ratio": 0.02})
    data = scene.model_dump(by_alias=True)
    for section in data["sections"].values():
        section |= {"inertia": section["inertia"] * 400, "shear_factor": 0.8}  # L/r of 30
    for material in data["materials"].values():
        material["poisson"] = 0.3
    found = analyse(Scene.read(data)).data
    s = found["s"].to_numpy()
    for node in (1 / 3, 2 / 3):  # of three elements; no station is on it
        i = np.searchsorted(s, node)
        for name in ("axial_force", "shear_force", "moment"):
            value = found[name].to_numpy()
            left, right = (1.5 * value[..., a] - 0.5 * value[..., b] for a, b in ((i - 1, i - 2), (i, i + 1)))
            assert np.abs(left - right).max() < 1e-6 * np.abs(value).max(), name  # of the extrapolation
    peak = float(np.abs(found["moment"]).max())
    for member, end in (("crank", 1), ("coupler", 0), ("coupler", 1), ("follower", 0), ("follower", 1)):
        assert np.abs(found["moment"].sel(member=member, s=end)).max() < 1e-7 * peak


def rotary_inertia(section):
    return beam(1, SIMPLY, section=section).rigidity("beam", np.array([0.0, 0.5, 1.0])).rotary_inertia


def test_rotary_inertia_of_sections():
    assert np.allclose(rotary_inertia(THICK), RHO_I, rtol=1e-14)
    varying = {"shape": "variable", "area": 1e-4, "inertia": "1e-8*(1+s)", "fibre": 0.01}
    assert np.allclose(rotary_inertia(varying), RHO * 1e-8 * np.array([1, 1.5, 2]), rtol=1e-14)
    outline = [(0.1, 0), (0.1 + HEIGHT, 0), (0.1 + HEIGHT, WIDTH), (0.1, WIDTH)]
    assert np.allclose(rotary_inertia({"shape": "polygon", "outline": outline}), RHO_I, rtol=1e-10)


def test_rotary_inertia_of_composites_is_about_the_neutral_line():
    # a strip of steel and three of a quarter of its modulus and a third of its density, 1 mm each and 20 mm wide
    neutral = 19 / 14 * 1e-3
    second = 0.02 * (1e-9 / 12 + 1e-3 * ((np.arange(4) + 0.5) * 1e-3 - neutral) ** 2)
    expected = RHO * (second[0] + second[1:].sum() / 3)
    plies = [{"thickness": 1e-3, "material": "steel"}, {"thickness": 3e-3, "material": "light"}]
    sizes = ((0.0, 1e-3, "steel"), (1e-3, 4e-3, "light"))
    parts = [{"outline": [(a, 0), (b, 0), (b, 0.02), (a, 0.02)], "material": of} for a, b, of in sizes]
    assert np.allclose(rotary_inertia({"shape": "laminate", "width": 0.02, "plies": plies}), expected, rtol=1e-12)
    assert np.allclose(rotary_inertia({"shape": "polygon", "parts": parts}), expected, rtol=1e-9)


def test_a_hole_turns_with_no_inertia():
    frame = {"shape": "polygon", "outline": [(0, 0), (4e-2, 0), (4e-2, 4e-2), (0, 4e-2)]}
    holes = [[(1e-2, 1e-2), (3e-2, 1e-2), (3e-2, 3e-2), (1e-2, 3e-2)]]
    expected = RHO * (4e-2**4 - 2e-2**4) / 12
    assert np.allclose(rotary_inertia(frame | {"holes": holes}), expected, rtol=1e-10)
