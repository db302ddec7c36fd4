"""Ranges of the natural frequencies about the motions of a sweep, by modes that keep their numbers through it."""

from __future__ import annotations

from fenics_mech._arrays import Array
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.mechanism import build_system
from fenics_mech.response.running_frequencies import running_frequencies
from fenics_mech.response.setup import CommonParts, without_stiffening
from fenics_mech.response.solution import PeriodicSolution, Solution

POSITIONS = 24  # of the cycle, at which they are found: the range of the demos' is that of 360 to 0.5 %


def running_ranges(solution: Solution, common: CommonParts) -> dict[str, Array]:
    """Give the lowest and highest frequency of each mode about the motion (Hz), ``(modes,)``; nothing where it rests.

    Modes have their numbers from the mechanism without axial forces, which is the same at all speeds. By their shapes a
    mode about the motion is the one that it is most like there, so that modes do not change places in a sweep.

    Parameters
    ----------
    solution
        The response.
    common
        Parts of the analysis that points share.
    """
    scene = solution.scene
    if not isinstance(solution, PeriodicSolution) or not scene.drives:
        return {}
    motion = common.motion(scene, scene.drive_angles(POSITIONS))
    system = without_stiffening(scene, build_system(scene, solution.system.beams, motion))
    modes = solve_modes(system, solution.modes.omega.shape[1], scene.petsc)
    found = running_frequencies(scene, system, modes)
    return {} if found is None else {"running_lowest": found.min(axis=0), "running_highest": found.max(axis=0)}
