"""Periodic response of the whole equation of motion, and whether it is stable."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech.effects.large_rotations import EFFECT as LARGE_ROTATIONS
from fenics_mech.eigenmodes import Modes, solve_modes
from fenics_mech.errors import MechanismError, SceneError, SolverError
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response
from fenics_mech.forces.impulse_work import AtImpulses
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.axial_forces import settle, settles
from fenics_mech.response.few_nodes import FEW_NODES, difference, on_few_nodes
from fenics_mech.response.periodic.collocation import periodic_orbit, solve_collocation
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.periodic.harmonic_balance import solve_harmonic_balance
from fenics_mech.response.periodic.known_motion import KnownMotion
from fenics_mech.response.periodic.newton import NEWTON, Orbit
from fenics_mech.response.setup import moved, rough_tension
from fenics_mech.response.solution import AtPoints, CollocationSolution, HarmonicSolution
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.response.stability.resonance import magnification
from fenics_mech.response.static.equilibrium import naming_buckled
from fenics_mech.response.velocity_jumps import jumps_at, velocity_jumps
from fenics_mech.scene import Analysis, Impulse, Scene

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class LongerSteps:
    """Steps whose motion is where Newton's method begins: measured, it then takes two or three iterations."""

    times: int = 4  # as long
    fewest: int = 60  # of them: with fewer the longer steps cost about what they save


LONGER = LongerSteps()


def by_collocation(
    scene: Scene,
    system: System,
    modes: Modes,
    near: KnownMotion | None = None,
    found: Callable[[KnownMotion], None] = lambda motion: None,
    damped_up_to: float | None = None,
) -> CollocationSolution:
    """Solve at collocation points; the response is that at the starts of the sub-intervals, after any impulse there.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the starts of the sub-intervals.
    modes
        Its modes, by which a resonance or an instability is named.
    near
        A motion beside the one that is sought, from which Newton's method may begin.
    found
        Called with the motion, before its stability is judged, where Newton's method may begin others from it.
    damped_up_to
        As `enough` of `damped_modes`.

    Raises
    ------
    SolverError
        When the cycle cannot be closed, Newton's method or the axial forces do not settle, or the motion is unstable.
    """
    few = _with_few_nodes(scene, system)
    if few is None:
        return _by_collocation(scene, system, modes, near, found, damped_up_to)
    near = near or KnownMotion.of(few.cycle.at_points(few.cycle.tableau), few.orbit)
    solution = _by_collocation(scene, system, modes, near, found, damped_up_to)
    apart = difference((few.system, few.response), (solution.system, solution.response))
    logger.info("with few nodes the motion differs by %.1e", apart)
    return replace(solution, thinned=few) if apart < FEW_NODES.largest_difference else solution


def _with_few_nodes(scene: Scene, system: System) -> CollocationSolution | None:
    """Give the motion with few nodes, whose stability is not judged; None where all are needed."""
    if (few := on_few_nodes(scene, system)) is None:
        return None
    try:
        return _by_collocation(*few, solve_modes(few[1], scene.analysis.modes, scene.petsc))
    except (MechanismError, ArithmeticError, np.linalg.LinAlgError) as error:  # all nodes will say it, or know better
        logger.info("no motion with few nodes: %s", error)
        return None


def _by_collocation(
    scene: Scene,
    system: System,
    modes: Modes,
    near: KnownMotion | None = None,
    found: Callable[[KnownMotion], None] = lambda motion: None,
    damped_up_to: float | None = None,
) -> CollocationSolution:
    """Solve with all nodes of a scene; parameters are those of `by_collocation`."""
    cycle = Cycle(scene, system, damped_up_to=damped_up_to)
    stability = cycle.stability(modes) if cycle.linear else None  # first, as it names a resonance
    at_points = cycle.at_points(cycle.tableau)
    if cycle.settling:
        at_points = _settled(cycle, at_points)
    with cycle.determined(modes):
        orbit = _orbit(cycle, at_points, _beginnings(cycle, near))
    assert orbit.flow is not None
    if orbit.linearised_here:
        cycle.keep(orbit.flow)
    if (known := KnownMotion.of(at_points, orbit)) is not None:
        found(known)
    condition, motion = condition_of(orbit), cycle.motion(orbit)
    cycle.refuse_magnified(modes, condition, motion)
    if not cycle.linear:
        stability = cycle.stability(modes, motion)
    equation, response = cycle.at_starts(orbit)
    return CollocationSolution(
        scene=scene,
        system=equation.system,
        response=response,
        modes=modes,
        condition=condition,
        stability=stability,
        cycle=cycle,
        equation=equation,
        orbit=orbit,
        inside=lambda: _at_points(cycle, at_points, orbit),
    )


def _at_points(cycle: Cycle, equation: Equation, orbit: Orbit) -> AtPoints:
    """Give a motion at the collocation points; `equation` is that at these points."""
    response = elastic_response(equation, orbit.displacement, orbit.velocity)
    return AtPoints(equation.system, response, cycle.weights, _at_impulses(cycle, orbit))


def stability_of(solution: CollocationSolution, allow_unstable: bool) -> Stability:
    """Judge the stability of a solution whose scene did not ask for that.

    Parameters
    ----------
    solution
        The solution.
    allow_unstable
        Whether an unstable motion passes.

    Raises
    ------
    SolverError
        When it is unstable, or an equation that is the same for all motions has a resonance.
    """
    return solution.cycle.judged(solution.modes, solution.cycle.motion(solution.orbit), allow_unstable)


