"""Derivatives of the numbers of a periodic result by the variables of a study, without another search for a motion.

The equation of motion ``R(q, q', q'', x) = 0`` is linearised about the solution. One more periodic problem for each
variable, ``M dq'' + C dq' + K dq = -dR/dx``, is solved by the steps that carried the motion, with their factors.
The derivative of R by x is a central difference of the assembled equation, at the motion as it is. So are those of the
numbers, at the motion and its change: of a largest value it is that at the peak.

Source: Haug and Arora, Applied Optimal Design, 1979, chapter 4 (direct differentiation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import elastic_response
from fenics_mech.recovery.dataset import collect_named
from fenics_mech.recovery.fields import recover
from fenics_mech.response.periodic.collocation import orbit_of
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.setup import mechanism
from fenics_mech.response.solution import CollocationSolution
from fenics_mech.scene import Scene
from fenics_mech.studies.design.trial import Trials, read_numbers

STEP = 6e-5  # of differences, as a share of a variable: of less rounding shows, of more its third power
SMALL = 1e-2  # share of a variable's range, below which its own size is no measure of a step


def sensitivity(trials: Trials, values: Sequence[float]) -> dict[str, Array] | None:
    """Give the derivatives of all numbers of a trial by the variables.

    Parameters
    ----------
    trials
        The trials, for which `Trials.linearised` holds.
    values
        A value of each variable, in SI.

    Returns
    -------
    dict or None
        By name, by each variable in SI, ``(variables,)``. None where the motion is not one by collocation, or its axial
        forces settle apart from it.

    Raises
    ------
    MechanismError
        When the analysis fails.
    """
    solution = trials.solution(values)
    if type(solution) is not CollocationSolution or solution.cycle.settling:
        return None
    here = np.array(values, dtype=float)
    columns = [_derivative(trials, solution, here, k) for k in range(len(here))]
    return {name: np.array([column[name] for column in columns]) for name in columns[0]}


@dataclass(frozen=True)
class _Beside:
    """The equation of motion at another value of a variable.

    Parameters
    ----------
    cycle
        The cycle there.
    faster
        How many times as fast the drive is.
    """

    cycle: Cycle
    faster: float

    def residual(self, solution: CollocationSolution) -> Array:
        """What the motion of a solution leaves over in the equation there, ``(points, coordinates)``."""
        orbit, k = solution.orbit, self.faster
        equation = self.cycle.at_points(solution.cycle.tableau)
        return equation.residual(orbit.displacement, k * orbit.velocity, k**2 * orbit.acceleration)


def _derivative(trials: Trials, solution: CollocationSolution, here: Array, k: int) -> dict[str, float]:
    """Give the derivatives of all numbers by one variable."""
    variable = trials.design.variables[k]
    span = variable.upper - variable.lower
    step = STEP * min(span, max(abs(here[k]), SMALL * span))
    ends = [here + sign * step * np.eye(len(here))[k] for sign in (1.0, -1.0)]
    beside = [_beside(trials, solution, end) for end in ends]
    ahead, behind = (side.residual(solution) for side in beside)
    flow = solution.orbit.flow
    assert flow is not None
    load = -(ahead - behind) / (2 * step)
    states = flow.cycle.solve(flow.added_by(load), None, CYCLIC.tolerance_of_change)
    change = orbit_of(flow, states, load)
    found = []
    for sign, side in zip((1.0, -1.0), beside):
        regular, orbit = side.cycle.steps.regular, solution.orbit
        q = (orbit.start + sign * step * change.start)[regular]
        rate = side.faster * (orbit.start_velocity + sign * step * change.start_velocity)[regular]
        found.append(_numbers(trials, solution, side, (q, rate)))
    return {name: (found[0][name] - found[1][name]) / (2 * step) for name in found[0]}


def _beside(trials: Trials, solution: CollocationSolution, values: Array) -> _Beside:
    """Build the mechanism at other values of the variables."""
    scene = Scene.read(trials.data_at(values.tolist()))
    system = mechanism(scene, common=trials.common)
    if system.transformation.names != solution.system.transformation.names:
        raise SolverError("the independent coordinates change with a variable of the study")
    return _Beside(Cycle(scene, system), scene.cycle_rate / solution.scene.cycle_rate)


def _numbers(
    trials: Trials, solution: CollocationSolution, side: _Beside, state: tuple[Array, Array]
) -> dict[str, float]:
    """Recover the numbers of a motion in the mechanism beside that of a solution, and nothing else."""
    scene, cycle = side.cycle.scene, side.cycle
    wanted = any(quantity.name in ("frequency", "assurance") for quantity in trials.quantities)
    modes = solve_modes(cycle.system, scene.analysis.modes, scene.petsc) if wanted else solution.modes
    other = replace(
        solution,
        scene=scene,
        system=cycle.system,
        response=elastic_response(cycle.start, *state),
        modes=modes,
        cycle=cycle,
        equation=cycle.start,
        points=None,
    )
    names = {name for quantity in trials.quantities for name in quantity.variables}
    result = collect_named(other, recover(other), names)
    return read_numbers(trials.quantities, result, trials.design.study.targets)
