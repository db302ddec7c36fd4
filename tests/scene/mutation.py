"""Files damaged by chance: what the fuzz tests and the long run of them feed the program.

Scenes are damaged as text and as data, solver options as data, drawings and measurements as bytes.
"""

import copy
import math
import random
import re
import tomllib
from collections.abc import Iterator
from typing import Any

from fenics_mech.scene.solver_options import OPTIONS
from tests.common import ROOT

TOKEN = re.compile(r'"[^"]*"|\b[\d.]+(e-?\d+)?\b|\b[A-Za-z_]\w*\b')
TEXTS = (
    "0", "-1", "1e308", "1e-300", "nan", "inf", '""', '"x"', "[]", "{}", "true", '"1 kg"', '"1 m"', '"-5 deg"',
    "[1,2,3]",
    '"ground.O"', "99999999999", '"slot"', '"é"', '"9**9**9 m"', "1e9", "[[[[1]]]]", '"coupler@0.5"', "1979-05-27",
    '"1e400 m"', "-0.0", '{kind="pulse"}',
)  # fmt: skip
VALUES: tuple[Any, ...] = (
    0, 1, -1, 2, 1e308, 1e-300, 1e30, -1e30, 1e-30, math.nan, math.inf, -math.inf, 10**9, 10**400, True, False,
    "", "x", "é", "a\nb", "\x00", "1 kg", "1 m", "-5 deg", "1e400 m", "9**9**9 m", "m", "ground.O", "crank.A",
    "coupler",
    "coupler@0.5", "coupler@0.0001", "slot", "weld", "prismatic", "auto", "all", "one", "static", "transient", "table",
    "quasi-static", "expression", "harmonics", "pulse", "1/theta", "sin(theta)", "1/cos(3*theta-1)", "theta**9**9", "+",
    [], [1, 2], [1, 2, 3], ["a", "b"], [[[[1]]]], [0] * 50, {}, {"kind": "pulse", "start": 0, "end": 1},
    {"kind": "expression", "formula": "1/(theta-3.3)"}, {"kind": "table", "angles": [0, 1], "values": [1, 2]},
    {"kind": "harmonics", "sine": [1.0]}, {"kind": "x"}, {"a": {"b": {"c": 1}}}, {"stiffness": 1e20, "damping": 1e20},
)  # fmt: skip
PARTS: dict[str, Any] = {  # whole tables that a demo may lack
    "springs": {"s": {"joint": "C", "stiffness": 1.0}, "t": {"between": ["ground.O", "coupler.B"], "stiffness": 10.0}},
    "dampers": {"d": {"joint": "B", "damping": 0.01}, "e": {"between": ["ground.O", "coupler.B"], "damping": 1.0}},
    "loads": {
        "p": {"at": "coupler@0.5", "force": [1, 2], "factor": {"kind": "pulse", "start": 1, "end": 2, "ramp": 0.1}},
        "l": {"member": "coupler", "line": [0, -1], "line_end": [0, 1], "axes": "member"},
    },
    "impulses": {"i": {"at": "B", "angle": "90 deg", "impulse": [0, 0.01]}},
    "gravity": [0, -9.81],
    "damping": {
        "ratio": [0.02, 0.01],
        "material": 1e-4,
        "external": 0.1,
        "relative": 0.1,
        "air": {"density": 1.2, "coefficient": 2},
    },
    "mesh": {"elements": 2, "grading": 1.2},
    "masses": {"m": {"at": "coupler.B", "mass": 0.1, "inertia": 1e-4}},
    "petsc": {"periodic_ksp_type": "gmres", "modes_eps_tol": 1e-9},
    "effects": ["coupling", "large-rotations"],
}


def damaged_text(text: str, chance: random.Random) -> str:
    """Delete a line, repeat one, or put something odd in a place of one; now and then, damage the bytes."""
    lines = text.split("\n")
    for _ in range(chance.choice([1, 1, 2])):
        i, kind = chance.randrange(len(lines)), chance.random()
        places = list(TOKEN.finditer(lines[i].split("#")[0]))
        if kind < 0.15 and len(lines) > 1:
            del lines[i]
        elif kind < 0.25:
            lines.insert(i, chance.choice(lines))
        elif kind < 0.28:
            lines[i] = lines[i][: chance.randrange(len(lines[i]) + 1)] + chance.choice('[]"\x00={')
        elif places:
            place, value = chance.choice(places), chance.choice(TEXTS)
            lines[i] = lines[i][: place.start()] + value + lines[i][place.end() :]
    return "\n".join(lines)


