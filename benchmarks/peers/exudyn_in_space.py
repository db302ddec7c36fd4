"""Machines in space drawn at random, by this program and by Exudyn: elastic places, moments and drive torques.

Five families are drawn in turn: an RSSR, a slider-crank in space, a spherical four-bar, Bennett's linkage (every second
one with an axis that leans), and a shaft with two universal joints. Round and rectangular sections, point masses, point
dampers to the ground and gravity differ from one machine to the next. The drive turns about Z at a constant speed.

Exudyn 1.13 runs in its own Python, as it needs another NumPy. Its beams have first order: two meshes are extrapolated.

Bennett's linkage is not stored: by Exudyn it does not yet repeat after these cycles, as its damping is small.

Usage: ``python -m benchmarks.peers.exudyn_in_space --machines 10 --seed 1 --exudyn /path/to/python``
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

import fenics_mech as fm
from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.geometry import SPACE
from fenics_mech.sections import numbers_of

REFERENCE = Path("tests/data/spatial/drawn_machines.npz")
ANGLES = 60
MESHES = (12, 24)  # elements a link of Exudyn
STEPS, CYCLES = 1200, 9  # of Exudyn: steps in a cycle, cycles of which the last is told
SHEAR = 10.0  # shear stiffness of Exudyn's beams over G A: this program's do not shear
FAMILIES = ("rssr", "slider", "spherical", "bennett", "shafts")
FINER = {"slider": 3, "bennett": 3}  # positions for each angle: these have accelerations of high harmonics
MATERIALS = {
    "steel": {"modulus": 207e9, "density": 7800.0, "poisson": 0.3},
    "aluminium": {"modulus": 70e9, "density": 2700.0, "poisson": 0.33},
}
HELD = {  # translations and rotations, the first axis of a joint being its own
    "revolute": [1, 1, 1, 0, 1, 1],
    "ball": [1, 1, 1, 0, 0, 0],
    "universal": [1, 1, 1, 1, 0, 0],
    "cylinder": [0, 1, 1, 0, 1, 1],
    "slider": [0, 1, 1, 1, 1, 1],
}
QUANTITIES = ("place", "moment", "torque")
Z = np.array([0.0, 0.0, 1.0])


def _plain(p: Any) -> tuple[float, ...]:
    return tuple(float(x) for x in p)


def _unit(v: Any) -> Array:
    return np.asarray(v / np.linalg.norm(v))


def _about(axis: Array, angle: Any) -> Array:
    """Give rotation matrices about an axis, by angles of any shape ``(..., 3, 3)``."""
    K, a = np.cross(np.eye(3), _unit(axis)), np.asarray(angle)[..., None, None]
    return np.asarray(np.eye(3) + np.sin(a) * K + (1 - np.cos(a)) * K @ K)


def _link(first: Array, last: Array, ends: str, section: str, material: str) -> dict[str, Any]:
    up = np.cross(last - first, Z if abs(_unit(last - first)[2]) < 0.9 else np.array([1.0, 0.0, 0.0]))
    member = {"ends": tuple(ends), "section": section, "material": material, "up": _plain(up)}
    return {"points": {ends[0]: _plain(first), ends[1]: _plain(last)}, "members": {ends: member}}


def _turn(one: str, other: str, axis: Array, **more: Any) -> dict[str, Any]:
    return {"connect": (one, other), "axis": _plain(axis), **more}


def _rssr(rng: np.random.Generator) -> dict[str, Any]:
    """Draw an RSSR whose crank can turn; the coupler's spin is held by a universal joint at the crank."""
    turned = TURN * np.arange(90) / 90
    while True:
        crank, rocker = rng.uniform(0.06, 0.1), rng.uniform(0.2, 0.3)
        Q = rng.uniform([0.2, -0.15, -0.1], [0.4, 0.15, 0.1])
        axes = SPACE.axes(_unit(np.array([0.0, 1.0, 0.0]) + 0.4 * rng.normal(size=3)))[:, [1, 2, 0]]
        u, v = axes[:, 0], axes[:, 1]
        A = crank * np.array([1.0, 0.0, 0.0])
        B = Q + rocker * (np.cos(a := rng.uniform(0, TURN)) * u + np.sin(a) * v)
        coupler = np.linalg.norm(B - A)
        way = _about(Z, turned) @ A - Q  # |Q + R (cos b u + sin b v) - A| = L has a solution b
        reach = (np.sum(way**2, axis=1) + rocker**2 - coupler**2) / (2 * rocker)
        lean = np.degrees(np.arccos(abs(_unit(B - A)[2])))
        if 0.25 < coupler < 0.45 and np.abs(reach / np.hypot(way @ u, way @ v)).max() < 0.85 and lean > 50:
            break
    across = np.cross(Z, B - A)
    return {
        "links": {"crank": (0 * A, A, "OA"), "coupler": (A, B, "AB"), "rocker": (Q, B, "QB")},
        "ground": {"Q": Q},
        "joints": {
            "A": {"connect": ("crank.A", "coupler.A"), "kind": "universal", "axes": (_plain(Z), _plain(across))},
            "B": {"connect": ("coupler.B", "rocker.B"), "kind": "ball"},
            "Q": _turn("ground.Q", "rocker.Q", axes[:, 2]),
        },
    }


