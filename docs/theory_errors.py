"""How good each theory is, against Exudyn: `python docs/theory_errors.py` makes the table and the picture anew.

It needs the extra `peers`, and takes about ten minutes.
"""

import csv
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import fenics_mech as fm
from fenics_mech.scene.meshing import with_elements
from fenics_mech.studies.converged import difference, extrapolated
from fenics_mech.studies.peers.beam_linkage import beam_linkage
from fenics_mech.studies.peers.compared import _exudyn, scene_of
from fenics_mech.studies.peers.exudyn_cycle import Integration
from fenics_mech.studies.peers.peer_runs import EXACT

DOCS = Path(__file__).parent
TABLE, PICTURE = DOCS / "validation" / "theory_errors.csv", DOCS / "images" / "theory_errors.png"
OF_TOLERANCES = DOCS / "validation" / "theory_tolerances.csv"
MACHINES = {  # demos, and what their modulus is multiplied by: axes turn by 0.003 to 0.1 rad, off and near resonances
    "four_bar": (8.0, 1.5, 1.0, 0.8),
    "slider_crank": (1.0, 0.3, 0.1),
    "watt": (1.0, 0.2),
    "stephenson": (1.0, 0.2),
}
RUNGS = {
    "equation (5.1)": (),
    "coupling": ("coupling",),
    "geometric stiffness": ("coupling", "geometric-stiffness"),
    "large rotations": ("coupling", "large-rotations"),
}
TOLERANCES = (1e-2, 1e-3)
STEPS, CYCLES, ELEMENTS = 2880, 14, 8  # after 9 cycles Exudyn's start is 5e-3 of a strain


def main() -> None:
    """Run every machine in every theory, and draw."""
    rows = [row for name, factors in MACHINES.items() for factor in factors for row in of_machine(name, factor)]
    write(rows, TABLE)
    write([of_tolerance(row) for row in rows if row["theory"].startswith("auto")], OF_TOLERANCES)
    draw(rows)


def write(rows: list[dict[str, Any]], file: Path) -> None:
    """Write a table."""
    with file.open("w", newline="") as opened:
        writer = csv.DictWriter(opened, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def of_tolerance(row: dict[str, Any]) -> dict[str, Any]:
    """Give what the page shows of a run with a tolerance."""
    return {
        "machine": f"{row['machine']}, modulus x {row['modulus_factor']:g}",
        "turn (rad)": row["turn"],
        "tolerance": row["theory"].split()[-1],
        "effects taken": row["effects"].replace(" ", ", "),
        "error": row["error"],
        "told": row["told"],
        "seconds": row["seconds"],
        "Exudyn's seconds": row["peer_seconds"],
    }


def of_machine(name: str, factor: float) -> Iterator[dict[str, Any]]:
    """Give the errors of all theories on a machine."""
    demo = fm.load(DOCS.parent / "demos" / f"{name}.toml")
    softer = {f"materials.{label}.modulus": factor * it.modulus for label, it in demo.materials.items()}
    scene = scene_of(demo.changed(softer), EXACT)
    begun = process_time()
    link = beam_linkage(scene)
    fine, half = (
        _exudyn(link, Integration(ELEMENTS, (n // 2,) * 4 + (n,) * CYCLES, 1e-6), lambda step: None)
        for n in (STEPS, STEPS // 2)
    )
    peer, took = extrapolated(fine, half, 2), process_time() - begun
    known = difference(fine, half).mid_span / 3
    analysis = {"sub_intervals": 240, "stages": 3, "solver": "collocation", "reduction": "none", "stability": False}
    passes = {"allow_large": True, "allow_unstable": True, "allow_coarse": True}
    settings = {f"analysis.{key}": value for key, value in (analysis | passes).items()}
    meshed = with_elements(scene, ELEMENTS).changed(settings)
    scenes = {rung: meshed.changed(effects=effects) for rung, effects in RUNGS.items()}
    free = scene.changed({"effects": "auto", "analysis.solver": "auto"})
    scenes |= {f"auto, tolerance {tolerance:g}": free.changed(tolerance=tolerance) for tolerance in TOLERANCES}
    for theory, stated in scenes.items():
        begun = process_time()
        try:
            result = fm.analyse(stated)
        except fm.MechanismError as error:
            print(name, factor, theory, str(error)[:200])
            continue
        yield (
            {"machine": name, "modulus_factor": factor, "theory": theory}
            | errors(result, peer)
            | {
                "seconds": f"{process_time() - begun:.2f}",
                "peer_error": f"{known:.1e}",
                "peer_seconds": f"{took:.1f}",
            }
        )
        print(f"{name}, modulus times {factor:g}, {theory}", flush=True)


def errors(result: fm.Result, peer: np.ndarray) -> dict[str, str]:
    """Give the error of the mid-span strains of a result, and what it tells of it."""
    data = result.data
    curves = np.stack([result.strain_at(str(member)) for member in data["member"].to_numpy()], axis=1)[..., None, None]
    scale = np.abs(curves).max() / np.abs(peer).max()  # both errors are shares of the same peak
    by_source = scale * data["relative_error"]
    theory = float(by_source.sel(source="theory")) if "theory" in data["source"] else 0.0
    return {
        "effects": " ".join(result.scene.effects),
        "turn": f"{data['rotation'].max().item():.3g}",
        "error": f"{difference(curves, peer).mid_span:.2e}",
        "told": f"{float(by_source.sum()):.2e}",
        "told_of_theory": f"{theory:.2e}",
        "not_told": data.attrs.get("not_estimated", ""),
    }


def draw(rows: list[dict[str, Any]]) -> None:
    """Draw true and told errors over the largest turn of an axis."""
    plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "savefig.dpi": 110})
    figure, axes = plt.subplots(figsize=(7.2, 4.4), layout="constrained")
    for (rung, _), colour in zip(RUNGS.items(), ("tab:red", "tab:orange", "tab:blue", "tab:green")):
        of_rung = [row for row in rows if row["theory"] == rung]
        turn, error, told = (
            np.array([float(row[key]) for row in of_rung]) for key in ("turn", "error", "told_of_theory")
        )
        axes.loglog(turn, 100 * error, "o", color=colour, markersize=5, label=rung)
        axes.loglog(turn[told > 0], 100 * told[told > 0], "o", color=colour, markersize=10, markerfacecolor="none")
    axes.plot([], [], "o", color="0.3", markersize=10, markerfacecolor="none", label="told by the result")
    axes.set(xlabel="largest turn of an axis (rad)", ylabel="error of the mid-span strain (% of the peak)")
    axes.grid(color="0.92")
    axes.legend(frameon=False)
    figure.savefig(PICTURE)


if __name__ == "__main__":
    main()
