"""Figures of the motion of rigid links: joint forces, and the angles and strokes of the freedoms."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._arrays import Array
from fenics_mech._constants import MILLI
from fenics_mech.forces.joint_forces import effort_units
from fenics_mech.recovery import Result
from fenics_mech.views.figures import SIZE, curve, empty_figure, finish, new_figure

SHOWN = {"N m": ("deg", float(np.degrees(1.0))), "N": ("mm", MILLI)}  # unit of a freedom by that of its effort


def rigid_force_figure(result: Result) -> Figure:
    """Draw the magnitude of each joint's force, and below it the torque or force of the first drive where there is one.

    Parameters
    ----------
    result
        The result of a scene of which no link bends.
    """
    driven = "input_torque" in result.data and bool(result.scene.drives or result.data["input_torque"].any())
    figure, panels = _panels(result, rows=1 + driven)
    forces = result.data["joint_force"].transpose("joint", "theta", "component")
    for joint, force in zip(forces["joint"].to_numpy(), forces.to_numpy()):
        panels[0].plot(*_over(result, np.linalg.norm(force, axis=-1)), label=f"joint {joint}")
    finish(panels[0], "Magnitude of the joint forces", "force (N)")
    panels[0].set_ylim(bottom=0)
    if driven:
        panels[1].plot(*_over(result, result.data["input_torque"].to_numpy()))
        slides = result.data["input_torque"].attrs["units"] == "N"
        finish(panels[1], *(("Drive force", "force (N)") if slides else ("Drive torque", "torque (N m)")))
    return figure


def freedom_figure(result: Result) -> Figure:
    """Draw the angle or stroke of each freedom, and below it their rates.

    Parameters
    ----------
    result
        The result of a motion with freedoms.
    """
    figure, panels = _panels(result, rows=2)
    efforts = effort_units(tuple(result.scene.freedoms), result.scene.joints)
    kinds = ("freedom_place", "Freedoms", ""), ("freedom_rate", "Their rates", "/s")
    for axes, (name, title, per) in zip(panels, kinds):
        for i, (freedom, effort) in enumerate(zip(result.scene.freedoms, efforts)):
            unit, factor = SHOWN[effort]
            axes.plot(*_over(result, factor * result.data[name].to_numpy()[:, i]), label=f"{freedom} ({unit}{per})")
        finish(axes, title, " or ".join(f"{unit}{per}" for unit in sorted({SHOWN[effort][0] for effort in efforts})))
    return figure


def _panels(result: Result, rows: int) -> tuple[Figure, Sequence[Axes]]:
    """Make a figure with axes over the drive angle, or over time for a motion in time."""
    height = 5.8 if rows > 1 else SIZE[1]
    if result.scene.analysis.method != "transient":
        return new_figure(rows, height)
    figure, axes = empty_figure(rows, height)
    time = result.data["time"].to_numpy()
    axes[-1].set_xlabel("time (s)")
    axes[-1].set_xlim(time[0], time[-1])
    return figure, axes


def _over(result: Result, values: Array) -> tuple[Array, Array]:
    """Abscissae and ordinates of a curve in a figure of `_panels`."""
    if result.scene.analysis.method == "transient":
        return result.data["time"].to_numpy(), values
    return curve(result.data["theta"].to_numpy(), values)
