"""Newton's method for a motion whose links have a nonlinear law, whatever solves the linear problem in each step."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.periodic.cyclic import CYCLIC
from fenics_mech.response.periodic.flow import FEW_STATES, Flow


@dataclass(frozen=True)
class NewtonLimits:
    """Limits of Newton's method."""

    most_iterations: int = 30  # before a motion counts as not found
    smallest_rise: float = 1 / 256  # of the load, before it is given up
    most_load_steps: int = 40  # tried, before it is given up: motions that are found take 1 to 5
    rise_by_strains: float = 1 / 16  # of the load, where tensions are those of the strains
    tolerance: float = 1e-9  # of the change of the displacement, relative
    of_answer: float = 1e-3  # the same where a tolerance of the answer is stated, as a share of it
    far: float = 0.01  # change beyond which a tension is guessed
    reuse_below: float = 0.05  # change, below which the same tangents are used again: that costs a third of new ones
    most_reuses: int = 4  # in which the answer has to be reached by the ratio of changes, or new tangents are made
    reuse_tolerance: float = 0.01  # of the tolerance: new tangents pass it by as much, as errors fall with squares
    alike: float = 1e-4  # change since the tangents, up to which they count as those about the answer
    rounding: float = 1e-6  # change that is rounding where it falls no more: near buckling little load moves much


logger = logging.getLogger(__name__)
NEWTON = NewtonLimits()


@dataclass(frozen=True)
class Orbit:
    """A motion at the points of a solver, ``(points, coordinates)``, and at the starts of its steps.

    Parameters
    ----------
    displacement, velocity, acceleration
        q, q' and q'' at the points.
    start, start_velocity
        q and q' at the starts, ``(steps, coordinates)``.
    flow
        The steps of the linear equation that was solved last, where there are some.
    linearised_here
        Whether that equation is linearised about this motion, up to `NewtonLimits.alike`, or about one beside it.
    """

    displacement: Array
    velocity: Array
    acceleration: Array
    start: Array
    start_velocity: Array
    flow: Flow | None = None
    linearised_here: bool = True

    def changed(self, load: Array) -> Orbit:
        """Give the motion under a little more load, by the same steps.

        Parameters
        ----------
        load
            What is added to the load at the points, ``(points, coordinates)``.
        """
        flow = self.flow
        assert flow is not None
        more = orbit_of(flow, flow.cycle.solve(flow.added_by(load), None, CYCLIC.tolerance_of_change), load)
        names = ("displacement", "velocity", "acceleration", "start", "start_velocity")
        return replace(self, **{name: getattr(self, name) + getattr(more, name) for name in names})


def orbit_of(flow: Flow, states: Array, load: Array) -> Orbit:
    """Give the motion inside the steps from the states at their starts.

    Parameters
    ----------
    flow
        The steps.
    states
        States at their starts, ``(steps, 2n)``.
    load
        Load at the collocation points (N, N m), ``(points, n)``.
    """
    n, tableau = flow.size, flow.tableau
    q, rate = flow.parts(states)
    h = flow.duration[:, None, None]
    acceleration = flow.accelerations(states, load)
    velocity = rate[:, None] + h * (tableau.inner @ acceleration)
    displacement = q[:, None] + h * tableau.points[:, None] * rate[:, None]
    displacement += h**2 * (tableau.square @ acceleration)
    return Orbit(
        displacement=displacement.reshape(-1, n),
        velocity=velocity.reshape(-1, n),
        acceleration=acceleration.reshape(-1, n),
        start=q,
        start_velocity=rate,
    )


