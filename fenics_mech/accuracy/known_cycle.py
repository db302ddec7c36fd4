"""A periodic motion as an estimate sees it: at the points of steps over its cycle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.exact_motion import THEORY, state_of
from fenics_mech.errors import UnresolvedError
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import CollocationSolution, Solution


@dataclass(frozen=True)
class KnownCycle:
    """A periodic motion at the points of steps of a cycle; `starts` has q and q' at the starts of the sub-intervals.

    A smooth one is a sum of harmonics.
    """

    cycle: Cycle
    state: Array
    starts: Array
    smooth: bool = False


def of_harmonics(solution: Solution) -> KnownCycle | None:
    """Take a motion by its Fourier series, in steps that are as long as that allows; None where it has no end."""
    q, system = solution.response.displacement, solution.system
    amplitudes = np.fft.rfft(q, axis=0) / len(q)
    amplitudes[1:] *= 2
    unit = system.transformation.unit_of(Equation(system).links_stiffness.diagonal)
    energy = np.sum(np.abs(amplitudes * unit) ** 2, axis=1)
    energy[0] = 0.0
    beyond = np.cumsum(energy[::-1])[::-1]  # of each harmonic and all above it
    highest = int(np.count_nonzero(beyond > THEORY.tail**2 * beyond[0]))
    has_end = beyond[3 * len(q) // 8] <= THEORY.end**2 * beyond[0]
    if len(q) < THEORY.positions * highest and not has_end:
        return None
    steps = min(max(THEORY.fewest, THEORY.steps * highest), len(q))
    taken = {"sub_intervals": steps, "solver": "collocation", "scheme": "radau", "stages": THEORY.stages}
    scene = solution.scene.model_copy(update={"analysis": solution.scene.analysis.model_copy(update=taken)})
    order, rate = np.arange(len(amplitudes)), abs(scene.cycle_rate)

    def at(theta: Array) -> Array:
        turned = np.exp(1j * np.abs(theta)[:, None] * order)
        return np.stack([(turned * (1j * rate * order) ** n @ amplitudes).real for n in range(3)])

    theta = scene.drive_angles(steps)
    there = moved(scene, system, solve_motion(scene, theta, near=system.motion))
    cycle = Cycle(scene, there, THEORY.damped_up_to)
    return KnownCycle(cycle, at(cycle.steps.angles(cycle.tableau.points)), at(theta)[:2], smooth=True)


def of_steps(solution: Solution) -> KnownCycle:
    """Take a motion at the points that it was solved for: between them long steps do not know the axial forces.

    Raises
    ------
    UnresolvedError
        When it was solved for at its positions only.
    """
    if not isinstance(solution, CollocationSolution):
        raise UnresolvedError("the positions are too few for the harmonics of the motion. Give more sub_intervals")
    orbit, regular = solution.orbit, solution.cycle.steps.regular
    return KnownCycle(solution.cycle, state_of(orbit), np.stack([orbit.start[regular], orbit.start_velocity[regular]]))
