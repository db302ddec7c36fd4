"""What the theory leaves out of a motion in time."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech.accuracy.exact_motion import POINTS, THEORY, answered, change_between, state_of
from fenics_mech.accuracy.fast_vibration import phase_rates, with_vibration
from fenics_mech.accuracy.quantities import Quantities
from fenics_mech.accuracy.transient_errors import cycles_done
from fenics_mech.errors import UnresolvedError
from fenics_mech.forces.elastic_response import elastic_response
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import orbit_of
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import TransientSolution
from fenics_mech.response.transient.in_time import by_time, concatenated, cycles_of, equation_along
from fenics_mech.response.transient.stated_start import stated_start
from fenics_mech.scene import Scene


def largest_change_in_time(solution: TransientSolution, exact: Scene) -> Mapping[str, Array]:
    """Largest change of a response in time, cycle by cycle, each from its own start or both from that of a result.

    Both motions are made by the same steps, from one position to the next: what is too fast for these dies out in both.
    The response has it, and exact strains bring it out of phase.

    Raises
    ------
    UnresolvedError
        When the positions are too few for the slowest vibration.
    """
    scene, over_cycle, course = solution.scene, solution.over_cycle, solution.course
    there = moved(exact, over_cycle, over_cycle.motion)
    both = (scene, over_cycle), (exact, there)
    at_start = equation_along(*both[0], solve_motion_in_time(scene, course.time[:1]))
    between = scene.period / scene.analysis.sub_intervals
    steps = _steps_between(at_start, between)
    step, responses, rates = between / steps, [], []
    own = np.concatenate([course.displacement[0], step * course.velocity[0]])  # a state of `Flow`: its pace is the step
    named, change = [stated_start(*one) for one in both], np.zeros_like(own)
    if named[0] is not None and named[1] is not None:
        before, after = (np.concatenate([one.displacement, step * one.velocity]) for one in named if one)
        change = after - before
    for part in cycles_of(course.time, scene.analysis.sub_intervals):
        time = course.time[part]
        inside = (time[:, None, None] + step * (np.arange(steps)[:, None] + POINTS.points)).ravel()
        motion = solve_motion_in_time(scene, inside)
        rung, top = (equation_along(*one, motion) for one in both)
        passed, changes = _carried(rung, top, step, own, change)
        motion, states = solve_motion_in_time(scene, time), np.stack([passed, passed + changes])[:, :-1:steps]
        q, rate = states[..., : over_cycle.size], states[..., over_cycle.size :] / step
        at_positions = [equation_along(*one, motion) for one in both]
        responses.append([elastic_response(one, q[i], rate[i]) for i, one in enumerate(at_positions)])
        own_equation, exact_equation = at_positions
        tension = mean_tension(own_equation.system, responses[-1][0])
        lost = course.displacement[part] - q[0], course.velocity[part] - rate[0]
        rates.append(phase_rates(own_equation, exact_equation.linearised(q[0], rate[0], tension), lost))
        own, change = passed[-1], changes[-1]
    whole, system = moved(exact, there, solution.system.motion), solution.system
    base, found = (concatenated(list(parts)) for parts in zip(*responses))
    changed = change_between((scene, system, base), (exact, whole, found))
    vibration = change_between((scene, system, base), (scene, system, solution.response))
    return dict(with_vibration(changed, vibration, between * np.cumsum(np.concatenate(rates))))


def change_anew(solution: TransientSolution, exact: Scene) -> Quantities:
    """Change of a response in time that is made anew with exact strains, by steps of the same tolerance.

    Blows make most of the strain by vibration that is too fast for the steps above. These are for linear responses.
    """
    exact = exact.changed(analysis__cycles=cycles_done(solution), analysis__settled=0.0)
    there = moved(exact, solution.over_cycle, solution.over_cycle.motion)
    found = by_time(exact, there, stated_start(exact, there) or solution.start)
    return change_between(*((one.scene, one.system, one.response) for one in (solution, found)))


def _carried(rung: Equation, top: Equation, step: float, own: Array, change: Array) -> tuple[Array, Array]:
    """Carry a state and its change through steps, whose points the equations are at: ``(steps + 1, 2 coordinates)``."""
    flow, changes = Flow(rung.linear, POINTS, step), np.zeros(0)
    passed = flow.march(own, flow.added)
    orbit = orbit_of(flow, passed[:-1], rung.linear.load)
    tension = mean_tension(rung.system, elastic_response(rung, orbit.displacement, orbit.velocity))

    def answer(tangents: Matrices, load: Array) -> Array:
        nonlocal changes
        flow = Flow(tangents, POINTS, step)
        first = not changes.size  # it goes on from the change before; the others add to it
        states = flow.march(change if first else np.zeros_like(change), flow.added_by(load))
        changes = states if first else changes + states
        return state_of(orbit_of(flow, states[:-1], load))

    answered(rung.residual(*state_of(orbit)), lambda _: top, state_of(orbit), tension, answer)
    return passed, changes


def _steps_between(equation: Equation, between: float) -> int:
    """Give the steps from one position to the next (s), by the slowest vibration at the start.

    Raises
    ------
    UnresolvedError
        When they are more than the estimate may take, or nothing vibrates.
    """
    mass, stiffness = equation.linear.mass.dense(0), equation.linear.stiffness.symmetric.dense(0)
    try:
        (square,) = eigh(mass, stiffness, eigvals_only=True, subset_by_index=[len(mass) - 1] * 2)  # 1 over omega^2
    except np.linalg.LinAlgError as error:
        raise UnresolvedError("axial forces let the start buckle") from error
    steps = math.ceil(between / math.sqrt(square) / THEORY.turn)
    if steps > THEORY.steps_between:
        raise UnresolvedError("the positions are too few for the vibration. Give more sub_intervals")
    return steps
