"""Picture of a synthesis: the four-bar in its positions, and its function or its transmission angle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from fenics_mech._constants import MILLI
from fenics_mech.scene import FunctionTask, PathTask
from fenics_mech.views.figures import COLOURS, empty_figure, finish

if TYPE_CHECKING:
    from fenics_mech.studies.synthesis.synthesise import Synthesised

MOST_DRAWN = 3  # positions of the links
FADED = 0.35  # of those that are not the first


def synthesis_figure(found: Synthesised) -> Figure:
    """Draw a synthesised four-bar."""
    figure, ((left, right),) = empty_figure(columns=2, height=4.2, shared=False)
    _draw_links(left, found)
    _draw_curve(right, found)
    return figure


def _draw_links(axes: Axes, found: Synthesised) -> None:
    linkage, course = found.linkage, found.course
    turned = np.array(course.turned)
    which = np.unique(np.linspace(0, len(turned) - 1, MOST_DRAWN).astype(int))
    for k in which[::-1]:
        at = np.array([course.start + turned[k]])
        first, second = (complex(pin[0]) for pin in linkage.pins(at))
        corners = np.array([linkage.origin, first, second, linkage.pivot]) * MILLI
        axes.plot(corners.real, corners.imag, "-o", color=COLOURS[0], ms=4, alpha=1.0 if k == 0 else FADED)
        if not isinstance(found.task, FunctionTask):  # the point is fixed on the coupler
            plate = np.array([first, complex(linkage.points(at)[0]), second]) * MILLI
            axes.fill(plate.real, plate.imag, color=COLOURS[0], alpha=FADED * (1.0 if k == 0 else FADED), lw=0)
    fixed = np.array([linkage.origin, linkage.pivot]) * MILLI
    axes.plot(fixed.real, fixed.imag, "^", color="black", ms=8, label="fixed pivots")
    if not isinstance(found.task, FunctionTask):
        if linkage.turns:
            whole = linkage.points(np.linspace(0, 2 * np.pi, len(course.angles))) * MILLI
            axes.plot(whole.real, whole.imag, color=COLOURS[1], lw=0.8, alpha=FADED)
        points = linkage.points(course.angles) * MILLI
        axes.plot(points.real, points.imag, color=COLOURS[1], label="point of the coupler")
        places = found.task.path if isinstance(found.task, PathTask) else [pose.at for pose in found.task.positions]
        asked = np.array([complex(*place) for place in places]) * MILLI
        axes.plot(asked.real, asked.imag, "x", color="black", label="asked")
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("X (mm)")
    finish(axes, linkage.kind[:1].upper() + linkage.kind[1:], "Y (mm)", columns=2)


def _draw_curve(axes: Axes, found: Synthesised) -> None:
    """Draw the follower's angle over the crank's with the asked points, or the transmission angle."""
    linkage, course, task = found.linkage, found.course, found.task
    crank = np.degrees(course.angles)
    axes.set_xlabel("angle of the crank (deg)")
    if isinstance(task, FunctionTask):
        second = linkage.pins(course.angles)[1]
        follower = np.unwrap(np.angle((second - linkage.pivot) / linkage.follower))
        shift = 2 * np.pi * np.round((task.follower[0] - follower[0]) / (2 * np.pi)) if len(task.follower) == 3 else 0.0
        axes.plot(crank, np.degrees(follower + shift), color=COLOURS[0], label="four-bar")
        asked = follower[0] + shift + np.array(task.follower) - task.follower[0]
        at = np.degrees(course.start + np.array(course.turned))
        axes.plot(at, np.degrees(asked), "x", color="black", label="asked")
        finish(axes, "Function", "angle of the follower (deg)")
        return
    axes.plot(crank, np.degrees(linkage.transmission(course.angles)), color=COLOURS[0])
    axes.axhline(np.degrees(task.least_transmission), color="0.5", lw=1)
    axes.set_ylim(0, 90)
    finish(axes, "Transmission angle", "deg")
