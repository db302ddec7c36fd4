"""Scenes drawn at random, whose answers are frozen: ``python -m tests.frozen.drawn_scenes`` writes them to `scenes`.

Those files are what was analysed: a later change of this module does not change them.
"""

import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from fenics_mech import Scene, analyse, load, write_scene
from fenics_mech.errors import AssemblyError
from tests.common import DEMOS, modes_of
from tests.machine import drawn_linkages as linkages

Tables = dict[str, Any]
SCENES = Path(__file__).parent / "scenes"
COUNT, SEED = 200, 1989
SHORTER: dict[str, Tables] = {  # of demos that take longer than 10 s
    "driven_pendulum": {"analysis.duration": 30.091, "analysis.sub_intervals": 200},
    "belt_friction": {"analysis.duration": 0.8, "analysis.sub_intervals": 400},
}
MATERIALS = ((71e9, 2714.0), (206e9, 7850.0), (114e9, 4430.0))  # aluminium, steel, titanium: E (Pa), density (kg/m^3)
COUPLED, LOADED, BENT = ("coupling",), ("coupling", "geometric-stiffness"), ("coupling", "large-rotations")
METHODS: dict[str, tuple[Any, Tables]] = {  # effects, and options of the analysis
    "coupling": (COUPLED, {"solver": "collocation"}),
    "geometric_stiffness": (LOADED, {"solver": "collocation"}),
    "large_rotations": (BENT, {"solver": "collocation"}),
    "auto": ("auto", {}),
    "sub_intervals": ((), {"solver": "sub-intervals", "sub_intervals": 240, "modes": 4}),
    "harmonic_balance": (COUPLED, {"solver": "harmonic-balance", "harmonics": 28}),
    "quasi_static": (LOADED, {"method": "quasi-static", "sub_intervals": 48}),
    "static": (BENT, {"method": "static"}),
    "transient": (COUPLED, {"method": "transient", "cycles": 1, "settled": 0.0, "time_tolerance": 1e-4}),
    "tolerance": ("auto", {}),
}


def machine(rng: np.random.Generator, draw: Any, method: str, rigid: float = 0.0) -> Tables:
    """Draw a linkage with sections, materials, masses, damping and speed, as real machines have them.

    Its links are 0.6 to 1.6 % of their length thick, and half of the scenes accept an answer with coarse steps.
    """
    tables = draw(rng).tables(rng, rng.uniform(0.2, 1.0), rigid)
    if all("rigid" in link for link in tables["links"].values()):
        return machine(rng, draw, method, rigid)
    modulus, density = MATERIALS[rng.integers(len(MATERIALS))]
    effects, analysis = METHODS[method]
    tables |= {"materials": {"m": {"modulus": modulus, "density": density, "poisson": 0.3}}, "effects": effects}
    tables |= {
        "mesh": {"elements": 3 if len(tables["links"]) < 5 else 2},
        "analysis": {"sub_intervals": 120, "stations": 5, **analysis},
    }
    if rng.random() < 0.5:
        tables["analysis"]["allow_coarse"] = True
    with_sections(rng, tables)
    with_speed(rng, tables)
    if method == "tolerance":
        tables["tolerance"] = 0.02
    return tables


def with_sections(rng: np.random.Generator, tables: Tables) -> None:
    """Give each link a section and a mass at its end, or its inertia."""
    material, tables["sections"], tables["masses"] = tables["materials"]["m"], {}, {}
    for name, link in tables["links"].items():
        places = [complex(*place) for place in link["points"].values()]
        length, breadth = max(abs(b - a) for a, b in pairwise(places)), rng.uniform(0.04, 0.08)
        height = rng.uniform(0.006, 0.016) * length * (5 if name == "crank" else 1)
        mass = material["density"] * breadth * length * height * length
        if "rigid" in link:
            centre = sum(places) / len(places)
            link["rigid"] = {"mass": mass, "inertia": mass * length**2 / 12, "centre": linkages.pair(centre)}
            continue
        for member in link["members"].values():
            member["section"] = name
        strip, tube = {"width": breadth * length, "height": height}, {"diameter": height, "thickness": 0.15 * height}
        shape, of_shape = ("tube", tube) if rng.random() < 0.2 else ("rectangle", strip)
        tables["sections"][name] = {"shape": shape, **of_shape}
        if rng.random() < 0.4:
            tables["masses"][name] = {"at": f"{name}.{list(link['points'])[1]}", "mass": rng.uniform(0.05, 0.5) * mass}


