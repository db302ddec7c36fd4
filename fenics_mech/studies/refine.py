"""Refinement of a scene: strain, stress and frequency on finer meshes and with shorter steps, with observed order.

Three answers with steps h, h/2 and h/4 give their order of convergence. Richardson's extrapolation gives the answer in
the limit of no step at all.
Source: Roache, Verification and Validation in Computational Science and Engineering (1998), chapter 5.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.analysis import analyse
from fenics_mech.errors import SceneError
from fenics_mech.recovery import Result
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.recovery.result import stamp
from fenics_mech.scene import Scene, refined
from fenics_mech.scene.load_cases import refuse_cases
from fenics_mech.studies.natural_frequencies import modes

RATIO = 2  # of the numbers of elements, or of sub-intervals, from one level to the next
EXACT = 1e-11  # share of a value below which differences between levels are rounding
MODES = 3  # whose frequencies are followed
FEWEST = 8  # sub-intervals of a level
UNITS = {"strain": "1", "stress": "Pa", "frequency": "Hz"}


@dataclass(frozen=True)
class Refinement(OfScene):
    """What `refine` found."""

    # By `quantity`, `refinement` ("elements", for periodic motions "sub_intervals" too) and `level`: the `count` of
    # elements or sub-intervals, and the `value` (SI, in what says `unit`). Of the last three levels the `order` and the
    # `extrapolated` answer, NaN where they do not converge, and the `error` of the scene's own answer beside that.
    KIND: ClassVar[str] = "refinement"
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech", "scene")


def refine(scene: Scene, levels: int = 3, progress: Callable[[str], None] = lambda level: None) -> Refinement:
    """Analyse a scene on finer and finer meshes, and with shorter and shorter steps."""
    # The scene is the second level of the steps, and the first of the meshes. All levels have the effects that it
    # calls for. Largest strains and stresses are those at the scene's stations and the coarsest level's angles. So
    # they converge as the equation does.
    if levels < 3:
        raise SceneError(f"{levels} levels show no order: 3 or more are needed", place="levels")
    refuse_cases(scene, "a refinement")
    if not scene.members():
        raise SceneError("no link has a member, and a refinement is of strains and frequencies", place="links")
    if scene.analysis.method == "periodic" and scene.tolerance is None:
        _counts(scene.analysis.sub_intervals, levels)  # before the first analysis
    progress("the scene as it is")
    lets = {"analysis.allow_coarse": True, "analysis.allow_ringing": True}  # the coarsest level too
    own = analyse(scene.changed({"tolerance": None} | lets))
    stated, by_steps = own.scene, own.scene.analysis.method == "periodic"
    results: dict[str, list[tuple[int, Result]]] = {"elements": [(int(own.data.attrs["elements"]), own)]}
    for level in range(1, levels):
        finer = refined(stated, level)
        progress(f"elements cut {level} times")
        result = analyse(finer)
        results["elements"].append((int(result.data.attrs["elements"]), result))
    if by_steps:
        results["sub_intervals"] = []
        for count in _counts(stated.analysis.sub_intervals, levels):
            progress(f"{count} sub-intervals")
            same = count == stated.analysis.sub_intervals
            result = own if same else analyse(stated.changed(analysis__sub_intervals=count))
            results["sub_intervals"].append((count, result))
    return Refinement(_labelled(results, scene))


def _counts(count: int, levels: int) -> list[int]:
    """Numbers of sub-intervals, the second of which is the scene's own."""
    if count % RATIO or count // RATIO < FEWEST:
        raise SceneError(
            f"{count} sub-intervals cannot be halved: an even number of {RATIO * FEWEST} or more is needed",
            place="analysis.sub_intervals",
        )
    return [count // RATIO * RATIO**level for level in range(levels)]


def _labelled(results: dict[str, list[tuple[int, Result]]], scene: Scene) -> xr.Dataset:
    """Label values, orders and extrapolated answers."""
    parts = []
    for refinement, levels in results.items():
        every = [len(result.data["theta"]) for _, result in levels]
        of_levels: list[dict[str, float]] = []
        for (_, result), count in zip(levels, every):
            found = _peaks(result, count // min(every))
            if refinement == "elements":
                found |= {f"frequency mode {i}": value for i, value in enumerate(_frequencies(result), 1)}
            of_levels.append(found)
        names = list(of_levels[0])
        values = np.array([[one.get(name, np.nan) for name in names] for one in of_levels])
        parts.append(_converged(refinement, [count for count, _ in levels], values, names))
    data = xr.concat(parts, "refinement", join="outer").assign_attrs(stamp(scene))
    quantities = [str(name) for name in parts[0]["quantity"].to_numpy()]  # of the meshes, which have all
    return data.sel(quantity=quantities).assign_coords(
        unit=("quantity", [UNITS[name.split(" ")[0]] for name in quantities])
    )


def _peaks(result: Result, every: int) -> dict[str, float]:
    """Largest strain and stress of each member at every so many positions."""
    found = {}
    for kind in ("strain", "stress"):
        curves = result.data[kind].isel(theta=slice(None, None, every))
        for member, value in zip(result.data["member"].to_numpy(), abs(curves).max(("theta", "s", "fibre")).to_numpy()):
            found[f"{kind} {member}"] = float(value)
    return found


def _frequencies(result: Result) -> list[float]:
    """Lowest natural frequencies at the first position (Hz)."""
    data = result.data
    if "frequency" not in data:
        data = modes(result.scene.changed(analysis__sub_intervals=FEWEST, analysis__modes=MODES)).data
    return data["frequency"].isel(theta=0).to_numpy()[:MODES].tolist()  # type: ignore[no-any-return]


def _converged(refinement: str, counts: Sequence[int], values: Array, names: Sequence[str]) -> xr.Dataset:
    """Give order and extrapolated answer of the last three of values, ``(levels, quantities)``."""
    order, extrapolated = richardson(values)
    own = values[1 if refinement == "sub_intervals" else 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.abs(own / extrapolated - 1)
    along = ("refinement", "quantity")
    return xr.Dataset(
        {
            "count": (("refinement", "level"), [list(counts)]),
            "value": (("refinement", "level", "quantity"), values[None]),
            "order": (along, order[None]),
            "extrapolated": (along, extrapolated[None]),
            "error": (along, error[None]),
        },
        {"refinement": [refinement], "level": np.arange(1, len(counts) + 1), "quantity": list(names)},
    )


def richardson(values: Array) -> tuple[Array, Array]:
    """Observed order and extrapolated value of the last three of ``(levels, quantities)``, each with half the steps."""
    coarse, middle, fine = values[-3:]
    first, second = middle - coarse, fine - middle
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = first / second
        order = np.where(ratio > 1, np.log(np.abs(ratio)) / np.log(RATIO), np.nan)
        extrapolated = fine + second / (ratio - 1)
    exact = np.maximum(np.abs(first), np.abs(second)) <= EXACT * np.abs(fine)
    return np.where(exact, np.nan, order), np.where(exact, fine, np.where(ratio > 1, extrapolated, np.nan))
