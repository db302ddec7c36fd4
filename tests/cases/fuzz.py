"""Scenes damaged by chance, through the commands: each gives an answer or an error of ours, never a traceback.

``python -m tests.cases.fuzz 2000`` is the long run, and ``python -m tests.cases.fuzz 1 1234`` repeats scene 1234.
"""

import copy
import io
import random
import re
import signal
import sys
import tempfile
import time
import tomllib
import traceback
from collections import Counter
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import typer

from fenics_mech import Scene
from fenics_mech.cli import app
from fenics_mech.errors import MechanismError
from fenics_mech.scene.writing import text_of
from tests.common import DEMOS, ROOT
from tests.scene.mutation import damaged_data

PATIENCE = 20  # seconds for a command: most take less than one
PATHS = [*sorted(DEMOS.rglob("*.toml")), *sorted((ROOT / "tests" / "cases" / "scenes").glob("*.toml"))]
UNITS = "mm", "m", "in", "kg", "N m", "rpm", "deg", "GPa", "MPa s", "N/m", "%", "1/s", "", "furlong"
WORDS = {  # what chance puts in the place of a word, by its key
    "method": ("periodic", "transient", "quasi-static", "static"),
    "solver": ("auto", "sub-intervals", "collocation", "harmonic-balance"),
    "kind": ("revolute", "prismatic", "slot", "weld", "friction", "clearance", "stop", "pulse", "table", "bushing"),
    "shape": ("rectangle", "round", "tube", "ellipse", "i", "custom", "laminate", "taper"),
    "effects": ("auto", ["coupling"], ["large-rotations"], ["geometric-stiffness"], ["shear"], []),
    "start": ("rigid", "static", "smooth", "periodic", "result.nc"),
}
SMALL = {"sub_intervals": 24, "stations": 5, "harmonics": 5, "cycles": 2}
COMMANDS = (  # after `check`, which all scenes go through
    *["run {s} -o {d} --no-plots --no-report"] * 6,
    *("modes {s} -o {d}", "effects {s}", "mesh {s} -o {d}", "balance {s} -o {d}/b.toml", "fatigue {s} -o {d}"),
    *["sweep {s} -o {d} --over {n}:2"] * 2,
    *("follow {s} -o {d} --over {n} --points 2 --most-points 4", "refine {s} -o {d}", "compare {s} -o {d}"),
    *("export {s} {d}/m.py", "export {s} {d}/m.mbd", "export {s} --matrices {d}/m.mat", "animate {s} -o {d}/m.png"),
)
OF_RESULTS = "report {r} -o {d}/r.html", "export {r} {d}/m.pvd {d}/m.mat {d}/strain.csv", "plot {r} -o {d}", "sound {r}"


MISUSED = typer.BadParameter.__mro__[2]  # the command line is refused: typer may have click in itself, or need it


class Late(BaseException):
    """A command that goes on for too long."""


def places(part: Any, path: str = "") -> list[tuple[Any, Any, str]]:
    """Give all places of nested data: what holds each, the key there, and the dotted path."""
    keys = list(part) if isinstance(part, dict) else range(len(part)) if isinstance(part, list) else ()
    here = [(part, key, f"{path}.{key}".lstrip(".")) for key in keys]
    return here + [one for _, key, where in here for one in places(part[key], where)]


def damaged(chance: random.Random, scenes: list[dict[str, Any]]) -> dict[str, Any]:
    """Give a scene with other words and units, tables of other scenes, and what `damaged_data` does."""
    data = copy.deepcopy(chance.choice(scenes))
    for _ in range(chance.choice((1, 1, 2, 3))):
        holder, key, _ = chance.choice(places(data))
        kind, known = chance.random(), [one for one in places(data) if one[1] in WORDS]
        if kind < 0.3 and known:
            holder, key, _ = chance.choice(known)
            holder[key] = copy.deepcopy(chance.choice(WORDS[key]))
        elif kind < 0.5 and isinstance(holder[key], str) and re.match(r"-?[\d.]", holder[key]):
            number = holder[key].split(" ")[0]
            holder[key] = chance.choice(
                (f"{number} {chance.choice(UNITS)}", f"1e{chance.randint(-9, 9)} {holder[key]}")
            )
        elif kind < 0.8:  # a table of another scene, in its place
            name, part = chance.choice(list(chance.choice(scenes).items()))
            old = data.get(name)
            data[name] = {**old, **copy.deepcopy(part)} if isinstance(old, dict) and isinstance(part, dict) else part
        else:
            data = damaged_data(data, chance)
    data["analysis"] = {**SMALL, **data["analysis"]} if isinstance(data.get("analysis"), dict) else dict(SMALL)
    if chance.random() < 0.9:
        data["analysis"] |= {key: SMALL[key] for key in ("sub_intervals", "cycles")}
    return data


