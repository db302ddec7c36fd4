"""Matrices of links that machines share: those of scenes that state the same, and of no others."""

import weakref
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import fenics_mech as fm
from fenics_mech.beams.element_matrices import assemble_beams
from fenics_mech.beams.made_once import LastMade
from fenics_mech.beams.mesh import mesh_scene
from fenics_mech.errors import SceneError
from fenics_mech.machine import from_scene
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import machine_of
from fenics_mech.solve import periodic, rigid_cycle
from tests.common import DEMOS

STRIP = {"shape": "rectangle", "width": "25 mm", "height": "8 mm"}
PLIES = [{"thickness": "3 mm", "material": name} for name in ("aluminium", "heavy")]
STATED = {  # everything that links depend on: a taper, a member of its own mesh, a load and an impulse inside members
    "sections.strip": STRIP,
    "sections.thin": STRIP | {"height": "5 mm"},
    "sections.cone": {"shape": "taper", "from": "strip", "to": "thin"},
    "materials.heavy": {"modulus": "10 GPa", "density": "7000 kg/m^3", "poisson": 0.3},
    "materials.aluminium.poisson": 0.33,
    "links.coupler.members.AB.section": "cone",
    "links.follower.members.CB.mesh": {"elements": 2, "grading": 1.2},
    "links.crank.members.OA.offset": "1 mm",
    "masses.pin": {"at": "crank.A", "mass": "10 g", "inertia": "1e-6 kg m^2"},
    "loads.push": {"at": "coupler@0.3", "force": (0, 1)},
    "impulses.hit": {"at": "follower@0.4", "impulse": (0.0, 1e-3), "angle": 0.5},
    "effects": ("coupling", "large-rotations", "rotary-inertia"),
}
LAMINATED = {"sections.two": {"shape": "laminate", "width": "25 mm", "plies": PLIES}}
LAMINATED |= {"links.coupler.members.AB": {"ends": ["A", "B"], "section": "two", "offset": "1 mm"}}
SHEARED = {"effects": ("coupling", "rotary-inertia", "shear"), "sections.crank.shear_factor": 0.8}
KEYS = ("links", "masses", "materials", "sections", "mesh")
PARTS = {  # what links depend on beside numbers
    "links.follower.members.CB.section": "thin",
    "links.follower.members.CB.material": "heavy",
    "links.follower.members.CB.ends": ("B", "C"),
    "links.follower.members.CB.mesh": None,
    "links.crank.members.OA.mesh": {"stations": (0.0, 0.4, 1.0)},
    "links.coupler": {"points": {"A": (0, 0), "B": (0.28, 0)}, "rigid": {"mass": 0.1, "centre": (0.1, 0.0)}},
    "masses.pin.at": "coupler.B",
    "loads.push.at": "coupler@0.31",
    "impulses.hit.at": "coupler@0.4",
    "masses": {},
    "loads": {},
    "effects": ("coupling",),
}
STATIONS = np.linspace(0, 1, 5)
OTHERS = {  # what links do not depend on
    "drive.speed": 20.0,
    "drive.start": 0.3,
    "gravity": (0.0, -9.81),
    "damping.material": 1e-4,
    "loads.push.force": (1.0, 2.0),
    "impulses.hit.impulse": (1e-3, 0.0),
    "springs.s": {"between": ("ground.O", "follower.B"), "stiffness": 50.0},
    "ground.points.C": (0.26, 0.001),
    "effects": ("large-rotations", "rotary-inertia", "coupling"),
}


@pytest.fixture(scope="module")
def stated() -> fm.Scene:
    return fm.load(DEMOS / "four_bar.toml").changed(STATED)


