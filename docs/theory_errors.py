"""How good each theory is, against Exudyn: `python docs/theory_errors.py` makes the tables and the picture anew.

It needs the extra `peers`, and takes about half an hour. `python docs/theory_errors.py draw` takes the table as it is,
and `add` runs the machines that it lacks.
"""

import csv
import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import process_time
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

import fenics_mech as fm
from benchmarks.converged import at_common_angles, extrapolated
from benchmarks.peers.compared import scene_of
from benchmarks.peers.exudyn_cycle import BeamStates, Integration, steady_cycle
from benchmarks.peers.peer_runs import EXACT
from fenics_mech.estimate.quantities import ERROR_VARIABLES, MEASURE
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.other_programs.beam_linkage import BeamLinkage, beam_linkage
from fenics_mech.scene.meshing import with_elements

DOCS = Path(__file__).parent
TABLE, PICTURE = DOCS / "validation" / "theory_errors.csv", DOCS / "images" / "theory_errors.png"
OF_QUANTITIES = DOCS / "validation" / "theory_quantities.csv"
OF_TOLERANCES = DOCS / "validation" / "theory_tolerances.csv"
MACHINES = {  # demos, and what their modulus and damping are multiplied by; stable, off and near resonances
    "four_bar": ((8, 1), (1.5, 1), (1, 1), (0.8, 1), (0.6, 1), (0.4, 4), (0.3, 6), (0.2, 12), (0.1, 20), (0.08, 25)),
    "slider_crank": ((1.0, 1), (0.3, 1), (0.1, 1), (0.08, 4), (0.045, 30)),
    "watt": ((1.0, 1), (0.2, 1), (0.05, 4), (0.04, 4), (0.03, 8)),
    "stephenson": ((1.0, 1), (0.2, 1), (0.06, 4)),
}
RUNGS = {
    "equation (5.1)": (),
    "coupling": ("coupling",),
    "geometric stiffness": ("coupling", "geometric-stiffness"),
    "large rotations": ("coupling", "large-rotations"),
}
TOLERANCES = (1e-2, 1e-3)
QUANTITIES = {"strain": "strain", "deflection": "deflection", "joint_force": "joint force", "torque": "torque"}
ANGLES, TIMED_ANGLES = 720, 120  # at which Exudyn gives its motion: joint forces have short peaks; and in timed runs
ELEMENTS, MESH, CHECK = 12, 12, 8  # elements a member here and in Exudyn
STEPS, FIRST_STEPS = 2880, 480  # a cycle of Exudyn, and in the cycles in which its start dies away
COARSE = ((2, 240), (4, 240), (4, 480), (6, 960), (8, 1440), (8, 2880), (12, 5760))  # its elements and steps
LEFT_OF_SHOCK = (
    0.1,
    0.001,
)  # of an error that is asked for: straight links that move at once vibrate more than steady ones
LEFT_OF_START = 1e-3  # of the start, after the coarse cycles, and of what these leave after the fine ones
Curves = dict[str, np.ndarray]
COLLOCATION = {"sub_intervals": 480, "stages": 3, "solver": "collocation"}
COLLOCATION |= {"stability": False, "allow_large": True, "allow_unstable": True, "allow_coarse": True}


def main() -> None:
    """Run every machine in every theory, and draw."""
    kept: list[dict[str, Any]] = []
    if sys.argv[1:] in (["draw"], ["add"]):
        with TABLE.open(newline="") as file:
            kept = list(csv.DictReader(file))
    rows = []
    for name, machine in [(name, machine) for name, machines in MACHINES.items() for machine in machines]:
        known = [row for row in kept if row["machine"] == label_of(name, *machine)]
        rows += known if known or sys.argv[1:] == ["draw"] else of_machine(name, *machine)
    write(rows, TABLE)
    write([of_rung(row) for row in rows if row["theory"] in list(RUNGS)[2:]], OF_QUANTITIES)
    write([of_tolerance(row) for row in rows if row["theory"].startswith("auto")], OF_TOLERANCES)
    draw(rows)


