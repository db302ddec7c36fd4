"""Beams that bend beyond the rotation of one frame: links in series whose frames stand along the bent axis."""

import numpy as np
import pytest
from scipy.special import ellipe, ellipj, ellipk

from fenics_mech.analysis import analyse
from fenics_mech.scene import Scene
from tests.effects import strips

THIN = strips.INERTIA / 10  # m^4: the Euler load stretches it by 5e-7
EI = strips.E * THIN
STIFF = 1e8  # EI/L of the springs that join the links: a hundred-millionth of the turn is theirs


def chain(angles, load):
    """A cantilever of length L cut into equal links at rough angles, which torsional springs hold in line."""
    length, count = strips.L / len(angles), len(angles)
    member = {"ends": ("A", "B"), "section": "strip", "material": "aluminium"}
    bar = {"points": {"A": (0, 0), "B": (length, 0)}, "members": {"AB": member}}
    before = ["ground.O", *(f"b{k}.B" for k in range(count - 1))]
    return Scene.read(
        {
            "materials": {"aluminium": {"modulus": strips.E, "density": strips.RHO}},
            "sections": {"strip": {"area": strips.A, "inertia": THIN, "fibre": 8e-4}},
            "ground": {"points": {"O": (0, 0)}},
            "links": {f"b{k}": bar | {"angle": float(angle)} for k, angle in enumerate(angles)},
            "joints": {f"J{k}": {"connect": (before[k], f"b{k}.A")} for k in range(count)},
            "springs": {
                f"J{k}": {"joint": f"J{k}", "stiffness": STIFF * EI / strips.L, "angle": 0.0} for k in range(count)
            },
            "loads": {"tip": {"at": f"b{count - 1}.B"} | load},
            "effects": ("large-rotations",),
            "mesh": {"elements": 8},
            "analysis": {"method": "static", "stations": 3},
        }
    )


def tip(angles, data):
    """Place of the tip over the length."""
    rigid = np.array([np.cos(angles).sum(), np.sin(angles).sum()]) / len(angles)
    return rigid + data["deflection"].isel(theta=0, member=-1, s=-1).to_numpy() / strips.L


@pytest.mark.parametrize("turn", [2.0, np.pi, 2 * np.pi])
def test_a_moment_bends_a_cantilever_up_to_a_full_circle(turn):
    angles = (np.arange(6) + 0.5) * turn / 6
    data = analyse(chain(angles, {"moment": turn * EI / strips.L})).data
    expected = np.array([np.sin(turn), 1 - np.cos(turn)]) / turn
    assert tip(angles, data) == pytest.approx(expected, abs=1e-6)  # 1e-7 by the mesh
    assert data["moment"].to_numpy() * strips.L / EI == pytest.approx(turn, rel=5e-6)
    assert data["rotation"].max() < 0.6


@pytest.mark.parametrize("turn", [1.0, 2.0, 2.5])
def test_a_strut_far_beyond_buckling_is_the_elastica(turn):
    """Half of a strut on two pins: ``P L^2/EI = K^2`` at the turn of its end (Timoshenko and Gere, section 2.7)."""
    parameter = np.sin(turn / 2) ** 2
    whole, second = ellipk(parameter), ellipe(parameter)
    places = (np.arange(6) + 0.5) / 6
    angles = np.round(2 * np.arcsin(np.sqrt(parameter) * ellipj(places * whole, parameter)[0]), 2)
    force = whole**2 * EI / strips.L**2
    data = analyse(chain(angles, {"force": (-force, 0)})).data
    expected = np.array([2 * second / whole - 1, 2 * np.sqrt(parameter) / whole])
    # the closed form has no stretch, 4e-7 to 9e-7 here; it shortens the way to the tip
    assert tip(angles, data) == pytest.approx(expected, abs=2e-6)
    moment = data["moment"].isel(theta=0, member=0, s=0).item()
    assert abs(moment) == pytest.approx(force * strips.L * expected[1], rel=5e-6)


def test_one_frame_bends_into_an_arc():
    data = analyse(chain(np.array([0.0]), {"moment": 1.4 * EI / strips.L})).data
    moved = data["deflection"].isel(theta=0, member=0, s=-1).to_numpy() / strips.L
    assert moved == pytest.approx([np.sin(1.4) / 1.4 - 1, (1 - np.cos(1.4)) / 1.4], abs=2e-6)
