"""The figure of a motion's freedoms: their angles and strokes, and their rates."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from fenics_mech._constants import MILLI
from fenics_mech.recovery import Result
from fenics_mech.scene.joints import effort_units
from fenics_mech.views.figures import empty_figure, finish
from fenics_mech.views.plot_marks import abscissa, over
from fenics_mech.views.reading import ForceReading

SHOWN = {"N m": ("deg", float(np.degrees(1.0))), "N": ("mm", MILLI)}  # unit of a freedom by that of its effort


def freedom_figure(result: Result) -> Figure:
    """Draw the angle or stroke of each freedom, and below it their rates."""
    reading, (figure, panels) = ForceReading(result), empty_figure(rows=2, height=5.8)
    efforts = effort_units(tuple(result.scene.freedoms), result.scene.joints)
    kinds = ("freedom_place", "Freedoms", ""), ("freedom_rate", "Their rates", "/s")
    for axes, (name, title, per) in zip(panels, kinds):
        for freedom, effort, values in zip(result.scene.freedoms, efforts, reading.of(name, "freedom").T):
            unit, factor = SHOWN[effort]
            axes.plot(*over(reading, factor * values), label=f"{freedom} ({unit}{per})")
        finish(axes, title, " or ".join(f"{unit}{per}" for unit in sorted({SHOWN[effort][0] for effort in efforts})))
    abscissa(panels[-1], reading)
    return figure
