"""The plot of natural frequencies over the drive angle, and beside them those of each member by itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fenics_mech._arrays import Array
from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.views.figures import angle_axis, curve, finish, logarithmic, new_axes

LABEL_HEIGHT = 0.05  # of the axes
MOST_BEYOND = 2  # labels of members whose frequencies lie above the axes, or below them


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
