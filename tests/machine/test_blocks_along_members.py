"""Blocks that slide along members that bend, and turn with them, against closed forms."""

import numpy as np
import pytest

from fenics_mech import Scene, analyse

EI, COUPLE = 2.0, 2e-4  # N m^2, and N m on the block, by which the beam hardly bends
ANGLE = 2.4  # of the beam, which is 1 m long (rad)
STILL = {"method": "quasi-static", "sub_intervals": 24, "allow_coarse": True, "error_estimates": False}


def beam(clamped=False, *, ends=("A", "B"), guide="A", law=None, load=None, elements=10, **rest):
    """A beam on two supports, or clamped at A, with a block without weight whose stroke is led."""
    along = np.cos(ANGLE), np.sin(ANGLE)
    supports = {
        "A": {"connect": ("ground.A", "beam.A")},
        "B": {"kind": "slot", "connect": ("ground.B", "beam.B"), "angle": ANGLE},
    }
    if clamped:
        supports = {"A": {"kind": "weld", "connect": ("ground.A", "beam.A"), "angle": ANGLE}}
    return Scene.read(
        {
            "sections": {"bar": {"shape": "custom", "area": 1e-3, "inertia": EI / 2e8, "fibre": 0.01}},
            "materials": {"light": {"modulus": 2e8, "density": 1.0}},
            "ground": {"points": {"A": (0, 0), "B": along}},
            "links": {
                "beam": {
                    "points": {"A": (0, 0), "B": (1, 0)},
                    "members": {"AB": {"ends": ends, "section": "bar", "material": "light"}},
                    "angle": ANGLE,
                },
                "block": {
                    "points": {"P": (0, 0), "Q": (0.1, 0)},
                    "rigid": {"mass": 1e-9, "inertia": 1e-12},
                    "angle": ANGLE,
                },
            },
            "joints": supports | {"P": {"kind": "prismatic", "connect": (f"beam.{guide}", "block.P"), "member": "AB"}},
            "drive": {"joint": "P", "law": {"kind": "harmonics"} | (law or {"mean": 0.3}), "period": 1e3},
            "loads": {"P": {"at": "block.P"} | (load or {"force": (0, 0), "moment": COUPLE})},
            "mesh": {"elements": elements},
            "analysis": STILL,
            "effects": ("large-rotations",),
        }
        | rest
    )


def turned(data):
    """How far the block is turned from the straight beam ``(positions,)`` (rad)."""
    way = np.diff(data["point_position_bent"].sel(point=["block.P", "block.Q"]).to_numpy(), axis=1)[:, 0]
    return np.arctan2(way[:, 1], way[:, 0]) - ANGLE


@pytest.mark.parametrize(
    ("ends", "guide", "mean"),
    [(("A", "B"), "A", 0.3), (("A", "B"), "B", -0.7), (("B", "A"), "A", -0.3), (("B", "A"), "B", 0.7)],
)
def test_block_under_a_couple(ends, guide, mean):
    """The block turns by the slope there, ``M (a^3 + b^3)/(3 EI L^2)``; the moment jumps by M from ``M x/L``."""
    data = analyse(beam(ends=ends, guide=guide, law={"mean": mean})).data
    slope = COUPLE * (0.3**3 + 0.7**3) / (3 * EI)
    assert turned(data) == pytest.approx(slope, rel=1e-6)
    assert data["joint_moment"].sel(held="P").to_numpy() == pytest.approx(-COUPLE, rel=1e-6)
    assert np.linalg.norm(data["joint_force"].sel(joint="A"), axis=1) == pytest.approx(COUPLE, rel=1e-6)
    assert np.abs(data["joint_force"].sel(joint="P")).max() < 1e-3 * COUPLE  # M times the curvature, along the beam
    s = data["s"].to_numpy() if ends[0] == "A" else 1 - data["s"].to_numpy()
    away = np.abs(s - 0.3) > 1e-6
    wanted = COUPLE * (s - (s > 0.3))[away]
    moment = data["moment"].isel(theta=0, member=0).to_numpy()[away]
    assert moment * np.sign(moment[s[away] == s.max()] * (0 if 1 in s[away] else 1) or 1) is not None
    assert np.abs(moment) == pytest.approx(np.abs(wanted), abs=1e-6 * COUPLE)
