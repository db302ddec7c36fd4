"""Springs: their tangent, closed forms of beams on springs, work, balance, and what must not change an answer."""

import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import AssemblyError, SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import Scene, parse
from fenics_mech.scene.factories import seed_four_bar
from tests.common import modes_of

EI, EA, L, MASS = 3.0, 1e6, 0.5, 0.8  # of the beam below
STRETCHED = {"between": ("coupler.B", "ground.O"), "stiffness": 200.0, "length": 0.1}
ANGLE = {"joint": "C", "stiffness": 0.7, "angle": 0.4}


def beam(joints, ground=None, **rest):
    """A beam from (0, 0) to (L, 0) with next to no mass of its own, and a mass at its end B."""
    data = {
        "materials": {"light": {"modulus": 1e9, "density": 1e-6}},
        "sections": {"strip": {"area": EA / 1e9, "inertia": EI / 1e9, "fibre": 1e-3}},
        "ground": {"points": {"O": (0, 0), "B": (L, 0)} | (ground or {})},
        "links": {
            "beam": {
                "points": {"O": (0, 0), "B": (L, 0)},
                "members": {"OB": {"ends": ("O", "B"), "section": "strip", "material": "light"}},
            }
        },
        "joints": joints,
        "masses": {"B": {"at": "beam.B", "mass": MASS}},
        "analysis": {"method": "static", "modes": 1},
    }
    return Scene.read(data | rest)


CLAMPED = {"O": {"kind": "weld", "connect": ("ground.O", "beam.O")}}
ON_PINS = {
    "O": {"connect": ("ground.O", "beam.O")},
    "B": {"kind": "slot", "connect": ("ground.B", "beam.B")},
}


def stiff(scale, **rest):
    """The seed four-bar with a modulus so many times higher."""
    return seed_four_bar(materials={"material": {"modulus": 71e9 * scale, "density": 2714}}, **rest)


def place(scene, system, at, v):
    """Places of a point at all angles under a displacement v in link axes, ``(angles, 2)``."""
    body, point = scene.point(at)
    found = system.motion.of_point(body, point)[0]
    if body == "ground":
        return found
    i = system.motion.links.index(body)
    dof = 3 * system.beams.mesh.node(at)
    u, w = v[:, dof], v[:, dof + 1]
    c, s = np.cos(system.motion.angle[:, i]), np.sin(system.motion.angle[:, i])
    return found + np.stack([c * u - s * w, s * u + c * w], axis=-1)


def rotation(scene, system, v):
    """Rotation of the follower at C under a displacement v, ``(angles,)``."""
    return system.motion.angle[:, 2] + v[:, 3 * system.beams.mesh.node("follower.C") + 2]


def energy(scene, system, v):
    first, second = (place(scene, system, at, v) for at in scene.springs["line"].between)
    length = np.linalg.norm(second - first, axis=1)
    turned = rotation(scene, system, v)
    angle = 0.4 + 2 * np.pi * np.round((turned - 0.4) / (2 * np.pi))
    return 100.0 * (length - 0.1) ** 2 + 0.35 * (turned - angle) ** 2


def test_mass_on_a_beam_and_a_spring():
    spring = {"s": {"between": ("ground.P", "beam.B"), "stiffness": "40 N/m", "length": "0.2 m"}}
    scene = beam(CLAMPED, {"P": (L, -0.2)}, springs=spring)
    expected = np.sqrt((3 * EI / L**3 + 40) / MASS) / (2 * np.pi)
    assert modes_of(scene).frequency[0, 0] == pytest.approx(expected, rel=1e-6)  # beam's own mass


def test_tension_over_length_is_a_stiffness_across_the_spring():
    # along the beam's axis the spring adds nothing to the bending but the turning of its tension of 30 N
    spring = {"s": {"between": ("beam.B", "ground.P"), "stiffness": "300 N/m", "length": "0.1 m"}}
    scene = beam(CLAMPED, {"P": (L + 0.2, 0)}, springs=spring)
    expected = np.sqrt((3 * EI / L**3 + 30 / 0.2) / MASS) / (2 * np.pi)
    assert modes_of(scene).frequency[0, 0] == pytest.approx(expected, rel=1e-6)


def test_beam_with_a_spring_under_its_end_shares_the_load():
    spring = {"s": {"between": ("ground.P", "beam.B"), "stiffness": 40.0}}
    load = {"tip": {"at": "beam.B", "force": (0.0, -2.0)}}
    data = analyse(beam(CLAMPED, {"P": (L, -0.2)}, springs=spring, loads=load)).data.isel(theta=0)
    sag = -2 / (3 * EI / L**3 + 40)
    assert data["deflection"].sel(member="beam", s=1, component="y").item() == pytest.approx(sag, rel=1e-9)
    assert data["spring_force"].sel(spring="s").item() == pytest.approx(40 * sag, rel=1e-9)
    assert data["joint_force"].sel(joint="O", component="y").item() == pytest.approx(2 + 40 * sag, rel=1e-9)
    assert data["moment"].sel(member="beam", s=0).item() == pytest.approx((-2 - 40 * sag) * L, rel=1e-9)


