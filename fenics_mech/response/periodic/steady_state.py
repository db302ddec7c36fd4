"""Periodic response of the whole equation of motion, how accurate it is, and whether it is stable."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech.accuracy.motion_errors import collocation_better, mesh_better, resonances_of, with_hidden
from fenics_mech.errors import SceneError, SolverError, UnresolvedError
from fenics_mech.forces.element_ends import mean_tension
from fenics_mech.forces.history import Better, Closed, Inside, Struck, history_of
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation, Matrices
from fenics_mech.modes import Modes
from fenics_mech.response import History
from fenics_mech.response.modal_damping import modal_damping
from fenics_mech.response.periodic.collocation import between, refined, solve_collocation
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.harmonic_balance import solve_harmonic_balance
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.periodic.tableau import Tableau, better_than
from fenics_mech.response.setup import moved, rough_tension, settle, system_at, with_tension
from fenics_mech.response.stability.floquet import Stability, floquet
from fenics_mech.response.stability.resonance import blaming, magnification, refuse_magnified
from fenics_mech.response.stability.turning import LinkAxes
from fenics_mech.response.static.equilibrium import naming_buckled
from fenics_mech.response.velocity_jumps import jumps_at, velocity_jumps
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
APART = 1e12  # of the fastest coordinate from the slowest
FASTEST = 1e14  # rad in a step; measured: right at 5e13, and multipliers next to 1 of no vibration at 5e15
HARMONIC_ORDER = 8  # the series falls faster than any power; this one asks for harmonics enough
States = Callable[[Array], tuple[Array, Array]]  # q and q' at places 0..1 in every step of the cycle


@dataclass(frozen=True, eq=False)
class Cycle:
    """The equation of motion of a scene at the collocation points of the steps of its cycle.

    Parameters
    ----------
    scene, system
        The scene, and its mechanism at the starts of the sub-intervals.
    """

    scene: Scene
    system: System
    _equations: dict[tuple[str, int], Equation] = field(default_factory=dict)
    _flows: dict[tuple[str, int], Flow] = field(default_factory=dict)

    @cached_property
    def steps(self) -> Steps:
        """The sub-intervals, cut where something jumps."""
        return Steps.of(self.scene)

    @cached_property
    def start(self) -> Equation:
        """The equation at the starts of the sub-intervals."""
        return Equation(self.system, modal_damping(self.scene, self.system))

    @property
    def settling(self) -> bool:
        """Whether axial forces of the response act on it."""
        return self.scene.analysis.tension == "settled" and self.system.terms.tension is not None

    @property
    def linear(self) -> bool:
        """Whether the equation does not depend on the motion."""
        return self.system.terms.law is None and not self.settling

    @property
    def tension(self) -> Array | None:
        """Rough axial force at the starts (N), where the links have a nonlinear law."""
        return rough_tension(self.scene, self.system)

    def inside(self, scheme: str, stages: int) -> Equation:
        """Give the equation at collocation points of all steps."""
        if (scheme, stages) not in self._equations:
            tableau = Tableau.of(scheme, stages)
            self._equations[scheme, stages] = equation_inside(self.scene, self.system, self.steps, tableau)
        return self._equations[scheme, stages]

    def flow(self, scheme: str, stages: int, motion: States | None = None) -> Flow:
        """Give the steps of the equation linearised about the motion (a linear one needs none)."""
        if (scheme, stages) not in self._flows:
            tableau, equation = Tableau.of(scheme, stages), self.inside(scheme, stages)
            matrices = (
                equation.linear if self.linear or motion is None else self._about(equation, *motion(tableau.points))
            )
            self._flows[scheme, stages] = Flow(matrices, tableau, self.steps.duration, self.scene.petsc)
        return self._flows[scheme, stages]

    def _about(self, equation: Equation, q: Array, rate: Array) -> Matrices:
        """Linearise about a motion."""
        law = equation.system.terms.law
        if law is None:
            return self.stiffened(equation, q, rate).linear
        return equation.linearised(q, rate, law.tension(*equation.in_links(q, rate)))

    @staticmethod
    def stiffened(equation: Equation, q: Array, rate: Array) -> Equation:
        """Give the equation with the axial forces of a motion."""
        tension = mean_tension(equation.system, history_of(equation, q, rate))
        return Equation(with_tension(equation.system, tension), equation.extra_damping)

    def stability(self, modes: Modes, motion: States | None = None) -> Stability | None:
        """Judge a motion, if the scene wants it.

        Raises
        ------
        SolverError
            When it is unstable, or an equation that is the same for all motions has a resonance.
        """
        analysis = self.scene.analysis
        if not analysis.stability:
            return None
        found = self._judged(modes, motion)
        if not analysis.allow_unstable:
            found.refuse_unstable()
        if self.linear:
            found.refuse_resonance()
        return found

    def _judged(self, modes: Modes, motion: States | None) -> Stability:
        if self.massless is not None:
            raise SolverError(
                f"{self.massless} has next to no mass: multipliers, lost to rounding, do not tell its vibration. Give "
                "its link a density or a mass, or write analysis.stability = false"
            )
        flow = self.flow("gauss", self.scene.analysis.stages, motion)
        return floquet(flow, self.start.linear, self.axes, modes, self.scene.petsc)

    @cached_property
    def axes(self) -> LinkAxes:
        """The links' axes at the starts of the steps."""
        return axes_at(self.scene, self.system, self.steps)

    @cached_property
    def massless(self) -> str | None:
        """Coordinate whose own vibration turns so far in a step that its multipliers are lost to rounding."""
        mass, stiffness = (np.diag(part[0]) for part in (self.start.linear.mass, self.start.linear.stiffness))
        heavy = np.flatnonzero(mass > 0)  # with lumped masses rotations have none
        pace = np.sqrt(np.abs(stiffness[heavy] / mass[heavy]))
        lost = pace.max() > FASTEST / float(np.max(self.steps.duration)) and pace.max() > APART * pace.min()
        return self.system.transformation.names[heavy[int(pace.argmax())]] if lost else None

    @contextmanager
    def determined(self, modes: Modes) -> Iterator[None]:
        """Add the mode at resonance to an error about a linear equation; see `blaming`."""
        if not self.linear or self.massless is not None:
            yield
            return
        with blaming(lambda: self._judged(modes, None).nearest()):
            yield

    def refuse_magnified(self, modes: Modes, condition: float, motion: States | None) -> None:
        """Raise `SolverError` where rounding would show in a motion of that condition."""
        refuse_magnified(condition, lambda: self._judged(modes, motion).nearest())

    def motion(self, orbit: Orbit) -> States:
        """Give a motion by collocation between the starts of the steps."""
        tableau = Tableau.of(self.scene.analysis.scheme, self.scene.analysis.stages)
        return lambda places: between(orbit, tableau, self.steps.duration, places)

    def history(self, orbit: Orbit, modes: Modes) -> tuple[Equation, History]:
        """Give the history of a motion by collocation, and a better one; both are at the starts of the sub-intervals.

        Returns
        -------
        tuple
            The equation there, with axial forces of the motion where they act on it, and the history.
        """
        analysis, at, start = self.scene.analysis, self.steps.regular, self.start
        points = better_than(analysis.scheme, analysis.stages, self.steps.disturbed)
        finer = self.flow(*points, self.motion(orbit))
        if self.settling:
            start = self.stiffened(start, orbit.start[at], orbit.start_velocity[at])
        better = collocation_better(self.scene, start, orbit, finer, (modes, self.steps))
        return start, replace(history_of(start, orbit.start[at], orbit.start_velocity[at]), better=better)


