"""Ranges of the natural frequencies about the motions of a sweep, by modes that keep their numbers through it."""

from __future__ import annotations

import logging

from fenics_mech._arrays import Array
from fenics_mech.answers.modes_by_poses import HeldMachine, over_cycle
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.scene import Scene

logger = logging.getLogger(__name__)
POSITIONS = 24  # of the cycle, at which they are found: the range of the demos' is that of 360 to 0.5 %


def running_ranges(scene: Scene) -> dict[str, Array]:
    """Give the lowest and highest frequency of each mode about the motion (Hz), ``(modes,)``."""
    # Modes have their numbers from the mechanism without axial forces, which is the same at all speeds. By their
    # shapes a mode about the motion is the one that it is most like there, so that modes do not change places in a
    # sweep.
    if scene.analysis.method != "periodic" or not scene.drives or not scene.members():
        return {}
    try:
        found = HeldMachine.of(over_cycle(scene, POSITIONS)).running()
    except (SceneError, SolverError) as error:
        logger.info("frequencies about the motion are not known: %s", error)
        return {}
    return {} if found is None else {"running_lowest": found.min(axis=0), "running_highest": found.max(axis=0)}