def _slider(rng: np.random.Generator) -> dict[str, Any]:
    """Draw a slider-crank in space, with a ball at its crank and a universal joint at its rigid block."""
    A = rng.uniform(0.04, 0.07) * np.array([1.0, 0.0, 0.0])
    way = _unit(np.array([1.0, 0.0, 0.0]) + 0.25 * rng.normal(size=3))
    B = A + rng.uniform(0.22, 0.32) * _unit(way + 0.15 * rng.normal(size=3))
    across = np.cross(way, Z)
    body = {"mass": rng.uniform(0.1, 0.4), "inertia": _plain(rng.uniform(1e-4, 1.5e-4, 3)), "centre": _plain(B)}
    axes = (_plain(across), _plain(np.cross(across, B - A)))
    return {
        "links": {"crank": (0 * A, A, "OA"), "rod": (A, B, "AB")},
        "bodies": {"block": {"points": {"B": _plain(B)}, "rigid": body}},
        "ground": {"G": B},
        "joints": {
            "A": {"connect": ("crank.A", "rod.A"), "kind": "ball"},
            "B": {"connect": ("block.B", "rod.B"), "kind": "universal", "axes": axes},
            "G": _turn("ground.G", "block.B", way, kind="slider"),
        },
    }


def _spherical(rng: np.random.Generator) -> dict[str, Any]:
    """Draw a spherical four-bar: the axes of its four hinges meet below the drive."""
    turned = TURN * np.arange(90) / 90
    centre = np.array([0.0, 0.0, -rng.uniform(0.25, 0.35)])
    while True:
        n2 = np.array([np.sin(a := rng.uniform(0.25, 0.4)), 0.0, np.cos(a)])
        n3, n4 = (_unit(rng.normal(size=3) + shift) for shift in ([1.0, 0.5, 1.0], [0.5, -1.0, 1.0]))
        # n3 is at the angle "coupler" of n2, and at "rocker" of n4: it exists where the triangle closes
        coupler, rocker = np.arccos([n2 @ n3, n3 @ n4])
        far = np.arccos(np.clip((_about(Z, turned) @ n2) @ n4, -1, 1))
        closes = (far < coupler + rocker - 0.2) & (far > abs(coupler - rocker) + 0.2)
        if closes.all() and 0.6 < coupler < 1.4 and 0.6 < rocker < 1.4 and np.arccos(n4[2]) > 0.6:
            break
    reach = -centre[2]
    A, B, D = (centre + reach * n for n in (n2, n3, n4))
    return {
        "links": {"crank": (np.zeros(3), A, "OA"), "coupler": (A, B, "AB"), "rocker": (D, B, "DB")},
        "ground": {"D": D},
        "joints": {
            "A": _turn("crank.A", "coupler.A", n2),
            "B": _turn("coupler.B", "rocker.B", n3),
            "D": _turn("ground.D", "rocker.D", n4),
        },
    }


