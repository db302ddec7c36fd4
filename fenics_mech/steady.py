"""Periodic response of the whole equation of motion, and whether it is stable."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fenics_mech.building import rigid_tension, settle, system_at, with_tension
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation, Matrices
from fenics_mech.modes import Modes
from fenics_mech.recovery.members import mean_tension
from fenics_mech.response import History
from fenics_mech.response.collocation import between, solve_collocation
from fenics_mech.response.damping import modal_damping
from fenics_mech.response.floquet import Stability, floquet
from fenics_mech.response.harmonic_balance import solve_harmonic_balance
from fenics_mech.response.history import history_of
from fenics_mech.response.impulses import velocity_jumps
from fenics_mech.response.newton import Orbit
from fenics_mech.response.steps import Steps
from fenics_mech.response.tableau import Tableau
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
States = Callable[[Array], tuple[Array, Array]]  # q and q' at places 0..1 in every step of the cycle


def by_collocation(scene: Scene, system: System, modes: Modes) -> tuple[System, History]:
    """Solve at collocation points; the history is that at the starts of the sub-intervals, after any impulse there.

    Returns
    -------
    tuple
        The mechanism, with the axial forces of the response where they are to settle, and its history.

    Raises
    ------
    SolverError
        When the cycle cannot be closed, Newton's method or the axial forces do not settle, or the motion is unstable.
    """
    tableau = Tableau.of(scene.analysis.scheme, scene.analysis.stages)
    steps = Steps.of(scene)
    equation = _equation_inside(scene, system, steps, tableau)
    start = Equation(system, modal_damping(scene, system))
    known = equation if scene.analysis.scheme == "gauss" else None
    if scene.analysis.tension == "settled" and system.terms.tension is not None:
        start, equation, known = _settled(scene, start, equation, tableau, steps)
    jump = velocity_jumps(scene, equation.system, steps)

    def solve() -> tuple[History, States]:
        orbit = solve_collocation(
            equation, tableau, steps.duration, scene.petsc, _tension(scene, equation.system), jump
        )
        history = history_of(start, orbit.start[steps.regular], orbit.start_velocity[steps.regular])
        return history, lambda places: between(orbit, tableau, steps.duration, places)

    return start.system, _judged(scene, start, modes, steps, known, solve)


def _settled(
    scene: Scene, start: Equation, inside: Equation, tableau: Tableau, steps: Steps
) -> tuple[Equation, Equation, Equation]:
    """Give the equations with axial forces of the response: at the starts of the steps, inside, and for stability."""
    orbit: Orbit | None = None

    def respond(system: System) -> History:
        nonlocal orbit
        equation = Equation(system, inside.extra_damping)
        jump = velocity_jumps(scene, system, steps)
        orbit = solve_collocation(equation, tableau, steps.duration, scene.petsc, None, jump)
        return history_of(equation, orbit.displacement, orbit.velocity)

    settled = settle(inside.system, respond)
    assert orbit is not None

    def stiffened(equation: Equation, q: Array, rate: Array) -> Equation:
        tension = mean_tension(equation.system, history_of(equation, q, rate))
        return Equation(with_tension(equation.system, tension), equation.extra_damping)

    at_starts = stiffened(start, orbit.start[steps.regular], orbit.start_velocity[steps.regular])
    equation = Equation(settled, inside.extra_damping)
    if scene.analysis.scheme == "gauss" or not scene.analysis.stability:
        return at_starts, equation, equation
    gauss = Tableau.of("gauss", scene.analysis.stages)
    at_gauss = between(orbit, tableau, steps.duration, gauss.points)
    return at_starts, equation, stiffened(_equation_inside(scene, start.system, steps, gauss), *at_gauss)


def by_harmonic_balance(scene: Scene, system: System, modes: Modes) -> tuple[System, History]:
    """Solve for a Fourier series; the history is that at the starts of the sub-intervals.

    Raises
    ------
    SceneError
        When impulses act, whose series does not converge, or axial forces are to settle.
    """
    if scene.analysis.tension == "settled" and system.terms.tension is not None:
        raise SceneError(
            "harmonic balance does not update axial forces",
            place="analysis.tension",
            hint="Write solver = 'collocation', or take the effect 'moderate-rotations'",
        )
    if scene.impulses:
        raise SceneError(
            "impulses make velocities jump, which harmonics do not follow",
            place="analysis.solver",
            hint="Write solver = 'collocation'",
        )
    start, steps = Equation(system, modal_damping(scene, system)), Steps.of(scene)

    def solve() -> tuple[History, States]:
        series = solve_harmonic_balance(
            start, scene.analysis.harmonics, scene.period, scene.petsc, _tension(scene, system)
        )
        history = history_of(start, *series.at(np.abs(system.motion.theta)))
        at = lambda places: series.at(np.abs(steps.angles(places, scene.cycle_rate)))  # noqa: E731
        return replace(history, error_estimate=series.error), at

    return system, _judged(scene, start, modes, steps, None, solve)


def _judged(
    scene: Scene,
    start: Equation,
    modes: Modes,
    steps: Steps,
    known: Equation | None,
    solve: Callable[[], tuple[History, States]],
) -> History:
    """Solve, and judge the stability: before if the equation is linear, as then it tells of a resonance too.

    Parameters
    ----------
    start
        The equation at the starts of the sub-intervals.
    known
        The equation at Gauss points, if there is one already.
    solve
        Gives the history, and the motion between.
    """
    analysis, law = scene.analysis, start.system.terms.law
    if not analysis.stability:
        return solve()[0]
    tableau = Tableau.of("gauss", analysis.stages)
    equation = known or _equation_inside(scene, start.system, steps, tableau)

    def judge(matrices: Matrices) -> Stability:
        found = floquet(matrices, tableau, steps.duration, start.linear, modes, scene.petsc)
        if not analysis.allow_unstable:
            found.refuse_unstable()
        return found

    if law is None:
        stability = judge(equation.linear)
        stability.refuse_resonance()
        return replace(solve()[0], stability=stability)
    history, at = solve()
    q, rate = at(tableau.points)
    assert equation.system.terms.law is not None
    tension = equation.system.terms.law.tension(*equation.in_links(q, rate))
    return replace(history, stability=judge(equation.linearised(q, rate, tension)))


def _equation_inside(scene: Scene, system: System, steps: Steps, tableau: Tableau) -> Equation:
    """Give the equation at collocation points of all steps."""
    theta = steps.angles(tableau.points, scene.cycle_rate)
    inside = system_at(scene, system.beams, solve_motion(scene, theta, near=system.motion))
    if inside.transformation.names != system.transformation.names:  # both choose their coordinates by their angles
        raise SolverError("the linkage has no coordinates that are good all over the cycle. Take other sub_intervals")
    return Equation(inside, modal_damping(scene, inside))


def _tension(scene: Scene, system: System) -> Array | None:
    """Rough axial force of each element (N), where the links have a nonlinear law."""
    return None if system.terms.law is None else rigid_tension(scene, system)