def with_speed(rng: np.random.Generator, tables: Tables) -> None:
    """Let the drive turn so fast that links have a strain of 1e-4 to 1e-3 by the rigid motion, and damp vibration.

    In each fifth machine the next multiple of the speed, from three on, is the lowest natural frequency instead.
    """
    quasi_static = {"method": "quasi-static", "sub_intervals": 24, "error_estimates": False, "allow_coarse": True}
    bare = {"drive": {"joint": "O", "speed": 1.0}, "effects": (), "tolerance": None, "analysis": quasi_static}
    scene = Scene.read(tables | bare)
    lowest = 2 * math.pi * float(modes_of(scene).frequency.min())
    speed = min((10 ** rng.uniform(-4, -3) / float(np.abs(analyse(scene).data["strain"]).max())) ** 0.5, lowest / 3)
    if rng.random() < 0.2:
        speed = lowest / math.ceil(lowest / speed)
    tables["drive"] = {"joint": "O", "speed": float(speed)}
    kept = tables["analysis"]
    if kept.get("method") == "transient":
        tables["drive"]["run_up"] = 2 * math.pi / float(speed)
    damping: tuple[Tables, ...] = ({"ratio": rng.uniform(0.01, 0.04)}, {"material": rng.uniform(0.02, 0.08) / lowest})
    tables["damping"] = damping[0 if kept.get("solver") == "sub-intervals" else rng.integers(2)]


def bending(rng: np.random.Generator, tables: Tables) -> tuple[str, str, float]:
    """Choose a member that bends, not that of the crank: its link, its name, and its length."""
    names = [name for name in tables["sections"] if name != "crank"]
    name = names[rng.integers(len(names))] if names else "crank"
    link = tables["links"][name]
    label, member = next(iter(link["members"].items()))
    a, b = (complex(*link["points"][end]) for end in member["ends"])
    return name, label, abs(b - a)


def force_of(tables: Tables, name: str, length: float) -> float:
    """Force at mid-span that bends a link on two pins to a strain of 1e-3 (N), by which loads and springs are sized."""
    section = tables["sections"][name]
    if section["shape"] == "tube":
        d, inner = section["diameter"], section["diameter"] - 2 * section["thickness"]
        resistance = math.pi * (d**4 - inner**4) / (32 * d)
    else:
        resistance = section["width"] * section["height"] ** 2 / 6
    return float(4e-3 * tables["materials"]["m"]["modulus"] * resistance / length)


def with_load(rng: np.random.Generator, tables: Tables) -> None:
    """Load a member by a force or along its length, so that it has a strain of 1e-4 to 1e-3 at mid-span."""
    name, label, length = bending(rng, tables)
    force = 10 ** rng.uniform(-1, 0) * force_of(tables, name, length)
    way = np.exp(1j * rng.uniform(-np.pi, np.pi))
    one = name if len(tables["links"][name]["members"]) == 1 else f"{name}.{label}"
    factors: tuple[Tables, ...] = (
        {},
        {"factor": {"kind": "harmonics", "mean": 1.0, "cosine": (0.5,), "sine": (0.0, 0.3)}},
        {"factor": {"kind": "pulse", "start": 1.0, "end": 2.5, "ramp": 0.5}},
    )
    factor = factors[0 if tables["analysis"].get("method") == "static" else rng.integers(len(factors))]
    spread = {"member": one, "line": linkages.pair(2 * force / length * way)}
    load = {"at": f"{one}@0.5", "force": linkages.pair(force * way)}, spread
    tables["loads"] = {"work": load[rng.integers(2)] | factor}


def inverted(rng: np.random.Generator, method: str) -> Tables:
    """Draw an inverted slider-crank: its guide is rigid, or the pin travels along the bent axis of its rocker."""
    tables = machine(rng, linkages.inverted, method, 0.5)
    rocker = tables["links"]["rocker"]
    if "members" in rocker and "block" not in tables["links"]:
        rocker["points"]["D"] = (abs(complex(*tables["ground"]["points"]["C"])) * 1.6, 0.0)
        del rocker["points"]["H"]
        rocker["members"] = {"CD": rocker["members"]["CD"]}
        crank, C = (
            complex(*place) for place in (tables["links"]["crank"]["points"]["A"], tables["ground"]["points"]["C"])
        )
        rocker["angle"] = float(np.angle(crank * np.exp(1j * tables["links"]["crank"]["angle"]) - C))
        tables["joints"]["S"] = {"kind": "slot", "connect": ("rocker.C", "crank.A"), "member": "CD"}
        with_speed(rng, tables)
    return tables


