"""Errors of a periodic response by collocation or harmonic balance: by its steps or harmonics, and by its mesh."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.accuracy.corrected_response import ESTIMATES, CorrectedResponse
from fenics_mech.accuracy.feedback import Answer, without_mesh
from fenics_mech.accuracy.linear_response import periodic_change
from fenics_mech.effects import Loads
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.collocation import between
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.solution import CollocationSolution, HarmonicSolution, PeriodicSolution


def collocation_errors(solution: CollocationSolution) -> dict[str, CorrectedResponse]:
    """Give a response by collocation without the errors of its steps ("time") and of its mesh.

    Parameters
    ----------
    solution
        The solution.

    Returns
    -------
    dict
        Responses by source; that of "time" is on few nodes, where the solution has them.

    Raises
    ------
    SolverError
        When the cycle of the more accurate steps cannot be closed.
    """
    return {"time": _without_steps(solution.on_few_nodes), "mesh": _mesh_error(solution, _of_orbit(solution))}


def answer_of(solution: CollocationSolution | HarmonicSolution) -> Answer:
    """Give how a periodic motion answers to small loads, by the steps that carried it.

    Parameters
    ----------
    solution
        The solution.
    """
    return _of_orbit(solution) if isinstance(solution, CollocationSolution) else _of_series(solution)[0]


def _of_orbit(solution: CollocationSolution) -> Answer:
    scene, cycle, orbit, equation = solution.scene, solution.cycle, solution.orbit, solution.equation
    flow = orbit.flow if orbit.linearised_here else cycle.flow(cycle.tableau, cycle.motion(orbit))
    assert flow is not None
    starts, step = (orbit.start, orbit.start_velocity), scene.period / len(equation.system.motion.theta)
    return _answer(equation, starts, flow, cycle.steps.regular, step)


def _of_series(solution: HarmonicSolution) -> tuple[Answer, tuple[Array, Array]]:
    """Answer of a motion by its series, and q and q' at the sub-intervals by steps of collocation."""
    cycle = solution.cycle
    motion, regular = cycle.series_motion(solution.series), cycle.steps.regular
    starts, flow = motion(np.zeros(1)), cycle.flow(Tableau.of("gauss", solution.scene.analysis.stages), motion)
    q, rate = (part[regular] for part in _collocated(*starts, flow))
    step = solution.scene.period / len(cycle.system.motion.theta)
    return _answer(cycle.start, starts, flow, regular, step), (q, rate)


def _without_steps(solution: CollocationSolution) -> CorrectedResponse:
    """Give a response by collocation without the error of its steps."""
    cycle, orbit, equation = solution.cycle, solution.orbit, solution.equation
    analysis, regular, size = solution.scene.analysis, cycle.steps.regular, equation.system.size
    safety = ESTIMATES.of_blows if cycle.steps.disturbed else ESTIMATES.of_steps
    points = more_accurate(analysis.stages)
    right = [part[regular, :size] for part in corrected(orbit, cycle.flow(points, cycle.motion(orbit)))]
    cycle.forget(points)
    order = 2 * analysis.stages - (analysis.scheme == "radau")
    return CorrectedResponse(elastic_response(equation, *right), order, safety)


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
    answer, finer = _of_series(solution)
    return {
        "harmonics": CorrectedResponse(elastic_response(solution.cycle.start, *finer), ESTIMATES.harmonic_order),
        "mesh": _mesh_error(solution, answer),
    }


def _mesh_error(solution: PeriodicSolution, answer: Answer) -> CorrectedResponse:
    """Correct a motion for its mesh."""
    return without_mesh(answer, solution.response)


def _answer(
    equation: Equation, starts: tuple[Array, Array], flow: Flow, regular: NDArray[np.bool_], step: float
) -> Answer:
    """Give how a motion answers to loads, by the steps that carried it: `starts` are its q and q' there.

    `equation` is at the sub-intervals, which have the duration `step` (s), and begin where steps are `regular`. The
    flow may have more coordinates, on which the loads do not act.
    """
    system, size = equation.system, equation.system.size
    q, rate = (part[regular, :size] for part in starts)
    unit = flow.unit[:size]

    def to(loads: Loads) -> Array:
        whole = np.pad(system.on_coordinates_by(loads), ((0, 0), (0, flow.size - size)))
        found = periodic_change(whole, flow.states(*starts), flow, regular)
        return np.concatenate([part[:, :size] for part in found], axis=1)

    def changed(change: Array, loads: Loads) -> ElasticResponse:
        return elastic_response(
            equation, q + change[:, :size], rate + change[:, size:], system.on_coordinates_by(loads)
        )

    within = ESTIMATES.little * float(np.linalg.norm(q * unit))
    return Answer(system, step, np.pad(unit, (0, size)), within, to, changed)


def more_accurate(stages: int) -> Tableau:
    """Points that estimate the error of a scheme: Radau points, of which there is one more.

    They damp what is too fast for the steps, and so give forces of stiff members, which Gauss points do not.

    Parameters
    ----------
    stages
        Points of a step.
    """
    return Tableau.of("radau", stages + 1)


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
    defect = finer.ends(states) - flow.states(*between(orbit, flow.tableau, flow.duration, np.ones(1)))
    return flow.parts(finer.cycle.solve(load + defect, states[0], CYCLIC.tolerance_of_change))


def _collocated(q: Array, rate: Array, flow: Flow) -> tuple[Array, Array]:
    """Give q and q' of a periodic motion as the steps of a linearised flow make it, ``(steps, coordinates)`` each."""
    states = flow.states(q, rate)
    states += flow.cycle.solve(flow.ends(states) - np.roll(states, -1, axis=0))
    return flow.parts(states)
