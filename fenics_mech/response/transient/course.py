"""What a motion in time starts from, how long it goes on, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_mech._arrays import Array


@dataclass(frozen=True)
class TransientLimits:
    """Limits of a motion in time and of its steps."""

    longest_step: float = 1 / 40  # of a cycle
    most_positions: int = 100_000  # at which a result is held
    stages: int = 5  # of a time step by collocation, at least: order 9, for steps that are few and long
    largest_tolerance: float = 0.02  # beyond it steps are as long as they may be
    rounding: float = 1e-12  # of a whole motion, by which the end of a step may be beside a position


TRANSIENT = TransientLimits()


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

    @property
    def touched(self) -> bool:
        """Whether contacts closed."""
        return self.laws is not None and self.laws.contacts.closed > 0

    @property
    def parted(self) -> bool:
        """Whether contacts opened."""
        return self.laws is not None and self.laws.contacts.opened > 0
