"""Beams whose pins are beside their neutral line, stated by one key: closed forms."""

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import fenics_mech as fm
from fenics_mech.errors import SceneError
from fenics_mech.scene.plausibility import implausible
from fenics_mech.studies.natural_frequencies import modes
from fenics_mech.views.model_plots import Skeleton

CASES = Path(__file__).parent / "scenes"
E, RHO, WIDTH, HEIGHT, LENGTH, LOAD = 210e9, 7850.0, 0.05, 0.1, 2.0, 20e3
AREA, INERTIA = WIDTH * HEIGHT, WIDTH * HEIGHT**3 / 12


def beam(offset=HEIGHT / 2, turned=0.0, ends=("A", "M", "B"), slide=False, **rest):
    """A beam in two members on two pins of the ground, its line turned by an angle."""
    c, s = math.cos(turned), math.sin(turned)
    places = {"A": (0.0, 0.0), "M": (c * LENGTH / 2, s * LENGTH / 2), "B": (c * LENGTH, s * LENGTH)}
    first, middle, last = ends
    part = {"section": "bar", "material": "steel", "offset": offset}
    members = {"left": part | {"ends": (first, middle)}, "right": part | {"ends": (middle, last)}}
    joints = {name: {"connect": (f"ground.{name}", f"beam.{name}")} for name in ("A", "B")}
    if slide:
        joints["B"] |= {"kind": "slot", "angle": turned}
    return fm.Scene.read(
        {
            "materials": {"steel": {"modulus": E, "density": RHO}},
            "sections": {"bar": {"shape": "rectangle", "width": WIDTH, "height": HEIGHT}},
            "ground": {"points": {name: places[name] for name in ("A", "B")}},
            "links": {"beam": {"points": places, "members": members}},
            "joints": joints,
            "loads": {"P": {"at": "beam.M", "force": (s * LOAD, -c * LOAD)}},
            "analysis": {"method": "static"},
        }
        | rest
    )


def thrust(offset):
    """Horizontal force of two pins that are `offset` below a beam's neutral line, under a load at its middle.

    The line of the pins may not get longer: 2 e (P L^2/(16 E I) - H e L/(2 E I)) = H L/(E A).
    """
    return offset * LOAD * LENGTH / (8 * (INERTIA / AREA + offset**2))


@pytest.mark.parametrize("turned", [0.0, 0.7, math.pi])
@pytest.mark.parametrize("offset", [HEIGHT / 2, -HEIGHT / 2, HEIGHT / 5, 1.5 * HEIGHT])
def test_eccentric_pins_that_stand_fast_push_and_relieve_the_beam(offset, turned):
    result = fm.analyse(beam(offset, turned))
    push, forces = thrust(offset), result.data["joint_force"].isel(theta=0)
    along, across = np.array([math.cos(turned), math.sin(turned)]), np.array([-math.sin(turned), math.cos(turned)])
    for name, sign in (("A", 1), ("B", -1)):  # 1e-9: cubic elements are exact under loads at nodes
        assert forces.sel(joint=name).to_numpy() @ along == pytest.approx(sign * push, rel=1e-9)
        assert forces.sel(joint=name).to_numpy() @ across == pytest.approx(LOAD / 2, rel=1e-9)
    middle = LOAD * LENGTH / 4 - push * offset
    stress = result.data["stress"].isel(theta=0).sel(member="beam.left").isel(s=-1)
    for fibre, sign in (("+", -1), ("-", 1)):  # the middle sags: its lower side is stretched
        expected = -push / AREA + sign * middle * HEIGHT / 2 / INERTIA
        assert float(stress.sel(fibre=fibre)) == pytest.approx(expected, rel=1e-8)


def test_the_case_has_its_thrust_and_moment():
    """Numbers of the case, which stubs of a made-up stiff material gave too, with warnings that were false."""
    assert thrust(0.05) == pytest.approx(75e3, rel=1e-12)
    assert LOAD * LENGTH / 4 - thrust(0.05) * 0.05 == pytest.approx(6250.0, rel=1e-12)
    result = fm.analyse(beam())
    assert not result.warnings
    moment = result.data["moment"].isel(theta=0).sel(member="beam.right").isel(s=0)
    assert abs(float(moment)) == pytest.approx(6250.0, rel=1e-8)


def test_the_axis_backwards_turns_the_sign_of_the_offset():
    forward, back = fm.analyse(beam()), fm.analyse(beam(-HEIGHT / 2, ends=("B", "M", "A")))
    for name in ("A", "B"):
        both = [run.data["joint_force"].isel(theta=0).sel(joint=name).to_numpy() for run in (forward, back)]
        assert both[0] == pytest.approx(both[1], rel=1e-9)


def test_a_sliding_pin_takes_no_thrust_and_moves_by_the_rotation():
    result = fm.analyse(beam(slide=True))
    assert abs(float(result.data["joint_force"].isel(theta=0).sel(joint="A", component="x"))) < 1e-6 * LOAD
    middle = float(result.data["moment"].isel(theta=0).sel(member="beam.left").isel(s=-1))
    assert abs(middle) == pytest.approx(LOAD * LENGTH / 4, rel=1e-9)


