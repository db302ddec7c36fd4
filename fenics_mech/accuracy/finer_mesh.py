"""The same motion on elements that are halved."""

from __future__ import annotations

import logging
import math

import numpy as np

from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import MechanismError
from fenics_mech.mechanism import System
from fenics_mech.response.motor_response import by_motor
from fenics_mech.response.periodic.known_motion import KnownMotion
from fenics_mech.response.periodic.steady_state import by_collocation, by_harmonic_balance
from fenics_mech.response.setup import mechanism
from fenics_mech.response.solution import (
    CollocationSolution,
    HarmonicSolution,
    MotorSolution,
    PeriodicSolution,
)
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import refined

logger = logging.getLogger(__name__)
LENIENT = {"stability": False, "allow_unstable": True, "allow_ringing": True, "error_estimates": False}


def on_finer_mesh(solution: PeriodicSolution) -> PeriodicSolution | None:
    """Give the same motion on elements that are halved; None where none is found.

    Parameters
    ----------
    solution
        The motion.
    """
    try:
        scene = _halved(solution)
        return _solved(solution, scene, mechanism(scene))
    except (MechanismError, ArithmeticError, np.linalg.LinAlgError) as error:
        logger.info("no motion on a finer mesh: %s", error)
        return None


def _halved(solution: PeriodicSolution) -> Scene:
    """Give the scene with halved elements; members that are reduced then have modes of four times the frequency."""
    scene = refined(solution.scene, 1).changed({f"analysis.{name}": value for name, value in LENIENT.items()})
    reduction = solution.system.beams.reduction
    return scene if reduction is None else scene.changed(analysis__cutoff=4 * reduction.cutoff / (2 * math.pi))


def _solved(solution: PeriodicSolution, scene: Scene, system: System) -> PeriodicSolution:
    """Solve for the same motion as on a coarser mesh, by the same solver; Newton's method begins from it.

    Where all modes are damped they all are on the finer mesh too, which has more coordinates.
    """
    modes = solve_modes(system, scene.analysis.modes, scene.petsc)
    match solution:
        case MotorSolution():
            return by_motor(scene, system, modes)
        case CollocationSolution(cycle=cycle, orbit=orbit):
            near, every = KnownMotion.of(cycle.at_points(cycle.tableau), orbit), cycle.damped is None
            return by_collocation(scene, system, modes, near, damped_up_to=math.inf if every else None)
        case HarmonicSolution():
            return by_harmonic_balance(scene, system, modes)
    raise TypeError(f"no finer mesh for a {type(solution).__name__}")