def _at_impulses(cycle: Cycle, orbit: Orbit) -> AtImpulses | None:
    """Give the state at the impulses of a motion by collocation, whose starts of steps are just after them."""
    scene, system, at = cycle.scene, cycle.system, cycle.steps.struck
    if not scene.impulses:
        return None
    theta = cycle.steps.start[at]
    equation = Equation(moved(scene, system, solve_motion(scene, theta, near=system.motion)))
    jump = jumps_at(scene, system, theta)
    together = (at[:, None] == at).astype(float) @ jump  # impulses at one angle strike at once
    mean_rate = orbit.start_velocity[at] - together / 2
    return AtImpulses(equation.system, elastic_response(equation, orbit.start[at], mean_rate), jump)


def condition_of(orbit: Orbit) -> float:
    """How many times a relative error of the steps comes out in a motion by collocation; see `magnification`.

    Parameters
    ----------
    orbit
        The motion, with the steps that it was solved with.
    """
    flow = orbit.flow
    assert flow is not None
    return magnification(flow.cycle, flow.states(orbit.start, orbit.start_velocity), np.tile(flow.unit, 2))


def _beginnings(cycle: Cycle, near: KnownMotion | None) -> Iterator[KnownMotion]:
    """Give motions from which Newton's method may begin, one after the other."""
    if near is not None:
        yield near
    if (longer := _by_longer_steps(cycle)) is not None:
        yield longer


def _orbit(cycle: Cycle, at_points: Equation, near: Iterable[KnownMotion] = ()) -> Orbit:
    scene, steps = cycle.scene, cycle.steps
    jump, tension = velocity_jumps(scene, at_points.system, steps), rough_tension(scene, at_points.system)
    with naming_buckled(at_points, tension):
        if cycle.linear:
            return periodic_orbit(cycle.flow(cycle.tableau), jump)
        stated = min(scene.tolerances.values(), default=0.0)
        tolerance = max(NEWTON.tolerance, NEWTON.of_answer * stated)
        known = () if at_points.system.terms.law is None else (motion.at(at_points) for motion in near)
        beginnings = (replace(motion, tolerance=tolerance) for motion in known)
        return solve_collocation(at_points, cycle.tableau, steps.duration, scene.petsc, tension, jump, beginnings)


def _by_longer_steps(cycle: Cycle) -> KnownMotion | None:
    """Give the motion by longer steps, for Newton's method to begin from; None where linear, or steps are long.

    Where it ends at a share of the load, one by all steps does so too.
    """
    scene, system = cycle.scene, cycle.system
    count, left = divmod(scene.analysis.sub_intervals, LONGER.times)
    if system.terms.law is None or system.beams.reduction is not None or left or count < LONGER.fewest:
        return None
    there = scene.model_copy(update={"analysis": scene.analysis.model_copy(update={"sub_intervals": count})})
    try:
        motion = solve_motion(there, there.drive_angles(count), near=system.motion)
        longer = Cycle(there, moved(there, system, motion), shorter=cycle)
        equation = longer.at_points(longer.tableau)
        return KnownMotion.of(equation, _orbit(longer, equation))
    except (MechanismError, ArithmeticError, np.linalg.LinAlgError) as error:  # all steps may have one
        logger.info("no motion by longer steps: %s", error)
        if isinstance(error, SolverError) and error.found_up_to:
            raise
        return None


def _settled(cycle: Cycle, at_points: Equation) -> Equation:
    """Give the equation with the axial forces of the response."""

    def respond(system: System) -> ElasticResponse:
        equation = Equation(system, at_points.modal_damping)
        orbit = _orbit(cycle, equation)
        return elastic_response(equation, orbit.displacement, orbit.velocity)

    return Equation(settle(at_points.system, respond), at_points.modal_damping)


def by_harmonic_balance(scene: Scene, system: System, modes: Modes) -> HarmonicSolution:
    """Solve for a Fourier series; the response is that at the starts of the sub-intervals.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the starts of the sub-intervals.
    modes
        Its modes, by which a resonance or an instability is named.

    Raises
    ------
    SceneError
        When impulses act, whose series does not converge, or axial forces are to settle.
    """
    _refuse_without_series(scene.analysis, scene.impulses, system)
    cycle, analysis = Cycle(scene, system), scene.analysis
    stability = cycle.stability(modes) if cycle.linear else None  # first, as it names a resonance
    tension = rough_tension(scene, system)
    with cycle.determined(modes):
        series = solve_harmonic_balance(cycle.start, analysis.harmonics, scene.period, scene.petsc, tension)
    motion = cycle.series_motion(series)
    cycle.refuse_magnified(modes, series.condition, motion)
    if not cycle.linear:
        stability = cycle.stability(modes, motion)
    starts = (part[cycle.steps.regular] for part in motion(np.zeros(1)))
    return HarmonicSolution(
        scene=scene,
        system=system,
        response=elastic_response(cycle.start, *starts),
        modes=modes,
        condition=series.condition,
        stability=stability,
        cycle=cycle,
        series=series,
    )


def _refuse_without_series(analysis: Analysis, impulses: Mapping[str, Impulse], system: System) -> None:
    """Raise `SceneError` where harmonic balance does not solve what the scene states."""
    if settles(analysis.tension, system.terms):
        raise SceneError(
            "harmonic balance does not update axial forces",
            place="analysis.tension",
            hint=f"Write solver = 'collocation', or take the effect {LARGE_ROTATIONS.name!r}",
        )
    if impulses:
        raise SceneError(
            "impulses make velocities jump, which harmonics do not follow",
            place="analysis.solver",
            hint="Write solver = 'collocation'",
        )
