"""Derivatives of the numbers of a periodic result by the variables of a study, without another search for a motion.

The equation of motion ``R(q, q', q'', x) = 0`` is linearised about the solution. One more periodic problem for each
variable, ``M dq'' + C dq' + K dq = -dR/dx``, is solved by the same steps, all with the same factors.
The derivative of R by x is a central difference at the motion as it is, of the links' forces in their own axes. So are
those of the numbers, at the motion and its change: of a largest value it is that at the peak. The damping of modes and
the natural frequencies change as the matrices of the links do, without other modes. Floquet multipliers change by what
the linearised equation leaves over of their disturbances.

Source: Haug and Arora, Applied Optimal Design, 1979, chapter 4 (direct differentiation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse import Stack
from fenics_mech.eigenmodes import Modes, natural, solve_modes
from fenics_mech.errors import DerivativeError, SolverError
from fenics_mech.forces.elastic_response import ElasticResponse, elastic_response, response_at
from fenics_mech.mechanism import System
from fenics_mech.mechanism.damping_factors import FullFactor
from fenics_mech.mechanism.equation import Equation
from fenics_mech.recovery import Result
from fenics_mech.recovery.dataset import collect, of_stability
from fenics_mech.recovery.fields import recover
from fenics_mech.recovery.result import stamp
from fenics_mech.response.periodic.collocation import between as inside_steps
from fenics_mech.response.periodic.cycle import Cycle, system_at_places
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.flow import Flow
from fenics_mech.response.periodic.near_known import BesideKnown, KnownModes, Path, State, between, modes_beside
from fenics_mech.response.periodic.newton import Orbit, orbit_of
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import mechanism
from fenics_mech.response.solution import AtPoints, CollocationSolution
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.response.stability.multiplier_changes import Disturbances
from fenics_mech.scene import Scene
from fenics_mech.studies.design.trial import Trials
from fenics_mech.studies.design.trial_tasks import read_numbers

STEP = 6e-5  # of differences, as a share of a variable: of less rounding shows, of more its third power
Held = tuple[Stack, Stack]  # M and K of the mechanism held at its positions
Starts = tuple[State, Array | None]  # changes of q and q' at starts, and that of the modes' damping
Points = tuple[Sequence[Array], Array | None]  # those of q, q' and q'' at collocation points
SMALL = 1e-2  # share of a variable's range, below which its own size is no measure of a step
SHARE = 1e-2  # of a step, that multipliers take: their angles change far more than other numbers
LARGEST = 0.99  # of the largest multiplier: a margin of stability looks at no smaller ones


def sensitivity(trials: Trials, values: Sequence[float]) -> dict[str, Array]:
    """Give the derivatives of all numbers of a trial by the variables.

    Parameters
    ----------
    trials
        The trials, for which `Trials.linearised` holds.
    values
        A value of each variable, in SI.

    Returns
    -------
    dict
        By name, by each variable in SI, ``(variables,)``.

    Raises
    ------
    DerivativeError
        When the motion is not one by collocation, its axial forces settle apart from it, or multipliers have no
        derivatives.
    MechanismError
        When the analysis fails.
    """
    solution = trials.solution(values)
    if type(solution) is not CollocationSolution:
        raise DerivativeError("the motion is not found by collocation alone")
    if solution.cycle.settling:
        raise DerivativeError("axial forces of the response act")
    here, known = np.array(values, dtype=float), _Known(trials, solution)
    flow = known.flow
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
    _modes: dict[Tableau, KnownModes] = field(default_factory=dict)

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
    def flow(self) -> Flow:
        """The steps of the equation linearised about the motion."""
        orbit, flow = self.solution.orbit, self.solution.orbit.flow
        assert flow is not None
        if self.cycle.linear:
            return flow
        # Newton's last tangents are those of the motion before, which differs by more than derivatives may
        return replace(flow, matrices=self.at_points.about(orbit.displacement, orbit.velocity, orbit.acceleration))

    @cached_property
    def gauss(self) -> Tableau:
        """Collocation points by which stability is judged."""
        return Tableau.of("gauss", self.solution.scene.analysis.stages)

    @cached_property
    def disturbances(self) -> Disturbances | None:
        """Disturbances that numbers are made from; None where stability is not looked at."""
        judged = [quantity for quantity in self.trials.quantities if quantity.needs_stability]
        stability = self.solution.stability
        if not judged or stability is None:
            return None
        share = LARGEST if all(quantity.name == "stability" for quantity in judged) else 0.0
        same = self.gauss == self.cycle.tableau
        flow = self.flow if same else self.cycle.flow(self.gauss, self.cycle.motion(self.solution.orbit))
        return Disturbances.find(flow, stability, share)

    @cached_property
    def state_at_gauss(self) -> State:
        """State q and q' at the points by which stability is judged, ``(points, coordinates)`` each."""
        return self.cycle.motion(self.solution.orbit)(self.gauss.points)

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
    def modes(self) -> KnownModes:
        """Damped modes at the starts of the sub-intervals."""
        return KnownModes.of(self.solution.system)

    def damping_change(self, ahead: _Side, behind: _Side) -> Array | None:
        """Give half the difference of the damping of modes on both sides, at the starts of the sub-intervals."""
        if not self.damped_alike:
            return None
        return _damping_change(self.modes, self.cycle.start, (ahead, behind), (ahead.held, behind.held))

    def damping_change_at(self, tableau: Tableau, start: Array | None, sides: tuple[_Side, _Side]) -> Array | None:
        """Give it at collocation points: by that at the starts, where damping is interpolated too."""
        if start is None:
            return None
        if self.cycle.damped_by_starts:
            return between(start, tableau.points)
        equation = self.cycle.at_points(tableau)
        if tableau not in self._modes:
            self._modes[tableau] = KnownModes.of(equation.system)
        ahead, behind = (natural(side.at_points(tableau)).held_matrices() for side in sides)
        return _damping_change(self._modes[tableau], equation, sides, (ahead, behind))


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
        return natural(self.cycle.system).held_matrices()

    def at_points(self, tableau: Tableau) -> System:
        """The mechanism at collocation points; many variables would keep much of it."""
        cycle = self.cycle
        return system_at_places(cycle.scene, cycle.system, cycle.steps, tableau.points)

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
        return BesideKnown(known.at_points, self.at_points(self.cycle.tableau), change).residual(*state)

    def tangents(self, shift: State, paths: Sequence[Path], change: Array | None) -> list[Array]:
        """What disturbances of the known motion with a change of its own pace leave over, ``(points, coordinates)``."""
        known, k, gauss = self.known, self.faster, self.known.gauss
        state = known.state_at_gauss[0] + shift[0], k * (known.state_at_gauss[1] + shift[1])
        there = [(q, k * rate, k**2 * second) for q, rate, second in paths]
        if self.assembled:
            matrices = self.cycle.at_points(gauss).about(*state)
            self.cycle.forget(gauss)
            return [matrices.left(*path) for path in there]
        return BesideKnown(known.cycle.at_points(gauss), self.at_points(gauss), change).tangents(state, there)

    def numbers(self, starts: Starts, points: Points | None, stability: Stability | None) -> dict[str, float]:
        """Recover the numbers of the known motion with changes at its own pace.

        `points` are the changes at collocation points, where they are needed.
        """
        known = self.known
        if stability is not None and known.names == {"multiplier"}:
            result = Result(of_stability(stability).assign_attrs(stamp(self.cycle.scene)))
        else:
            result = self._recovered(starts, points, stability)
        return read_numbers(known.trials.quantities, result, known.trials.design.study.targets)

    def _recovered(self, starts: Starts, points: Points | None, stability: Stability | None) -> Result:
        """Recover what numbers are made from."""
        known, cycle, inside = self.known, self.cycle, None
        response = self._at_starts(*starts)
        if points is not None:
            inside = partial(AtPoints, *self._at_points(*points), cycle.weights)
        other = replace(  # the equation is not replaced, as nothing is recovered from it
            known.solution, scene=cycle.scene, system=cycle.system, response=response, modes=self._modes(), cycle=cycle
        )
        other = replace(other, stability=stability, inside=inside)
        return collect(other, recover(other), None, names=known.names)

    def _at_starts(self, shift: State, change: Array | None) -> ElasticResponse:
        """The response at the starts of the sub-intervals, where the equation of motion gives the acceleration."""
        known, k = self.known, self.faster
        q, rate = known.state[0] + shift[0], k * (known.state[1] + shift[1])
        if self.assembled:
            return elastic_response(self.cycle.start, q, rate)
        beside = BesideKnown(known.cycle.start, self.cycle.system, change)
        return beside.response(q, rate, beside.acceleration(q, rate, k**2 * known.acceleration))

    def _at_points(self, shift: Sequence[Array], change: Array | None) -> tuple[System, ElasticResponse]:
        """The mechanism and its response at the collocation points.

        The linearised equation gives the change of the acceleration. By the equation itself it would be rounded as
        the forces of stretching are, beside which the mean of a drive's power is small.
        """
        known, k, orbit = self.known, self.faster, self.known.solution.orbit
        path = (orbit.displacement, orbit.velocity, orbit.acceleration)
        q, rate, acceleration = (k**i * (old + new) for i, (old, new) in enumerate(zip(path, shift)))
        if self.assembled:
            equation = self.cycle.at_points(known.cycle.tableau)
            return equation.system, response_at(equation, q, rate, acceleration)
        system = self.at_points(known.cycle.tableau)
        return system, BesideKnown(known.at_points, system, change).response(q, rate, acceleration)

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
    at_starts
        Half the difference of their damping of modes at the starts of the sub-intervals; None where there is none.
    """

    ahead: _Side
    behind: _Side
    step: float
    at_starts: Array | None

    @classmethod
    def of(cls, known: _Known, here: Array, k: int) -> _Neighbours:
        """Build them beside the values of all variables, ``(variables,)``."""
        variable = known.trials.design.variables[k]
        span = variable.upper - variable.lower
        step = STEP * min(span, max(abs(here[k]), SMALL * span))
        ahead, behind = (_side(known, here + sign * step * np.eye(len(here))[k]) for sign in (1.0, -1.0))
        return cls(ahead, behind, step, known.damping_change(ahead, behind))

    def _damping_change_at(self, tableau: Tableau) -> tuple[Array | None, Array | None]:
        """Changes of the damping of modes on both sides, at collocation points."""
        change = self.ahead.known.damping_change_at(tableau, self.at_starts, (self.ahead, self.behind))
        return change, _minus(change)

    def load(self) -> Array:
        """Give minus the derivative of the residual, ``(points, coordinates)``."""
        changes = self._damping_change_at(self.ahead.known.cycle.tableau)
        more, less = (side.residual(change) for side, change in zip((self.ahead, self.behind), changes))
        return -(more - less) / (2 * self.step)

    def derivatives(self, change: Orbit) -> dict[str, float]:
        """Give the derivatives of all numbers by that of the motion."""
        regular = self.ahead.known.cycle.steps.regular
        q, rate = self.step * change.start[regular], self.step * change.start_velocity[regular]
        ahead, behind = self._stability(change)
        points = self._at_points(change)
        more = self.ahead.numbers(((q, rate), self.at_starts), points[0], ahead)
        less = self.behind.numbers(((-q, -rate), _minus(self.at_starts)), points[1], behind)
        quantities = self.ahead.known.trials.quantities
        share = {name: SHARE if one.needs_stability else 1.0 for one in quantities for name in one.names}
        return {name: (more[name] - less[name]) / (2 * self.step * share[name]) for name in more}

    def _at_points(self, change: Orbit) -> tuple[Points, Points] | tuple[None, None]:
        """Changes at the collocation points to both sides, by which powers are integrated; None where none is asked."""
        if "mean_power" not in self.ahead.known.names:
            return None, None
        path = change.displacement, change.velocity, change.acceleration
        more, less = self._damping_change_at(self.ahead.known.cycle.tableau)
        ahead, behind = ([sign * self.step * part for part in path] for sign in (1.0, -1.0))
        return (ahead, more), (behind, less)

    def _stability(self, change: Orbit) -> tuple[Stability | None, Stability | None]:
        """Multipliers at a share of the step to both sides; None where no number is made from them."""
        known = self.ahead.known
        if (disturbances := known.disturbances) is None:
            return None, None
        cycle, gauss, parts = known.cycle, known.gauss, disturbances.parts
        q, rate = (self.step * part for part in inside_steps(change, cycle.tableau, cycle.steps.duration, gauss.points))
        paths = [(part.displacement, part.velocity, part.acceleration) for part in parts]
        more, less = self._damping_change_at(gauss)
        ahead = self.ahead.tangents((q, rate), paths, more)
        behind = self.behind.tangents((-q, -rate), paths, less)
        changes = SHARE * disturbances.changes([(a - b) / 2 for a, b in zip(ahead, behind)])
        faster = [1 + SHARE * (side.faster - 1) for side in (self.ahead, self.behind)]
        return disturbances.changed(changes, faster[0]), disturbances.changed(-changes, faster[1])


def _side(known: _Known, values: Array) -> _Side:
    """Build the mechanism at other values of the variables."""
    scene = Scene.read(known.trials.data_at(values.tolist()))
    system = mechanism(scene, common=known.trials.common)
    if system.transformation.names != known.solution.system.transformation.names:
        raise SolverError("the independent coordinates change with a variable of the study")
    return _Side(known, Cycle(scene, system))


def _minus(change: Array | None) -> Array | None:
    return None if change is None else -change