def _bennett(rng: np.random.Generator, lean: float) -> dict[str, Any]:
    """Draw Bennett's linkage: sin(twist)/length is that of all bars; its last axis may lean (rad)."""
    a, alpha, beta = rng.uniform(0.1, 0.14), rng.uniform(0.4, 0.55), rng.uniform(1.9, 2.2)
    b = a * np.sin(beta) / np.sin(alpha)
    first = rng.uniform(0.8, 1.4)
    second = 2 * np.arctan(np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2) / np.tan(first / 2))

    def bar(turn: float, length: float, twist: float) -> Array:
        T = np.eye(4)
        T[:3, :3] = _about(Z, turn) @ _about(np.array([1.0, 0.0, 0.0]), twist)
        T[:3, 3] = length * np.array([np.cos(turn), np.sin(turn), 0.0])
        return T

    # hinges in turn: the drive, A, B, D; from D, the ground leads back to the drive
    steps = [bar(first, a, alpha), bar(second, b, beta), bar(-first, a, alpha), bar(-second, b, beta)]
    T, frames = np.eye(4), []
    for step in steps:
        T = T @ step
        frames.append(T)
    assert np.abs(frames[3] - np.eye(4)).max() < 1e-9
    (A, n2), (B, n3), (D, n4) = ((T[:3, 3], T[:3, 2]) for T in frames[:3])
    misaligned = {"misaligned": {"about": _plain(SPACE.axes(n4)[:, 1]), "by": lean}} if lean else {}
    return {
        "links": {"crank": (np.zeros(3), A, "OA"), "coupler": (A, B, "AB"), "rocker": (D, B, "DB")},
        "ground": {"D": D},
        "joints": {
            "A": _turn("crank.A", "coupler.A", n2),
            "B": _turn("coupler.B", "rocker.B", n3),
            "D": _turn("ground.D", "rocker.D", n4, **misaligned),
        },
    }


def _shafts(rng: np.random.Generator) -> dict[str, Any]:
    """Draw three shafts with two universal joints between them; the last may slide in its bearing."""
    places, ways = [np.zeros(3)], [Z]
    for bend in rng.uniform(0.3, 0.55, 2):
        ways.append(_about(_about(Z, rng.uniform(0, TURN)) @ np.array([1.0, 0.0, 0.0]), bend) @ ways[-1])
    for way, length in zip(ways, rng.uniform(0.12, 0.25, 3)):
        places.append(places[-1] + length * way)
    origin, U, V, D = places

    def cross(one: Array, other: Array) -> tuple[tuple[float, ...], tuple[float, ...]]:
        normal = np.cross(one, other)
        return _plain(normal), _plain(np.cross(normal, other))

    return {
        "links": {"input": (origin, U, "OU"), "middle": (U, V, "UV"), "output": (V, D, "VD")},
        "ground": {"D": D},
        "joints": {
            "U": {"connect": ("input.U", "middle.U"), "kind": "universal", "axes": cross(ways[0], ways[1])},
            "V": {"connect": ("middle.V", "output.V"), "kind": "universal", "axes": cross(ways[1], ways[2])},
            "D": _turn("ground.D", "output.D", ways[2], kind="cylinder"),
        },
        "hinge": "D",
    }


