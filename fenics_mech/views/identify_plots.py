"""Pictures of an identification: what is predicted beside what was measured, and their differences."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech.studies.design.result_curves import Curve
from fenics_mech.views.figures import COLOURS, angle_axis, empty_figure, finish, save_all
from fenics_mech.views.study_units import number_unit

if TYPE_CHECKING:
    from fenics_mech.studies.design.identify import Identified

BAND = 2  # standard deviations of noise, that the band of the differences has on both sides
FAINT = 0.15  # opacity of that band
HEIGHTS = {"height_ratios": [3, 1]}


def plot_identified(found: Identified, folder: str | Path) -> list[Path]:
    """Make the plots of an identification in a folder: one of each curve, and one of all single numbers."""
    curves = [k for k, one in enumerate(found.observations) if isinstance(one.of, Curve)]
    figures = {f"prediction_{i}": curve_figure(found, k) for i, k in enumerate(curves, 1)}
    if len(curves) < len(found.observations):
        figures["prediction_numbers"] = numbers_figure(found)
    return save_all(figures, folder)


def curve_figure(found: Identified, which: int) -> Figure:
    """Draw a measured curve, what is predicted at the start and in the end, and the difference below."""
    one, part = found.observations[which], found.parts[which]
    assert isinstance(one.of, Curve)
    angle = np.degrees(one.of.angles) % 360
    order = np.argsort(angle)
    figure, (above, below) = empty_figure(rows=2, height=5.2, grid=HEIGHTS)
    told = number_unit(one.of, found.explorer.trials.design, one.values)
    first, last, measured = (v / told.size for v in (found.first[part], found.fit.predicted[part], one.values))
    above.plot(angle, measured, ".", color="0.45", ms=4, label="measured")
    above.plot(angle[order], first[order], "--", color=COLOURS[1], lw=1.1, label="at the start")
    above.plot(angle[order], last[order], color=COLOURS[0], label="in the end")
    above.plot([], [], color=COLOURS[0], alpha=FAINT, lw=8, label=f"{BAND} deviations of the noise, below")
    finish(above, "Prediction and measurement", told.label(one.text))
    noise = float(found.fit.noise[which]) / told.size
    below.axhspan(-BAND * noise, BAND * noise, color=COLOURS[0], alpha=FAINT, lw=0)
    below.plot(angle, measured - last, ".", color="0.45", ms=4)
    below.set_ylabel(told.label("difference"))
    angle_axis(below)
    return figure


def numbers_figure(found: Identified) -> Figure:
    """Draw the differences of single numbers in units of their deviation, at the start and in the end."""
    which = [k for k, one in enumerate(found.observations) if not isinstance(one.of, Curve)]
    figure, (axes,) = empty_figure(height=1.6 + 0.35 * len(which))
    _draw_numbers(axes, found, which)
    return figure


def _draw_numbers(axes: Axes, found: Identified, which: list[int]) -> None:
    rows = np.arange(len(which))[::-1]
    points = [found.parts[k].start for k in which]
    measured, noise = found.fit.data.values[points], found.fit.noise[which]
    axes.axvspan(-BAND, BAND, color=COLOURS[0], alpha=0.15, lw=0)
    axes.plot((measured - found.first[points]) / noise, rows, "s", color=COLOURS[1], mfc="none", label="at the start")
    axes.plot((measured - found.fit.predicted[points]) / noise, rows, "o", color=COLOURS[0], label="in the end")
    axes.set_yticks(rows, [found.observations[k].text for k in which])
    axes.set_ylim(-0.6, len(which) - 0.4)
    axes.set_xlabel("measured less predicted value, in standard deviations of the measurement")
    finish(axes, "Prediction and measurement", "")
