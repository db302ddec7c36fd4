"""Motions with freedoms that repeat, of links that bend."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.mechanism import System
from fenics_mech.response.solution import FreeSolution
from fenics_mech.response.transient.course import FreeCourse
from fenics_mech.response.transient.free_motion import course_of, solution_from, start_of
from fenics_mech.response.transient.free_state import FreeState
from fenics_mech.response.transient.shooting import (
    ANGLE,
    ELASTIC,
    SHOOTING,
    STROKE,
    History,
    Lap,
    repeated_motion,
    sizes_of,
)
from fenics_mech.scene import Scene
from fenics_mech.scene.start_state import StartState

OTHER_TIMES = 0.131, 0.317, 0.573, 0.811  # of a period, at which the equation is compared
SAME = 1e-9  # of the accelerations, up to which they are the same at another time


@dataclass(frozen=True)
class BendingRunner:
    """Integrates the motion of links that bend.

    Parameters
    ----------
    state
        The equation.
    """

    state: FreeState

    @property
    def kinds(self) -> Index:
        """Kind of each coordinate, ``(coordinates,)``."""
        return np.append(np.full(self.state.size, ELASTIC), kinds_of(self.state.scene))

    def begin(self) -> StartState:
        """Give the state that the freedoms state, without vibration."""
        return start_of(self.state)

    def run(self, start: StartState, duration: float, samples: int) -> tuple[StartState, History]:
        """Let the motion go on from a state for so long (s); give its end, and what it was at equal steps of time.

        Parameters
        ----------
        start, duration, samples
            The state, the time (s), and the number of steps.
        """
        course = self._course(start, duration, samples, carries=False)
        return _last_of(course), (course.time, course.displacement, course.velocity)

    def lap(self, start: StartState, duration: float) -> Lap:
        """Give the motion from a state on, with all disturbances of it.

        Parameters
        ----------
        start, duration
            The state, and the time (s).
        """
        course = self._course(start, duration, SHOOTING.samples, carries=True)
        assert course.beside is not None
        sizes = sizes_of(course.displacement, course.velocity, self.kinds)
        seconds = course.acceleration[[0, -1]]
        return Lap(start, _last_of(course), seconds, sizes, course.beside.monodromy, course.touched)

    def depends_on_time(self, start: StartState) -> bool:
        """Whether the equation at a state is another one at other times.

        Parameters
        ----------
        start
            The state.
        """
        self.state.rewind(start)
        times = start.time + self.state.scene.period * np.append(0.0, OTHER_TIMES)
        states = (np.tile(part, (len(times), 1)) for part in (start.displacement, start.velocity))
        here, *others = self.state.accelerations(times, *states)
        return differs(here, np.array(others))

    def _course(self, start: StartState, duration: float, samples: int, *, carries: bool) -> FreeCourse:
        other = replace(self.state, scene=lasting(self.state.scene, duration, samples))
        return course_of(other, start, carries=carries)


def by_repeated_motion(scene: Scene, system: System) -> FreeSolution:
    """Find the motion of freedoms and links that repeats.

    Parameters
    ----------
    scene
        A scene with a freedom for all that can move.
    system
        Its mechanism at time 0.

    Raises
    ------
    SolverError
        When no motion beside that of the scene repeats, or it is not stable.
    """
    repeated = repeated_motion(scene, BendingRunner(FreeState(scene, system)))
    state = FreeState(repeated.scene, system)
    course = course_of(state, repeated.start)
    if scene.analysis.repeats == 1:
        course = replace(course, change=repeated.change)
    return replace(solution_from(state, repeated.start, course), repeated=repeated)


def kinds_of(scene: Scene) -> Index:
    """Give the kind of each freedom, ``(freedoms,)``.

    Parameters
    ----------
    scene
        The scene.
    """
    return np.array([ANGLE if scene.joints[name].kind == "revolute" else STROKE for name in scene.freedoms], dtype=int)


def lasting(scene: Scene, duration: float, samples: int) -> Scene:
    """Give the scene of a motion that goes on for so long, without what else is wanted to be known of it.

    Parameters
    ----------
    scene
        The scene.
    duration
        How long (s): of drives, whole cycles.
    samples
        Steps at whose ends the motion is given.
    """
    cycles = round(duration / scene.period) if scene.drives else 1
    changes: dict[str, Any] = {"cycles": cycles} if scene.drives else {"duration": duration}
    changes |= {"sub_intervals": max(4, samples // cycles), "lyapunov": False, "poincare": None}
    return scene.model_copy(update={"analysis": scene.analysis.model_copy(update=changes)})


def differs(here: Array, others: Array) -> bool:
    """Whether accelerations at other times are others.

    Parameters
    ----------
    here, others
        ``(coordinates,)`` and ``(times, coordinates)``.
    """
    return bool(np.abs(others - here).max() > SAME * max(float(np.abs(here).max()), float(np.abs(others).max())))


def _last_of(course: FreeCourse) -> StartState:
    return StartState(float(course.time[-1]), course.displacement[-1], course.velocity[-1], course.links[-1])