def drawn(number: int, seed: int = 1) -> fm.SpatialScene:
    """Draw a machine.

    Parameters
    ----------
    number
        Its number from 0; the families take turns.
    seed
        Of all machines.

    Returns
    -------
    fm.SpatialScene
        Periodic, with its results at mid member, at a multiple of `ANGLES` positions. Its speed is a third to a sixth
        of the slowest natural frequency as drawn, and each damper is about 8 % of critical damping. Bennett's linkage
        is slower and has a tenth of that damping.
    """
    rng = np.random.default_rng([seed, number])
    family = FAMILIES[number % len(FAMILIES)]
    if family == "bennett":
        lean = float(np.radians(rng.uniform(0.3, 0.8))) if number // len(FAMILIES) % 2 else 0.0
        made = _bennett(rng, lean)
    else:
        made = {"rssr": _rssr, "slider": _slider, "spherical": _spherical, "shafts": _shafts}[family](rng)
    material = str(rng.choice(list(MATERIALS)))
    sections: dict[str, Any] = {}
    links: dict[str, Any] = dict(made.get("bodies", {}))
    masses: dict[str, Any] = {}
    moving = {}  # kg of each link
    for k, (name, (first, last, ends)) in enumerate(made["links"].items()):
        size = rng.uniform(5e-3, 8e-3) * (1.4 if k == 0 else 1.0)
        if rng.random() < 0.5:
            sections[name] = {"shape": "round", "diameter": size}
            area = np.pi * size**2 / 4
        else:
            height = rng.uniform(0.6, 0.9) * size
            sections[name] = {"shape": "rectangle", "height": height, "width": size}
            area = height * size
        links[name] = _link(first, last, ends, name, material)
        moving[name] = MATERIALS[material]["density"] * area * np.linalg.norm(last - first)  # type: ignore[operator]
        if rng.random() < 0.5:
            masses[f"at_{name}"] = {"at": f"{name}@0.5", "mass": 0.5 * moving[name] * rng.uniform(0.5, 1.5)}
            moving[name] += masses[f"at_{name}"]["mass"]
    joints = {"O": _turn("ground.O", f"{next(iter(made['links']))}.O", Z)} | made["joints"]
    gravity = _plain(9.81 * _unit(rng.normal(size=3))) if rng.random() < 0.5 else (0.0, 0.0, 0.0)
    data: dict[str, Any] = {
        "name": f"{family} {number}",
        "materials": {material: MATERIALS[material]},
        "sections": sections,
        "ground": {"points": {"O": (0.0, 0.0, 0.0)} | {name: _plain(p) for name, p in made["ground"].items()}},
        "links": links,
        "joints": joints,
        "masses": masses,
        "gravity": gravity,
        "drive": {"joint": "O", "speed": 1.0},
        "mesh": {"elements": 4},
        "analysis": {
            "method": "quasi-static",
            "positions": 8,
            "stations": 3,
            "modes": 1,
            "multipliers": 0,
            "error_estimates": False,
        },
    }
    slowest = TURN * float(fm.analyse(fm.SpatialScene.read(data)).data["frequency"].min())
    # dampers drive Bennett's linkage through its two flat poses, where it gives way all at once
    slower, ratio = (2.5, 0.008) if family == "bennett" else (1.0, 0.08)
    data["drive"]["speed"] = float(f"{slowest / (slower * rng.uniform(3, 6)):.4g}")
    data["dampers"] = {
        f"{name}_{s}": {"at": f"{name}@0.{s}", "damping": float(f"{2 * ratio * slowest * mass:.3g}")}
        for name, mass in moving.items()
        for s in (5, 75)
    }
    if "hinge" in made:
        data["dampers"]["hinge"] = {"joint": made["hinge"], "damping": float(f"{rng.uniform(0.01, 0.03):.3g}")}
    positions = ANGLES * FINER.get(family, 1)
    data["analysis"] |= {"method": "periodic", "positions": positions, "modes": 0}
    return fm.SpatialScene.read(data)


