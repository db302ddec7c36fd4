"""Blocks that slide along members that bend, and turn with them, against closed forms."""

import numpy as np
import pytest

from fenics_mech import Scene, analyse
from fenics_mech.machine.from_scene import machine_of

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
    way = np.diff(data["point_position_bent"].sel(point=["block.P", "block.Q"]).to_numpy(), axis=1)[:, 0] @ [
        [np.cos(ANGLE), -np.sin(ANGLE)],
        [np.sin(ANGLE), np.cos(ANGLE)],
    ]
    return np.arctan2(way[:, 1], way[:, 0])


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
    assert moment == pytest.approx(wanted if ends[0] == "A" else -wanted, abs=1e-6 * COUPLE)


def test_block_that_turns_far():
    """A couple bends a clamped beam to a circle, by 100 degrees as far as to the block."""
    angle = np.radians(100)
    data = analyse(
        beam(True, law={"mean": 0.75}, load={"force": (0, 0), "moment": EI * angle / 0.75}, elements=16)
    ).data
    assert turned(data) == pytest.approx(angle, rel=2e-3)
    place = data["point_position_bent"].sel(point="block.P").to_numpy()
    across, along = (place @ [-np.sin(ANGLE), np.cos(ANGLE)], place @ [np.cos(ANGLE), np.sin(ANGLE)])
    radius = 0.75 / angle
    assert along == pytest.approx(radius * np.sin(angle), rel=2e-3)
    assert across == pytest.approx(radius * (1 - np.cos(angle)), rel=2e-3)


def test_drive_along_a_member():
    """It holds the load along the beam, which stretches between its support and the block."""
    pull = 3.0 * np.array([np.cos(ANGLE), np.sin(ANGLE)])
    data = analyse(beam(law={"mean": 0.5, "cosine": (0.2,)}, load={"force": tuple(pull)})).data
    assert data["drive_effort"].to_numpy() == pytest.approx(-3.0, rel=1e-4)
    stroke = 0.5 + 0.2 * np.cos(data["theta"].to_numpy())
    place = np.linalg.norm(data["point_position_bent"].sel(point="block.P"), axis=1)
    assert place - stroke == pytest.approx(3.0 * stroke / 2e5, abs=5e-7)  # without the stretch within its element


@pytest.mark.parametrize("elements", [5, 10])
def test_block_between_nodes(elements):
    """The element gives way under the block, without which the slope was 16 % and 9 % off."""
    data = analyse(beam(law={"mean": 0.5, "cosine": (0.3,)}, elements=elements)).data
    a = 0.5 + 0.3 * np.cos(data["theta"].to_numpy())
    assert turned(data) == pytest.approx(COUPLE * (a**3 + (1 - a) ** 3) / (3 * EI), rel=1e-8)


@pytest.mark.parametrize(("unknown", "step"), [("K", 1e-6), ("M", 1e-2)])
def test_tangents_under_a_block(unknown, step):
    """Also by the force and the couple that it exerts."""
    machine, rng = machine_of(beam(law={"mean": 0.34}, elements=3)).machine, np.random.default_rng(1)
    state = {name: scale * rng.normal(size=(1, machine.size)) for name, scale in (("K", 0.02), ("C", 1.0), ("M", 1.0))}
    found = machine.residual(np.zeros(1), *state.values())
    tangent = machine.pattern.matrix(getattr(found, unknown)[0]).toarray()
    differences = np.empty_like(tangent)
    for k in range(machine.size):
        sides = []
        for change in (step, -step):
            beside = {name: x.copy() for name, x in state.items()}
            beside[unknown][0, k] += change
            sides.append(machine.residual(np.zeros(1), *beside.values(), tangents=False).force[0])
        differences[:, k] = (sides[0] - sides[1]) / (2 * step)
    rides = slice(machine.n + len(machine.rows), None)
    for part in (np.s_[rides], np.s_[:, rides], np.s_[:]):
        assert tangent[part] == pytest.approx(differences[part], abs=1e-8 * np.abs(differences[part]).max())
