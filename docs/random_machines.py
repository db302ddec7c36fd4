"""Machines drawn at random, against Exudyn: `python docs/random_machines.py` makes the table of `validation/theory.md`.

It needs the extra `peers`, and takes about twenty minutes. A number as an argument makes the rows of that machine only,
which are printed.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from theory_errors import QUANTITIES, TOLERANCES, Peer, as_in_exudyn, compared, shown, write

import fenics_mech as fm
from benchmarks.peers.compared import scene_of
from benchmarks.peers.exudyn_cycle import Integration, steady_cycle
from benchmarks.peers.peer_runs import EXACT
from fenics_mech.other_programs.beam_linkage import beam_linkage

TABLE = Path(__file__).parent / "validation" / "random_machines.csv"
MACHINES = range(20, 44)  # seeds of what is drawn
MODULUS, DENSITY, WIDTH = 71e9, 2714.0, 0.02  # aluminium
WITHOUT_MOTION = Integration(8, (1440,) * 40)  # where this program finds no motion that is stable: 40 cycles from rest
FREE = {"effects": "auto", "analysis.solver": "auto", "analysis.stability": True}


def main() -> None:
    """Compare the machines."""
    named = [int(seed) for seed in sys.argv[1:]]
    rows = [row for seed in named or MACHINES for row in of_machine(seed)]
    if not named:
        write(rows, TABLE)


def four_bar(rng: np.random.Generator, crank: float) -> dict[str, Any]:
    """Draw a four-bar whose crank turns round."""
    while True:
        coupler, follower, ground = rng.uniform(1.2, 4, 3) * crank
        least, *between, most = sorted([crank, coupler, follower, ground])
        if least == crank and crank + most < 0.93 * sum(between):
            return {
                "coupler": coupler,
                "follower": follower,
                "ground": ground,
                "branch": rng.choice(["open", "crossed"]),
            }


def slider_crank(rng: np.random.Generator, crank: float) -> dict[str, Any]:
    """Draw a slider-crank."""
    return {"rod": rng.uniform(1.6, 4) * crank, "offset": rng.uniform(-0.3, 0.3) * crank}


def scene_by(seed: int) -> fm.Scene:
    """Draw a machine: its links are strips, and turn at 3 to 15 % of the lowest frequency of a link on two pins."""
    rng = np.random.default_rng(seed)
    crank, is_four_bar = rng.uniform(0.05, 0.15), rng.random() < 0.7
    lengths = four_bar(rng, crank) if is_four_bar else slider_crank(rng, crank)
    flexible = [lengths[name] for name in ("coupler", "follower", "rod") if name in lengths]
    heights = [rng.uniform(0.006, 0.016) * np.mean(flexible) for _ in flexible]
    lowest = min(
        (np.pi / length) ** 2 * height * (MODULUS / DENSITY / 12) ** 0.5 for length, height in zip(flexible, heights)
    )
    of_crank = max(0.004, 2 * max(heights))
    return (fm.four_bar if is_four_bar else fm.slider_crank)(
        crank=crank,
        **lengths,
        sections=[fm.RectangleSection(width=WIDTH, height=height) for height in (of_crank, *heights)],
        material={"modulus": MODULUS, "density": DENSITY},
        speed=lowest * rng.uniform(0.03, 0.15),
        masses=tuple(rng.uniform((0.0, 0.02), (0.05, 0.1))),
        damping={"ratio": rng.uniform(0.01, 0.04)},
        mesh={"elements": 4},
        name=f"{'four-bar' if is_four_bar else 'slider-crank'} {seed}",
    )


def of_machine(seed: int) -> Iterator[dict[str, Any]]:
    """Compare one machine with all tolerances, or say why there is no motion, and whether that of Exudyn repeats."""
    scene = scene_of(scene_by(seed), EXACT)
    results, reason = [], ""
    for tolerance in TOLERANCES:
        try:
            results.append(as_in_exudyn(fm.analyse(scene.changed(FREE).changed(tolerance=tolerance))))
        except fm.MechanismError as error:
            reason = str(error)
    peer = Peer.of(scene) if results else None
    for row in (row_of(result, peer) for result in results) if peer else [without_motion(scene, reason)]:
        print(scene.name, *row.values(), sep="; ", flush=True)
        yield {"machine": scene.name} | row


def row_of(result: fm.Result, peer: Peer) -> dict[str, Any]:
    """Give the errors of a result."""
    row = compared(result, peer.curves)
    about = {"turn (rad)": row["turn"], "tolerance (%)": f"{100 * result.scene.tolerance:g}"}
    about |= {"last effect": row["effects"].split()[-1]} | shown(row)
    return about | {"strain uncertain by": f"{100 * peer.error['strain']:.2g}", "no motion": ""}


def without_motion(scene: fm.Scene, reason: str) -> dict[str, Any]:
    """Say why there is no motion, and how well the last of Exudyn's cycles repeats."""
    kind = "unstable" if "unstable" in reason else "a member buckles" if "buckles" in reason else "not found"
    try:
        cycle = steady_cycle(beam_linkage(scene), WITHOUT_MOTION, 120, forces=True)
        repeats = f"strains repeat to {100 * cycle.periodicity:.2g} %"
    except fm.MechanismError:
        repeats = "fails"
    empty = ("turn (rad)", "tolerance (%)", "last effect", *QUANTITIES.values(), "strain uncertain by")
    return dict.fromkeys(empty, "") | {"no motion": f"{kind}; Exudyn: {repeats}"}


if __name__ == "__main__":
    main()
