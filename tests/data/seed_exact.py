"""Strains of the seed as geometrically exact beams, by Exudyn: `python -m tests.data.seed_exact FILE`.

They share with this program's beams, link frames and periodic solver only the rigid-body position at which they start.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.peers.exudyn_cycle import BeamStates, Integration, import_exudyn, steady_cycle
from fenics_mech._arrays import Array
from fenics_mech.other_programs.beam_linkage import beam_linkage
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar

SEED_RETARDATION = 1.339e-4  # s: a damping ratio of 0.02 at 298.8 rad/s, the seed's coupler on two pins
MEMBERS = {"coupler": 1, "follower": 2}  # and their numbers among the members
ANGLES, CYCLES = 360, 16


def refined(coarse: BeamStates, fine: BeamStates) -> BeamStates:
    """Extrapolate to a vanishing step from curves of which the second has half the step of the first (Richardson)."""
    names = ("axial", "bending", "place")
    return replace(fine, **{name: (4 * getattr(fine, name) - getattr(coarse, name)) / 3 for name in names})


def between(one: BeamStates, other: BeamStates) -> Array:
    """Largest differences of fibre strains of two cycles, over the other's largest strain, ``(beams,)``."""
    return np.abs(one.strain - other.strain).max(axis=(0, 2)) / np.abs(other.strain).max(axis=(0, 2))


def exact_seed() -> Scene:
    """Give the seed with damping of the material alone."""
    return seed_four_bar(damping={"material": SEED_RETARDATION})


def converged_seed(elements: int = 32, steps: int = 5760) -> tuple[BeamStates, list[str]]:
    """Curves of the seed four-bar, extrapolated to a vanishing time step, and what their accuracy was measured to be.

    Returns
    -------
    tuple
        The curves, and lines that say how they were made and how far coarser ones are from them.
    """
    linkage = beam_linkage(exact_seed())

    def run(elements: int, steps: int) -> BeamStates:
        return steady_cycle(linkage, Integration(elements, (steps,) * CYCLES, 1e-6), ANGLES)

    runs = [run(elements, steps // n) for n in (4, 2, 1)]
    before, found = (refined(coarse, fine) for coarse, fine in pairwise(runs))
    rough = run(elements // 2, steps // 2)
    lines = [
        "Seed four-bar, 32.3 rad/s, as geometrically exact beams: strains of the outer fibres at mid-span,",
        "axial strains, and distances of the mid-spans from their chords along the normal (m).",
        f"Exudyn {import_exudyn().__version__}, {elements} ANCFCable2D elements a link, Kelvin-Voigt damping "
        f"{SEED_RETARDATION:g} s, {CYCLES} cycles from the rigid motion,",
        f"generalized-alpha with {steps // 2} and {steps} steps per cycle, extrapolated to step 0.",
        "Largest differences in coupler and follower, over the largest strain of each:",
    ]
    compared = {
        f"{steps // 2} steps from {steps}": between(runs[1], runs[2]),
        f"{steps} steps from step 0": between(runs[2], found),
        f"step 0 from {steps // 4} and {steps // 2} steps": between(before, found),
        f"{elements // 2} elements from {elements}, {steps // 2} steps": between(rough, runs[1]),
    }
    places = list(MEMBERS.values())
    lines += [f"  {what}: " + ", ".join(f"{value:.1e}" for value in by[places]) for what, by in compared.items()]
    return found, [*lines, f"  the end of a cycle from its start: {found.periodicity:.1e} at most"]


def write_curves(path: Path, curves: BeamStates, comment: list[str]) -> None:
    """Write curves of coupler and follower as CSV, angles in degrees, below a comment."""
    columns = {"theta_deg": 360 * np.arange(len(curves.axial)) / len(curves.axial)}
    for name, i in MEMBERS.items():
        columns |= {f"{name}_plus": curves.strain[:, i, 0], f"{name}_minus": curves.strain[:, i, 1]}
    columns |= {f"{name}_axial": curves.axial[:, i] for name, i in MEMBERS.items()}
    columns |= {f"{name}_deflection": curves.deflection[:, i] for name, i in MEMBERS.items()}
    rows = [",".join(f"{value:.7g}" for value in row) for row in zip(*columns.values())]
    path.write_text("\n".join([*(f"# {line}" for line in comment), ",".join(columns), *rows, ""]))


if __name__ == "__main__":
    write_curves(Path(sys.argv[1]), *converged_seed())
