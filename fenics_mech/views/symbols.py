"""Shapes that stand for supports, guides, sliders, springs and dampers in every drawing of a mechanism."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array

INK, SHADE, RIGID = "#222222", "#d9d9d9", "#a0a0a0"


@dataclass(frozen=True)
class Proportions:
    """Half widths and radii over the extent of the motion, and margins of the picture."""

    ribbon: float = 0.008
    outline: float = 0.0102
    pin: float = 0.013
    hole: float = 0.008
    peak: float = 0.026
    traced: float = 0.009
    mass: float = 0.02  # of the largest point mass
    load: float = 0.14  # length of the arrow of the largest load
    head: float = 0.035  # of it, the length of its head
    name: float = 0.018  # from a pin to its name, in both directions
    support: float = 0.045
    block: float = 0.018
    margin: float = 0.06  # around the motion
    bar: float = 0.17  # of the picture's width, kept free for the colour bar
    text: float = 0.1  # of its height, kept free for text above and below


DRAWN = Proportions()
TRIANGLE = np.array([[0, 0], [-0.6, -1], [0.6, -1]])  # of a support, below its point; of height 1
BLOCK_CORNERS = np.array([[-1.6, -1.0], [1.6, -1.0], [1.6, 1.0], [-1.6, 1.0]])  # of a slider's block
ARROWS = 7  # of a load along a member
COILS = 5  # of a spring


def support_strokes() -> Array:
    """Give the line under a support's triangle, and its hatch, ``(strokes, 2, 2)``."""
    left = np.linspace(-0.9, 0.7, 6)
    hatch = np.stack([np.stack([left, left * 0 - 1.35], -1), np.stack([left + 0.3, left * 0 - 1], -1)], axis=1)
    return np.concatenate([[[[-0.95, -1], [0.95, -1]]], hatch])


def guide_strokes(guide: Array, extent: float) -> Array:
    """Give the line under a slider's block, and its hatch, ``(strokes, 2, 2)``."""
    # guide: both ends of the slider's travel (m), ``(2, 2)``; extent: of the motion (m)
    first, second = guide
    along = (second - first) / max(float(np.linalg.norm(second - first)), 1e-300)
    normal = np.array([-along[1], along[0]])
    below = DRAWN.block * extent * normal
    count = max(int(np.linalg.norm(second - first) / (0.32 * DRAWN.support * extent)), 2)
    tops = np.linspace(first - below, second - below, count)
    feet = tops - 0.35 * DRAWN.support * extent * (normal + 0.85 * along)
    return np.concatenate([[[tops[0], tops[-1]]], np.stack([feet, tops], axis=1)])


def coil(ends: Array, half_width: float) -> Array:
    """Give the zigzag of a spring between two points, ``(points, 2)``."""
    # ends: the points (m), ``(2, 2)``; half_width: of the zigzag (m)
    places = np.concatenate([[0, 0.2], 0.2 + 0.6 * (np.arange(2 * COILS) + 0.5) / (2 * COILS), [0.8, 1]])
    sides = np.concatenate([[0, 0], (-1.0) ** np.arange(2 * COILS), [0, 0]])
    return _beside(ends, places, half_width * sides)


def dashpot(ends: Array, half_width: float) -> list[Array]:
    """Give the strokes of a damper between two points: rod with piston, cylinder, and what holds it."""
    strokes = [
        ([0, 0.52], [0, 0]),
        ([0.52, 0.52], [-0.8, 0.8]),
        ([0.4, 0.62, 0.62, 0.4], [-1, -1, 1, 1]),
        ([0.62, 1], [0, 0]),
    ]
    return [_beside(ends, np.array(places), half_width * np.array(sides)) for places, sides in strokes]


def arc(centre: Array, radius: float, start: float, end: float) -> Array:
    """Give an arc of a circle, ``(points, 2)``."""
    # centre: its centre (m); radius: its radius (m); start, end: angles (rad); the arc runs from the one to the other
    turn = np.linspace(start, end, 40)
    return centre + radius * np.stack([np.cos(turn), np.sin(turn)], axis=-1)


def _beside(ends: Array, places: Array, across: Array) -> Array:
    """Points at shares of the line between two points, and at distances across it, ``(points, 2)``."""
    line = ends[1] - ends[0]
    normal = np.array([-line[1], line[0]]) / max(float(np.linalg.norm(line)), 1e-300)
    return np.asarray(ends[0] + places[:, None] * line + across[:, None] * normal)
