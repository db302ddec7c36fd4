"""Shear flexibility: exact stiffness, Timoshenko's frequencies, shear factors, and what is missing is said."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from tests.effects.test_rotary_inertia import bending

E, RHO, NU, LENGTH = 210e9, 7850.0, 0.3, 0.8
G = E / (2 * (1 + NU))
STEEL = {"modulus": E, "density": RHO, "poisson": NU}
WELD = {"A": {"kind": "weld", "connect": ("ground.A", "beam.A")}}
SIMPLY = {"A": {"connect": ("ground.A", "beam.A")}, "C": {"kind": "slot", "connect": ("ground.C", "beam.C")}}
COWPER = 10 * (1 + NU) / (12 + 11 * NU)  # of a rectangle


def beam(elements, section, joints, *, effects=("shear",), steel=None, **rest):
    """Make a straight beam A-C that nothing drives."""
    return Scene.read(
        {
            "materials": {"steel": steel or STEEL},
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
            "analysis": {"method": "static", "modes": 3, "stations": 9},
            "effects": effects,
        }
        | rest
    )


def rectangle(slenderness):
    """Section of a beam of this length over its radius of gyration."""
    height = np.sqrt(12) * LENGTH / slenderness
    return {"shape": "rectangle", "width": height / 2, "height": height}


def rigidities(section):
    """EI and G A_s of a rectangle."""
    area = section["width"] * section["height"]
    return E * area * section["height"] ** 2 / 12, COWPER * G * area


@pytest.mark.parametrize("elements", [1, 4])
@pytest.mark.parametrize("slenderness", [5, 1e5])
def test_cantilever_under_an_end_load_is_exact_with_one_element(elements, slenderness):
    section = rectangle(slenderness)
    ei, gas = rigidities(section)
    force = -1e-6 * ei / LENGTH**2
    loads = {"tip": {"at": "beam.C", "force": (0, force)}}
    data = analyse(beam(elements, section, WELD, loads=loads)).data.isel(theta=0, member=0)
    x = data["s"].to_numpy() * LENGTH
    expected = force * (LENGTH * x**2 / 2 - x**3 / 6) / ei + force * x / gas  # F L^3/3EI + F L/(k G A) at the tip
    assert np.allclose(data["deflection"].sel(component="y"), expected, rtol=0, atol=1e-9 * np.abs(expected).max())
    assert np.allclose(data["moment"], force * (LENGTH - x), rtol=0, atol=1e-9 * abs(force) * LENGTH)
    assert np.allclose(data["shear_force"], -force, rtol=1e-9)


@pytest.mark.parametrize("elements", [1, 2])
def test_a_line_load_is_exact_at_the_nodes_and_between(elements):
    # clamped at A, on a roller at C: the shear changes the roller's force
    section = rectangle(5)
    ei, gas = rigidities(section)
    snow = {"snow": {"member": "beam", "line": (0, -100.0), "line_end": (0, -40.0)}}
    scene = beam(elements, section, WELD | {"C": SIMPLY["C"]}, loads=snow)
    data = analyse(scene).data.isel(theta=0, member=0)
    x = data["s"].to_numpy() * LENGTH
    load = np.polynomial.Polynomial([-100.0, 60.0 / LENGTH])
    # Q = c + int q, M = m + int Q, with w' = phi + shear angle; Q is dM/dx here and pushes -Q/(G A_s)
    unit = [np.polynomial.Polynomial([0, 1.0]), np.polynomial.Polynomial([1.0])]  # moments of c and m
    parts = [(load.integ(2), load.integ(1)), (unit[0], np.polynomial.Polynomial([1.0])), (unit[1], 0 * unit[0])]
    shapes = [moment.integ(2) / ei - shear.integ() / gas for moment, shear in parts]
    moments = [moment for moment, _ in parts]
    ends = np.array([[f(LENGTH) for f in shapes[1:]], [f(LENGTH) for f in moments[1:]]])
    c, m = np.linalg.solve(ends, [-shapes[0](LENGTH), -moments[0](LENGTH)])
    deflection, moment = (f[0](x) + c * f[1](x) + m * f[2](x) for f in (shapes, moments))
    found = data["deflection"].sel(component="y")
    assert np.allclose(found, deflection, rtol=0, atol=1e-10 * np.abs(deflection).max())
    assert np.allclose(data["moment"], moment, rtol=0, atol=1e-9 * np.abs(moment).max())


def timoshenko(slenderness, count=3):
    """Exact frequencies (rad/s) of a simply supported beam: the lower root of (Timoshenko 1921), w = sin(n pi x/L)."""
    ratio, r2 = E / (COWPER * G), (LENGTH / slenderness) ** 2
    q2 = (np.arange(1, count + 1) * np.pi / LENGTH) ** 2
    a, b, c = r2 * RHO * ratio / E, 1 + r2 * q2 * (1 + ratio), E / RHO * r2 * q2**2
    return np.sqrt(2 * c / (b + np.sqrt(b**2 - 4 * a * c)))


def frequencies(elements, slenderness, effects=("rotary-inertia", "shear")):
    """Frequencies (rad/s) of the three first modes that move across."""
    return bending(beam(elements, rectangle(slenderness), SIMPLY, effects=effects).changed(analysis__modes=9))[:3]


@pytest.mark.parametrize("slenderness", [1e3, 1e5])
def test_frequencies_of_thin_beams_converge_with_the_fourth_power_and_do_not_lock(slenderness):
    coarse, fine = (frequencies(n, slenderness) / timoshenko(slenderness) - 1 for n in (4, 8))
    assert np.all(fine > 0)  # Rayleigh: from above
    assert np.all(fine < 1.5e-3)  # as without shear: a beam that locks would be far too stiff
    assert np.all(np.abs(np.log2(coarse / fine) - 4) < 0.2)


def test_frequencies_of_thick_beams_converge_with_the_square():
    """Inside an element the shear force is constant, and sections turn linearly: both are errors of order 2."""
    whole = [frequencies(n, 10) / timoshenko(10) - 1 for n in (16, 32)]
    assert np.all(np.abs(np.log2(whole[0] / whole[1]) - 2) < 0.05)
    assert np.all(whole[1] < 4e-3)
    assert np.all(whole[1] > 0)


def test_timoshenkos_frequencies_are_those_of_bernoulli_and_euler_for_thin_beams():
    classic = (np.arange(1, 4) * np.pi / LENGTH) ** 2 * np.sqrt(E / RHO) * LENGTH / 1e5
    assert np.allclose(timoshenko(1e5), classic, rtol=1e-7)  # (n pi r/L)^2 apart
    assert timoshenko(10)[0] / ((np.pi / LENGTH) ** 2 * np.sqrt(E / RHO) * LENGTH / 10) < 0.86  # and far from it here


def shear_stiffness(section, steel=None, **materials):
    scene = beam(1, section, WELD, steel=steel, effects=(), materials={"steel": steel or STEEL} | materials)
    return float(scene.shear_stiffness("beam", np.array([0.5]))[0])


FACTORS = [  # section, area, Cowper's shear factor for a Poisson ratio of 0.3
    ({"shape": "rectangle", "width": 0.02, "height": 0.05}, 1e-3, 0.8497),
    ({"shape": "round", "diameter": 0.02}, np.pi * 1e-4, 0.8864),
    ({"shape": "tube", "diameter": 0.02, "thickness": 1e-8}, np.pi * 2e-10, 0.5306),
    ({"shape": "tube", "diameter": 0.02, "thickness": 0.01}, np.pi * 1e-4, 0.8864),
    ({"shape": "I", "height": 0.1, "width": 1e-3, "flange": 1e-9, "web": 1e-3}, 1e-4, 0.8497),  # no flanges
    ({"shape": "custom", "area": 2e-4, "inertia": 1e-9, "fibre": 0.01, "shear_factor": 0.4}, 2e-4, 0.4),
    ({"shape": "variable", "area": "1e-4*(1+2*s)", "inertia": 1e-9, "fibre": 0.01, "shear_factor": 0.7}, 2e-4, 0.7),
    ({"shape": "rectangle", "width": 0.02, "height": 0.05, "shear_factor": 0.8}, 1e-3, 0.8),
]


@pytest.mark.parametrize(("section", "area", "factor"), FACTORS)
def test_shear_factors_are_cowpers_or_stated(section, area, factor):
    assert shear_stiffness(section) == pytest.approx(G * area * factor, rel=1e-4)  # printed to 4 digits


def test_shear_factor_of_an_i_is_about_its_web():
    section = {"shape": "I", "height": 0.2, "width": 0.1, "flange": 8e-3, "web": 5e-3}
    assert shear_stiffness(section) == pytest.approx(G * 5e-3 * (0.2 - 8e-3), rel=0.06)


def test_a_shear_modulus_of_its_own_goes_with_the_factor_for_no_lateral_contraction():
    section = {"shape": "rectangle", "width": 0.02, "height": 0.05}
    wood = {"modulus": 11e9, "density": 500, "shear_modulus": 0.7e9}
    assert shear_stiffness(section, wood) == pytest.approx(0.7e9 * 1e-3 * 5 / 6, rel=1e-12)


def test_a_laminate_of_one_material_has_the_factor_five_sixths():
    plies = [{"thickness": t, "material": "steel"} for t in (1e-3, 4e-3, 2e-3)]
    found = shear_stiffness({"shape": "laminate", "width": 0.02, "plies": plies})
    assert found == pytest.approx(G * 0.02 * 7e-3 * 5 / 6, rel=1e-12)


def test_a_sandwich_shears_in_its_core():
    plies = [{"thickness": t, "material": m} for t, m in ((1e-3, "steel"), (2e-2, "foam"), (1e-3, "steel"))]
    foam = {"modulus": 7e7, "density": 50, "shear_modulus": 2e7}
    found = shear_stiffness({"shape": "laminate", "width": 0.05, "plies": plies}, foam=foam)
    expected = 2e7 * 0.05 * 0.021**2 / 0.02  # b G d^2/c, d between the middles of the faces: Allen (1969)
    assert found == pytest.approx(expected, rel=5e-3)


def test_a_polygon_has_the_stated_share_of_its_area():
    parts = [
        {"outline": [(0, 0), (0.02, 0), (0.02, 0.01), (0, 0.01)], "material": "steel"},
        {"outline": [(0.02, 0), (0.03, 0), (0.03, 0.01), (0.02, 0.01)], "material": "foam"},
    ]
    foam = {"modulus": 7e7, "density": 50, "shear_modulus": 2e7}
    found = shear_stiffness({"shape": "polygon", "parts": parts, "shear_factor": 0.5}, foam=foam)
    assert found == pytest.approx(0.5 * (G * 2e-4 + 2e7 * 1e-4), rel=1e-12)


def test_tip_of_a_wedge_converges():
    section = {"area": "2e-3*(1-s/2)", "inertia": "1e-6*(1-s/2)**3", "fibre": "0.05*(1-s/2)"}
    section = {"shape": "variable", "shear_factor": 0.8} | section
    s = (1 + np.polynomial.legendre.leggauss(40)[0]) / 2
    weight = np.polynomial.legendre.leggauss(40)[1] / 2
    by_bending = np.sum(weight * (1 - s) ** 2 / (1 - s / 2) ** 3) * LENGTH**3 / (E * 1e-6)
    expected = 1e3 * (by_bending + np.sum(weight / (1 - s / 2)) * LENGTH / (0.8 * G * 2e-3))
    errors = []
    for elements in (4, 8):
        data = analyse(beam(elements, section, WELD, loads={"tip": {"at": "beam.C", "force": (0, 1e3)}})).data
        errors.append(abs(float(data["deflection"].isel(theta=0, member=0, s=-1)[1]) / expected - 1))
    # the shear angle of an element is constant, that of a wedge is not: its own part falls with h^2
    assert np.log2(errors[0] / errors[1]) > 1.9
    assert errors[1] < 5e-5  # shear gives 8e-3 of the deflection


def test_a_taper_needs_shear_factors_at_both_ends_or_none():
    scene = beam(1, rectangle(10), WELD)
    half = rectangle(20) | {"shear_factor": 0.8}
    sections = {"it": {"shape": "taper", "from": "a", "to": "b"}, "a": rectangle(10), "b": half}
    with pytest.raises(SceneError, match="only one of its two sections"):
        scene.changed(sections=sections)
    scene.changed(sections=sections | {"a": rectangle(10) | {"shear_factor": 0.9}})