def axes_at(scene: Scene, system: System, steps: Steps) -> LinkAxes:
    """Give the links' axes at the starts of steps, of a mechanism at the starts of the sub-intervals."""
    whole = steps.regular.all()
    return LinkAxes.of(system, system.motion if whole else solve_motion(scene, steps.start, near=system.motion))


def equation_inside(scene: Scene, system: System, steps: Steps, tableau: Tableau) -> Equation:
    """Give the equation at collocation points of all steps."""
    theta = steps.angles(tableau.points, scene.cycle_rate)
    inside = system_at(scene, system.beams, solve_motion(scene, theta, near=system.motion))
    if inside.transformation.names != system.transformation.names:  # both choose their coordinates by their angles
        raise UnresolvedError(
            "the linkage has no coordinates that are good all over the cycle. Take other sub_intervals"
        )
    return Equation(inside, modal_damping(scene, inside))


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
    cycle, analysis = Cycle(scene, system), scene.analysis
    stability = cycle.stability(modes) if cycle.linear else None  # first, as it names a resonance
    tableau, steps = Tableau.of(analysis.scheme, analysis.stages), cycle.steps
    inside = cycle.inside(analysis.scheme, analysis.stages)
    if cycle.settling:
        inside = _settled(cycle, inside, tableau)
    with cycle.determined(modes):
        orbit = _orbit(scene, inside, tableau, steps)
    condition = condition_of(orbit)
    cycle.refuse_magnified(modes, condition, None if cycle.linear else cycle.motion(orbit))
    if not cycle.linear:
        stability = cycle.stability(modes, cycle.motion(orbit))
    start, history = cycle.history(orbit, modes)
    within = Inside(
        inside.system,
        history_of(inside, orbit.displacement, orbit.velocity),
        shares_of(tableau, steps),
        _struck(scene, system, steps, orbit),
    )
    return start.system, replace(history, stability=stability, closed=Closed(condition, within))


