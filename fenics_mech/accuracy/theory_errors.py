"""What the theory of a scene leaves out, from its own answer.

The exact motion is found from it, see `exact_motion`, so that a resonance amplifies both alike.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.accuracy.all_nodes import on_all_nodes
from fenics_mech.accuracy.corrected_response import ESTIMATES
from fenics_mech.accuracy.exact_motion import THEORY, answered, at_rest, change_between, state_of
from fenics_mech.accuracy.known_cycle import KnownCycle, of_harmonics, of_steps
from fenics_mech.accuracy.quantities import ERROR_VARIABLES, Quantities
from fenics_mech.accuracy.theory_in_time import change_anew, largest_change_in_time
from fenics_mech.accuracy.theory_ladder import exact_theory
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response, response_at
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.motor_response import MotorCycle
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import orbit_of
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import (
    FreeSolution,
    MotorSolution,
    PeriodicSolution,
    Solution,
    TransientSolution,
)
from fenics_mech.response.transient.free_motion import course_of, solution_from, start_of
from fenics_mech.response.transient.free_state import FreeState
from fenics_mech.scene import Scene


def theory_errors(solution: Solution) -> Mapping[str, Array] | None:
    """Estimate by how much exact strains and the coupling would change each quantity.

    Parameters
    ----------
    solution
        The response.

    Returns
    -------
    mapping or None
        By quantity, as `Quantities.largest`; empty where the scene has these effects. Infinite where the exact equation
        has no stable answer near the response. None where there is no estimate: where nothing holds the mechanism,
        joints have laws, positions are too few, or blows in time strike reduced members.
    """
    scene = solution.scene
    if exact_theory(scene) is scene:
        return {}
    if _not_followed(solution) or len(solution.system.motion.free):
        return None
    try:
        whole = on_all_nodes(solution)
        with np.errstate(all="ignore"):  # axes that would turn by 90 degrees have no forces
            change = _change(whole, exact_theory(whole.scene))
    except UnresolvedError:
        return None
    except SolverError:
        return dict.fromkeys(ERROR_VARIABLES, np.array(np.inf))
    return {name: np.nan_to_num(part, nan=np.inf, posinf=np.inf) for name, part in change.items()}


def _not_followed(solution: Solution) -> bool:
    """Whether its theory is not told: joint laws of periodic motions, or contacts that closed."""
    if isinstance(solution, FreeSolution):
        return solution.course.touched
    return bool(solution.scene.joint_laws)


def _change(solution: Solution, exact: Scene) -> Mapping[str, Array]:
    """Give the largest change by quantity."""
    match solution:
        case MotorSolution():
            return _under_motor(solution, exact).largest
        case FreeSolution():
            return _of_free_motion(solution, exact).largest
        case PeriodicSolution():
            return _about_cycle(solution, exact).largest
        case TransientSolution() if solution.scene.impulses or solution.system.terms.law is not None:
            return change_anew(solution, exact).largest
        case TransientSolution():
            return largest_change_in_time(solution, exact)
        case _:
            return _about_positions(solution, exact).largest


def _of_free_motion(solution: FreeSolution, exact: Scene) -> Quantities:
    """Change of a motion with freedoms, which exact strains move on another path: it is made anew, by rougher steps."""
    system, start = solution.state.system, solution.start
    there = FreeState(exact, moved(exact, system, system.motion))
    if start.links is None:
        start = start_of(there)
    found = solution_from(there, start, course_of(there, start, ESTIMATES.rougher))
    return change_between(*((one.scene, one.system, one.response) for one in (solution, found)))


def _about_positions(solution: Solution, exact: Scene) -> Quantities:
    """Change of a static or quasi-static response, position by position."""
    scene, system, response = solution.scene, solution.system, solution.response
    there = moved(exact, system, system.motion)
    displacement = response.displacement + at_rest(system, there, response)
    changed = ElasticResponse(displacement, system.rigid_acceleration, np.zeros_like(system.rigid_acceleration))
    return change_between((scene, system, response), (exact, there, changed))


def _about_cycle(solution: Solution, exact: Scene) -> Quantities:
    """Change of a periodic response, at the points of steps of its cycle."""
    motion = (None if solution.scene.impulses else of_harmonics(solution)) or of_steps(solution)
    cycle, state, (q, rate), scene = motion.cycle, motion.state, motion.starts, motion.cycle.scene
    analysis = scene.analysis
    inside, starts = cycle.at_points(cycle.tableau), cycle.start
    if cycle.settling:
        inside, starts = cycle.stiffened(inside, *state[:2]), cycle.stiffened(starts, q, rate)
    exact = exact.model_copy(update={"analysis": analysis})
    exactly = Cycle(exact, moved(exact, starts.system, starts.system.motion), cycle.damped_up_to)
    top, top_starts = exactly.at_points(exactly.tableau), exactly.start
    tension = mean_tension(inside.system, response_at(_undamped(inside), *state))
    found = _closed(inside.residual(*state), lambda _: top, motion, tension)
    change = change_between(
        (scene, starts.system, elastic_response(_undamped(starts), q, rate)),
        (exact, top_starts.system, elastic_response(_undamped(top_starts), *found)),
    )
    return change.at_more_angles(THEORY.between) if motion.smooth else change


def _undamped(equation: Equation) -> Equation:
    """Give an equation without the forces of modal damping, which are no stress of the links: inertia balances them."""
    return replace(equation, modal_damping=None)


def _under_motor(solution: MotorSolution, exact: Scene) -> Quantities:
    """Change of a periodic response with a motor, of which the twist of its shaft is a part."""
    motion, system, scene = of_steps(solution), solution.cycle.system, solution.cycle.scene
    both = [MotorCycle(scene, system), MotorCycle(exact, moved(exact, system, system.motion))]
    theta = motion.cycle.steps.angles(motion.cycle.tableau.points)
    rung, exactly = (partial(one.about_twist, theta) for one in both)
    q, rate, _ = motion.state
    own, links = both[0].links_at(theta, q, rate, motion.state[..., -1])
    tension = mean_tension(own.system, links)
    known = rung(motion.state[..., -1]).residual(*motion.state)
    found = _closed(known, lambda state: exactly(state[..., -1]), motion, tension)
    twists = solution.twist, both[1].accelerated(system.motion.theta, *found)
    changed = []
    for one, (q, rate), twist in zip(both, (motion.starts, found), twists):
        equation, response = one.links_at(system.motion.theta, q, rate, twist)
        changed.append((one.scene, equation.system, response))
    return change_between(*changed)


def _closed(known: Array, exact: Callable[[Array], Equation], motion: KnownCycle, tension: Array) -> Array:
    """Give q and q' of the exact motion over a cycle at the starts of the sub-intervals, ``(2, angles, coordinates)``.

    `known` is what the motion leaves of its own equation at its points, and `exact` gives the exact one about a state.
    """
    cycle, at_starts = motion.cycle, [motion.starts]

    def answer(tangents: Matrices, load: Array) -> Array:
        flow = Flow(tangents, cycle.tableau, cycle.steps.duration, cycle.scene.petsc)
        if not flow.cycle.growth < THEORY.most_growth:
            raise SolverError(f"beside the motion a disturbance grows by 1e{flow.cycle.growth:.0f} in a cycle")
        orbit = orbit_of(flow, flow.cycle.roughly(flow.added_by(load)), load)
        at_starts.append(np.stack([part[cycle.steps.regular] for part in (orbit.start, orbit.start_velocity)]))
        return state_of(orbit)

    answered(known, exact, motion.state, tension, answer)
    return np.sum(at_starts, axis=0)
