"""What must not change an answer: turning or mirroring the whole scene, and the units that it is written in."""

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from fenics_mech import analyse
from fenics_mech.scene import Scene
from fenics_mech.scene.units import registry
from tests.common import analysed

UNITS = {
    "m": ["m", "mm", "cm", "inch", "ft"],
    "kg": ["kg", "g", "lb"],
    "kg*m**2": ["kg m^2", "g mm^2", "lb inch^2"],
    "Pa": ["Pa", "GPa", "psi", "N/mm^2"],
    "kg/m**3": ["kg/m^3", "g/cm^3", "lb/inch^3"],
    "m**2": ["mm^2", "inch^2"],
    "m**4": ["mm^4", "inch^4"],
    "rad": ["rad", "deg"],
    "rad/s": ["rad/s", "rpm", "deg/s"],
    "s": ["s", "ms"],
}
KEYS = {
    "width": "m",
    "height": "m",
    "fibre": "m",
    "position": "m",
    "centre": "m",
    "mass": "kg",
    "modulus": "Pa",
    "density": "kg/m**3",
    "area": "m**2",
    "angle": "rad",
    "turn": "rad",
    "speed": "rad/s",
    "period": "s",
}


def turned(scene, angle):
    """The scene's data, turned about the origin: only what the ground holds changes, and the rough positions."""
    data, turn = scene.model_dump(), np.exp(1j * angle)
    points = data["ground"]["points"]
    points.update({name: _pair(turn * complex(*place)) for name, place in points.items()})
    for link in data["links"].values():
        link["angle"] += angle
    for joint in data["joints"].values():
        if joint["kind"] in ("slot", "prismatic") and joint["connect"][0].startswith("ground."):
            joint["angle"] += angle
            joint["turn"] = joint.get("turn", 0.0) + angle
            if joint["kind"] == "slot":
                joint.pop("turn")
    _change_loads(data, lambda force: turn * force)
    for drive in _drives(data):
        joint = data["joints"][drive["joint"]]
        if joint["kind"] == "revolute" and joint["connect"][0].startswith("ground."):
            _add_to_law(drive, angle)
    return data


def mirrored(scene):
    """The scene's data, mirrored about the x axis."""
    data = scene.model_dump()
    for body in (data["ground"], *data["links"].values()):
        body["points"] = {name: (x, -y) for name, (x, y) in body["points"].items()}
        if body.get("rigid"):
            body["rigid"]["centre"] = (body["rigid"]["centre"][0], -body["rigid"]["centre"][1])
        body["angle"] = -body.get("angle", 0.0)
    data["ground"].pop("angle")
    _change_loads(data, np.conj)
    for joint in data["joints"].values():
        joint.update({key: -joint[key] for key in ("angle", "turn") if key in joint})
    for drive in _drives(data):
        if data["joints"][drive["joint"]]["kind"] == "revolute":
            law = drive["law"]
            if drive["speed"] is not None:
                drive["speed"], drive["start"] = -drive["speed"], -drive["start"]
            elif law["kind"] == "expression":
                law["formula"] = f"-({law['formula']})"
            else:
                negative = {key: tuple(-a for a in law[key]) for key in ("cosine", "sine")}
                law.update(negative, mean=-law["mean"])
    return data


def _pair(z):
    return (z.real, z.imag)


def _change_loads(data, change):
    """Change the forces of all loads, which are in the fixed frame, as complex numbers."""
    for load in data["loads"].values():
        load.update({key: _pair(change(complex(*load[key]))) for key in ("force", "line") if key in load})


def _drives(data):
    return data["drive"] if isinstance(data["drive"], list | tuple) else [data["drive"]]


def _add_to_law(drive, angle):
    law = drive["law"]
    if law is None:
        drive["start"] += angle
    elif law["kind"] == "expression":
        law["formula"] = f"{law['formula']} + {angle!r}"
    else:
        law["mean"] += angle


def few(scene):
    return scene.changed(
        analysis__sub_intervals=48,
        analysis__allow_ringing=True,
        analysis__allow_coarse=True,
        analysis__stability=False,
        analysis__stations=5,
    )


def assert_same(a, b, accuracy, sign=1.0):
    """Frequencies, strains and torques of two results; sign is that of bending and of torques."""
    for name, factor in (("frequency", 1), ("strain_axial", 1), ("strain_bending", sign), ("moment", sign)):
        if name not in a:
            continue
        first, second = a[name].to_numpy(), factor * b[name].to_numpy()
        assert np.abs(first - second).max() < accuracy * np.abs(first).max(), name


@pytest.mark.slow
def test_turning_the_scene_changes_nothing(machine):
    scene = few(machine)
    assert_same(analysed(scene).data, analyse(Scene.read(turned(scene, 0.7))).data, 1e-6)  # of differences: 1e-7


@pytest.mark.parametrize("effects", [(), ("coupling", "large-rotations")])
def test_turning_a_four_bar_with_a_rigid_coupler_changes_nothing(effects, scene_of):
    # what (5.1) drops depends on the coordinates: they are the coupler's own, not its pins' X and Y
    body = {"mass": 0.03, "inertia": 2e-4, "centre": (0.14, 0.0)}
    rigid = scene_of("four_bar").changed(links__coupler__members={}, links__coupler__rigid=body)
    scene = few(rigid.changed(effects=effects, analysis__solver="collocation"))
    assert_same(analysed(scene).data, analyse(Scene.read(turned(scene, 0.7))).data, 1e-6)  # by differences: 1e-7


def test_mirroring_the_scene_changes_signs_only(machine):
    scene = few(machine)
    plain, other = analysed(scene).data, analyse(Scene.read(mirrored(scene))).data
    assert_same(plain, other, 1e-6, sign=-1.0)  # linear motions are read off by differences
    force = plain["joint_force"].to_numpy()
    assert np.abs(force - other["joint_force"].to_numpy() * [1, -1]).max() < 1e-6 * np.abs(force).max()


def restated(part, rng, path=()):
    """Write all quantities of a scene's data as strings in random units."""
    if isinstance(part, dict):
        return {key: restated(value, rng, (*path, key)) for key, value in part.items() if value is not None}
    if isinstance(part, list | tuple):
        return [restated(value, rng, path) for value in part]
    unit = _unit_of(path)
    if unit is None or not isinstance(part, float):
        return part
    other = rng.choice(UNITS[unit])
    return f"{registry().Quantity(part, unit).to(other).magnitude!r} {other}"


def _unit_of(path):
    if path[0] == "analysis":
        return None
    if "points" in path:
        return "m"
    if path[-1] in ("inertia", "start"):
        return {"inertia": "m**4" if path[0] == "sections" else "kg*m**2", "start": "rad"}[path[-1]]
    if path[-1] in ("mean", "cosine", "sine"):
        return "rad" if path[0] == "drive" else "m"
    return KEYS.get(path[-1])


@pytest.mark.parametrize("name", ["slider_crank", "manipulator", "rigid_crank"])
@given(seed=st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=4, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_random_units_give_the_same_answer(name, seed, scene_of):
    scene = few(scene_of(name))
    text = restated(scene.model_dump(), np.random.default_rng(seed))
    assert any(isinstance(x, str) for x in text["ground"]["points"][next(iter(text["ground"]["points"]))])
    assert_same(analysed(scene).data, analyse(Scene.read(text)).data, 1e-6)
