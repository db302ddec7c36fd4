"""Lumped mass: the known frequencies of a chain of lumps, convergence, and consistency of what lumps feel."""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from tests.common import modes_of

E, RHO, LENGTH, AREA, INERTIA = 71e9, 2714.0, 0.4, 4e-5, 8.7e-12
SIMPLY = {"A": {"connect": ("ground.A", "beam.A")}, "C": {"kind": "slot", "connect": ("ground.C", "beam.C")}}
STRIP = {"area": AREA, "inertia": INERTIA, "fibre": 8e-4}


def beam(elements, section=STRIP, effects=("lumped-mass",)):
    return Scene.read(
        {
            "materials": {"aluminium": {"modulus": E, "density": RHO}},
            "sections": {"it": section},
            "ground": {"points": {"A": (0, 0), "C": (LENGTH, 0)}},
            "links": {
                "beam": {
                    "points": {"A": (0, 0), "C": (LENGTH, 0)},
                    "members": {"AC": {"ends": ("A", "C"), "section": "it", "material": "aluminium"}},
                }
            },
            "joints": SIMPLY,
            "mesh": {"elements": elements},
            "analysis": {"method": "quasi-static", "modes": 3},
            "effects": effects,
        }
    )


def omega(scene):
    return np.sort(modes_of(scene).modes.omega[0])


def of_lumps(elements, count=3):
    """Frequencies (rad/s) of equal lumps on a massless simply supported beam: w_j = sin j k, phi_j = cos j k.

    Every inner node has the same two equations (in w and h phi), from the stiffness (7.2) of the elements beside it,
    the mass rho A h and the moment of inertia rho A h^3/39. The lower root is the bending mode.
    """
    h, k = LENGTH / elements, np.arange(1, count + 1) * np.pi / elements
    a, b, d = 24 * (1 - np.cos(k)), -12 * np.sin(k), 39 * (8 + 4 * np.cos(k))
    b2 = 39 * b**2
    root = 2 * (a * d - b2) / (a + d + np.sqrt((a - d) ** 2 + 4 * b2))
    return np.sqrt(root * E * INERTIA / (RHO * AREA * h**4))


@pytest.mark.parametrize("elements", [4, 9])
def test_frequencies_of_a_chain_of_lumps(elements):
    assert np.allclose(omega(beam(elements)), of_lumps(elements), rtol=1e-8)  # the eigensolver's round-off


def test_frequencies_converge_from_below_with_the_square_of_the_element_size():
    truth = (np.arange(1, 4) * np.pi / LENGTH) ** 2 * np.sqrt(E * INERTIA / (RHO * AREA))
    coarse, fine = (omega(beam(n)) / truth - 1 for n in (12, 24))
    assert np.all(fine < 0)  # the lumps' moments of inertia
    assert np.all(np.abs(np.log2(coarse / fine) - 2) < 0.1)
    h = LENGTH / 24
    assert np.allclose(fine, -((np.arange(1, 4) * np.pi / LENGTH) ** 2) * h**2 / 78, rtol=0.03)  # -(k r)^2/2


def test_rigid_inertia_and_section_forces_are_those_of_the_lumps():
    analysis = {"method": "quasi-static", "sub_intervals": 12, "stations": 49, "allow_coarse": True}
    consistent = analyse(seed_four_bar(analysis=analysis))
    alpha = solve_motion(consistent.scene, consistent.data["theta"].to_numpy()).alpha[:, 1]
    errors = []
    for elements in (4, 8):
        scene = seed_four_bar(effects=("lumped-mass",), mesh={"elements": elements}, analysis=analysis)
        lumped = analyse(scene)
        kinks = np.diff(lumped.data["moment"], n=2, axis=-1)  # inside elements the moment runs straight
        step = 48 // elements
        inside = np.isin(np.arange(1, 48) % step, (0, 1, step - 1), invert=True)  # it jumps by the lumps' own moment
        peak = float(np.abs(lumped.data["moment"]).max())
        assert np.abs(kinks[..., inside]).max() < 1e-10 * peak
        assert np.abs(kinks).max() > 1e-3 * peak
        for s, sign in ((0, 1), (1, -1)):  # beside a pin there is the moment that turns the lump there
            lump = RHO * 4.06e-5 * (0.2794 / elements) ** 3 / 78
            moment = lumped.data["moment"].sel(member="coupler", s=s)
            assert np.allclose(moment, sign * lump * alpha, rtol=0, atol=1e-10 * peak)
        change = lumped.data["joint_force"] - consistent.data["joint_force"]
        errors.append(float(np.abs(change).max() / np.abs(consistent.data["joint_force"]).max()))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1)
    assert errors[1] < 0.01


def test_collocation_takes_lumps_and_sections_that_turn():
    analysis = {"sub_intervals": 48, "solver": "collocation", "stability": False, "allow_coarse": True}
    given = {"effects": ("coupling", "lumped-mass", "rotary-inertia"), "damping": {"material": 2e-4}}
    lumped = analyse(seed_four_bar(analysis=analysis, mesh={"elements": 8}, **given))
    consistent = analyse(seed_four_bar(analysis=analysis, **given | {"effects": ("coupling", "rotary-inertia")}))
    peak = float(np.abs(consistent.data["moment"]).max())
    assert np.abs(lumped.data["moment"] - consistent.data["moment"]).max() < 0.05 * peak  # as near as 8 lumps come
