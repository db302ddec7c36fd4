"""Motions of the points of a sweep, kept until the points at peaks are analysed again with estimates."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fenics_mech._files import read_bounded, write_whole
from fenics_mech.solve import Path as Steps
from fenics_mech.solve.stages import radau

MOST = 1_000_000  # numbers of a motion that is kept: a larger one is found again as fast as it is written and read
# Numbers alone: archives and headers would have to be trusted.
LEADING = 3  # numbers before the motion of poses: coordinates, stages of a step, and unknowns
MOST_STAGES = 10


def write_motion(path: Path, motion: Steps) -> None:
    """Write a motion, if it is not large."""
    paced = motion.paced(1.0)
    sizes = np.array([motion.n, *motion.a.shape[1:]], dtype=float)
    parts = [sizes, motion.starts / motion.period, *(x.ravel() for x in (paced.q0, paced.v0, paced.a))]
    if sum(part.size for part in parts) <= MOST:
        numbers = np.concatenate(parts).astype(float)
        write_whole(path, lambda temporary: temporary.write_bytes(numbers.tobytes()))


def read_steps(path: Path) -> Steps | None:
    """Read a motion of poses in a period of 1 s; None where there is none."""
    try:
        numbers = np.frombuffer(read_bounded(path, 8 * MOST))
    except (OSError, ValueError):
        return None
    if len(numbers) < LEADING or not np.isfinite(numbers).all() or (numbers[:LEADING] < 0).any():
        return None
    n, stages, size = (int(number) for number in numbers[:LEADING])
    steps, rest = divmod(len(numbers) - LEADING, 1 + (2 + stages) * size)
    if rest or not (steps and 0 < n <= size and 0 < stages <= MOST_STAGES):
        return None
    shares, *states = np.split(numbers[LEADING:], np.cumsum([steps, steps * size, steps * size]))
    shapes = (steps, size), (steps, size), (steps, stages, size)
    q0, v0, a = (part.reshape(shape) for part, shape in zip(states, shapes))
    return Steps(radau(stages), shares, 1.0, n, q0, v0, a)
