"""Forces in the sections of members: along a member at one place of the motion, inside all that the motion reaches."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.views.figures import COLOURS, empty_figure, finish, new_axes
from fenics_mech.views.geometry import at_angles
from fenics_mech.views.plot_marks import number_of
from fenics_mech.views.reading import SECTION_FORCES, Reading, reading_of_members
from fenics_mech.views.words import in_degrees, sentence, short

MOST_MEMBERS = 3  # side by side in a figure
HEIGHT = 6.6  # inches, of the figure
TITLE: dict[str, Any] = {"x": 0.01, "ha": "left", "fontsize": 11, "fontweight": "bold"}
ENVELOPE: dict[str, Any] = {"color": COLOURS[0], "alpha": 0.15, "linewidth": 0, "label": "all that the motion reaches"}


def plot_section_forces(
    result: Result, member: str, axes: Axes | None = None, *, force: str = "moment", at: float | None = None
) -> Axes:
    """Plot a section force along a member at one place of the motion. Shaded is all that the motion reaches.

    Parameters
    ----------
    result
        The result.
    member
        Label of the member.
    axes
        Where to draw; without them a figure is made.
    force
        What is drawn: "axial_force" (tension positive), "shear_force" (dM/ds) or "moment".
    at
        Drive angle (rad), or time (s) of a motion in time; without it that of the member's largest stress.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    ViewError
        When there is no such member or force.
    ResultError
        When the result lacks what is drawn.

    Examples
    --------
    >>> axes = fm.plot_section_forces(fm.Result.load("out/result.nc"), "coupler", force="shear_force")
    >>> axes.get_ylabel()
    'shear force (N)'
    """
    axes, reading = axes or new_axes(), reading_of_members(result)
    if force not in SECTION_FORCES:
        raise ViewError(f"there is no section force {force!r}; there are {', '.join(SECTION_FORCES)}")
    i = number_of(reading, member)
    where = _draw(axes, reading, i, force, at)
    axes.set_xlabel(_along(reading, i))
    name, kind = SECTION_FORCES[force]
    finish(axes, f"{sentence(name)} of {member} at {where}", f"{name} ({reading.units.label(kind)})")
    return axes


def _draw(axes: Axes, reading: Reading, i: int, force: str, at: float | None) -> str:
    """Draw a force along a member with all that the motion reaches, and say where in the motion it is."""
    values = reading.section_force(force)[:, i]
    x = reading.s * reading.lengths[i] / reading.units.size("length")
    now, where = _at(reading, values, reading.peaks[i].k, at)
    if len(values) > 1:
        axes.fill_between(x, values.min(axis=0), values.max(axis=0), **ENVELOPE)
    axes.plot(x, now, color=COLOURS[0], label="at this place of the motion")
    axes.axhline(0, color="#888888", linewidth=0.8, zorder=1.5)
    axes.set_xlim(x[0], x[-1])
    return where


def _at(reading: Reading, values: Array, peak: int, at: float | None) -> tuple[Array, str]:
    """Values at a drive angle (rad) or time (s), or at a position, and where that is in words."""
    if at is None:
        return values[peak], reading.at(peak)
    if not reading.in_time:
        return at_angles(reading.theta, values, np.array([at]))[0], in_degrees(at)
    time = reading.data["time"].to_numpy()
    if not time[0] <= at <= time[-1]:
        raise ViewError(f"the motion lasts from {time[0]:.6g} s to {time[-1]:.6g} s, and is asked for at {at:.6g} s")
    return np.array([np.interp(at, time, column) for column in values.T]), f"{short(at)} s"


def section_force_figure(result: Result) -> Figure:
    """Draw axial force, shear force and moment along the most stressed members, at the drive angles of their peaks."""
    reading = reading_of_members(result)
    shown = sorted(reading.ranked[:MOST_MEMBERS])
    figure, panels = empty_figure(len(SECTION_FORCES), HEIGHT, columns=len(shown))
    rows = [[row] for row in panels] if len(shown) == 1 else panels
    for row, (force, (name, kind)) in zip(rows, SECTION_FORCES.items()):
        row[0].set_ylabel(f"{name} ({reading.units.label(kind)})")
        for axes, i in zip(row, shown):
            where = _draw(axes, reading, i, force, None)
            if force == next(iter(SECTION_FORCES)):
                axes.set_title(f"{reading.members[i]} at {where}", fontweight="bold", loc="left", fontsize=10)
    for axes, i in zip(rows[-1], shown):
        axes.set_xlabel(_along(reading, i))
    handles, names = rows[0][0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=2, fontsize=8, frameon=False)
    few = f"; {len(shown)} of {len(reading.members)} members" * (len(shown) < len(reading.members))
    figure.suptitle(f"Forces in the sections when the stress of each member is largest{few}", **TITLE)
    return figure


def _along(reading: Reading, i: int) -> str:
    """Name the axis of the places along a member."""
    first, second = reading.ends[i]
    return f"{reading.units.label('length')} from {first} to {second}"
