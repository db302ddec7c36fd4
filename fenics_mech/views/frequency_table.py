"""Natural frequencies over the cycle: a table for people, and one in a file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from rich.markup import escape
from rich.table import Table

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech._files import write_whole
from fenics_mech.answers.modes_by_poses import LARGEST_KNOWN
from fenics_mech.views.tables import number, table_of
from fenics_mech.views.words import percent

TOLD = 0.005  # share of a frequency, from which spin and axial forces are told
MEANING = (
    "mesh error: share of the frequency, by halved elements; MAC (modal assurance "
    "criterion): likeness of a mode's shape at neighbouring positions, 1 where it hardly changes"
)
RUNNING_MEANING = (
    "frequencies are those of the mechanism held at each position; running: in the motion and under the loads, "
    "where spin and axial forces change them by up to {}"
)


def frequency_table(
    frequency: Array,
    assurance: Array,
    off: Array,
    supported: Mapping[str, float] | None = None,
    speed: tuple[str, float] | None = None,
    running: Array | None = None,
    theory: Array | None = None,
) -> Table:
    """Tabulate the range of each mode's frequency over the cycle, its error, and how surely it was tracked."""
    # frequency: natural frequencies (Hz), ``(angles, modes)``; assurance: MAC of each mode with itself at the next
    # position, ``(angles, modes)``; off: share by which the mesh has them wrong, ``(modes,)``; `LARGEST_KNOWN` means
    # that or more; supported: frequency of each member as a simply supported beam (Hz), by label; eq. (7.6); running:
    # frequencies about the motion (Hz), ``(angles, modes)``, NaN where they are not known. They have rows of their own
    # where spin and axial forces change one by `TOLD` or more; theory: share by which shear and rotary inertia, which
    # do not act, would lower each, ``(modes,)``. It has a column where one is `TOLD` or more
    units = [("Hz", 1.0)] if speed is None else [("Hz", 1.0), (speed[0], TURN / speed[1])]
    gap = " " if speed is None else "\n"
    ranges = [f"{limit}{gap}({unit})" for unit, _ in units for limit in ("lowest", "highest")]
    theory = np.zeros(frequency.shape[1]) if theory is None else theory
    by_theory = theory.max(initial=0.0) >= TOLD
    errors = ["mesh error", *(["theory error"] if by_theory else [])]
    table = table_of("Natural frequencies over the cycle", "mode", *ranges, *errors, "lowest MAC")

    def span(curve: Array) -> Iterator[str]:
        return (number(size * limit) for _, size in units for limit in (curve.min(), curve.max()))

    for mode, (curve, mac, share) in enumerate(zip(frequency.T, assurance.T, off), 1):
        rigid = not curve.any()
        name = f"{mode}, rigid body" if rigid else str(mode)
        unknown = share >= LARGEST_KNOWN
        wrong = f"{LARGEST_KNOWN:.0%} or more" if unknown else "" if rigid else f"{100 * share:.2g} %"
        beside = [f"{100 * theory[mode - 1]:.2g} %" if theory[mode - 1] else ""] if by_theory else []
        table.add_row(name, *span(curve), wrong, *beside, f"{mac.min():.3f}")
    change = np.zeros(frequency.shape[1]) if running is None else changes(frequency, running)
    changed = np.flatnonzero(change >= TOLD)
    if running is not None and len(changed):
        table.add_section()
        for mode in changed:
            table.add_row(f"{mode + 1} running", *span(running[:, mode]), "", "")
    if supported:
        table.add_section()
        for member, value in supported.items():
            table.add_row(
                f"{escape(member)} simply supported", *(number(size * value) for _, size in units for _ in "12"), "", ""
            )
        by = "theory error: share that shear and rotary inertia would take off; " if by_theory else ""
        table.caption, table.caption_justify = f"{by}{MEANING}", "left"
    if running is not None and len(changed):
        diverges = "" if running[:, changed].all() else " (0: it diverges)"
        table.caption = f"{RUNNING_MEANING.format(percent(change.max()))}{diverges}; {table.caption}"
    return table


def changes(frequency: Array, running: Array) -> Array:
    """Give the largest share by which spin and axial forces change each frequency, ``(modes,)``."""
    elastic = frequency.any(axis=0) & np.isfinite(running).all(axis=0)
    found = np.zeros(len(elastic))
    found[elastic] = np.abs(running[:, elastic] / frequency[:, elastic] - 1).max(axis=0)
    return found


def write_frequencies(theta: Array, frequency: Array, path: Path) -> Path:
    """Write a CSV of the drive angle (rad) and each mode's frequency (Hz)."""
    header = ",".join(["theta_rad", *(f"mode_{mode}_Hz" for mode in range(1, frequency.shape[1] + 1))])
    rows = np.column_stack([theta, frequency])
    write_whole(path, lambda temporary: np.savetxt(temporary, rows, "%.12g", ",", header=header, comments=""))
    return path