def problem(scene: fm.SpatialScene, elements: int, steps: int = STEPS, cycles: int = CYCLES) -> dict[str, Any]:
    """Give a scene as `exudyn_space_run` reads it, in plain numbers.

    Parameters
    ----------
    scene
        A drawn machine.
    elements, steps, cycles
        Elements a link, steps in a cycle, and cycles.
    """
    links, dampers = [], {}
    for label, (name, member) in scene.members().items():
        first, last = (np.array(scene.links[name].points[end]) for end in member.ends)
        section, material = numbers_of(scene.sections[member.section]), scene.materials[member.material]
        E, G, rho, inertia = material.modulus, material.rigidity, material.density, np.array(section.inertia)[::-1]
        links.append(
            {
                "name": label,
                "first": first.tolist(),
                "last": last.tolist(),
                "axes": SPACE.axes(last - first, np.array(member.up)).tolist(),
                "EA": E * section.area,
                "GA": SHEAR * G * section.area,
                "GJ": G * section.torsion,
                "EI": (E * inertia).tolist(),
                "rA": rho * section.area,
                "rI": (rho * inertia).tolist(),
            }
        )
    bodies = [
        {
            "name": name,
            "mass": link.rigid.mass,
            "inertia": np.diag(link.rigid.inertia).tolist(),
            "centre": link.rigid.centre,
        }
        for name, link in scene.links.items()
        if link.rigid is not None
    ]
    points = []
    for damper in scene.dampers.values():
        if isinstance(damper, fm.PointDamper):
            points.append([*_at(damper.at), damper.damping])
        else:
            dampers[damper.joint] = damper.damping  # type: ignore[union-attr]
    joints = [_joint(scene, name) | {"damping": dampers.get(name, 0.0)} for name in scene.joints]
    return {
        "speed": scene.cycle_rate,
        "gravity": scene.gravity,
        "links": links,
        "bodies": bodies,
        "masses": [[*_at(mass.at), mass.mass] for mass in scene.masses.values()],
        "dampers": points,
        "joints": joints,
        "elements": elements,
        "steps": steps,
        "cycles": cycles,
        "angles": ANGLES,
    }


def _at(place: str) -> tuple[str, float]:
    name, s = place.split("@")
    return name, float(s)


def _joint(scene: fm.SpatialScene, name: str) -> dict[str, Any]:
    """Give what a joint of Exudyn holds, and its frames: the first axis is the joint's, a cross has the last two."""
    joint = scene.joints[name]
    sides, places = [], []
    for point in joint.connect:
        body, own = point.split(".")
        last = body in scene.links and bool(scene.links[body].members) and own != next(iter(scene.links[body].points))
        sides.append((body, float(last)))
        places.append(scene.point(point)[1])
    if joint.axes is not None:
        one, other = map(np.array, joint.axes)
        frame = SPACE.axes(np.cross(one, other), one)
        frames = [frame, frame]
    else:
        frame = SPACE.axes(np.array(joint.axis or Z))
        frames = [frame, frame]
    found = {"held": HELD[joint.kind], "bodies": sides, "places": places, "frames": [f.tolist() for f in frames]}
    if joint.misaligned is not None:
        assert np.allclose(frame[:, 1], joint.misaligned.about)
        found |= {key: found[key][::-1] for key in ("bodies", "places", "frames")}  # type: ignore[index]
        found["lean"] = joint.misaligned.by
    return found


def by_exudyn(stated: Mapping[str, Any], python: str) -> dict[str, Array]:
    """Let Exudyn solve a problem.

    Parameters
    ----------
    stated
        The problem.
    python
        The Python in which Exudyn is installed.

    Returns
    -------
    dict
        ``place`` (m) and ``moment`` (N m, in section axes) at mid member ``(angles, links, 3)``, ``torque`` (N m)
        ``(angles,)``, ``change`` of these three from the cycle before, and ``seconds`` of processor time.
    """
    with tempfile.TemporaryDirectory() as folder:
        one, other = Path(folder, "problem.json"), Path(folder, "result.npz")
        one.write_text(json.dumps(stated))
        script = Path(__file__).with_name("exudyn_space_run.py")
        subprocess.run([python, str(script), str(one), str(other)], check=True, stdout=subprocess.DEVNULL)
        with np.load(other) as stored:
            return dict(stored)


def by_us(scene: fm.SpatialScene, elements: int) -> dict[str, Array]:
    """Give the same of this program, and the elastic part of places ``elastic`` (m).

    Parameters
    ----------
    scene
        The machine.
    elements
        A member.
    """
    start = time.process_time()
    data = fm.analyse(scene.changed({"mesh.elements": elements})).data
    return read_off(data) | {"seconds": np.array(time.process_time() - start)}