def welds(rng: np.random.Generator, method: str) -> Tables:
    """Weld an arm with a mass to the coupler of a four-bar."""
    tables = machine(rng, linkages.four_bar, method)
    coupler = tables["links"]["coupler"]
    long = 0.5 * complex(*coupler["points"]["B"]).real
    turn, mass = float(rng.uniform(-2, 2)), {"at": "arm.T", "mass": rng.uniform(0.0, 0.02)}
    member = {"ends": ("W", "T"), "section": "coupler", "material": "m"}
    arm = {"points": {"W": (0.0, 0.0), "T": (long, 0.0)}, "members": {"WT": member}}
    tables["links"]["arm"] = arm | {"angle": coupler["angle"] + turn}
    tables["joints"]["W"] = {"kind": "weld", "connect": ("coupler.P", "arm.W"), "angle": turn}
    tables["masses"]["T"] = mass
    with_speed(rng, tables)
    return tables


def springs(rng: np.random.Generator, method: str) -> Tables:
    """Join points and links of a linkage by springs and dampers."""
    tables = machine(rng, LINKAGES[rng.integers(len(LINKAGES))], method)
    name, _, length = bending(rng, tables)
    stiffness = force_of(tables, name, length) / length
    rate = stiffness / tables["drive"]["speed"]
    point = f"{name}.{list(tables['links'][name]['points'])[1]}"
    tables["springs"] = {"line": {"between": ("ground.O", point), "stiffness": rng.uniform(0.02, 0.2) * stiffness}}
    if "C" in tables["joints"]:
        tables["springs"]["hinge"] = {"joint": "C", "stiffness": rng.uniform(0.02, 0.2) * stiffness * length**2}
    tables["dampers"] = {"line": {"between": ("ground.O", point), "damping": rng.uniform(0.01, 0.1) * rate}}
    if "A" in tables["joints"]:
        tables["dampers"]["hinge"] = {"joint": "A", "damping": rng.uniform(0.001, 0.01) * rate * length**2}
    return tables


def with_rigid_links(rng: np.random.Generator, tables: Tables) -> None:
    """Let all links be rigid, with masses of 0.2 to 1 kg."""
    for link in tables["links"].values():
        (*_, a), (*_, b) = list(link["points"].items())[:2]
        size, mass = abs(complex(*b) - complex(*a)), rng.uniform(0.2, 1.0)
        link["rigid"] = {"mass": mass, "inertia": mass * size**2 / 12, "centre": (size / 2, 0.0)}
        del link["members"]
    for key in ("sections", "materials", "masses", "damping", "effects"):
        tables.pop(key, None)


def motors(rng: np.random.Generator, method: str) -> Tables:
    """Drive a linkage over a shaft that twists; where a method has no such shaft, by a direct-current motor in time."""
    method = "auto" if method == "tolerance" else method  # which takes 40 s
    tables = machine(rng, (linkages.four_bar, linkages.slider_crank)[rng.integers(2)], method)
    name, _, length = bending(rng, tables)
    torque, speed = force_of(tables, name, length) * length, tables["drive"]["speed"]
    inertia = 20 * torque / speed**2
    if method in ("sub_intervals", "static", "harmonic_balance", "quasi_static", "transient"):
        del tables["drive"]
        effort = {"kind": "dc-motor", "stall_torque": 5 * torque, "no_load_speed": speed}
        tables["freedoms"] = {"O": {"effort": effort, "inertia": inertia, "speed": 0.5 * speed}}
        tables["analysis"] = {"method": "transient", "duration": 0.25 / speed, "sub_intervals": 24, "stations": 5}
        if method != "transient":  # the links are rigid, and it takes longer
            tables["analysis"] |= {"duration": 12.0 / speed, "sub_intervals": 96}
            with_rigid_links(rng, tables)
        return tables
    shaft = {"stiffness": rng.uniform(2, 20) * torque, "inertia": inertia, "damping": 0.2 * torque / speed}
    tables["drive"]["motor"] = shaft
    return tables


def drive_laws(rng: np.random.Generator, method: str) -> Tables:
    """Swing the crank of a linkage by a law of its drive."""
    tables = machine(rng, LINKAGES[rng.integers(len(LINKAGES))], method)
    speed = tables["drive"]["speed"]
    laws: tuple[Tables, ...] = (
        {"kind": "harmonics", "mean": 0.0, "sine": (rng.uniform(0.3, 1.2), rng.uniform(-0.2, 0.2))},
        {"kind": "expression", "formula": "0.8 * sin(theta) ** 3"},
        {"kind": "table", "values": tuple((0.7 * np.sin(np.linspace(0, 2 * np.pi, 13)[:-1]) ** 2).tolist())},
        {"kind": "rest-to-rest", "end": 1.0, "out": (0.05, 0.4), "back": (0.55, 0.95), "profile": "polynomial-4-5-6-7"},
    )
    tables["drive"] = {"joint": "O", "law": laws[rng.integers(len(laws))], "period": 2 * math.pi / speed}
    return tables