@dataclass
class _Progress:
    """How Newton's method gets on, by relative changes of the displacement.

    Near the answer it takes the same tangents for several iterations: the modified Newton method.

    Parameters
    ----------
    tolerance
        Of the change.
    changes
        The changes, one an iteration.
    used
        How many of the last ones are by the present tangents.
    """

    tolerance: float
    changes: list[float] = field(default_factory=list)
    used: int = 0

    def add(self, change: float) -> None:
        """Take the change of one more iteration.

        Parameters
        ----------
        change
            The change.
        """
        self.changes.append(change)
        self.used += 1

    @property
    def moved(self) -> float:
        """By how much the motion has changed at most since it gave the present tangents."""
        return sum(self.changes[-self.used :])

    @property
    def ratio(self) -> float:
        """By how much each change is smaller than the one before, by the same tangents."""
        before, last = self.changes[-2:]
        # new tangents and a change c leave k c**2/2, and then the same tangents leave k c of each further change
        return (2 if self.used == 2 else 1) * last / before

    @property
    def ended(self) -> bool:
        """Whether the next change will be below the tolerance, as `settled` has it."""
        if self.used < 2:
            return settled(self.changes, self.tolerance)
        return self.changes[-1] * min(self.ratio, 1.0) <= NEWTON.reuse_tolerance * self.tolerance

    def reusable(self, flow: Flow) -> bool:
        """Whether the present tangents are worth being used again.

        Stability of many states needs the steps that are linear about the answer.

        Parameters
        ----------
        flow
            The steps with these tangents.
        """
        last = self.changes[-1]
        if self.used < 2:
            return last < (NEWTON.reuse_below if 2 * flow.size <= FEW_STATES else NEWTON.alike)
        foreseen = last * self.ratio ** (NEWTON.most_reuses + 1)
        return self.ratio < 1 and foreseen <= NEWTON.reuse_tolerance * self.tolerance


@dataclass(frozen=True)
class Beginning:
    """A motion from which Newton's method begins.

    Parameters
    ----------
    displacement, velocity
        q and q' at the points of a solver, ``(points, coordinates)``.
    tension
        Axial force of each element (N), ``(points, elements)``.
    tolerance
        Relative change of the displacement at which the method ends.
    """

    displacement: Array
    velocity: Array
    tension: Array
    tolerance: float = NEWTON.tolerance


def improved(equation: Equation, solve: Callable[[Matrices], Orbit], near: Beginning) -> Orbit:
    """Solve for the motion beside one that is known.

    Parameters
    ----------
    equation, solve
        As of `solve_nonlinear`.
    near
        The known motion.

    Raises
    ------
    SolverError
        When the method does not converge.
    """
    return _at_load(equation, solve, lambda tension: tension, 1.0, near, near.tension)[0]


def solve_nonlinear(
    equation: Equation,
    solve: Callable[[Matrices], Orbit],
    tension: Array,
    accept: Callable[[Matrices], None] | None = None,
    guess: Callable[[Array], Array] = lambda tension: tension,
) -> Orbit:
    """Solve for a motion; where Newton's method fails, the load is brought up little by little.

    Where that fails too, equilibria go on with the tensions of the strains, by small steps. Elements that are short for
    their thickness need them: forces across change their length as much as those along them, so that a held tension
    is a bad guess.

    Parameters
    ----------
    equation
        The equation of motion at the points.
    solve
        Gives the motion of a linear equation at these points.
    tension
        Rough axial force of each element under the whole load (N), ``(points, elements)``.
    accept
        Raises a `SolverError` where an answer with these tangents is none, such as an equilibrium that buckles.
    guess
        Improves the guess of a tension that is not yet right.

    Raises
    ------
    SolverError
        When the method does not converge, with the drive angle where it fails; `UnresolvedError` when a motion is
        sought, as shorter steps may have one.
    """
    orbit: Orbit | None = None
    done, rise, tried, held = 0.0, 1.0, 0, True
    while done < 1:
        tried += 1
        factor = min(done + rise, 1.0)
        try:
            begun = tension if done else factor * tension
            found, new_tension = _at_load(equation, solve, guess if held else None, factor, orbit, begun)
            if accept is not None:
                own = new_tension if held else None
                accept(equation.linearised(found.displacement, found.velocity, own, factor, found.acceleration))
            orbit, tension, done = found, new_tension, factor
        except (SolverError, FloatingPointError) as error:  # iterates that run away may overflow
            rise /= 2
            given_up = rise < NEWTON.smallest_rise or tried >= NEWTON.most_load_steps
            if given_up and held and accept is not None:
                held, rise, tried = False, NEWTON.rise_by_strains, 0
            elif given_up:
                if isinstance(error, SolverError):
                    error.found_up_to = done
                raise
    assert orbit is not None
    return orbit


