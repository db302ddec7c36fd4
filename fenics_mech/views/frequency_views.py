"""Natural frequencies for people: a table, a file, and the plot beside those of each member by itself."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from rich.markup import escape
from rich.table import Table

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech._files import write_whole
from fenics_mech.answers.modes_by_poses import LARGEST_KNOWN
from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.views.figures import angle_axis, curve, finish, logarithmic, new_axes
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
LABEL_HEIGHT = 0.05  # of the axes
MOST_BEYOND = 2  # labels of members whose frequencies lie above the axes, or below them


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
    errors = ["mesh error"] + ["theory error"] * bool(by_theory)
    table = table_of("Natural frequencies over the cycle", "mode", *ranges, *errors, "lowest MAC")

    def span(line: Array) -> Iterator[str]:
        return (number(size * limit) for _, size in units for limit in (line.min(), line.max()))

    for mode, (line, mac, share) in enumerate(zip(frequency.T, assurance.T, off), 1):
        rigid = not line.any()
        name = f"{mode}, rigid body" if rigid else str(mode)
        unknown = share >= LARGEST_KNOWN
        wrong = f"{LARGEST_KNOWN:.0%} or more" if unknown else "" if rigid else f"{100 * share:.2g} %"
        beside = [f"{100 * theory[mode - 1]:.2g} %" if theory[mode - 1] else ""] if by_theory else []
        table.add_row(name, *span(line), wrong, *beside, f"{mac.min():.3f}")
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
        table.caption = f"{by}{MEANING}"
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


def plot_frequencies(result: Result, axes: Axes | None = None) -> Axes:
    """Plot the natural frequencies over the drive angle, and beside them each member's own on two pins.

    Parameters
    ----------
    result
        The result.
    axes
        Where to draw; without them a figure is made.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    ViewError
        When the result has no natural frequencies.

    Examples
    --------
    >>> changes = {"effects": ["coupling"], "analysis.sub_intervals": 90}
    >>> fm.plot_frequencies(fm.analyse(fm.load("demos/four_bar.toml").changed(changes))).get_ylabel()
    'frequency (Hz)'
    """
    if "frequency" not in result.data:
        raise ViewError("the result has no natural frequencies: only periodic motions have")
    supported = {member: float(found[0]) for member, found in simply_supported_frequencies(result.scene).items()}
    frequency, theta = result.data["frequency"].to_numpy(), result.data["theta"].to_numpy()
    return draw_frequencies(frequency, theta, supported, axes or new_axes())


def draw_frequencies(frequency: Array, theta: Array, supported: Mapping[str, float], axes: Axes) -> Axes:
    """Draw tracked natural frequencies on a log axis that holds their range, the members' supported ones dashed."""
    # frequency: frequencies of the tracked modes (Hz), ``(angles, modes)``; theta: drive angles (rad), ``(angles,)``;
    # supported: frequency of each member as a simply supported beam (Hz), by label; eq. (7.6)
    bends = frequency.max(axis=0) > 0  # others are of a rigid body
    for mode in np.flatnonzero(bends):
        axes.plot(*curve(theta, frequency[:, mode]), label=f"mode {mode + 1}")
    frequency = frequency[:, bends]
    low, high = frequency.min() / 1.1, frequency.max() * 1.1
    logarithmic(axes, low, high)
    _draw_supported(axes, dict(sorted(supported.items(), key=lambda item: item[1])))
    angle_axis(axes)
    dashed = ". Dashed: each member simply supported" if any(low <= f <= high for f in supported.values()) else ""
    finish(axes, f"Natural frequencies{dashed}", "frequency (Hz)")
    return axes


def _draw_supported(axes: Axes, supported: Mapping[str, float]) -> None:
    """Draw a dashed line for each frequency, in rising order, and its label at the right edge, none upon another."""
    low, high = np.log(axes.get_ylim())
    grey: dict[str, Any] = {"color": "#555555", "linewidth": 0.9}
    named = _named(supported, *axes.get_ylim())
    places = (np.log([value for _, value in named]) - low) / (high - low)
    labels = _spread(np.clip(places, 0, 1), LABEL_HEIGHT)
    for (text, value), place, label in zip(named, places, labels):
        if 0 <= place <= 1:
            axes.axhline(value, linestyle=(0, (5, 3)), zorder=1.5, **grey)
            axes.plot([1, 1.015], [place, label], linestyle="-", transform=axes.transAxes, clip_on=False, **grey)
        axes.text(1.02, label, text, transform=axes.transAxes, va="center", fontsize=9, color="#333333")


def _named(supported: Mapping[str, float], low: float, high: float) -> list[tuple[str, float]]:
    """Write a label for each frequency (Hz): members that share one have one, and of those far beyond few are named."""
    shared: dict[str, list[str]] = {}
    for name, value in supported.items():
        shared.setdefault(f"{value:.4g}", []).append(name)
    found = [(names, supported[names[0]]) for names in shared.values()]
    below, above = ([one for one in found if beyond(one[1])] for beyond in (low.__gt__, high.__lt__))
    named = [(f"{_several(names)} {value:.4g} Hz", value) for names, value in found if low <= value <= high]
    for beyond, arrow in ((below[::-1], "\N{DOWNWARDS ARROW}"), (above, "\N{UPWARDS ARROW}")):
        labels = [(f"{_several(names)} {value:.4g} Hz {arrow}", value) for names, value in beyond[:MOST_BEYOND]]
        if more := sum(len(names) for names, _ in beyond[MOST_BEYOND:]):
            labels.append((f"{more} more {arrow}", beyond[MOST_BEYOND][1]))
        named += labels
    return sorted(named, key=lambda label: label[1])


def _several(names: list[str]) -> str:
    """Name one or two members, or the first of more."""
    return ", ".join(names) if len(names) < 3 else f"{names[0]} and {len(names) - 1} more"


def _spread(places: Array, gap: float) -> Array:
    """Push sorted places apart until neighbours are `gap` apart, each as little as its neighbours and 1 allow."""
    places = places.copy()
    for _ in range(200):
        places[-1:] = np.minimum(places[-1:], 1.0)
        missing = np.clip(gap - np.diff(places), 0, None)
        places[:-1] -= missing / 2
        places[1:] += missing / 2
    return places
