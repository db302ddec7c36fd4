"""How true estimated errors of hard cases are: `python docs/hard_estimates.py` makes the table of `validation/cost.md`.

Ten demos with four kinds of difficulty, each analysed with few elements and steps, and against three times the elements
and four times the steps. It takes about half an hour.
Names of demos as arguments make rows of these only, which are printed.
"""

import csv
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import fenics_mech as fm
from fenics_mech.estimate.quantities import MEASURE

DOCS = Path(__file__).parent
TABLE, DEMOS = DOCS / "validation" / "hard_estimates.csv", DOCS.parent / "demos"
MACHINES = (
    "composite_four_bar", "counterweighted_rocker", "four_bar", "jansen", "manipulator", "pulsating_column",
    "quick_return", "slider_crank", "stephenson", "watt",
)  # fmt: skip
PRESSED = ["coupling", "geometric-stiffness"]
KINDS: dict[str, tuple[float, float, list[str], str, int, int]] = {
    # times the speed, damping ratio, effects, solver, elements, sub-intervals
    "coarse": (1.0, 0.02, ["coupling"], "collocation", 2, 60),
    "lightly damped": (1.6, 0.003, ["coupling"], "collocation", 3, 180),
    "sub-intervals": (1.3, 0.01, [], "sub-intervals", 2, 120),
    "axial forces": (1.2, 0.005, PRESSED, "collocation", 2, 120),
}
LENIENT = {"allow_coarse": True, "allow_unstable": True}
FINER = {"solver": "collocation", "stability": False, "error_estimates": False}
KNOWN = 1e-5  # of the strain: smaller true errors are not told from those of the reference
NOT_COMPARED = ["effects", "theory", "joints", "stations", "positions"]  # which both answers share


def main() -> None:
    """Run the cases."""
    named = sys.argv[1:]
    rows = [row for name in named or MACHINES for row in rows_of(name)]
    if named:
        return
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def rows_of(name: str) -> Iterator[dict[str, str]]:
    """Compare the four kinds of one demo."""
    for kind in KINDS:
        row = {"demo": name, "case": kind, "estimate": "", "true error": "", "estimate over true error": ""}
        try:
            found = fm.analyse(scene_of(name, kind))
        except fm.MechanismError as error:
            row["estimate"] = f"refused: {type(error).__name__}"
        else:
            row |= compared(found, scene_of(name, kind, finer=True))
        print(*row.values(), sep="; ", flush=True)
        yield row


def compared(found: fm.Result, finer: fm.Scene) -> dict[str, str]:
    """Compare the estimated error of strains with that against a finer scene."""
    estimate = float(found.data["relative_error"].drop_sel(source=NOT_COMPARED, errors="ignore").sum())
    try:
        true = error_of(found, fm.analyse(finer))
    except fm.MechanismError as error:
        return {"estimate": f"{estimate:.1e}", "true error": f"not known: {type(error).__name__}"}
    ratio = f"{estimate / true:.2g}" if true > KNOWN else ""
    return {"estimate": f"{estimate:.1e}", "true error": f"{true:.1e}", "estimate over true error": ratio}


def scene_of(name: str, kind: str, *, finer: bool = False) -> fm.Scene:
    """Make a hard case of a demo, or its reference."""
    faster, ratio, effects, solver, elements, steps = KINDS[kind]
    content: dict[str, Any] = tomllib.loads((DEMOS / f"{name}.toml").read_text())
    drives = content.get("drive", [])
    for drive in drives if isinstance(drives, list) else [drives]:
        if "speed" in drive:
            number, unit = drive["speed"].split(" ", 1)
            drive["speed"] = f"{faster * float(number)} {unit}"
    if name == "pulsating_column":  # its load presses it, and its flywheel is not to be damped
        effects = [*effects, "geometric-stiffness"] if "geometric-stiffness" not in effects else effects
    else:
        content["damping"] = {"ratio": ratio}
    options = content["analysis"] | LENIENT | {"solver": solver, "sub_intervals": (4 if finer else 1) * steps}
    content["analysis"] = options | (FINER if finer else {})
    times = 3 if finer else 1
    content["mesh"] = content.get("mesh", {}) | {"elements": times * elements}
    for member in (one for link in content["links"].values() for one in link.get("members", {}).values()):
        if "elements" in member.get("mesh", {}):  # else the reference has the member's own error
            member["mesh"]["elements"] *= times
    content["effects"] = effects
    return fm.Scene.read(content)


def error_of(found: fm.Result, reference: fm.Result) -> float:
    """Largest error of a strain, as estimates measure it."""
    strain = found.data["strain"]
    exact = reference.data["strain"].to_numpy()[:: reference.data.sizes["theta"] // found.data.sizes["theta"]]
    axes = tuple(i for i, name in enumerate(strain.dims) if name != "member")
    largest = np.abs(exact).max(axes)
    measure = np.maximum(largest, MEASURE.small_member * largest.max())
    return float((np.abs(strain.to_numpy() - exact).max(axes) / measure).max())


if __name__ == "__main__":
    main()
