"""A planar machine that is stated in space against the planar product, which has its own scene, mesh and recovery."""

import numpy as np
import pytest

import fenics_mech as fm
from tests.common import DEMOS
from tests.space.machines import ORIGIN, X, Z, body, place, scene

ELEMENTS, ALUMINIUM = 4, {"modulus": 71e9, "density": 2714.0, "poisson": 0.3}
STRIP = {"shape": "rectangle", "width": 25.4e-3, "height": 1.6e-3}
BAR = {"shape": "rectangle", "width": 25.4e-3, "height": 4e-3}


def planar(name, speed, positions, sections):
    """Give a planar demo with rectangles, exact strains and rotary inertia, and damping of its material."""
    analysis = {"method": "periodic", "solver": "poses", "stages": 3, "sub_intervals": positions, "allow_coarse": True}
    return fm.load(DEMOS / f"{name}.toml").changed(
        {
            "sections": sections,
            "effects": ("large-rotations", "rotary-inertia"),
            "damping": {"material": 5e-4},
            "mesh": {"elements": ELEMENTS},
            "analysis": analysis | {"error_estimates": False, "stations": 11},
            "drive.speed": speed,
        }
    )


def beam(ends, first, last, section):
    """Give a link of one member whose height lies in the plane, as that of a planar scene does."""
    one, other = ends
    up = np.cross(Z, np.asarray(last) - np.asarray(first))
    member = {"ends": (one, other), "section": section, "material": "made", "up": place(up)}
    return {"points": {one: place(first), other: place(last)}, "members": {one + other: member}}


def meeting(first, second, from_first, from_second):
    """Give the place at distances from two places, on the left of the way from the first to the second."""
    first, second = np.asarray(first), np.asarray(second)
    way, d = second - first, float(np.linalg.norm(second - first))
    along = (from_first**2 - from_second**2 + d * d) / (2 * d)
    up = np.cross(Z, way / d)
    return first + along * way / d + np.sqrt(from_first**2 - along**2) * up


def four_bar(speed, positions):
    A, C = np.array([4.25 * 0.0254, 0, 0]), np.array([10 * 0.0254, 0, 0])
    B = meeting(A, C, 11 * 0.0254, 10.65 * 0.0254)
    return scene(
        {
            "crank": beam("OA", ORIGIN, A, "crank"),
            "coupler": beam("AB", A, B, "strip"),
            "follower": beam("CB", C, B, "strip"),
        },
        {
            "O": {"connect": ("ground.O", "crank.O"), "axis": Z},
            "A": {"connect": ("crank.A", "coupler.A"), "axis": Z},
            "B": {"connect": ("coupler.B", "follower.B"), "axis": Z},
            "C": {"connect": ("ground.C", "follower.C"), "axis": Z},
        },
        materials={"made": ALUMINIUM},
        sections={"crank": BAR, "strip": STRIP},
        ground={"points": {"O": ORIGIN, "C": place(C)}},
        masses={"A": {"at": "crank.A", "mass": 45.2e-3}, "B": {"at": "follower.B", "mass": 37.55e-3}},
        drive={"joint": "O", "speed": speed},
        damping={"material": 5e-4},
        mesh={"elements": ELEMENTS},
        analysis={"positions": positions, "modes": 0},
    )


def slider_crank(speed, positions):
    """The slider is a rigid body of the demo's mass."""
    A, G = np.array([60e-3, 0, 0]), np.array([0, 10e-3, 0])
    B = np.array([60e-3 + np.sqrt(0.3**2 - 0.01**2), 10e-3, 0])
    return scene(
        {
            "crank": beam("OA", ORIGIN, A, "bar"),
            "rod": beam("AB", A, B, "strip"),
            "slider": body({"B": B}, 120e-3, (0, 0, 0), B),
        },
        {
            "O": {"connect": ("ground.O", "crank.O"), "axis": Z},
            "A": {"connect": ("crank.A", "rod.A"), "axis": Z},
            "pin": {"connect": ("slider.B", "rod.B"), "axis": Z},
            "B": {"connect": ("ground.G", "slider.B"), "kind": "slider", "axis": X},
        },
        materials={"made": ALUMINIUM},
        sections={"bar": BAR, "strip": STRIP},
        ground={"points": {"O": ORIGIN, "G": place(G)}},
        masses={"A": {"at": "crank.A", "mass": 30e-3}},
        drive={"joint": "O", "speed": speed},
        damping={"material": 5e-4},
        mesh={"elements": ELEMENTS},
        analysis={"positions": positions, "modes": 0},
    )


def differences(flat, deep, stations):
    """Give how far both answers differ at some stations, by name, relative to the largest value."""
    joints = [str(name) for name in flat["joint"].values if name in deep["joint"].values]
    pairs = {
        "torque": (np.ravel(flat["input_torque"]), np.ravel(deep["input_torque"])),
        "joint force": (flat["joint_force"].sel(joint=joints), deep["joint_force"].sel(joint=joints)[..., :2]),
    }
    one, other = flat.isel(s=stations), deep.isel(s=stations)
    pairs |= {
        "moment": (one["moment"], other["section_moment"][..., 2]),
        "axial force": (one["axial_force"], other["section_force"][..., 0]),
        # in the plane it is the slope of the moment, in space what the further part exerts
        "shear force": (one["shear_force"], -other["section_force"][..., 1]),
        "deflection": (one["deflection"], other["deflection"][..., :2]),
        "strain": (one["strain"], other["strain"][..., [0, 3]]),
        "stress": (one["stress"], other["stress"][..., [0, 3]]),
    }
    return {
        name: float(np.abs(np.asarray(a) - np.asarray(b)).max() / np.abs(np.asarray(a)).max())
        for name, (a, b) in pairs.items()
    }


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "build", "speed", "sections"),
    [
        ("four_bar", four_bar, 20.0, {"crank": BAR, "strip": STRIP}),
        ("slider_crank", slider_crank, 60.0, {"bar": BAR, "strip": STRIP}),
    ],
)
def test_a_planar_machine_is_the_same_in_space(name, build, speed, sections):
    """All is equal at the nodes; within an element the plane adds how inertia bends it, and space draws the cubic.

    That makes up to 1.2e-3 of the deflections of four elements, and falls with their fourth power. The moments of
    inertia on either axis differ by 4e-5 of the largest moment, and shear forces by 1e-4.
    """
    flat = fm.analyse(planar(name, speed, 60, sections)).data
    deep = fm.analyse(build(speed, 60)).data
    at_nodes = differences(flat, deep, [0, 5, 10])
    assert max(at_nodes.values()) < 1e-5, at_nodes  # strains at pins, which are 0 but for rounding of both recoveries
    assert max(at_nodes[key] for key in ("torque", "joint force", "deflection", "axial force")) < 1e-8
    between = differences(flat, deep, slice(None))
    assert between["deflection"] < 2e-3
    assert max(between[key] for key in ("moment", "shear force", "axial force")) < 2e-4
    for key in ("deflection", "joint_force"):
        assert float(np.abs(deep[key][..., 2]).max()) < 1e-12 * float(np.abs(deep[key]).max())
