"""What the solvers of the response give: a kind of `Solution` each. None of them estimates an error."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

from fenics_mech._arrays import Array
from fenics_mech.eigenmodes import Modes
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.impulse_work import AtImpulses
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.periodic.cycle import Cycle
from fenics_mech.response.periodic.harmonic_balance import Series
from fenics_mech.response.periodic.newton import Orbit
from fenics_mech.response.stability.floquet import Stability
from fenics_mech.response.transient.course import Course, FreeCourse
from fenics_mech.response.transient.free_state import FreeState
from fenics_mech.scene import Scene
from fenics_mech.scene.start_state import StartState


@dataclass(frozen=True)
class AtPoints:
    """A motion at points inside all its steps.

    Parameters
    ----------
    system, response
        The mechanism and its response there.
    weights
        Weights of the points in a mean over the cycle, or over a motion in time, ``(points,)``.
    impulses
        The state at the impulses of the cycle, where there are some.
    """

    system: System
    response: ElasticResponse
    weights: Array
    impulses: AtImpulses | None = None


@dataclass(frozen=True, kw_only=True)
class Solution:
    """The response of a scene at its positions.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the positions, with the axial forces of the response where they settle.
    response
        The elastic response there.
    """

    scene: Scene
    system: System
    response: ElasticResponse

    @property
    def on_few_nodes(self) -> Solution:
        """The same response with few nodes, where its mesh is far finer than estimates need; else itself."""
        return self


@dataclass(frozen=True, kw_only=True)
class StaticSolution(Solution):
    """A static or quasi-static response."""


@dataclass(frozen=True, kw_only=True)
class InTime(Solution):
    """A response in time.

    Parameters
    ----------
    course
        The motion in time, and how it came about.
    start
        The state from which it started.
    """

    course: Course
    start: StartState


@dataclass(frozen=True, kw_only=True)
class FreeSolution(InTime):
    """A motion in time of a linkage with freedoms: the course and the start hold theirs after the links' coordinates.

    Parameters
    ----------
    state
        The equation of the motion.
    """

    course: FreeCourse
    state: FreeState

    @property
    def points(self) -> AtPoints | None:
        """The motion at the points over which powers are integrated."""
        if (inside := self.course.inside) is None:
            return None
        course = inside.course
        states = course.displacement, course.velocity, course.acceleration
        return AtPoints(*self.state.along(states, course), inside.weights)


@dataclass(frozen=True, kw_only=True)
class PeriodicSolution(Solution):
    """A periodic response.

    Parameters
    ----------
    modes
        Modes at the positions.
    condition
        How many times a relative error of the cycle's equations comes out in the motion; None where it is not known.
    stability
        Whether small disturbances decay; None where that was not examined.
    """

    modes: Modes
    condition: float | None = None
    stability: Stability | None = None


@dataclass(frozen=True, kw_only=True)
class CollocationSolution(PeriodicSolution):
    """A periodic response by collocation.

    Parameters
    ----------
    cycle
        The equation of motion over the cycle.
    equation
        That equation at the positions, with the axial forces of the response where they settle.
    orbit
        The motion at the collocation points and at the starts of all steps.
    inside
        Gives the motion at the collocation points as forces see it, where energy is balanced over them.
    thinned
        The same motion with few nodes, where its mesh is far finer than that of others; see `few_nodes`.
    """

    cycle: Cycle
    equation: Equation
    orbit: Orbit
    inside: Callable[[], AtPoints] | None = None
    thinned: CollocationSolution | None = None

    @cached_property
    def points(self) -> AtPoints | None:
        """The motion at the collocation points."""
        return None if self.inside is None else self.inside()

    @property
    def on_few_nodes(self) -> CollocationSolution:
        """The same motion with few nodes, where its mesh is far finer than estimates need; else itself."""
        return self.thinned or self


@dataclass(frozen=True, kw_only=True)
class MotorSolution(CollocationSolution):
    """A periodic response of a mechanism on the shaft of a motor: all of it belongs to the crank's own motion.

    Parameters
    ----------
    twist
        Angle of the crank ahead of its drive (rad) and two time derivatives, ``(3, angles)``.
    """

    twist: Array


@dataclass(frozen=True, kw_only=True)
class HarmonicSolution(PeriodicSolution):
    """A periodic response as a Fourier series.

    Parameters
    ----------
    cycle
        The equation of motion over the cycle.
    series
        The coordinates as a Fourier series.
    """

    cycle: Cycle
    series: Series
