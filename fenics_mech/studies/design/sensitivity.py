"""Derivatives of the numbers of a periodic result by the variables of a study, without another search for a motion.

The equation of motion ``R(q, q', q'', x) = 0`` is linearised about the solution. One more periodic problem for each
variable, ``M dq'' + C dq' + K dq = -dR/dx``, is solved by the steps that carried the motion, with their factors.
The derivative of R by x is a central difference at the motion as it is, of the links' forces in their own axes. So are
those of the numbers, at the motion and its change: of a largest value it is that at the peak. The damping of modes and
the natural frequencies change as the matrices of the links do, without other modes.

Source: Haug and Arora, Applied Optimal Design, 1979, chapter 4 (direct differentiation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.eigenmodes import Modes, solve_modes
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import elastic_response
from fenics_mech.mechanism import System
from fenics_mech.mechanism.damping_factors import FullFactor
from fenics_mech.mechanism.equation import Equation
from fenics_mech.recovery.dataset import collect
from fenics_mech.recovery.fields import recover
from fenics_mech.response.periodic.collocation import orbit_of
from fenics_mech.response.periodic.cycle import Cycle, system_at_places
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.near_known import BesideKnown, KnownModes, between, modes_beside
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.setup import mechanism
from fenics_mech.response.solution import CollocationSolution
from fenics_mech.scene import Scene
from fenics_mech.studies.design.trial import Trials, read_numbers

STEP = 6e-5  # of differences, as a share of a variable: of less rounding shows, of more its third power
Held = tuple[Stack, Stack]  # M and K of the mechanism held at its positions
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
    here, known = np.array(values, dtype=float), _Known(trials, solution)
    flow = solution.orbit.flow
    assert flow is not None
    near = [_Neighbours.of(known, here, k) for k in range(len(here))]
    loads = [one.load() for one in near]
    added = np.stack([flow.added_by(load) for load in loads], axis=-1)
    states = flow.cycle.solve(added, None, CYCLIC.tolerance_of_change)
    columns = [one.derivatives(orbit_of(flow, states[..., k], load)) for k, (one, load) in enumerate(zip(near, loads))]
    return {name: np.array([column[name] for column in columns]) for name in columns[0]}


@dataclass(frozen=True, eq=False)
class _Known:
    """The motion that is known, and what its derivatives by all variables have in common.

    Parameters
    ----------
    trials
        The trials.
    solution
        The motion.
    """

    trials: Trials
    solution: CollocationSolution

    @property
    def cycle(self) -> Cycle:
        """The equation of motion over the cycle."""
        return self.solution.cycle

    @cached_property
    def names(self) -> set[str]:
        """Variables of the result that numbers are made from."""
        return {name for quantity in self.trials.quantities for name in quantity.variables}

    @cached_property
    def at_points(self) -> Equation:
        """The equation at the collocation points."""
        return self.cycle.at_points(self.cycle.tableau)

    @cached_property
    def state(self) -> tuple[Array, Array]:
        """State q and q' at the starts of the sub-intervals, ``(positions, coordinates)`` each."""
        orbit, regular = self.solution.orbit, self.cycle.steps.regular
        return orbit.start[regular], orbit.start_velocity[regular]

    @cached_property
    def acceleration(self) -> Array:
        """Acceleration q'' at the starts of the sub-intervals, ``(positions, coordinates)``."""
        return self.cycle.start.acceleration(*self.state)

    @cached_property
    def damped_alike(self) -> bool:
        """Whether the damping of modes is one ratio of all of them, so that it changes as their matrices do."""
        factor = self.cycle.start.modal_damping
        whole = isinstance(factor, FullFactor) and factor.values.shape[1] == factor.values.shape[2]
        return whole and isinstance(self.solution.scene.damping.ratio, float)

    @cached_property
    def modes(self) -> tuple[KnownModes, KnownModes | None]:
        """Damped modes at the starts of the sub-intervals, and at the points where damping is not interpolated."""
        smooth = self.cycle.damped_by_starts
        return KnownModes.of(self.solution.system), None if smooth else KnownModes.of(self.at_points.system)

    def damping_changes(self, ahead: _Side, behind: _Side) -> tuple[Array | None, Array | None]:
        """Give half the difference of the damping of modes on both sides, at the starts and at the points."""
        if not self.damped_alike:
            return None, None
        (at_starts, at_points), cycle = self.modes, self.cycle
        start = _damping_change(at_starts, cycle.start, (ahead, behind), (ahead.held, behind.held))
        if at_points is None:
            return start, between(start, cycle.tableau.points)
        there = ahead.at_points().held_matrices(), behind.at_points().held_matrices()
        return start, _damping_change(at_points, self.at_points, (ahead, behind), there)


def _damping_change(
    modes: KnownModes, equation: Equation, sides: tuple[_Side, _Side], held: tuple[Held, Held]
) -> Array:
    """Half the difference of the damping of modes on both sides, ``(positions, coordinates, coordinates)``."""
    mass, stiffness = (more + -1.0 * less for more, less in zip(*held))
    scenes, factor = (sides[0].known.solution.scene, *(side.cycle.scene for side in sides)), equation.modal_damping
    assert factor is not None
    ratio, more, less = (float(np.mean(scene.damping.ratio)) for scene in scenes)  # it is one number
    whole = factor.values.transpose(0, 2, 1) @ factor.values
    return (ratio * modes.change_of_damping(mass, stiffness) + (more - less) / ratio * whole) / 2