def read_off(data: xr.Dataset) -> dict[str, Array]:
    """Read places, moments and torque at mid member off a dataset.

    Parameters
    ----------
    data
        Of an analysis.
    """
    middle = data.sel(s=0.5).isel(theta=slice(None, None, data.sizes["theta"] // ANGLES))
    found = {"place": middle["place"], "elastic": middle["deflection"], "moment": middle["section_moment"]}
    return {name: np.asarray(value) for name, value in found.items()} | {
        "torque": np.asarray(middle["input_torque"])[:, 0]
    }


def differences(found: Mapping[str, Array], exact: Mapping[str, Array]) -> Array:
    """Give the largest differences of places, moments and torque, over the largest elastic place, moment and torque.

    Parameters
    ----------
    found
        Of this program.
    exact
        The reference.
    """
    scales = (found["elastic"], exact["moment"], exact["torque"])
    return np.array(
        [
            np.linalg.norm(np.atleast_2d(found[name] - exact[name]), axis=-1).max()
            / np.linalg.norm(np.atleast_2d(scale), axis=-1).max()
            if name != "torque"
            else np.abs(found[name] - exact[name]).max() / np.abs(scale).max()
            for name, scale in zip(QUANTITIES, scales)
        ]
    )


def extrapolated(coarse: Mapping[str, Array], fine: Mapping[str, Array]) -> dict[str, Array]:
    """Extrapolate errors that are four times smaller with halved elements.

    Parameters
    ----------
    coarse, fine
        Of the two meshes.
    """
    return {name: (4 * fine[name] - coarse[name]) / 3 for name in QUANTITIES}


def compare(numbers: Sequence[int], seed: int, python: str) -> dict[str, Array]:
    """Compare machines, print the differences, and give what is stored.

    Parameters
    ----------
    numbers
        Of the machines.
    seed
        Of all.
    python
        The Python in which Exudyn is installed.
    """
    stored: dict[str, Array] = {}
    print("machine, speed (rad/s), largest elastic place (mm); differences of place, moment, torque (%):")
    for number in numbers:
        scene = drawn(number, seed)
        steps = STEPS * (2 if scene.analysis.positions > ANGLES else 1)
        coarse, fine = (by_exudyn(problem(scene, n, steps), python) for n in MESHES)
        exact = extrapolated(coarse, fine)
        runs = {n: by_us(scene, n) for n in (4, 8)}
        largest = float(np.linalg.norm(runs[8]["elastic"], axis=-1).max())
        change = fine["change"] / np.array([largest, 1.0, 1.0])
        print(f"{scene.name}, {scene.cycle_rate:.4g} rad/s, {1e3 * largest:.3g} mm", flush=True)
        for what, values in (
            ("Exudyn, last cycle from the one before", change),
            (f"Exudyn, {MESHES[1]} elements", differences(fine | {"elastic": runs[8]["elastic"]}, exact)),
            *((f"this program, {n} elements", differences(run, exact)) for n, run in runs.items()),
            ("this program, extrapolated", differences(runs[8] | extrapolated(runs[4], runs[8]), exact)),
        ):
            print(f"  {what}: " + ", ".join(f"{100 * value:.3g}" for value in values), flush=True)
        seconds = ", ".join(f"{float(run['seconds']):.3g}" for run in (coarse, fine, *runs.values()))
        print(f"  processor time (s) of Exudyn with {MESHES}, this program with 4 and 8: {seconds}", flush=True)
        stored[f"{number}_scene"] = np.array(scene.model_dump_json(by_alias=True))
        stored |= {f"{number}_{name}": exact[name] for name in QUANTITIES}
    return stored


def main() -> None:
    """Run the comparison from the command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machines", type=int, default=10)
    parser.add_argument("--only", type=int, nargs="*", help="numbers of the machines, instead of the first ones")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--exudyn", required=True, help="the Python in which Exudyn is installed")
    parser.add_argument("--out", type=Path, default=REFERENCE, help="file of the references; those of others stay")
    given = parser.parse_args()
    stored = compare(given.only or range(given.machines), given.seed, given.exudyn)
    if given.out.exists():
        with np.load(given.out) as before:
            stored = dict(before) | stored
    np.savez_compressed(given.out, **stored)


if __name__ == "__main__":
    main()
