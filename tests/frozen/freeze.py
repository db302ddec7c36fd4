"""Frozen answers to the scenes in `scenes`, and how far those of the present program are from them.

``python -m tests.frozen.freeze compare`` prints every variable whose difference is beyond the errors that are told, and
ends with 1 where there is one. ``write`` freezes the present answers. Both take names of scenes, and all without them.
"""

import argparse
import json
import math
import os
import re
import sys
import time
from collections.abc import Iterator
from contextlib import nullcontext
from dataclasses import asdict, dataclass, field
from hashlib import blake2b
from itertools import pairwise
from multiprocessing import get_context
from pathlib import Path
from typing import Any

os.environ.setdefault("OMP_NUM_THREADS", "1")  # sums over threads differ in their last digits

import numpy as np

from fenics_mech import MechanismError, analyse, load
from fenics_mech.estimate.quantities import ERROR_VARIABLES
from tests.frozen.told_errors import EXACT, told

FOLDER = Path(__file__).parent
SCENES, NUMBERS = FOLDER / "scenes", FOLDER / "numbers.npz"
POSITIONS, HARMONICS = 12, 8  # kept of a curve, evenly spread, and of its spectrum; of all positions the peak is kept
DROPPED = 26  # last bits of each number, so that the file is small: 26 bits are kept, and the digest has all
PEAK, ATTRIBUTE = " peak", "attrs."
OWN = ("state",)  # variables in coordinates of the present equation, which another has not
TOLD = re.compile(
    r".*(_error|_estimate|error_order|_residual|power_error)$|attrs\.(time_steps|dofs|cycle_change|condition)$"
)
CHOICES = ("gauge_s", "vibration_harmonic", "vibration_mode", "multiplier_mode", "multiplier_frequency")  # of a largest
PLACES = "theta", "time"


@dataclass(frozen=True)
class Answer:
    """What is frozen of an analysis.

    Parameters
    ----------
    numbers
        By variable the values at some positions, and with `PEAK` the largest sizes over all positions.
    texts
        What is told in words: the error in which the analysis ended, the solver, names of places.
    marks
        By variable a digest of all bits of its values.
    """

    numbers: dict[str, np.ndarray] = field(default_factory=dict)
    texts: dict[str, Any] = field(default_factory=dict)
    marks: dict[str, str] = field(default_factory=dict)


def answer_to(name: str) -> Answer:
    """Analyse a scene of the folder."""
    try:
        scene = load(SCENES / f"{name}.toml")
        data = analyse(scene).data
    except MechanismError as error:
        words = re.sub(r"-?\d[\d.]*(e[+-]?\d+)?", "#", str(error)).split()[:10]
        return Answer(texts={"error": f"{type(error).__name__}: {' '.join(words)}"})
    found = Answer()
    for variable, array in data.variables.items():
        values = array.to_numpy()
        if values.dtype.kind not in "biuf":
            found.texts[variable] = values.tolist()
        elif variable not in OWN:
            found.marks[variable] = blake2b(np.ascontiguousarray(values).tobytes(), digest_size=6).hexdigest()
            found.numbers.update(reduced(variable, array.dims, values.astype(float)))
    with_components(found.numbers)
    for key, value in data.attrs.items():
        if isinstance(value, int | float):
            found.numbers[ATTRIBUTE + key] = np.array(float(value))
    acting = [one["name"] for one in json.loads(data.attrs.get("effects", "[]")) if one["acts"]]
    found.texts.update(
        effects=acting, solver=data.attrs.get("solver", ""), warnings=len(json.loads(data.attrs["warnings"]))
    )
    if "not_estimated" in data.attrs or not scene.analysis.error_estimates:
        found.texts["not_estimated"] = True
    return found