def scene_of(chance: random.Random, scenes: list[dict[str, Any]]) -> dict[str, Any]:
    """Give a damaged scene; most are ones that can be read, as others get no further than that."""
    tries = 1 if chance.random() < 0.2 else 30
    while True:
        data, tries = damaged(chance, scenes), tries - 1
        try:
            text_of(data)
            Scene.read(copy.deepcopy(data))
        except TypeError:  # what TOML has no word for
            continue
        except MechanismError:
            if tries > 0:
                continue
        return data


def range_of(chance: random.Random, data: dict[str, Any]) -> str:
    """Give a number of a scene and a range about it, as the option --over takes them; half of them are speeds."""
    known = [(where, str(holder[key])) for holder, key, where in places(data) if isinstance(holder, dict)]
    found = [(where, re.fullmatch(r"(-?\d[\d.]*(?:e-?\d+)?)( .*)?", text)) for where, text in known]
    found = [(where, match) for where, match in found if match] or [("analysis.stations", re.match("(5)()", "5"))]
    speeds = [one for one in found if one[0].endswith("speed")]
    where, match = chance.choice(speeds if speeds and chance.random() < 0.5 else found)
    number, unit = float(match[1]), match[2] or ""
    if match[0].isdigit():
        return f"{where}={number:.0f}:{number + 1:.0f}"
    return f"{where}={0.9 * number:.6g}{unit}:{1.1 * number:.6g}{unit}"


def attempt(words: list[str]) -> str:
    """Run a command here, and say how it ended: "done", an error of ours by its kind, or the traceback."""

    def late(*_: object) -> None:
        raise Late

    signal.signal(signal.SIGALRM, late)
    signal.alarm(PATIENCE)
    try:
        with redirect_stdout(io.StringIO()), redirect_stderr(io.StringIO()) as said:
            app(words, standalone_mode=False)
        return f"noise: {said.getvalue()}" if "Warning" in said.getvalue() else "done"
    except (MechanismError, MISUSED, Late) as error:
        return type(error).__name__
    except BaseException:
        return traceback.format_exc()
    finally:
        signal.alarm(0)


def one(number: int, folder: Path) -> list[tuple[str, str]]:
    """Run the commands of one damaged scene, and give each with its end."""
    chance, scene, out = random.Random(number), folder / f"{number}.toml", folder / str(number)
    result = out / "result.nc"
    data = scene_of(chance, [tomllib.loads(path.read_text()) for path in PATHS])
    scene.write_text(text_of(data))
    into = {"s": scene, "d": out, "n": range_of(chance, data), "r": result}
    ends = []
    for command in ("check {s}", chance.choice(COMMANDS), chance.choice(OF_RESULTS)):
        if command not in OF_RESULTS or result.exists():
            words = [word.format_map(into) for word in command.split(" ")]
            ends.append((" ".join(words), attempt(words)))
    return ends


def main(count: int, first: int = 0) -> None:
    """Run so many scenes from a number on, and print tracebacks and how commands ended."""
    ends: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as made:
        for number in range(first, first + count):
            began = time.perf_counter()
            print(f"scene {number}", file=sys.stderr, flush=True)
            for command, end in one(number, Path(made)):
                odd = " " in end or end == "Late"
                ends[f"{command.split()[0]} {'traceback' if ' ' in end else end}"] += 1
                if odd:
                    print(f"## {number}: {command} ({time.perf_counter() - began:.0f} s)\n{end}", flush=True)
    print(*(f"{number:6d} {end}" for end, number in sorted(ends.items())), sep="\n")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
