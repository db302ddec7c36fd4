"""What a tolerance costs on every demo: `python docs/tolerance_costs.py` makes the table of `validation/cost.md` anew.

It takes about half an hour. Names of demos as arguments make rows of these only, which are printed.
"""

import csv
import math
import sys
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

import fenics_mech as fm
from fenics_mech.estimate.quantities import MEASURE
from fenics_mech.scene.meshing import with_elements

DOCS = Path(__file__).parent
TABLE, DEMOS = DOCS / "validation" / "tolerance_costs.csv", DOCS.parent / "demos"
TOLERANCES = 1e-2, 1e-3, 1e-4
LENIENT = {
    "analysis.stability": False,
    "analysis.error_estimates": False,
    "analysis.allow_coarse": True,
    "analysis.allow_unstable": True,
}


def main() -> None:
    """Run the demos."""
    named = sys.argv[1:]
    rows = [row_of(name) for name in named or sorted(file.stem for file in DEMOS.glob("*.toml"))]
    if named:
        return
    with TABLE.open("w", newline="") as file:
        writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def row_of(name: str) -> dict[str, str]:
    """Give what each tolerance leaves of an error and takes of time on a demo."""
    scene = fm.load(DEMOS / f"{name}.toml")
    row = {"demo": name} | {f"{100 * tolerance:g} %": run(scene, tolerance) for tolerance in TOLERANCES}
    print(*row.values(), sep="; ", flush=True)
    return row


def run(scene: fm.Scene, tolerance: float) -> str:
    """Say the true error, the estimated one in brackets, the time, and the elements and steps that were taken."""
    begun = process_time()
    try:
        found = fm.analyse(scene.changed(tolerance=tolerance))
    except fm.MechanismError as error:
        return f"refused after {process_time() - begun:.2g} s: {str(error).split(':')[0]}"
    seconds, steps = process_time() - begun, found.scene.analysis.sub_intervals
    equation = {"effects", "theory"} if scene.effects != "auto" else {"effects"}  # the reference leaves it out as well
    estimated = found.data["relative_error"].drop_sel(source=list(equation), errors="ignore").sum().item()
    taken = f"{estimated:.1e}), {seconds:.2g} s, {found.data.attrs['dofs']} dofs, {steps} steps"
    try:
        return f"{error_of(found):.1e} ({taken}"
    except fm.MechanismError:
        return f"({taken}"


def error_of(found: fm.Result) -> float:
    """Largest error of a strain, against 1.5 times the elements and twice the steps, as a tolerance measures it."""
    data, scene = found.data, found.scene
    finer: dict[str, Any] = LENIENT | {"tolerance": None}
    if periodic := scene.analysis.method == "periodic":
        finer["analysis.sub_intervals"] = 2 * scene.analysis.sub_intervals
    elements = math.ceil(1.5 * scene.mesh.elements)
    exact = fm.analyse(with_elements(scene, elements).changed(finer)).data["strain"].to_numpy()
    differs = np.abs(data["strain"].to_numpy() - (exact[::2] if periodic else exact))
    axes = tuple(i for i, name in enumerate(data["strain"].dims) if name != "member")
    largest = np.abs(exact).max(axes)
    return float((differs.max(axes) / np.maximum(largest, MEASURE.small_member * largest.max())).max())


if __name__ == "__main__":
    main()
