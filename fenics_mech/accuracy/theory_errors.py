"""What the theory of a scene leaves out, from its own answer.

The forces of exact strains and of the coupling are taken at the known motion. Those that the scene's equation lacks act
as a load. The exact equation, linearised about the motion, answers to it, so that a resonance amplifies both alike.

A state here is q, q' and q'', ``(3, angles, coordinates)``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.linalg import eigh

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.accuracy.fast_vibration import phase_rates, with_vibration
from fenics_mech.accuracy.quantities import ERROR_VARIABLES, Quantities, stations_of
from fenics_mech.accuracy.theory_ladder import exact_theory, judged_by_answer
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.kinematics import solve_motion
from fenics_mech.kinematics.run_up import solve_motion_in_time
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices, not_positive
from fenics_mech.response.motor_response import MotorCycle
from fenics_mech.response.periodic.collocation import orbit_of
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.newton import Orbit, settled
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import moved
from fenics_mech.response.solution import (
    CollocationSolution,
    MotorSolution,
    PeriodicSolution,
    Solution,
    SuperposedSolution,
    TransientSolution,
)
from fenics_mech.response.transient.in_time import concatenated, cycles_of, equation_along
from fenics_mech.scene import Scene


@dataclass(frozen=True)
class TheoryLimits:
    """How the theory's error is estimated: two digits are enough."""

    stages: int = 3  # Radau points of a step
    tail: float = 0.003  # of the motion's amplitude, in harmonics that are left to shorter steps
    positions: int = 8  # for the fastest of the other harmonics: with fewer the series has wrong axial forces
    steps: int = 4  # for the same; each has three Radau points
    turn: float = 0.8  # rad of the slowest vibration in a step in time; measured: 0.94 to 1.0 of the truth, 0.3 with 5
    steps_between: int = 8  # of these, between two positions
    fewest: int = 48  # steps
    between: int = 4  # times as many angles, at which the largest change by such a series is looked for
    most_iterations: int = 8  # of Newton's method: it converges quadratically where the exact motion is near
    accepted: float = 0.1  # change by the last iteration, up to which its answer is an estimate
    converged: float = 1e-4  # change that the next iteration would make: axial stiffness makes forces of it
    most_growth: float = 3.0  # powers of 10 in a cycle, of a disturbance beside the motion: no stable one is near then
    damped_up_to: float = 1.0  # as of `Cycle`, of a motion by its harmonics; measured: more modes change 3e-4 of it