def test_torsional_spring_at_a_pin_holds_the_beams_end():
    spring = {"s": {"joint": "O", "stiffness": "5 N*m/rad"}}
    load = {"end": {"at": "beam.O", "moment": 0.3}}
    data = analyse(beam(ON_PINS, springs=spring, loads=load)).data.isel(theta=0)
    turned = 0.3 / (3 * EI / L + 5)
    assert data["spring_force"].sel(spring="s").item() == pytest.approx(5 * turned, rel=1e-9)
    assert data["moment"].sel(member="beam", s=0).item() == pytest.approx(5 * turned - 0.3, rel=1e-9)


def test_torsional_spring_at_the_drive_is_felt_by_it():
    analysis = {"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True}
    spring = {"s": {"joint": "O", "stiffness": "2 N*m/rad"}}
    plain, sprung = (analyse(seed_four_bar(analysis=analysis, springs=springs)) for springs in ({}, spring))
    change = sprung.data["input_torque"] - plain.data["input_torque"]
    assert np.allclose(change, 2.0 * plain.data["theta"], rtol=0, atol=1e-11)  # the crank's end is held: exact


def _moved(scene, system, by):
    return replace(system, motion=solve_motion(scene, system.motion.theta + by, near=system.motion))


def test_drive_does_the_work_that_the_springs_store():
    # virtual work: torque d theta is the change of the springs' energy F^2/(2 k); here with links that hardly bend
    springs = {"line": STRETCHED, "hinge": ANGLE}
    analysis = {"method": "quasi-static", "sub_intervals": 96}
    plain, sprung = (analyse(stiff(1e7, analysis=analysis, springs=some)).data for some in ({}, springs))
    torque = sprung["input_torque"].to_numpy() - plain["input_torque"].to_numpy()
    stiffness = np.array([springs[name]["stiffness"] for name in sprung["spring"].to_numpy()])
    stored = (sprung["spring_force"].to_numpy() ** 2 / (2 * stiffness)).sum(axis=1)
    slope = np.fft.irfft(1j * np.arange(49) * np.fft.rfft(stored))
    assert np.abs(torque - slope).max() < 1e-6 * np.abs(slope).max()


def test_springs_take_no_power_over_a_cycle():
    # in collocation with all terms of the linear equation, on stiff links: the time steps leave 4e-7 of the torque
    springs = {"line": {"between": ("coupler.B", "ground.O"), "stiffness": 20.0}, "hinge": ANGLE}
    scene = stiff(
        1e2,
        springs=springs,
        effects=("coupling", "large-rotations"),
        damping={"material": 1e-7},
        analysis={"sub_intervals": 48, "stability": False},
    )
    torque = analyse(scene).data["input_torque"].to_numpy()
    assert abs(torque.mean()) < 2e-6 * np.abs(torque).max()


def test_spring_without_free_length_balances_a_weight():
    # lever of length 0.4 with 5 N at its end; spring from 0.15 above the pivot to 0.1 along the lever: k a r = weight L
    data = {
        "materials": {"stiff": {"modulus": 1e15, "density": 1e-3}},
        "sections": {"strip": {"shape": "rectangle", "width": "20 mm", "height": "20 mm"}},
        "ground": {"points": {"O": (0, 0), "P": (0, 0.15)}},
        "links": {
            "lever": {
                "points": {"O": (0, 0), "S": (0.1, 0), "E": (0.4, 0)},
                "members": {
                    name: {"ends": tuple(name), "section": "strip", "material": "stiff"} for name in ("OS", "SE")
                },
            }
        },
        "joints": {"O": {"connect": ("ground.O", "lever.O")}},
        "loads": {"weight": {"at": "lever.E", "force": (0.0, -5.0)}},
        "springs": {"s": {"between": ("ground.P", "lever.S"), "stiffness": 5 * 0.4 / (0.15 * 0.1), "length": 0.0}},
        "drive": {"joint": "O", "speed": 1e-3},
        "analysis": {"method": "quasi-static", "sub_intervals": 24},
    }
    balanced = analyse(Scene.read(data)).data["input_torque"]
    loaded = analyse(Scene.read(data | {"springs": {}})).data["input_torque"]
    assert np.abs(loaded).max() == pytest.approx(2.0, rel=1e-6)
    assert np.abs(balanced).max() < 1e-7 * np.abs(loaded).max()  # what the lever bends


@pytest.mark.parametrize("change", ["turned", "mirrored"])
def test_turning_and_mirroring(change):
    """With 90 positions the damping of modes is interpolated between these alone, in axes of any direction."""
    scene = seed_four_bar(
        springs={
            "line": {"between": ("coupler.B", "ground.P"), "stiffness": 50.0},
            "hinge": {"joint": "C", "stiffness": 0.5},
        },
        dampers={
            "line": {"between": ("crank.A", "ground.P"), "damping": 0.5},
            "hinge": {"joint": "B", "damping": 1e-3},
        },
        ground={"points": {"O": (0, 0), "C": (0.254, 0), "P": (0.05, 0.4)}},
        effects=("coupling", "large-rotations"),
        analysis={"sub_intervals": 90, "modes": 3, "stability": False, "allow_coarse": True},
    )
    data, sign = scene.model_dump(), 1.0
    if change == "mirrored":
        sign = -1.0
        data["ground"]["points"] = {name: (x, -y) for name, (x, y) in data["ground"]["points"].items()}
        data["drive"]["speed"] *= -1
        data["drive"]["start"] *= -1
        for link in data["links"].values():
            link["angle"] *= -1
    else:
        c, s = np.cos(0.7), np.sin(0.7)
        data["ground"]["points"] = {n: (c * x - s * y, s * x + c * y) for n, (x, y) in data["ground"]["points"].items()}
        data["drive"]["start"] += 0.7
        for link in data["links"].values():
            link["angle"] += 0.7
    plain, other = analyse(scene).data, analyse(Scene.read(data)).data
    signs = {"strain_bending": sign, "input_torque": sign, "strain_axial": 1.0}
    for name, factor in signs.items():
        assert np.abs(plain[name] - factor * other[name].to_numpy()).max() < 1e-8 * np.abs(plain[name]).max(), name
    for kind in ("spring", "damper"):
        for which, factor in (("line", 1.0), ("hinge", sign)):
            first, second = (d[f"{kind}_force"].sel({kind: which}).to_numpy() for d in (plain, other))
            assert np.abs(first - factor * second).max() < 1e-8 * np.abs(first).max(), (kind, which)


def test_units_are_read():
    text = (
        'springs.a = { between = ["coupler.B", "ground.O"], stiffness = "2 N/mm", length = "10 cm" }\n'
        'springs.b = { joint = "C", stiffness = "2 N m/deg", angle = "90 deg" }\n'
        'dampers.c = { joint = "C", damping = "3 N mm s/rad" }\n'
    )
    scene = Scene.read(json.loads(seed_four_bar().model_dump_json()) | tomllib.loads(text))
    a, b = scene.springs.values()
    assert (a.stiffness, a.length) == (pytest.approx(2000), pytest.approx(0.1))
    assert (b.stiffness, b.angle) == (pytest.approx(360 / np.pi), pytest.approx(np.pi / 2))
    assert scene.dampers["c"].damping == pytest.approx(3e-3)
    assert Scene.read(json.loads(scene.model_dump_json())) == scene


@pytest.mark.parametrize(
    ("spring", "place", "words"),
    [
        ({"between": ("crank.X", "ground.O"), "stiffness": 1}, "springs.s.between", "no point 'crank.X'"),
        ({"between": ("crank.A", "coupler.A"), "stiffness": 1}, "springs.s.between", "no direction"),
        ({"between": ("crank.A", "crank.A"), "stiffness": 1}, "springs.s.between", "no direction"),
        ({"between": ("ground.O", "ground.C"), "stiffness": 1}, "springs.s.between", "one rigid body"),
        ({"joint": "Q", "stiffness": 1}, "springs.s.joint", "no joint 'Q'"),
        ({"joint": "A", "bodies": ("crank", "ground"), "stiffness": 1}, "springs.s.bodies", "no body of joint A"),
        ({"joint": "A", "bodies": ("crank", "crank"), "stiffness": 1}, "springs.s.bodies", "against itself"),
        ({"joint": "A", "stiffness": "3 N/m"}, "springs.s.stiffness", "wrong unit"),
        ({"joint": "A", "stiffness": 0}, "springs.s.stiffness", "greater than 0"),
        ({"joint": "A", "between": ("crank.A", "ground.C"), "stiffness": 1}, "springs.s.between", "unknown key"),
        ({"stiffness": 1}, "springs.s.between", "neither"),
    ],
)
def test_bad_springs_are_refused(spring, place, words):
    with pytest.raises(SceneError) as caught:
        seed_four_bar(springs={"s": spring})
    assert caught.value.place == place
    assert words in caught.value.message


def test_spring_that_is_wound_up_for_ever_is_refused():
    scene = seed_four_bar(springs={"s": {"joint": "O", "stiffness": 1.0}}, analysis={"sub_intervals": 24})
    with pytest.raises(SceneError, match="winds the spring up"):
        analyse(scene)


def test_ends_that_meet_are_refused():
    spring = {"s": {"between": ("crank.A", "ground.P"), "stiffness": 1.0, "length": 0.1}}
    scene = seed_four_bar(
        springs=spring,
        ground={"points": {"O": (0, 0), "C": (0.254, 0), "P": (0.10795, 0)}},
        analysis={"method": "quasi-static", "sub_intervals": 4, "allow_coarse": True},
    )
    with pytest.raises(AssemblyError, match="drive angle 0 deg"):
        analyse(scene)
    free = scene.changed(springs__s__length=0.0)  # pulls with k times the distance: no direction is needed
    assert np.isfinite(analyse(free).data["input_torque"]).all()


def test_scene_file_with_springs_can_be_written_in_toml(demo_text):
    scene = parse(demo_text + '\n[springs.s]\nbetween = ["follower.B", "ground.O"]\nstiffness = "200 N/m"\n')
    assert scene.springs["s"].length is None
