"""What a motion in time starts from, how long it goes on, and what came of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.response.periodic.tableau import Tableau


@dataclass(frozen=True)
class TransientLimits:
    """Limits of a motion in time and of its steps."""

    longest_step: float = 1 / 40  # of a cycle
    stages: int = 5  # of a time step by collocation, at least: order 9, for steps that are few and long
    interpolation: float = 1e-2  # of the tolerance of a step, to which matrices are interpolated
    longest_gap: float = 2.0  # between nodes of the interpolation, over the mean one, at most
    rounding: float = 1e-12  # of a whole motion, by which the end of a step may be beside a position


TRANSIENT = TransientLimits()


@dataclass(frozen=True)
class Schedule:
    """What is to be computed.

    Parameters
    ----------
    cycle
        Duration of a cycle of the drive at its speed (s).
    samples
        Equal parts of a cycle at whose ends the motion is given.
    cycles
        Cycles after the run-up, at most.
    settled
        Difference of two successive cycles, relative to the largest displacement, at which to stop; 0 never stops.
    steady_after
        Time from which the drive is at its speed (s): cycles are counted and compared from there on.
    tolerance
        Relative error of a time step.
    tableau, longest
        Collocation points of a time step, and its largest length as a share of a cycle.
    """

    cycle: float
    samples: int
    cycles: int
    settled: float
    steady_after: float
    tolerance: float
    tableau: Tableau
    longest: float = TRANSIENT.longest_step

    def lead(self, start: float) -> int:
        """Number of samples before cycles are counted, from a start.

        Parameters
        ----------
        start
            Time of the start (s).
        """
        return max(0, int(np.ceil((self.steady_after - start) / self.cycle * self.samples - 1e-6)))

    def count(self, start: float) -> int:
        """Number of times at which the motion is given, from a start.

        Parameters
        ----------
        start
            Time of the start (s).
        """
        return self.lead(start) + self.cycles * self.samples + 1

    def times(self, start: float) -> Array:
        """Times at which the motion is given (s), with the last of the last cycle.

        Parameters
        ----------
        start
            Time of the start (s).

        Returns
        -------
        numpy.ndarray
            ``(times,)``.
        """
        return start + self.cycle / self.samples * np.arange(self.count(start), dtype=float)


@dataclass(frozen=True)
class VelocityJumps:
    """Impulses as they strike.

    Parameters
    ----------
    time
        When (s), ascending.
    which
        Which jump, of each time.
    jump
        Changes of q', ``(impulses, coordinates)``.
    """

    time: Array
    which: Index
    jump: Array

    def at(self, time: float, rounding: float) -> Array:
        """Change of q' at a time, ``(coordinates,)``.

        Parameters
        ----------
        time
            Time (s).
        rounding
            By how much it may differ from that of an impulse (s).
        """
        now = self.which[np.searchsorted(self.time, time - rounding) : np.searchsorted(self.time, time + rounding)]
        return np.asarray(self.jump[now].sum(axis=0))


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