@dataclass(frozen=True, eq=False)
class _Side:
    """The mechanism at another value of a variable.

    Parameters
    ----------
    known
        The motion that is known.
    cycle
        The equation of motion there.
    """

    known: _Known
    cycle: Cycle

    @property
    def faster(self) -> float:
        """How many times as fast the drive is."""
        return self.cycle.scene.cycle_rate / self.known.solution.scene.cycle_rate

    @cached_property
    def held(self) -> Held:
        """M and K at the starts of the sub-intervals."""
        return self.cycle.system.held_matrices()

    def at_points(self) -> System:
        """The mechanism at the collocation points; many variables would keep much of it."""
        cycle = self.cycle
        return system_at_places(cycle.scene, cycle.system, cycle.steps, cycle.tableau.points)

    @cached_property
    def assembled(self) -> bool:
        """Whether the equation is assembled, as its damping of modes does not follow from the known one."""
        damped = np.any(self.cycle.scene.damping.ratio) or np.any(self.known.solution.scene.damping.ratio)
        return bool(damped) and not self.known.damped_alike

    def residual(self, change: Array | None) -> Array:
        """What the known motion leaves over there, ``(points, coordinates)``, by the change of the damping of modes."""
        orbit, k, known = self.known.solution.orbit, self.faster, self.known
        state = orbit.displacement, k * orbit.velocity, k**2 * orbit.acceleration
        if self.assembled:
            return self.cycle.at_points(self.cycle.tableau).residual(*state)
        return BesideKnown(known.at_points, self.at_points(), change).residual(*state)

    def numbers(self, shift: tuple[Array, Array], change: Array | None) -> dict[str, float]:
        """Recover the numbers of the known motion with a change of q and q' of its own pace, and nothing else."""
        (q, rate), known, cycle, k = self.known.state, self.known, self.cycle, self.faster
        q, rate = q + shift[0], k * (rate + shift[1])
        if self.assembled:
            response = elastic_response(cycle.start, q, rate)
        else:
            beside = BesideKnown(known.cycle.start, cycle.system, change)
            response = beside.response(q, rate, k**2 * known.acceleration)
        other = replace(  # the equation is not replaced, as nothing is recovered from it
            known.solution, scene=cycle.scene, system=cycle.system, response=response, modes=self._modes(), cycle=cycle
        )
        result = collect(other, recover(other), None, names=known.names)
        return read_numbers(known.trials.quantities, result, known.trials.design.study.targets)

    def _modes(self) -> Modes:
        """Natural modes there, as far as numbers are made from them."""
        solution, needed = self.known.solution, self.known.names
        if not {"frequency", "assurance"} & needed:
            return solution.modes
        near = None if "assurance" in needed else modes_beside(solution.modes, *self.held)
        scene = self.cycle.scene
        return solve_modes(self.cycle.system, scene.analysis.modes, scene.petsc) if near is None else near


@dataclass(frozen=True, eq=False)
class _Neighbours:
    """The mechanisms on both sides of the known one, by one variable.

    Parameters
    ----------
    ahead, behind
        The mechanisms.
    step
        Distance of their values from the known one.
    at_starts, at_points
        Half the difference of their damping of modes; None where there is none.
    """

    ahead: _Side
    behind: _Side
    step: float
    at_starts: Array | None
    at_points: Array | None

    @classmethod
    def of(cls, known: _Known, here: Array, k: int) -> _Neighbours:
        """Build them beside the values of all variables, ``(variables,)``."""
        variable = known.trials.design.variables[k]
        span = variable.upper - variable.lower
        step = STEP * min(span, max(abs(here[k]), SMALL * span))
        ahead, behind = (_side(known, here + sign * step * np.eye(len(here))[k]) for sign in (1.0, -1.0))
        return cls(ahead, behind, step, *known.damping_changes(ahead, behind))

    def load(self) -> Array:
        """Give minus the derivative of the residual, ``(points, coordinates)``."""
        more, less = self.ahead.residual(self.at_points), self.behind.residual(_minus(self.at_points))
        return -(more - less) / (2 * self.step)

    def derivatives(self, change: Orbit) -> dict[str, float]:
        """Give the derivatives of all numbers by that of the motion."""
        regular = self.ahead.known.cycle.steps.regular
        q, rate = self.step * change.start[regular], self.step * change.start_velocity[regular]
        more = self.ahead.numbers((q, rate), self.at_starts)
        less = self.behind.numbers((-q, -rate), _minus(self.at_starts))
        return {name: (more[name] - less[name]) / (2 * self.step) for name in more}


def _side(known: _Known, values: Array) -> _Side:
    """Build the mechanism at other values of the variables."""
    scene = Scene.read(known.trials.data_at(values.tolist()))
    system = mechanism(scene, common=known.trials.common)
    if system.transformation.names != known.solution.system.transformation.names:
        raise SolverError("the independent coordinates change with a variable of the study")
    return _Side(known, Cycle(scene, system))


def _minus(change: Array | None) -> Array | None:
    return None if change is None else -change