def write(rows: list[dict[str, Any]], file: Path) -> None:
    """Write a table."""
    with file.open("w", newline="") as opened:
        writer = csv.DictWriter(opened, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def shown(row: dict[str, Any]) -> dict[str, str]:
    """Give the true and told errors of a run as the page shows them (%)."""
    return {
        title: f"{100 * float(row[name]):.2g} ({100 * float(row[f'told_{name}']):.2g})"
        for name, title in QUANTITIES.items()
    }


def of_rung(row: dict[str, Any]) -> dict[str, Any]:
    """Give what the page shows of a theory."""
    return {"machine": row["machine"], "turn (rad)": row["turn"], "theory": row["theory"]} | shown(row)


def of_tolerance(row: dict[str, Any]) -> dict[str, Any]:
    """Give what the page shows of a run with a tolerance."""
    about = {
        "machine": row["machine"],
        "turn (rad)": row["turn"],
        "tolerance (%)": f"{100 * float(row['theory'].split()[-1]):g}",
        "last effect": row["effects"].split()[-1],
    }
    return about | shown(row) | {"seconds": row["seconds"], "Exudyn's seconds": row["peer_seconds"]}


@dataclass(frozen=True)
class Peer:
    """Exudyn's steady cycle of a machine.

    Parameters
    ----------
    scene, linkage
        The machine, and what Exudyn is given of it.
    decay
        What a cycle leaves of a disturbance.
    curves
        The quantities over the cycle, without the error of the time steps.
    error
        Error of each quantity by steps and elements, from runs with longer ones; they fall with powers of 4 and 2.
    periodicity
        Largest difference of a strain at the end of the cycle from that at its start.
    """

    scene: fm.Scene
    linkage: BeamLinkage
    decay: float
    curves: Curves
    error: dict[str, float]
    periodicity: float

    @classmethod
    def of(cls, scene: fm.Scene) -> "Peer":
        """Integrate until the start has died away."""
        linkage = beam_linkage(scene)
        settings = {f"analysis.{name}": value for name, value in (COLLOCATION | {"stability": True}).items()}
        multipliers = fm.analyse(with_elements(scene, 8).changed(settings)).data["multiplier"].to_numpy()
        decay = float(np.linalg.norm(multipliers, axis=-1).max())
        cycles = max(4, math.ceil(math.log(LEFT_OF_START) / math.log(decay)))

        def run(elements: int, steps: int) -> BeamStates:
            how = Integration(elements, (FIRST_STEPS,) * cycles + (steps,) * cycles, 1e-6)
            return steady_cycle(linkage, how, ANGLES, forces=True)

        runs = run(MESH, STEPS), run(MESH, STEPS // 2), run(MESH, STEPS // 4), run(CHECK, STEPS // 2)
        fine, half, quarter, other_mesh = (curves(scene, cycle) for cycle in runs)
        found, rough = (
            {name: extrapolated(curve, coarse[name], 2) for name, curve in finer.items()}
            for finer, coarse in ((fine, half), (half, quarter))
        )
        by_steps, by_mesh = errors(rough, found), errors(other_mesh, half)
        error = {name: by_steps[name] / 15 + by_mesh[name] / ((MESH / CHECK) ** 2 - 1) for name in found}
        return cls(scene, linkage, decay, found, error, runs[0].periodicity)

    def seconds(self, error: float) -> str:
        """Give the processor time of Exudyn's first run with an error of strain as small as this."""
        for left, (elements, steps) in product(LEFT_OF_SHOCK, COARSE):
            cycles = max(2, math.ceil(math.log(error * left) / math.log(self.decay)))
            how = Integration(elements, (steps // 2,) * (cycles // 2) + (steps,) * (cycles - cycles // 2))
            cycle = steady_cycle(self.linkage, how, TIMED_ANGLES, forces=True)
            if errors(curves(self.scene, cycle), self.curves)["strain"] <= error:
                return f"{cycle.seconds:.2f}"
        return f"more than {cycle.seconds:.0f}"


def label_of(name: str, factor: float, damped: float) -> str:
    """Give what the tables call a machine."""
    return f"{name}, E x {factor:g}" + (f", damping x {damped:g}" if damped != 1 else "")


def of_machine(name: str, factor: float, damped: float) -> Iterator[dict[str, Any]]:
    """Give the errors of all theories on a machine."""
    demo = fm.load(DOCS.parent / "demos" / f"{name}.toml")
    softer = {f"materials.{label}.modulus": factor * it.modulus for label, it in demo.materials.items()}
    scene = scene_of(demo.changed(softer).changed({"damping.ratio": damped * demo.damping.ratio}), EXACT)
    peer = Peer.of(scene)
    settings = {f"analysis.{key}": value for key, value in COLLOCATION.items()}
    meshed = with_elements(scene, ELEMENTS).changed(settings)
    scenes = {rung: meshed.changed(effects=effects) for rung, effects in RUNGS.items()}
    free = scene.changed({"effects": "auto", "analysis.solver": "auto"})
    scenes |= {f"auto, tolerance {tolerance:g}": free.changed(tolerance=tolerance) for tolerance in TOLERANCES}
    machine = label_of(name, factor, damped)
    for theory, stated in scenes.items():
        begun = process_time()
        try:
            result = fm.analyse(stated)
        except fm.MechanismError as error:
            print(machine, theory, str(error)[:200], flush=True)
            continue
        seconds = process_time() - begun
        row = {"machine": machine, "theory": theory} | compared(as_in_exudyn(result), peer.curves)
        row["effects"] = " ".join(result.scene.effects)
        row |= {f"peer_error_{what}": f"{error:.1e}" for what, error in peer.error.items()}
        row |= {"periodicity": f"{peer.periodicity:.1e}", "decay": f"{peer.decay:.2g}", "seconds": f"{seconds:.2f}"}
        yield row | {"peer_seconds": peer.seconds(stated.tolerance) if stated.tolerance else ""}
        print(*row.values(), flush=True)


def as_in_exudyn(result: fm.Result) -> fm.Result:
    """Give a result without rotary inertia, which Exudyn's beams lack."""
    effects = [name for name in result.scene.effects if name != "rotary-inertia"]
    return result if effects == list(result.scene.effects) else fm.analyse(result.scene.changed(effects=effects))


def curves(scene: fm.Scene, of: fm.Result | BeamStates) -> Curves:
    """Give the quantities of a motion over its cycle, by members, joints and drives.

    Strains are those at mid-span; deflections are differences from places of rigid links, of ends and mid-spans.
    """
    if isinstance(of, BeamStates):
        labels = beam_linkage(scene).joints
        forces = np.stack([of.force[:, labels.index(name)] for name in scene.joints], axis=1)
        return {"strain": of.strain, "deflection": of.place - rigid(scene, len(of.place)), "joint_force": forces} | {
            "torque": of.torque[:, None]
        }
    at, dimensions = of.data, ("theta", "member", "s", "component")
    at = at.sel(s=[0, 0.5, 1]) if 0.5 in at["s"] else at.interp(s=[0, 0.5, 1], method="cubic")
    return {
        "strain": at["strain"].sel(s=0.5).transpose("theta", "member", "fibre").to_numpy(),
        "deflection": at["deflection"].transpose(*dimensions).to_numpy(),
        "joint_force": at["joint_force"].transpose("theta", "joint", "component").to_numpy(),
        "torque": at["drive_effort"].transpose("theta", "drive").to_numpy(),
    }


def rigid(scene: fm.Scene, angles: int) -> np.ndarray:
    """Give places of both ends and the middle of the rigid members, ``(angles, members, 3, 2)``."""
    motion = solve_motion(scene, scene.drive_angles(angles))
    ends = np.array(
        [
            [motion.of_point(link, end)[0] for end in scene.member_ends(label)]
            for label, (link, _) in scene.members().items()
        ]
    )
    first, last = np.moveaxis(ends, (1, 2), (0, 1))
    return np.stack([first, (first + last) / 2, last], axis=2)


def errors(found: Curves, known: Curves) -> dict[str, float]:
    """Give the largest error of each quantity, relative to its measure."""
    by_quantity = {}
    for name, measure in measures(known).items():
        one, other = at_common_angles(found[name], known[name])
        by_quantity[name] = float((size(one - other, name) / measure).max())
    return by_quantity


def measures(known: Curves) -> Curves:
    """Give what errors are relative to: the largest of a member, or of all joint forces, see `accuracy.quantities`."""
    largest = {name: size(curve, name) for name, curve in known.items()}
    of_members = {
        name: np.maximum(largest[name], MEASURE.small_member * largest[name].max()) for name in ("strain", "deflection")
    }
    return largest | of_members | {"joint_force": largest["joint_force"].max(keepdims=True)}


def size(curve: np.ndarray, name: str) -> np.ndarray:
    """Give the largest magnitude of a quantity over the cycle, ``(members, joints or drives,)``."""
    magnitude = np.linalg.norm(curve, axis=-1) if name in ("deflection", "joint_force") else np.abs(curve)
    return magnitude.max(axis=(0, *range(2, magnitude.ndim)))


def compared(result: fm.Result, known: Curves) -> dict[str, str]:
    """Give the errors of a result, and what it tells of them by all sources and by the theory alone."""
    data = result.data
    row = {"effects": " ".join(result.scene.effects), "turn": f"{data['rotation'].max().item():.3g}"}
    row["vibration"] = f"{(data['vibration_amplitude'] / data['largest_strain'].max()).max().item():.2g}"
    row |= {name: f"{error:.2e}" for name, error in errors(curves(result.scene, result), known).items()}
    mid_span = size(curves(result.scene, result)["strain"], "strain") / data["largest_strain"].to_numpy()
    apart = {"effects"}  # that Exudyn leaves out as well
    if result.scene.tolerance is None:
        apart.add("stations")  # it has some at the places that are compared
    data = data.sel(source=[source for source in data["source"].to_numpy() if source not in apart])
    for name, measure in measures(known).items():
        told = data[f"{ERROR_VARIABLES[name][0]}_error"].transpose("source", ...).to_numpy()
        told = told * mid_span if name == "strain" else told  # it is told of a member's largest strain
        row[f"told_{name}"] = f"{(told.sum(axis=0) / measure).max():.2e}"
        of_theory = (told[data["source"].to_numpy() == "theory"] / measure).max(initial=0.0)
        row[f"theory_{name}"] = f"{of_theory:.2e}"
    return row | {"not_told": data.attrs.get("not_estimated", "")}


def draw(rows: list[dict[str, Any]]) -> None:
    """Draw true and estimated errors over the largest turn of an axis, which is that with large rotations."""
    plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "savefig.dpi": 110})
    figure, axes = plt.subplots(2, 2, figsize=(9, 7), layout="constrained", sharex=True, sharey=True)
    turns = {row["machine"]: float(row["turn"]) for row in rows if row["theory"] == "large rotations"}
    for axis, (name, title) in zip(axes.flat, QUANTITIES.items()):
        for rung, colour in zip(RUNGS, ("tab:red", "tab:orange", "tab:blue", "tab:green")):
            of_rung = [row for row in rows if row["theory"] == rung]
            turn = np.array([turns[row["machine"]] for row in of_rung])
            error, told = (np.array([float(row[key]) for row in of_rung]) for key in (name, f"theory_{name}"))
            axis.loglog(turn, 100 * error, "o", color=colour, markersize=4, label=rung)
            axis.loglog(turn[told > 0], 100 * told[told > 0], "o", color=colour, markersize=8, markerfacecolor="none")
        axis.plot([], [], "o", color="0.3", markersize=8, markerfacecolor="none", label="estimated by the program")
        axis.set_title(title, fontsize=10)
        axis.grid(color="0.92")
    figure.supxlabel("largest turn of an axis (rad)", fontsize=10)
    figure.supylabel("error (% of the peak)", fontsize=10)
    figure.legend(*axes[0, 0].get_legend_handles_labels(), frameon=False, loc="outside upper center", ncols=5)
    figure.savefig(PICTURE)


if __name__ == "__main__":
    main()