def reduced(variable: str, dims: tuple[str, ...], values: np.ndarray) -> dict[str, np.ndarray]:
    """Keep some positions and the first harmonics of a variable, and its largest sizes over all positions."""
    if "harmonic" in dims:
        return {
            variable: values.take(range(min(HARMONICS, values.shape[dims.index("harmonic")])), dims.index("harmonic"))
        }
    if "theta" not in dims:
        return {variable: values}
    axis = dims.index("theta")
    count = values.shape[axis]
    kept = np.unique(np.arange(min(POSITIONS, count)) * count // min(POSITIONS, count))
    return {variable: values.take(kept, axis), variable + PEAK: np.fmax.reduce(np.abs(values), axis=axis)}


def with_components(numbers: dict[str, np.ndarray]) -> None:
    """Replace amplitudes and phases by cosine and sine components: the phase of a small amplitude is by chance."""
    for name in [name.removesuffix("_phase") for name in numbers if name.endswith("_phase")]:
        amplitude, phase = numbers.pop(f"{name}_amplitude"), numbers.pop(f"{name}_phase")
        numbers |= {f"{name}_cosine": amplitude * np.cos(phase), f"{name}_sine": amplitude * np.sin(phase)}


def packed(answer: Answer) -> dict[str, np.ndarray]:
    """Give an answer as two arrays of bytes: its layout, and its numbers by planes of bytes, which compress well."""
    layout = asdict(answer) | {"numbers": {name: values.shape for name, values in answer.numbers.items()}}
    flat = np.concatenate([[0.0], *(values.ravel() for values in answer.numbers.values())])
    bits = (flat.view(np.uint64) + np.uint64(2 ** (DROPPED - 1))) & ~np.uint64(2**DROPPED - 1)
    text = json.dumps(layout).encode()
    return {"layout": np.frombuffer(text, np.uint8), "numbers": bits.view(np.uint8).reshape(-1, 8).T.copy()}


def unpacked(layout: np.ndarray, numbers: np.ndarray) -> Answer:
    """Give back what `packed` made."""
    kept = json.loads(layout.tobytes())
    flat = np.ascontiguousarray(numbers.T).view(np.float64).ravel()
    ends = np.cumsum([1, *(math.prod(shape) for shape in kept["numbers"].values())])
    parts = {
        name: flat[a:b].reshape(shape)
        for (name, shape), (a, b) in zip(kept["numbers"].items(), pairwise(ends.tolist()))
    }
    return Answer(parts, kept["texts"], kept["marks"])


def read(names: list[str] | None = None) -> dict[str, Answer]:
    """Give the frozen answers to some scenes, or to all, by name."""
    with np.load(NUMBERS) as file:
        names = names or [key.removesuffix("/layout") for key in file.files if key.endswith("/layout")]
        return {name: unpacked(file[f"{name}/layout"], file[f"{name}/numbers"]) for name in names}


@dataclass(frozen=True)
class Difference:
    """How far a variable is from its frozen values: `relative` to the largest of them, and over the `told` error."""

    scene: str
    variable: str
    difference: float
    relative: float
    told: float
    remark: str = ""

    @property
    def ratio(self) -> float:
        """Difference over the told error; NaN where no error is told."""
        return self.relative / self.told if self.relative else 0.0


def differences(scene: str, frozen: Answer, present: Answer) -> Iterator[Difference]:
    """Give the difference of every variable that is not told of errors or a choice between nearly equal ones."""
    ends = [answer.texts.get("error", "an answer") for answer in (frozen, present)]
    if ends[0] != ends[1]:
        yield Difference(scene, "error", np.inf, np.inf, 0.1, f"{ends[0]!r} has become {ends[1]!r}")
        return
    same = at_same_positions(frozen, present)
    for variable in frozen.numbers:
        if variable.endswith(PEAK) or TOLD.match(variable) or variable in (CHOICES if same else (*CHOICES, *PLACES)):
            continue
        names = [variable] if same or variable + PEAK not in frozen.numbers else []
        names += [variable + PEAK] if variable + PEAK in frozen.numbers else []
        remark = "" if same or names == [variable] else "peaks alone, at other positions"
        apart = max(distance(frozen.numbers[name], present.numbers.get(name)) for name in names)
        largest = max(size_of(frozen.numbers[name]) for name in {variable, *names})
        relative = apart / largest if apart and largest else apart
        error = sum(told(answer.numbers, answer.texts, variable, largest) for answer in (frozen, present))
        yield Difference(scene, variable, apart, relative, error, remark)


def at_same_positions(frozen: Answer, present: Answer) -> bool:
    """Whether both have their kept values at the same drive angles and times."""
    pairs = [(frozen.numbers.get(name), present.numbers.get(name)) for name in PLACES]
    return all(a is b is None or distance(a, b) <= EXACT * size_of(a) for a, b in pairs)


def size_of(values: np.ndarray) -> float:
    """Give the largest size of any value; 0 of none."""
    return float(np.abs(values[np.isfinite(values)]).max(initial=0.0))


def distance(a: np.ndarray, b: np.ndarray | None) -> float:
    """Give the largest difference of any value; infinite where shapes differ, or one alone is a number."""
    if b is None or a.shape != b.shape or (np.isnan(a) != np.isnan(b)).any():
        return np.inf
    known = ~np.isnan(a) & (a != b)
    return float(np.abs(a - b)[known].max(initial=0.0))


def remarks(scene: str, frozen: Answer, present: Answer) -> Iterator[str]:
    """Say which words, choices and told errors differ, and which variables are new."""
    for key in sorted({*frozen.texts, *present.texts} - {"error"}):
        if (old := frozen.texts.get(key)) != (new := present.texts.get(key)):
            yield f"{scene}: {key} was {old}, and is {new}"
    for name in ERROR_VARIABLES.values():
        key = f"{ATTRIBUTE}{name[1]}error_estimate"
        old, new = (float(answer.numbers.get(key, np.array(0.0))) for answer in (frozen, present))
        if max(old, new) > 1e-6 and not 0.5 < new / (old or np.nan) < 2:
            yield f"{scene}: {key.removeprefix(ATTRIBUTE)} was {old:.2g}, and is {new:.2g}"
    if new_ones := sorted(set(present.numbers) - set(frozen.numbers)):
        yield f"{scene}: not frozen are {', '.join(new_ones)}"


def answers(names: list[str], jobs: int) -> Iterator[tuple[str, Answer]]:
    """Analyse scenes, in so many processes at a time, and say how long it took."""
    began = time.perf_counter()
    with get_context("spawn").Pool(jobs) if jobs > 1 else nullcontext() as pool:
        for name, answer in zip(names, pool.imap(answer_to, names) if pool else map(answer_to, names)):
            print(f"{time.perf_counter() - began:7.1f} s  {name}", file=sys.stderr, flush=True)
            yield name, answer


def write(names: list[str], jobs: int) -> None:
    """Freeze the present answers to scenes; those to others stay."""
    kept = read() if NUMBERS.exists() else {}
    known = {path.stem for path in SCENES.glob("*.toml")}
    kept = {name: answer for name, answer in kept.items() if name in known} | dict(answers(names, jobs))
    arrays = {f"{name}/{key}": part for name in sorted(kept) for key, part in packed(kept[name]).items()}
    np.savez_compressed(NUMBERS, **arrays)


def compare(names: list[str], jobs: int, everything: bool = False) -> int:
    """Print the differences beyond the told errors, and give their number; with `everything` all that are not 0."""
    frozen, found, said, same, count = read(names), list[Difference](), list[str](), 0, 0
    for name, present in answers(names, jobs):
        found += differences(name, frozen[name], present)
        said += remarks(name, frozen[name], present)
        same += sum(present.marks.get(key) == mark for key, mark in frozen[name].marks.items())
        count += len(frozen[name].marks)
    beyond = [one for one in found if one.ratio > 1]
    untold = [one for one in found if np.isnan(one.ratio) and one.relative > EXACT]
    shown = [one for one in found if one.relative] if everything else [*beyond, *untold]
    if shown:
        print(f"{'scene':34} {'variable':28} {'difference':>11} {'relative':>9} {'told':>9} {'ratio':>9}")
    for one in sorted(shown, key=lambda one: -np.nan_to_num(one.ratio, nan=-1.0)):
        numbers = f"{one.difference:11.3g} {one.relative:9.2g} {one.told:9.2g} {one.ratio:9.2g}"
        print(f"{one.scene:34} {one.variable:28} {numbers} {one.remark}".rstrip())
    print(*said, sep="\n", end="\n" if said else "")
    scenes = {one.scene for one in beyond}
    print(
        f"{len(names)} scenes, {count} variables: {same} are the same to the last bit; {len(beyond)} differ by more "
        f"than the told errors, in {len(scenes)} scenes, and {len(untold)} where no error is told"
    )
    return len(beyond)


def main(words: list[str] | None = None) -> int:
    """Run a command, and give its exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.frozen.freeze", description=__doc__)
    parser.add_argument("command", choices=("write", "compare"))
    parser.add_argument("names", nargs="*", help="scenes; all without them")
    parser.add_argument("--jobs", type=int, default=1, help="processes at a time")
    parser.add_argument("--all", action="store_true", help="show differences within the told errors too")
    stated = parser.parse_args(words)
    names = stated.names or sorted(path.stem for path in SCENES.glob("*.toml"))
    if stated.command == "write":
        write(names, stated.jobs)
        return 0
    return int(compare(names, stated.jobs, stated.all) > 0)


if __name__ == "__main__":
    sys.exit(main())