def symmetric_frequency(offset):
    """First frequency (Hz) that is symmetric about the middle, of a beam on two fast pins beside its neutral line.

    Bending w = a cos bx + c cosh bx and stretching u = d sin kx of the neutral line from the middle, with
    b^4 = rho A w^2/(E I) and k^2 = rho w^2/E; at x = L/2 w = 0, u + e w' = 0 and E I w'' = e E A u'.
    """

    def determinant(omega):
        b, k, x = (RHO * AREA * omega**2 / (E * INERTIA)) ** 0.25, omega * math.sqrt(RHO / E), LENGTH / 2
        rows = [
            [math.cos(b * x), math.cosh(b * x), 0.0],
            [-offset * b * math.sin(b * x), offset * b * math.sinh(b * x), math.sin(k * x)],
            [
                -INERTIA * b**2 * math.cos(b * x),
                INERTIA * b**2 * math.cosh(b * x),
                -offset * AREA * k * math.cos(k * x),
            ],
        ]
        return np.linalg.det(np.array(rows) / np.abs(rows).max(axis=1, keepdims=True))

    pinned = (math.pi / LENGTH) ** 2 * math.sqrt(E * INERTIA / (RHO * AREA))
    return brentq(determinant, 0.9 * pinned, 2.2 * pinned, xtol=1e-9) / (2 * math.pi)


@pytest.mark.parametrize("offset", [1e-6, HEIGHT / 5, HEIGHT / 2, -HEIGHT / 2])
def test_frequencies_are_those_of_the_beam_on_eccentric_pins(offset):
    scene = beam(offset, loads={}, mesh={"elements": 8})
    found = modes(scene).data["frequency"].to_numpy().ravel()
    expected = symmetric_frequency(offset)
    # 1e-4: 16 cubic elements, which stretch linearly, leave about (k L/16)^2/24
    assert np.abs(found / expected - 1).min() < 1e-4


def test_exact_strains_know_the_offset_too():
    """A load of 1 % of the case's: linear and exact strains agree to about the load's share of the buckling load."""
    small = {"P": {"at": "beam.M", "force": (0.0, -LOAD / 100)}}
    exact = fm.analyse(beam(effects=("large-rotations",), loads=small, mesh={"elements": 6}))
    assert float(exact.data["joint_force"].isel(theta=0).sel(joint="A", component="x")) == pytest.approx(
        thrust(HEIGHT / 2) / 100, rel=1e-3
    )


def test_a_swung_arm_beside_its_pin_has_the_centrifugal_force_of_its_mass():
    """A bar at constant speed about a pin beside it: m w^2 (L/2) along it and m w^2 e across it, at the pin."""
    speed, arm = 50.0, 0.03
    scene = fm.load(CASES.parents[2] / "demos" / "four_bar.toml")
    scene = beam(
        arm,
        loads={},
        ground={"points": {"A": (0, 0)}},
        joints={"A": {"connect": ("ground.A", "beam.A")}},
        drive={"joint": "A", "speed": speed},
        analysis={"method": "quasi-static", "sub_intervals": 8},
    )
    force = fm.analyse(scene).data["joint_force"].isel(theta=0, joint=0).to_numpy()
    mass = RHO * AREA * LENGTH
    assert force == pytest.approx([-mass * speed**2 * LENGTH / 2, -mass * speed**2 * arm], rel=1e-9)


def test_the_key_is_read_with_units_written_back_and_drawn(tmp_path):
    scene = beam("50 mm")
    again = fm.load(fm.write_scene(scene, tmp_path / "beam.toml"))
    assert again.links == scene.links
    assert again.links["beam"].members["left"].offset == pytest.approx(0.05)
    lines = Skeleton.at_start(scene).beside
    assert lines.shape == (6, 2, 2)
    assert lines[0] == pytest.approx(np.array([[0, 0.05], [1.0, 0.05]]))


def test_an_offset_in_wrong_units_is_suspected_and_a_bracket_is_not():
    assert not implausible(beam(3 * HEIGHT))
    told, _ = implausible(beam(50.0))
    assert told.startswith("links.beam.members.left.offset: the section is 50 m beside its pins")
    assert "50 mm = 0.05 m is likely meant" in told or "0.05 m is likely meant" in told


def test_stubs_of_a_made_up_material_are_told_of_what_replaces_them():
    (told,) = implausible(fm.load(CASES / "offset_axis.toml"))
    assert told.startswith("materials.stiff.modulus")
    assert "`offset`" in told
    assert "likely meant" not in told


def test_effects_that_do_not_know_an_offset_say_where_it_is_stated():
    with pytest.raises(SceneError, match=r"links\.beam\.members.*leave out the member's offset"):
        fm.analyse(beam(effects=("lumped-mass",)))
