"""Errors of a periodic response by collocation or harmonic balance: by its steps or harmonics, and by its mesh."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.accuracy.corrected_response import ESTIMATES, CorrectedResponse, corrected_for_mesh
from fenics_mech.accuracy.feedback import without_mesh
from fenics_mech.accuracy.linear_response import periodic_change
from fenics_mech.effects import Loads
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.solution import CollocationSolution, HarmonicSolution


def collocation_errors(solution: CollocationSolution) -> dict[str, CorrectedResponse]:
    """Give a response by collocation without the errors of its steps ("time") and of its mesh.

    Parameters
    ----------
    solution
        The solution.

    Returns
    -------
    dict
        Responses by source.

    Raises
    ------
    SolverError
        When the cycle of the more accurate steps cannot be closed.
    """
    scene, cycle, orbit, equation = solution.scene, solution.cycle, solution.orbit, solution.equation
    analysis, regular, size = scene.analysis, cycle.steps.regular, equation.system.size
    points = more_accurate(analysis.stages)
    safety = ESTIMATES.of_blows if cycle.steps.disturbed else ESTIMATES.of_steps
    finer = cycle.flow(*points, cycle.motion(orbit))
    right = (part[regular, :size] for part in corrected(orbit, finer))
    order = 2 * analysis.stages - (analysis.scheme == "radau")
    assert orbit.flow is not None
    starts, step = (orbit.start, orbit.start_velocity), scene.period / len(equation.system.motion.theta)
    return {
        "time": CorrectedResponse(elastic_response(equation, *right), order, safety),
        "mesh": _mesh_error(solution.response, AnswerOfSteps(equation, starts, orbit.flow, regular, step)),
    }


def harmonic_errors(solution: HarmonicSolution) -> dict[str, CorrectedResponse]:
    """Give a response by harmonic balance without the errors of its harmonics and of its mesh.

    Parameters
    ----------
    solution
        The solution.

    Returns
    -------
    dict
        Responses by source: "harmonics" and "mesh".

    Raises
    ------
    SolverError
        When the cycle of the more accurate steps cannot be closed.
    """
    cycle = solution.cycle
    motion, regular = cycle.series_motion(solution.series), cycle.steps.regular
    starts, flow = motion(np.zeros(1)), cycle.flow("gauss", solution.scene.analysis.stages, motion)
    finer = (part[regular] for part in collocated_motion(*starts, flow))
    step = solution.scene.period / len(cycle.system.motion.theta)
    return {
        "harmonics": CorrectedResponse(elastic_response(cycle.start, *finer), ESTIMATES.harmonic_order),
        "mesh": _mesh_error(solution.response, AnswerOfSteps(cycle.start, starts, flow, regular, step)),
    }


def _mesh_error(response: ElasticResponse, answer: AnswerOfSteps) -> CorrectedResponse:
    return corrected_for_mesh(answer.system, *without_mesh(answer, response))


@dataclass(frozen=True)
class AnswerOfSteps:
    """How a periodic motion answers to small loads, by the steps that carried the motion itself; see `Answer`.

    Parameters
    ----------
    equation
        The equation of motion at the starts of the sub-intervals.
    starts
        q and q' at the starts of all steps, with all coordinates.
    flow
        The steps of the cycle, linearised about the motion. They may have more coordinates, on which the load does not
        act.
    regular
        Which steps begin a sub-interval.
    step
        Duration of the sub-intervals (s).
    """

    equation: Equation
    starts: tuple[Array, Array]
    flow: Flow
    regular: NDArray[np.bool_]
    step: float

    @property
    def system(self) -> System:
        """The mechanism at the starts of the sub-intervals."""
        return self.equation.system

    @cached_property
    def motion(self) -> tuple[Array, Array]:
        """Coordinates q and their rates q' at the starts of the sub-intervals."""
        q, rate = (part[self.regular, : self.system.size] for part in self.starts)
        return q, rate

    @property
    def unit(self) -> Array:
        """Factors of q, and none of q'."""
        return np.pad(self.flow.unit[: self.system.size], (0, self.system.size))

    @property
    def loss(self) -> float:
        """Least loss factor of vibration."""
        return self.equation.linear.loss

    @property
    def within(self) -> float:
        """Size of a change up to which the equation is taken as linear."""
        size = self.system.size
        return ESTIMATES.little * float(np.linalg.norm(self.motion[0] * self.flow.unit[:size]))

    def to(self, loads: Loads) -> Array:
        """Give the changes of q and q' by loads, ``(angles, 2 coordinates)``.

        Parameters
        ----------
        loads
            At the starts of the sub-intervals.
        """
        size = self.system.size
        whole = np.pad(self.system.on_coordinates_by(loads), ((0, 0), (0, self.flow.size - size)))
        found = periodic_change(whole, self.flow.states(*self.starts), self.flow, self.regular)
        return np.concatenate([part[:, :size] for part in found], axis=1)

    def changed(self, change: Array, loads: Loads) -> ElasticResponse:
        """Give the response with changes of q and q', under loads.

        Parameters
        ----------
        change
            As `to` gives it (m, rad; m/s, rad/s), ``(angles, 2 coordinates)``.
        loads
            The loads of this change.
        """
        (q, rate), size = self.motion, self.system.size
        return elastic_response(
            self.equation, q + change[:, :size], rate + change[:, size:], self.system.on_coordinates_by(loads)
        )


def more_accurate(stages: int) -> tuple[str, int]:
    """Scheme and number of points that estimate the error of a scheme: Radau points, of which there is one more.

    They damp what is too fast for the steps, and so give forces of stiff members, which Gauss points do not.

    Parameters
    ----------
    stages
        Points of a step.
    """
    return "radau", stages + 1


def corrected(orbit: Orbit, finer: Flow) -> tuple[Array, Array]:
    """Give q and q' at the starts of the steps by a more accurate method, ``(steps, coordinates)`` each.

    Each step is made again from its start by the more accurate method, which also carries the change at its end round
    the cycle.

    Parameters
    ----------
    orbit
        A motion by collocation.
    finer
        The same steps with Radau points, one more, in the equation linearised about the orbit.

    Raises
    ------
    SolverError
        When the cycle cannot be closed.
    """
    assert orbit.flow is not None
    flow = orbit.flow
    states = flow.states(orbit.start, orbit.start_velocity)
    load = np.roll(states, -1, axis=0) - finer.carried(states)  # with it the answer is the orbit's own
    defect = finer.ends(states) - flow.ends(states)
    return flow.parts(finer.cycle.solve(load + defect, states[0], CYCLIC.tolerance_of_change))


def collocated_motion(q: Array, rate: Array, flow: Flow) -> tuple[Array, Array]:
    """Give a periodic motion of any origin as steps by collocation make it, ``(steps, coordinates)`` each.

    Parameters
    ----------
    q, rate
        q and q' at the starts of the steps.
    flow
        The steps, of the equation linearised about the motion.

    Raises
    ------
    SolverError
        When the cycle cannot be closed.
    """
    states = flow.states(q, rate)
    states += flow.cycle.solve(flow.ends(states) - np.roll(states, -1, axis=0))
    return flow.parts(states)
