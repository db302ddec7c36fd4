"""Names in a drawing that do not cover one another."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes

from fenics_mech._arrays import Array
from fenics_mech.views.figures import figure_in

WIDE, TALL = 0.62, 1.15  # of the font size, that a letter is wide and a line is tall
GAP, MOST = 2.0, 500  # distance of dots on a line (typographic points), and their largest number
FARTHER = (1.0, 2.2)  # distances that are tried
NAMES = 100  # dots that count as much as a name that is covered
DIRECTIONS = np.stack([np.cos(turn := np.arange(16) * np.pi / 8 + np.pi / 4), np.sin(turn)], axis=-1)


class Labels:
    """Names that do not cover one another, nor the lines of the drawing."""

    # lines: lines of the drawing in the units of the axes, ``(lines, 2, 2)``

    def __init__(self, axes: Axes, lines: Array) -> None:
        self.axes = axes
        self.boxes: list[Array] = []  # middle and half size of each name
        low, high = np.array([self.axes.get_xlim(), self.axes.get_ylim()]).T
        box = self.axes.bbox
        points = np.array([box.width, box.height]) * 72 / figure_in(self.axes).dpi
        self.point = float(np.max((high - low) / points))  # length of a typographic point in the units of the axes
        self.dots = np.concatenate([np.zeros((0, 2)), *(self._dotted(line) for line in lines)])

    def _dotted(self, line: Array) -> Array:
        """Points of a line at about equal distances, which a name must not cover."""
        count = int(np.clip(np.linalg.norm(line[1] - line[0]) / (GAP * self.point), 2, MOST))
        return np.asarray(np.linspace(line[0], line[1], count))

    def add(self, text: str, places: Array, distance: float, look: dict[str, Any]) -> None:
        """Write a name beside the place where it covers least."""
        # places: where it may stand, the best first, ``(places, 2)``
        half = np.array([WIDE * len(text), TALL]) * look["fontsize"] * self.point / 2
        reach = half / np.maximum(np.abs(DIRECTIONS), 1e-9)
        nearest = reach.min(axis=1, keepdims=True)
        arms = np.concatenate([(nearest + far * distance * self.point) * DIRECTIONS for far in FARTHER])
        middles = (places[:, None] + arms).reshape(-1, 2)
        middle = middles[int(np.argmin([self._covered(at, half) for at in middles]))]
        self.boxes.append(np.stack([middle, half]))
        x, y = middle
        self.axes.text(x, y, text, ha="center", va="center", zorder=6, **look)

    def _covered(self, middle: Array, half: Array) -> float:
        """Dots of lines in a box, and area of names that it covers, which counts more."""
        dots = float((np.abs(self.dots - middle) < half).all(axis=1).sum())
        if not self.boxes:
            return dots
        others = np.array(self.boxes)
        both = np.clip(half + others[:, 1] - np.abs(middle - others[:, 0]), 0, None)
        return dots + NAMES * float((both.prod(axis=1) / (4 * half.prod())).sum())