def damaged_data(data: dict[str, Any], chance: random.Random) -> dict[str, Any]:
    """Delete, replace, exchange, scale, misspell or repeat parts of a scene's data, one to three times."""
    data = copy.deepcopy(data)
    for _ in range(chance.choice([0, 0, 1, 2])):
        name = chance.choice(list(PARTS))
        data[name] = copy.deepcopy(PARTS[name])
    for _ in range(chance.choice([1, 1, 1, 2, 3])):
        places = list(_places(data))
        holder, key = chance.choice(places)
        kind = chance.random()
        if kind < 0.15:
            del holder[key]
        elif kind < 0.45:
            holder[key] = copy.deepcopy(chance.choice(VALUES))
        elif kind < 0.6:
            other, other_key = chance.choice(places)
            holder[key] = copy.deepcopy(other[other_key])
        elif kind < 0.8 and isinstance(holder[key], int | float):
            holder[key] = holder[key] * chance.choice([-1, 0, 1e-9, 1e-3, 0.5, 2, 1e3, 1e9])
        elif isinstance(holder, dict):
            holder[chance.choice([key + "x", key.upper(), "", "é", key[:-1], "a.b", "new"])] = holder[key]
        else:
            holder.append(holder[key])
    return data


HARMFUL = (  # of PETSc, which a scene must not name
    "modes_st_pc_python_type", "modes_eps_view", "periodic_ksp_monitor", "modes_options_file", "transient_ts_monitor",
    "stability_eps_view_values", "periodic_mat_type", "log_view", "modes_fn_python_type", "transient_ts_python_type",
)  # fmt: skip
OPTION_VALUES: tuple[Any, ...] = (
    *VALUES, "python", "shell", "ascii:victim.txt", "scene.toml:Solver", "gmres", "lu", "lu -log_view", "\x1b[31m",
    1e-9, 10**6,
)  # fmt: skip
PIECES = (  # of drawings and measurements
    b"", b"\0", b"\xff", b"\x1b[31m", b"-1", b"0", b"1e308", b"nan", b"1000000000000",
    b"*INCLUDE, INPUT=/etc/passwd\n",
    b'SystemCall "touch broken";', b'Include "/etc/passwd";', b"$EndNodes\n", b"{", b"}", b";", b",", b'"', b"\n",
    b"\r",
)  # fmt: skip


def damaged_options(chance: random.Random) -> dict[str, Any]:
    """Give one to three solver options: good ones, harmful ones and misspelt ones, with values of any kind."""
    found = {}
    for _ in range(chance.choice([1, 2, 3])):
        key = chance.choice([*OPTIONS, *HARMFUL * 10])
        if chance.random() < 0.1:
            key = chance.choice([key[:-1], key + "\0", key.upper(), "-" + key, key + " -log_view"])
        value = chance.choice(OPTION_VALUES)
        kind = OPTIONS.get(key)
        if chance.random() < 0.7 and kind and "enum" in kind:
            value = chance.choice(kind["enum"])
        elif chance.random() < 0.7 and kind and "minimum" in kind:
            value = chance.choice([kind["minimum"], kind["maximum"]])
        found[key] = value
    return found


def damaged_bytes(content: bytes, chance: random.Random) -> bytes:
    """Cut a file, repeat a part of it, change a byte, or put something odd into it, one to three times."""
    for _ in range(chance.choice([1, 1, 2, 3])):
        a, b = sorted(chance.randrange(len(content) + 1) for _ in range(2))
        b = min(b, a + 40)
        kind = chance.random()
        if kind < 0.1:
            content = content[:a]
        elif kind < 0.25:
            content = content[:b] + content[a:]
        elif kind < 0.5:
            content = content[:a] + bytes([chance.randrange(256)]) + content[a + 1 :]
        else:
            content = content[:a] + chance.choice(PIECES) + content[a if kind < 0.8 else b :]
    return content


def _places(part: Any) -> Iterator[tuple[Any, Any]]:
    """All places of nested data, as what holds them and the key there."""
    for key in list(part) if isinstance(part, dict) else range(len(part)):
        yield part, key
        if isinstance(part[key], dict | list):
            yield from _places(part[key])


def scenes() -> dict[str, str]:
    """Texts of all demos, by name."""
    return {path.stem: path.read_text() for path in sorted((ROOT / "demos").glob("*.toml"))}


def drawings() -> dict[str, bytes]:
    """Contents of all drawings, by the name of the file, and one for Abaqus."""
    found = {path.name: path.read_bytes() for path in sorted((ROOT / "meshes").glob("*.[gm][es][oh]"))}
    return found | {
        "bar.inp": b"*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n*ELEMENT, TYPE=T2D2\n1, 1, 2\n*ELSET, ELSET=crank\n1\n"
        b"*NSET, NSET=ground_O\n1\n"
    }


def data_of(text: str) -> dict[str, Any]:
    """Give the data of a good scene file."""
    return tomllib.loads(text)