def changes(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Give every number and text below a key, changed."""
    if isinstance(value, dict):
        for name, part in value.items():
            yield from changes(part, f"{path}.{name}")
    elif isinstance(value, (list, tuple)):
        for number, part in enumerate(value):
            yield from changes(part, f"{path}.{number}")
    elif isinstance(value, int) and not isinstance(value, bool):
        yield path, value + 1
    elif isinstance(value, float):
        yield path, 1.01 * value + 0.001 * (value == 0)


def arrays(thing: Any, path: str = "") -> dict[str, np.ndarray]:
    """Give all arrays of links, those of their mesh too, by where they are."""
    if isinstance(thing, np.ndarray):
        return {path: thing}
    if not type(thing).__module__.startswith("fenics_mech.beams"):
        return {}
    return {k: a for name, part in vars(thing).items() for k, a in arrays(part, f"{path}.{name}").items()}


def assembled(scene: fm.Scene) -> Any:
    """Assemble the links of the whole scene."""
    links = assemble_beams(scene, mesh_scene(scene, loads_at_nodes=True))
    for name, changed in from_scene.SECTIONS.items():
        links = changed(scene, links) if name in scene.effects else links
    return links


@pytest.mark.parametrize("more", [LAMINATED, SHEARED], ids=["laminated", "tapered and sheared"])
def test_matrices_are_those_of_the_whole_scene_to_the_last_bit(stated, more):
    """They are made from a scene with nothing but what they depend on."""
    scene = stated.changed(more)
    whole = assemble_beams(scene, mesh_scene(scene, loads_at_nodes=True))
    for name, changed in from_scene.SECTIONS.items():
        whole = changed(scene, whole) if name in scene.effects else whole
    made = machine_of(scene).links
    for links in (made, whole):
        _ = links.element_stiffness, links.element_mass, links.element_rotary_mass, links.element_bow
    found, expected = arrays(made), arrays(whole)
    assert len(found) > 20
    assert found.keys() == expected.keys()
    assert all(np.array_equal(found[name], expected[name]) for name in found)
    assert made.mesh.node_name == whole.mesh.node_name
    assert made.inertia.bodies == whole.inertia.bodies


def test_another_number_or_part_of_links_is_never_answered_by_matrices_made_before(stated, monkeypatch):
    """Each is changed in turn. What is assembled are here the parts themselves, so that it takes no time."""
    monkeypatch.setattr(from_scene, "MADE", LastMade(1000))
    monkeypatch.setattr(from_scene, "_assembled", lambda parts: parts)
    scene = stated.changed(LAMINATED)
    data = scene.model_dump(by_alias=True)
    tried = [{path: value} for key in KEYS for path, value in changes(data[key], key)]
    tried += [{path: value} for path, value in PARTS.items()]
    found = [scene, *(scene.changed(one) for one in tried if valid(scene, one))]
    crank = scene.links["crank"].model_copy(update={"points": dict(reversed(scene.links["crank"].points.items()))})
    for links in (dict(reversed(scene.links.items())), scene.links | {"crank": crank}):
        found.append(scene.model_copy(update={"links": links}))
    made = [from_scene._matrices(one) for one in found]
    assert len(made) > 50
    assert len({id(one) for one in made}) == len(made)
    assert all(from_scene._matrices(one) is before for one, before in zip(found, made))


def valid(scene: fm.Scene, change: dict[str, Any]) -> bool:
    """Say whether a scene may be changed so."""
    try:
        scene.changed(change)
    except SceneError:
        return False
    return True


def test_matrices_are_made_once_for_scenes_that_share_them(stated):
    made = machine_of(stated).links
    for path, value in OTHERS.items():
        assert machine_of(stated.changed({path: value})).links is made, path


def test_few_matrices_are_kept(stated, monkeypatch):
    monkeypatch.setattr(from_scene, "MADE", LastMade(from_scene.MADE.most))
    monkeypatch.setattr(from_scene, "_assembled", lambda parts: parts)
    made = [weakref.ref(from_scene._matrices(stated.changed({"mesh.elements": n}))) for n in range(2, 16)]
    assert sum(one() is not None for one in made) == from_scene.MADE.most == 8


def test_nothing_writes_into_matrices_that_are_shared(seed, monkeypatch):
    """Every array of them refuses it, in a cycle and along members, whose answers are the same to the last bit."""
    monkeypatch.setattr(from_scene, "MADE", LastMade(1))
    scene = seed.changed(effects=("coupling", "large-rotations"))
    found = []
    for _ in range(2):
        made = machine_of(scene)
        made.machine.chart = rigid_cycle(made.machine, scene.period, 16)
        cycle = periodic(made.machine, scene.period, 12)
        a = cycle.a.reshape(-1, made.machine.size)
        found.append((made.links, a, along_members(made, cycle.evaluation, a, STATIONS)))
        for array in arrays(made.links).values():
            array.setflags(write=False)
    (links, a, along), (again, *same) = found
    assert again is links
    assert len(arrays(links)) > 20
    assert np.array_equal(a, same[0])
    assert all(np.array_equal(getattr(along, name), value) for name, value in vars(same[1]).items())