def joint_laws(rng: np.random.Generator, method: str) -> Tables:
    """Give a slider-crank of rigid links, driven or free, a law at one of its joints: its motion in time."""
    tables = linkages.slider_crank(rng).tables(rng, rng.uniform(0.2, 0.6), 0.0)
    with_rigid_links(rng, tables)
    tables["links"]["piston"] = {"points": {"B": (0.0, 0.0), "P": (0.0, 0.0)}, "rigid": {"mass": rng.uniform(0.1, 1.0)}}
    along = tables["joints"]["B"]["angle"]
    tables["joints"]["G"] = {"kind": "prismatic", "connect": ("ground.G", "piston.P"), "angle": along}
    tables["joints"]["B"] = {"connect": ("rod.B", "piston.B")}
    speed, resistance = float(rng.uniform(5, 30)), float(rng.uniform(5, 50))
    rubbing = {"kind": "friction", "coefficient": rng.uniform(0.05, 0.2), "width": 1e-2}
    hard = {"stiffness": 1e9, "restitution": 0.5}
    laws: tuple[Tables, ...] = (
        {"joint": "G", **rubbing},
        {"joint": "A", "radius": "10 mm", **rubbing},
        {"kind": "bushing", "joint": "B", "stiffness": ("1 kN/mm", "2 kN/mm"), "damping": (300.0, 300.0)},
        {"kind": "clearance", "joint": "B", "radial": "0.5 mm", "radius": "10 mm", "contact": hard},
        {"kind": "joint-effort", "joint": "G", "effort": {"kind": "formula", "formula": f"-{resistance:.6g} * omega"}},
    )
    tables["joint_laws"] = {"law": laws[rng.integers(len(laws))]}
    tables["analysis"] = {"method": "transient", "sub_intervals": 96}
    if rng.random() < 0.5:
        tables["drive"] = {"joint": "O", "speed": speed}
        tables["analysis"] |= {"cycles": 1, "settled": 0.0}
    else:
        tables["freedoms"] = {"O": {"speed": speed, "inertia": 0.02}}
        tables["analysis"] |= {"duration": 6.0 / speed}
    return tables


def laws(rng: np.random.Generator, method: str) -> Tables:
    """Give the drive or a joint a law."""
    return (drive_laws, joint_laws)[rng.integers(2)](rng, method)


def meshes(rng: np.random.Generator, method: str) -> Tables:
    """Cut the members of a linkage into more elements."""
    tables = machine(rng, LINKAGES[rng.integers(len(LINKAGES))], method)
    tables["mesh"] = {"elements": int(rng.integers(3, 8))}
    return tables


LINKAGES = (linkages.four_bar, linkages.slider_crank, linkages.watt, linkages.stephenson)
KINDS = {
    "four_bar": lambda rng, method: machine(rng, linkages.four_bar, method),
    "slider_crank": lambda rng, method: machine(rng, linkages.slider_crank, method),
    "inverted": inverted,
    "watt": lambda rng, method: machine(rng, linkages.watt, method),
    "stephenson": lambda rng, method: machine(rng, linkages.stephenson, method),
    "welds": welds,
    "rigid_links": lambda rng, method: machine(rng, LINKAGES[rng.integers(len(LINKAGES))], method, 0.5),
    "springs": springs,
    "motors": motors,
    "laws": laws,
    "meshes": meshes,
}


def drawn(number: int, attempt: int = 0) -> Scene:
    """Draw a scene: kinds take turns, and each kind meets all methods that it can. One that locks is drawn anew."""
    turn, place = divmod(number, len(KINDS))
    kind, method = list(KINDS)[place], list(METHODS)[(turn + place) % len(METHODS)]
    rng = np.random.default_rng([SEED, number + COUNT * attempt])
    try:
        tables = KINDS[kind](rng, method)
    except AssemblyError:
        return drawn(number, attempt + 1)
    if "drive" in tables and tables.get("sections"):
        if method == "static" or rng.random() < 0.3:
            tables["gravity"] = (0.0, -9.81)
        if method == "static" or rng.random() < 0.4:
            with_load(rng, tables)
    return Scene.read(tables | {"name": f"{kind} {turn:02d} {method}"})


def main() -> None:
    """Write all scenes: the demos as they are, those that take over 10 s for a shorter time, and what is drawn."""
    SCENES.mkdir(exist_ok=True)
    for path in DEMOS.rglob("*.toml"):
        if "plugin" not in path.parts:  # which needs its package
            write_scene(load(path).changed(SHORTER.get(path.stem, {})), SCENES / f"demo_{path.stem}.toml")
    for number in range(COUNT):
        scene = drawn(number)
        write_scene(scene, SCENES / f"{scene.name.replace(' ', '_')}.toml")


if __name__ == "__main__":
    main()