def _at_load(
    equation: Equation,
    solve: Callable[[Matrices], Orbit],
    guess: Callable[[Array], Array] | None,
    factor: float,
    begun: Orbit | Beginning | None,
    tension: Array,
) -> tuple[Orbit, Array]:
    """Iterate at a share of the load until nothing changes; with tensions of the strains where nothing guesses them."""
    weight = _weights(equation)
    zero = np.zeros_like(equation.linear.load)
    old: tuple[Array, Array] = (zero, zero) if begun is None else (begun.displacement, begun.velocity)
    tolerance = begun.tolerance if isinstance(begun, Beginning) else NEWTON.tolerance
    second = begun.acceleration if isinstance(begun, Orbit) else None
    orbit: Orbit | None = None
    tangents: Matrices | None = None
    progress = _Progress(tolerance)
    changes = progress.changes
    while not progress.ended:
        if len(changes) == NEWTON.most_iterations or (len(changes) > 4 and changes[-1] > 2 * min(changes[:-1])):
            assert orbit is not None
            raise _failure(equation, orbit, factor, weight, len(changes))
        if orbit and orbit.flow and tangents and progress.reusable(orbit.flow):
            state = orbit.displacement, orbit.velocity, orbit.acceleration
            residual, tangents = equation.residual_near(tangents, state, tension, factor)
            orbit = orbit.changed(-residual)
        else:
            if guess is not None and (not changes or changes[-1] > NEWTON.far):
                tension = guess(tension)
            try:
                tangents = equation.linearised(*old, None if guess is None else tension, factor, second)
                orbit = solve(tangents)
            except np.linalg.LinAlgError as error:
                raise SolverError(
                    f"the tangent matrix is singular at {factor:.3g} of the load: lower the load, it is at a buckling "
                    "load"
                ) from error
            progress.used = 0
        new = (orbit.displacement, orbit.velocity)
        tension = equation.predicted_tension(tangents, *new)
        change, size = (float(np.linalg.norm(weight * part)) for part in (new[0] - old[0], new[0]))
        progress.add(change / max(size, TINY))
        logger.debug("Newton %d at %.3g of the load: relative change %.2e", len(changes), factor, changes[-1])
        old, second = new, orbit.acceleration
    assert orbit is not None
    return replace(orbit, linearised_here=progress.moved <= max(NEWTON.alike, math.sqrt(tolerance))), tension


def _weights(equation: Equation) -> Array:
    """Give factors that make roots of energies of the coordinates, ``(points, coordinates)``.

    They are by the stiffness of the links, where these resist: springs at joints may be far stiffer, and hide changes.
    """
    own, whole = (np.abs(part.diagonal) for part in (equation.links_stiffness, equation.linear.stiffness))
    of_links = whole[:, : own.shape[1]]  # a motor's twist comes after them
    return np.sqrt(np.hstack([np.where(own > 0, own, of_links), whole[:, own.shape[1] :]]))


def settled(changes: Sequence[float], tolerance: float = NEWTON.tolerance) -> bool:
    """Whether relative changes of the displacement, one an iteration, are at their end.

    That is where they have come down to rounding, or where the next one will be below the tolerance: each is a multiple
    of the square of the one before it, and the multiple is taken to be at least 1.

    Parameters
    ----------
    changes
        Changes relative to the displacement, the last one last.
    tolerance
        Of the change.
    """
    if not changes or changes[-1] <= tolerance:
        return bool(changes)
    if len(changes) == 1:
        return False
    before, last = changes[-2:]
    if last < NEWTON.rounding and last > before / 2:
        return True
    return last**2 * max(1.0, last / before**2) <= tolerance


def _failure(equation: Equation, orbit: Orbit, factor: float, weight: Array, iterations: int) -> SolverError:
    kind: type[SolverError] = SolverError
    left_over = equation.residual(orbit.displacement, orbit.velocity, orbit.acceleration)
    left_over -= (factor - 1) * equation.linear.load
    worst = int(np.linalg.norm(left_over / weight, axis=1).argmax())
    theta = np.degrees(equation.system.motion.theta[worst])
    bent = equation.system.bent_most(worst, orbit.displacement[worst, : equation.system.size])
    left = np.linalg.norm(left_over / weight) / np.linalg.norm(equation.linear.load / weight)
    remains = f"The relative residual is {left:.1e}, largest"
    if not np.isfinite(left):
        remains = "It grew beyond all numbers, first"
    if np.any(orbit.velocity):
        kind, sought = UnresolvedError, "motion"
        hint = "Give more damping, a lower speed or more sub_intervals, or method = 'transient'"
    else:
        sought = "equilibrium"
        hint = "Lower the load: an axis may turn by less than 90 degrees from its straight line"
    return kind(
        f"no {sought} found: Newton's method stopped after {iterations} "
        f"iterations at {factor:.3g} of the load. {remains} at drive angle "
        f"{theta:.6g} deg, where link {bent} bends most. {hint}"
    )
