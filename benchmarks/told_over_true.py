"""What analyses tell of their errors over what these are: `python -m benchmarks.told_over_true`, machines by chance.

Each machine is analysed with few steps and elements, and again with four times as many of both. Its told error is that
of time steps, mesh and rounding; what theory and positions leave out is in both runs. Below 0.8 an estimate misleads.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np
import typer
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._console import tell
from fenics_mech.analysis import analyse
from fenics_mech.errors import AssemblyError, MechanismError
from fenics_mech.estimate.quantities import ERROR_VARIABLES
from fenics_mech.scene import Scene
from tests.frozen import drawn_scenes
from tests.machine import drawn_linkages

Tables = dict[str, Any]
FINER = 4  # times as many elements and sub-intervals has the reference
SAME = ("theory", "effects", "positions", "stations")  # sources that the reference has as well
STEPS, ELEMENTS = (36, 48), (2,)  # of a cycle, and of a member
LEAST = 1e-7  # of the largest value: smaller true errors are rounding of both runs
MISLEADING, WASTEFUL = 0.8, 3.0  # told over true, below and above it
SIZES = ("strain", "deflection", "joint_force", "torque")


def main(
    machines: Annotated[int, typer.Option(help="How many are drawn.")] = 60,
    seed: Annotated[int, typer.Option(help="By which they are drawn.")] = 2026,
    first: Annotated[int, typer.Option(help="Number of the first one.")] = 0,
) -> None:
    """Draw machines, analyse each twice, and print told over true errors of its largest values."""
    found: dict[str, list[float]] = {size: [] for size in SIZES}
    for number in range(first, first + machines):
        scene, begun = drawn(seed, number), time.monotonic()
        try:
            ratios = told_over_true(scene)
        except MechanismError as error:
            print(f"{number:3d} {scene.name:32} {type(error).__name__}: {str(error)[:150]}", flush=True)
            continue
        row = "  ".join(f"{size} {told:.1e}/{true:.1e} = {told / true:.2f}" for size, (told, true) in ratios.items())
        print(f"{number:3d} {scene.name:32} {row}  ({time.monotonic() - begun:.0f} s)", flush=True)
        for size, (told, true) in ratios.items():
            found[size].append(told / true)
    print(summary(found))


def drawn(seed: int, number: int, attempt: int = 0) -> Scene:
    """Draw the scene of a machine; kinds take turns, and one that locks is drawn anew.

    Parameters
    ----------
    seed, number, attempt
        What chance begins with.
    """
    rng = np.random.default_rng([seed, number, attempt])
    kind = list(KINDS)[number % len(KINDS)]
    try:
        tables = KINDS[kind](rng)
        if rng.random() < 0.3:
            tables["gravity"] = (0.0, -9.81)
        if rng.random() < 0.4 and tables.get("sections"):
            drawn_scenes.with_load(rng, tables)
        tables["mesh"] = {"elements": int(rng.choice(ELEMENTS))}
        steps = {"sub_intervals": int(rng.choice(STEPS)), "stations": 5, "allow_coarse": True, "stability": False}
        return Scene.read(tables | {"name": f"{kind} {number}", "analysis": steps, "effects": "auto"})
    except AssemblyError:
        return drawn(seed, number, attempt + 1)


def shafts(rng: np.random.Generator) -> Tables:
    """Drive a linkage over a shaft that twists."""
    return drawn_scenes.motors(rng, "auto")


KINDS = {
    "four-bar": lambda rng: drawn_scenes.machine(rng, drawn_linkages.four_bar, "auto"),
    "slider-crank": lambda rng: drawn_scenes.machine(rng, drawn_linkages.slider_crank, "auto"),
    "inverted slider-crank": lambda rng: drawn_scenes.inverted(rng, "auto"),
    "Watt six-bar": lambda rng: drawn_scenes.machine(rng, drawn_linkages.watt, "auto"),
    "weld": lambda rng: drawn_scenes.welds(rng, "auto"),
    "springs and dampers": lambda rng: drawn_scenes.springs(rng, "auto"),
    "rigid links": lambda rng: drawn_scenes.machine(rng, drawn_linkages.four_bar, "auto", 0.5),
    "Stephenson six-bar": lambda rng: drawn_scenes.machine(rng, drawn_linkages.stephenson, "auto"),
    "drive law": lambda rng: drawn_scenes.drive_laws(rng, "auto"),
    "shaft": shafts,
}


def told_over_true(scene: Scene) -> dict[str, tuple[float, float]]:
    """Give the told and the true error of the largest values, each over the largest value.

    Parameters
    ----------
    scene
        The scene.

    Returns
    -------
    dict
        By quantity. One that is exact, or that the machine has not, is left out.
    """
    result = analyse(scene)
    here, analysis = result.data, scene.analysis
    finer = {"mesh.elements": FINER * scene.mesh.elements, "effects": result.scene.effects}
    finer |= {"analysis.sub_intervals": FINER * analysis.sub_intervals, "analysis.error_estimates": False}
    exact = analyse(scene.changed(finer)).data
    found = {}
    for size in SIZES:
        name, _, place = ERROR_VARIABLES[size]
        if name not in here or not here[name].size:
            continue
        largest = float(np.abs(here[name]).max())
        true = float(off(here[name], exact[name]).max()) / largest if largest else 0.0
        if true > LEAST:
            found[size] = told(here, name, place) / largest, true
    return found


def off(here: xr.DataArray, exact: xr.DataArray) -> Array:
    """Give the differences at the positions that both have."""
    difference = here - exact.isel(theta=slice(None, None, FINER)).to_numpy()
    if "component" in difference.dims:
        difference = np.hypot(difference.isel(component=0), difference.isel(component=1))
    return np.abs(difference.to_numpy())


def told(here: xr.Dataset, name: str, place: str) -> float:
    """Give the told error of a variable at its worst place, by the sources that the reference has not."""
    errors = here[f"{name}_error"]
    errors = errors.sel(source=[source for source in errors["source"].to_numpy() if source not in SAME])
    return float(errors.sum("source").max(place))


def summary(found: dict[str, Sequence[float]]) -> str:
    """Write a line for each quantity: median, and shares below, within and above the limits."""
    lines = []
    for size, values in found.items():
        ratios = np.array(values)
        if not len(ratios):
            continue
        low, high = (ratios < MISLEADING).mean(), (ratios > WASTEFUL).mean()
        lines.append(
            f"{size:12} {len(ratios):3d} machines, median {np.median(ratios):.2f}, "
            f"{1 - low - high:.0%} within {MISLEADING:g} to {WASTEFUL:g}, {low:.0%} below (least {ratios.min():.2f}), "
            f"{high:.0%} above (most {ratios.max():.1f})"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    try:
        typer.run(main)
    except MechanismError as error:
        tell(f"error: {error}")
        sys.exit(1)
