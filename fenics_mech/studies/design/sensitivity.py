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
from fenics_mech.analysis import collected, solved
from fenics_mech.eigenmodes import solve_modes
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import elastic_response
from fenics_mech.recovery import Result
from fenics_mech.response.periodic.collocation import orbit_of
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.setup import mechanism
from fenics_mech.response.solution import CollocationSolution
from fenics_mech.scene import Scene
from fenics_mech.studies.design.trial import Trials

STEP = 3e-5  # of differences of the assembled equation, as a share of a variable's range


@dataclass(frozen=True)
class Sensitivity:
    """Numbers of a result and their derivatives.

    Parameters
    ----------
    numbers
        By name.
    derivatives
        By name, by each variable in SI, ``(variables,)``.
    """

    numbers: dict[str, float]
    derivatives: dict[str, Array]


def has_sensitivity(trials: Trials) -> bool:
    """Whether `sensitivity` knows the problem: periodic, stated effects, numbers that need no multipliers, no choices.

    Parameters
    ----------
    trials
        The trials.
    """
    scene = trials.design.scene
    stated = scene.effects != "auto" and scene.tolerance is None and not scene.impulses
    plain = not any(variable.choices for variable in trials.design.variables)
    judged = any(quantity.needs_stability for quantity in trials.quantities)
    return scene.analysis.method == "periodic" and stated and plain and not judged and bool(scene.members())


def sensitivity(trials: Trials, values: Sequence[float]) -> Sensitivity | None:
    """Give the numbers of a trial and their derivatives by the variables.

    Parameters
    ----------
    trials
        The trials.
    values
        A value of each variable, in SI.

    Returns
    -------
    Sensitivity or None
        None where the motion is not one by collocation, or its axial forces settle apart from it.

    Raises
    ------
    MechanismError
        When the analysis fails.
    """
    scene = Scene.read(trials.data_at(values))
    solution, result = solved(scene, common=trials.common)
    if type(solution) is not CollocationSolution or solution.cycle.settling:
        return None
    here = np.array(values, dtype=float)
    numbers = _numbers(trials, result)
    columns = [_derivative(trials, solution, here, k) for k in range(len(here))]
    return Sensitivity(numbers, {name: np.array([column[name] for column in columns]) for name in numbers})


def _numbers(trials: Trials, result: Result) -> dict[str, float]:
    targets = trials.design.study.targets
    return {quantity.text: quantity.of(result, targets) for quantity in trials.quantities}


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
    step = STEP * (variable.upper - variable.lower)
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
        found.append(_numbers(trials, _result(trials, solution, side, (q, rate))))
    return {name: (found[0][name] - found[1][name]) / (2 * step) for name in found[0]}


def _beside(trials: Trials, solution: CollocationSolution, values: Array) -> _Beside:
    """Build the mechanism at other values of the variables."""
    scene = Scene.read(trials.data_at(values.tolist()))
    system = mechanism(scene, common=trials.common)
    if system.transformation.names != solution.system.transformation.names:
        raise SolverError("the independent coordinates change with a variable of the study")
    return _Beside(Cycle(scene, system), scene.cycle_rate / solution.scene.cycle_rate)


def _result(trials: Trials, solution: CollocationSolution, side: _Beside, state: tuple[Array, Array]) -> Result:
    """Recover the result of a motion in the mechanism beside that of a solution."""
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
    return collected(other)