THEORY = TheoryLimits()
POINTS = Tableau.of("radau", THEORY.stages)


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
        has no stable answer near the response. None where there is no estimate, see `judged_by_answer`: nor is there
        one where nothing holds the mechanism, joints have laws, or its positions are too few.
    """
    scene = solution.scene
    exact = exact_theory(scene)
    if exact is scene:
        return {}
    if (
        isinstance(solution, SuperposedSolution)
        or not judged_by_answer(scene)
        or len(solution.system.motion.free)
        or scene.joint_laws
    ):
        return None
    try:
        with np.errstate(all="ignore"):  # axes that would turn by 90 degrees have no forces
            change = _change(solution, exact)
    except UnresolvedError:
        return None
    except SolverError:
        return dict.fromkeys(ERROR_VARIABLES, np.array(np.inf))
    return {name: np.nan_to_num(part, nan=np.inf, posinf=np.inf) for name, part in change.items()}


def _change(solution: Solution, exact: Scene) -> Mapping[str, Array]:
    match solution:
        case MotorSolution():
            return _under_motor(solution, exact).largest
        case PeriodicSolution():
            return _about_cycle(solution, exact).largest
        case TransientSolution():
            return _in_time(solution, exact)
        case _:
            return _about_positions(solution, exact).largest


def _about_positions(solution: Solution, exact: Scene) -> Quantities:
    """Change of a static or quasi-static response, position by position."""
    scene, system, response = solution.scene, solution.system, solution.response
    there = moved(exact, system, system.motion)
    displacement = response.displacement + _at_rest(system, there, response)
    changed = ElasticResponse(displacement, system.rigid_acceleration, np.zeros_like(system.rigid_acceleration))
    return _between((scene, system, response), (exact, there, changed))


def _at_rest(system: System, there: System, response: ElasticResponse) -> Array:
    """Change of a displacement without inertia, ``(angles, coordinates)``; `there` has the exact theory."""
    rung, top = (Equation(replace(one, terms=replace(one.terms, coupled=False))) for one in (system, there))
    still = np.zeros_like(response.displacement)

    def answer(tangents: Matrices, load: Array) -> Array:
        if len(not_positive(tangents.stiffness)):
            raise SolverError("the exact equilibrium is not stable")
        return np.stack([tangents.stiffness.solve(load), still, still])

    state = np.stack([response.displacement, still, still])
    return _answered(rung, lambda _: top, state, mean_tension(system, response), answer)[0]


def _about_cycle(solution: Solution, exact: Scene) -> Quantities:
    """Change of a periodic response, at the points of steps of its cycle."""
    motion = (None if solution.scene.impulses else _of_harmonics(solution)) or _of_steps(solution)
    cycle, state, (q, rate), scene = motion.cycle, motion.state, motion.starts, motion.cycle.scene
    analysis = scene.analysis
    inside, starts = cycle.at_points(cycle.tableau), cycle.start
    if cycle.settling:
        inside, starts = cycle.stiffened(inside, *state[:2]), cycle.stiffened(starts, q, rate)
    exact = exact.changed(analysis=analysis)
    exactly = Cycle(exact, moved(exact, starts.system, starts.system.motion), cycle.damped_up_to)
    top, top_starts = exactly.at_points(exactly.tableau), exactly.start
    tension = mean_tension(inside.system, elastic_response(inside, *state[:2]))
    found = _closed(inside, lambda _: top, motion, tension)
    change = _between(
        (scene, starts.system, elastic_response(starts, q, rate)),
        (exact, top_starts.system, elastic_response(top_starts, *found)),
    )
    return change.at_more_angles(THEORY.between) if motion.smooth else change


def _under_motor(solution: MotorSolution, exact: Scene) -> Quantities:
    """Change of a periodic response with a motor, of which the twist of its shaft is a part."""
    motion, system, scene = _of_steps(solution), solution.cycle.system, solution.cycle.scene
    both = [MotorCycle(scene, system), MotorCycle(exact, moved(exact, system, system.motion))]
    theta = motion.cycle.steps.angles(motion.cycle.tableau.points)
    rung, exactly = (partial(one.about_twist, theta) for one in both)
    q, rate, _ = motion.state
    own, links = both[0].links_at(theta, q, rate, motion.state[..., -1])
    tension = mean_tension(own.system, links)
    found = _closed(rung(motion.state[..., -1]), lambda state: exactly(state[..., -1]), motion, tension)
    twists = solution.twist, both[1].accelerated(system.motion.theta, *found)
    changed = []
    for one, (q, rate), twist in zip(both, (motion.starts, found), twists):
        equation, response = one.links_at(system.motion.theta, q, rate, twist)
        changed.append((one.scene, equation.system, response))
    return _between(*changed)


def _closed(rung: Equation, exact: Callable[[Array], Equation], motion: _Motion, tension: Array) -> Array:
    """Give q and q' of the exact motion over a cycle at the starts of the sub-intervals, ``(2, angles, coordinates)``.

    `rung` is the motion's own equation at its points, and `exact` gives the exact one about a state there.
    """
    cycle, at_starts = motion.cycle, [motion.starts]

    def answer(tangents: Matrices, load: Array) -> Array:
        flow = Flow(tangents, cycle.tableau, cycle.steps.duration, cycle.scene.petsc)
        if not flow.cycle.growth < THEORY.most_growth:
            raise SolverError(f"beside the motion a disturbance grows by 1e{flow.cycle.growth:.0f} in a cycle")
        orbit = orbit_of(flow, flow.cycle.solve(flow.added_by(load)), load)
        at_starts.append(np.stack([part[cycle.steps.regular] for part in (orbit.start, orbit.start_velocity)]))
        return _state(orbit)

    _answered(rung, exact, motion.state, tension, answer)
    return np.sum(at_starts, axis=0)


def _in_time(solution: TransientSolution, exact: Scene) -> Mapping[str, Array]:
    """Largest change of a response in time from the same start, cycle by cycle.

    Both motions are made by the same steps, from one position to the next: what is too fast for these dies out in both.
    The response has it, and exact strains bring it out of phase.

    Raises
    ------
    UnresolvedError
        When the law of the response is nonlinear already.
    """
    scene, over_cycle, course = solution.scene, solution.over_cycle, solution.course
    if over_cycle.terms.law is not None:
        raise UnresolvedError("the response is not one of a linear equation")
    there = moved(exact, over_cycle, over_cycle.motion)
    both = (scene, over_cycle), (exact, there)
    at_start = [equation_along(*one, solve_motion_in_time(scene, course.time[:1])) for one in both]
    between = scene.period / scene.analysis.sub_intervals
    steps = _steps_between(at_start[0], between)
    step, responses, rates = between / steps, [], []
    own = np.concatenate([course.displacement[0], step * course.velocity[0]])  # a state of `Flow`: its pace is the step
    change = np.zeros_like(own)
    if scene.analysis.start == "static":
        here, exactly = (equation.system for equation in at_start)
        still = ElasticResponse(course.displacement[:1], here.rigid_acceleration)
        change[: over_cycle.size] = _at_rest(here, exactly, still)[0]
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
    changed = _between((scene, system, base), (exact, whole, found))
    vibration = _between((scene, system, base), (scene, system, solution.response))
    return dict(with_vibration(changed, vibration, between * np.cumsum(np.concatenate(rates))))


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
        return _state(orbit_of(flow, states[:-1], load))

    _answered(rung, lambda _: top, _state(orbit), tension, answer)
    return passed, changes


def _state(orbit: Orbit) -> Array:
    return np.stack([orbit.displacement, orbit.velocity, orbit.acceleration])


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


def _answered(
    rung: Equation,
    exact: Callable[[Array], Equation],
    state: Array,
    tension: Array,
    answer: Callable[[Matrices, Array], Array],
) -> Array:
    """Give the change of a state by the forces of the exact equation about it that its own equation `rung` lacks.

    These are two steps of Newton's method or more: axial forces are right to the first order of a change only.

    Raises
    ------
    SolverError
        Where they do not converge.
    """
    known, found, changes = rung.residual(*state), state, list[float]()
    while len(changes) < THEORY.most_iterations:
        top = exact(found)
        tangents = top.linearised(found[0], found[1], tension)
        change = answer(tangents, known - top.residual(*found))
        tension = top.predicted_tension(found[0], found[1], *(found + change)[:2])
        found = found + change
        changes.append(float(np.linalg.norm(change[0])) / max(float(np.linalg.norm(found[0])), TINY))
        if len(changes) > 1 and settled(changes, THEORY.converged):
            break
    if not changes[-1] < THEORY.accepted:
        raise SolverError(f"the exact motion is not near: the last iteration changes it by {changes[-1]:.1g}")
    return found - state


def _between(rung: tuple[Scene, System, ElasticResponse], top: tuple[Scene, System, ElasticResponse]) -> Quantities:
    s = stations_of(top[1])
    found, base = (Quantities.of(scene, system, response.undamped, s=s) for scene, system, response in (top, rung))
    return found - base


@dataclass(frozen=True)
class _Motion:
    """A periodic motion at the points of steps of a cycle; `starts` has q and q' at the starts of the sub-intervals.

    A smooth one is a sum of harmonics.
    """

    cycle: Cycle
    state: Array
    starts: Array
    smooth: bool = False


def _of_harmonics(solution: Solution) -> _Motion | None:
    """Take a motion by its Fourier series, in steps that are as long as that allows; None where it has no end."""
    q, system = solution.response.displacement, solution.system
    amplitudes = np.fft.rfft(q, axis=0) / len(q)
    amplitudes[1:] *= 2
    unit = np.sqrt(Equation(system).links_stiffness.diagonal.mean(axis=0))
    energy = np.sum(np.abs(amplitudes * unit) ** 2, axis=1)
    energy[0] = 0.0
    beyond = np.cumsum(energy[::-1])[::-1]  # of each harmonic and all above it
    highest = int(np.count_nonzero(beyond > THEORY.tail**2 * beyond[0]))
    if len(q) < THEORY.positions * highest:
        return None
    steps = min(max(THEORY.fewest, THEORY.steps * highest), len(q))
    taken = {"sub_intervals": steps, "solver": "collocation", "scheme": "radau", "stages": THEORY.stages}
    scene = solution.scene.changed(analysis=solution.scene.analysis.model_copy(update=taken))
    order, rate = np.arange(len(amplitudes)), abs(scene.cycle_rate)

    def at(theta: Array) -> Array:
        turned = np.exp(1j * np.abs(theta)[:, None] * order)
        return np.stack([(turned * (1j * rate * order) ** n @ amplitudes).real for n in range(3)])

    theta = scene.drive_angles(steps)
    there = moved(scene, system, solve_motion(scene, theta, near=system.motion))
    cycle = Cycle(scene, there, THEORY.damped_up_to)
    return _Motion(cycle, at(cycle.steps.angles(cycle.tableau.points)), at(theta)[:2], smooth=True)


def _of_steps(solution: Solution) -> _Motion:
    """Take a motion at the points that it was solved for: between them long steps do not know the axial forces.

    Raises
    ------
    UnresolvedError
        When it was solved for at its positions only.
    """
    if not isinstance(solution, CollocationSolution):
        raise UnresolvedError("the positions are too few for the harmonics of the motion. Give more sub_intervals")
    orbit, regular = solution.orbit, solution.cycle.steps.regular
    return _Motion(solution.cycle, _state(orbit), np.stack([orbit.start[regular], orbit.start_velocity[regular]]))
