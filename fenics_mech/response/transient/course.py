"""What a motion in time starts from, how long it goes on, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.response.transient.beside import Beside
from fenics_mech.scene import Analysis, Scene


@dataclass(frozen=True)
class TransientLimits:
    """Limits of a motion in time and of its steps."""

    longest_step: float = 1 / 40  # of a cycle
    most_positions: int = 100_000  # at which a result is held
    stages: int = 5  # of a time step by collocation, at least: order 9, for steps that are few and long
    largest_tolerance: float = 0.02  # beyond it steps are as long as they may be
    rounding: float = 1e-12  # of a whole motion, by which the end of a step may be beside a position


TRANSIENT = TransientLimits()


def refuse_rough(analysis: Analysis) -> None:
    """Raise `SceneError` where a tolerance does not govern the steps in time.

    Parameters
    ----------
    analysis
        What the scene asks for.
    """
    if analysis.time_tolerance > TRANSIENT.largest_tolerance:
        raise SceneError(
            f"{analysis.time_tolerance:g} is more than {TRANSIENT.largest_tolerance:g}, up to which it governs the "
            "steps in time",
            place="analysis.time_tolerance",
            hint="Take a smaller one: the error of the steps is not known with this one",
        )


@dataclass(frozen=True)
class StartState:
    """State from which a motion in time starts.

    Parameters
    ----------
    time
        Time (s).
    displacement, velocity
        q (m, rad) and q' (m/s, rad/s) there, ``(coordinates,)`` each.
    links
        Coordinates of the links there (m, m, rad), ``(3 links,)``; None at time 0, where the scene states them.
    """

    time: float
    displacement: Array
    velocity: Array
    links: Array | None = None

    @classmethod
    def stated(cls, scene: Scene) -> StartState:
        """Give the state at time 0: angles, strokes and rates that the freedoms of a scene state.

        Parameters
        ----------
        scene
            The scene, with a freedom for all that can move.
        """
        names, freedoms = ("start", "rate_at_start"), scene.freedoms.values()
        place, rate = (np.array([getattr(part, name) or 0.0 for part in freedoms]) for name in names)
        return cls(0.0, place, rate)


@dataclass(frozen=True)
class Course:
    """A motion in time: q and q' ``(times, coordinates)``, and how it came about.

    Parameters
    ----------
    time, displacement, velocity
        Times (s) and the motion there, after any impulse.
    change
        Difference of the last two cycles, relative; infinite where there is only one.
    steps
        Time steps that were made.
    interpolation
        Largest relative error of the interpolated matrices and load.
    """

    time: Array
    displacement: Array
    velocity: Array
    change: float
    steps: int
    interpolation: float


@dataclass(frozen=True)
class ContactCount:
    """How often contacts of a motion closed and opened.

    Parameters
    ----------
    closed, opened
        The numbers. Where none opened, the motion depends on its steps as one without contacts does.
    """

    closed: int = 0
    opened: int = 0


@dataclass(frozen=True)
class LawCourse:
    """What joint laws exert in a motion.

    Parameters
    ----------
    forces
        Forces and moments on the frames of the joints, by law; see `LawForces`.
    efforts
        What each law exerts (N or N m), ``(times,)`` each: along the guide or about the pin. The size of its force
        where it takes the place of a pin.
    depths
        Indentation at the contacts of each law that has some (m or rad), ``(times,)`` each: the largest of its
        contacts, negative where none touches.
    largest
        Largest effort of each law, between the times too.
    contacts
        How often contacts closed and opened.
    """

    forces: dict[str, Array]
    efforts: dict[str, Array]
    depths: dict[str, Array]
    largest: dict[str, float]
    contacts: ContactCount


@dataclass(frozen=True)
class PointsInside:
    """A motion at the points of a quadrature of its time steps.

    Parameters
    ----------
    course
        The motion there.
    weights
        Weights of the points in a mean over the motion, ``(points,)``.
    """

    course: FreeCourse
    weights: Array


@dataclass(frozen=True)
class FreeCourse(Course):
    """A motion in time with freedoms, whose angles and strokes come after the coordinates q.

    Parameters
    ----------
    acceleration
        Second time derivatives of the coordinates, ``(times, coordinates)``.
    links
        Coordinates of the links (m, m, rad), ``(times, 3 links)``.
    laws
        What joint laws exert; None where there are none.
    inside
        The same motion at the points of a quadrature of its time steps; None of such points themselves.
    beside
        What was followed beside the motion; None of such points.
    """

    acceleration: Array
    links: Array
    laws: LawCourse | None = None
    inside: PointsInside | None = None
    beside: Beside | None = None

    @property
    def touched(self) -> bool:
        """Whether contacts closed."""
        return self.laws is not None and self.laws.contacts.closed > 0

    @property
    def parted(self) -> bool:
        """Whether contacts opened."""
        return self.laws is not None and self.laws.contacts.opened > 0