def shares_of(tableau: Tableau, steps: Steps) -> Array:
    """Weights of the collocation points of all steps in a mean over the cycle, ``(steps x points,)``."""
    return np.outer(steps.duration / steps.duration.sum(), tableau.weights).ravel()


def _struck(scene: Scene, system: System, steps: Steps, orbit: Orbit) -> Struck | None:
    """Give the state at the impulses of a motion by collocation, whose starts of steps are just after them."""
    if not scene.impulses:
        return None
    at = steps.struck
    motion = solve_motion(scene, steps.start[at], near=system.motion)
    equation, jump = Equation(moved(scene, system, motion)), jumps_at(scene, system, steps.start[at])
    together = (at[:, None] == at).astype(float) @ jump  # impulses at one angle strike at once
    mean_rate = orbit.start_velocity[at] - together / 2
    return Struck(equation.system, history_of(equation, orbit.start[at], mean_rate), jump)


def condition_of(orbit: Orbit) -> float:
    """How many times a relative error of the steps comes out in a motion by collocation; see `magnification`."""
    flow = orbit.flow
    assert flow is not None
    return magnification(flow.cycle, flow.states(orbit.start, orbit.start_velocity), np.tile(flow.unit, 2))


def _orbit(scene: Scene, inside: Equation, tableau: Tableau, steps: Steps) -> Orbit:
    jump, tension = velocity_jumps(scene, inside.system, steps), rough_tension(scene, inside.system)
    with naming_buckled(inside, tension):
        return solve_collocation(inside, tableau, steps.duration, scene.petsc, tension, jump)


def _settled(cycle: Cycle, inside: Equation, tableau: Tableau) -> Equation:
    """Give the equation with the axial forces of the response."""

    def respond(system: System) -> History:
        equation = Equation(system, inside.extra_damping)
        orbit = _orbit(cycle.scene, equation, tableau, cycle.steps)
        return history_of(equation, orbit.displacement, orbit.velocity)

    return Equation(settle(inside.system, respond), inside.extra_damping)


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
    cycle, analysis = Cycle(scene, system), scene.analysis
    stability = cycle.stability(modes) if cycle.linear else None  # first, as it names a resonance
    with cycle.determined(modes):
        series = solve_harmonic_balance(cycle.start, analysis.harmonics, scene.period, scene.petsc, cycle.tension)

    def motion(places: Array) -> tuple[Array, Array]:
        return series.at(np.abs(cycle.steps.angles(places, scene.cycle_rate)))

    cycle.refuse_magnified(modes, series.condition, None if cycle.linear else motion)
    if not cycle.linear:
        stability = cycle.stability(modes, motion)
    flow, regular = cycle.flow("gauss", analysis.stages, motion), cycle.steps.regular
    starts = motion(np.zeros(1))
    q, rate = (part[regular] for part in starts)
    mesh = mesh_better(scene, cycle.start, (q, rate), starts, flow, regular)
    resonances = resonances_of(scene, cycle.start, modes)
    finer = (part[regular] for part in refined(*starts, flow))
    better = {
        "harmonics": Better(history_of(cycle.start, *finer), HARMONIC_ORDER),
        "mesh": with_hidden(mesh, cycle.start, (q, rate), resonances, resonances.by_mesh),
    }
    closed = Closed(series.condition)
    return system, replace(history_of(cycle.start, q, rate), stability=stability, better=better, closed=closed)
