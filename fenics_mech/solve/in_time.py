"""Motion in time by Radau IIA, with steps that an error bound chooses."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SolverError
from fenics_mech.geometry import PoseMotion
from fenics_mech.machine import Machine
from fenics_mech.solve.blows import with_rows
from fenics_mech.solve.contacts import Contacts
from fenics_mech.solve.stages import radau
from fenics_mech.solve.step import SHORT, Step, now

SAFETY, LEAST, MOST = 0.9, 0.2, 4.0  # of a step's change: Hairer and Wanner, Solving ODE II, chapter IV.8
TOO_LONG = 50.0  # error of a step in which something grows: the next one is half as long
FIXED = 1e-9  # tolerance of steps of a stated length (m, rad), which only Newton's method has
ROUNDING = 1e-9  # of a step, by which the last of even ones may be too short


@dataclass
class Course:
    """A motion in time at the ends of its steps.

    Parameters
    ----------
    t
        Instants (s).
    motion
        Places, rotations, velocities and spins of all poses at these instants.
    multipliers
        ``(instants, rows)``.
    """

    t: Array
    motion: list[PoseMotion]
    multipliers: Array


def steps_in_time(
    machine: Machine,
    v: Array,
    times: Array,
    *,
    h: float | None = None,
    tolerance: Array | float = 1e-6,
    share: float = 1e-4,
    stages: int = 3,
    longest: float = np.inf,
    struck: Callable[[float, Array], Array] | None = None,
    shapes: Callable[[], Array] | None = None,
    angles: Sequence[Array] | None = None,
) -> Iterator[Step]:
    """Follow a motion from the poses of the machine's chart, which moves along when the next step is asked for.

    A step ends at each of the stated instants, and where a contact closes or opens. There the equation is fulfilled,
    and between the stages it is not.

    Parameters
    ----------
    machine
        The machine; its chart rests.
    v
        Rates at the start ``(size,)``.
    times
        The start, and instants at which a step ends, ascending (s).
    h
        Longest step (s), where steps are not chosen; None to choose them.
    tolerance
        Largest error of a coordinate in a step (m, rad), of all or of each ``(coordinates,)``, where steps are chosen.
    share
        Largest error of a rate of indentation in a step, of that at which the contact began.
    stages
        Stages of a step.
    longest
        Longest step where steps are chosen (s).
    struck
        Gives the rates after impulses at the stated instants, all but the last, by their instant (s) and the rates
        before, which it gives back where none strike; None where there are none.
    shapes
        Gives those of a step where the chart is; None where no other tolerance holds for changes of shape.
    angles
        Measures of every term at the start, by which whole turns count; None where the terms know.

    Raises
    ------
    SolverError
        When a step has no solution.
    """
    tableau, fixed, duration, exponent = radau(stages), h is not None, times[-1] - times[0], 1 / (stages + 2)
    t, step = float(times[0]), h or min(1e-3 * duration, longest)
    allowed = np.broadcast_to(FIXED if fixed else np.asarray(tolerance, dtype=float), machine.n)
    a, contacts = np.zeros((stages, machine.size)), Contacts(machine, share)
    contacts.begin(t, v, angles)
    known = None if shapes is None else shapes()

    def begun() -> Step:
        return Step(machine, tableau, t, step, v, allowed, angles, a, shapes=known)

    for stop in times[1:]:
        before, v = v, v if struck is None else struck(t, v)
        if not fixed and (t == times[0] or v is not before):
            short = replace(begun(), h=SHORT * step).solved()
            a = np.tile(tableau.back @ short.a, (stages, 1))
        while t < stop:
            parts = math.ceil((stop - t) / min(step, longest) - ROUNDING)
            step = (stop - t) / parts
            try:
                made = begun().solved()
                error = 0.0 if fixed else max(made.error(a[0]), contacts.error(made, a[0]))
                if not fixed and error <= 1 and made.grows:
                    error = TOO_LONG
                made, event = contacts.up_to_event(made) if error <= 1 else (made, None)
            except SolverError:
                if fixed or step < 1e-9 * duration:
                    raise
                error = np.inf
            if error > 1:
                step *= max(LEAST, SAFETY * error**-exponent)
                continue
            yield made
            if event is not None:
                contacts.pass_event(made, event)
            t = float(stop) if parts == 1 and made.h == step else t + made.h
            angles = [x[-1:] for x in made.measures]
            v, last = machine.rebase(*(x[-1] for x in made.at(np.ones(1))))
            known = None if shapes is None else shapes()
            v = with_rows(machine, t, v) if contacts.terms and machine.rows else v
            a = np.tile(last, (stages, 1))
            step = h or step * min(MOST, SAFETY * max(error, 1e-300) ** -exponent)


def march(
    machine: Machine,
    v: Array,
    duration: float,
    *,
    h: float | None = None,
    tolerance: float = 1e-6,
    stages: int = 3,
    start: float = 0.0,
) -> Course:
    """Follow a motion from the poses of the machine's chart, which moves along.

    Parameters
    ----------
    machine
        The machine; its chart is at rest.
    v
        Rates at the start ``(size,)``.
    duration
        s.
    h
        Length of all steps (s); None to choose them.
    tolerance
        Largest error of a coordinate in a step (m, rad), where steps are chosen.
    stages
        Stages of a step.
    start
        First instant (s).

    Raises
    ------
    SolverError
        When a step has no solution.
    """
    rows = len(machine.rows)
    times, motions, multipliers = [start], [now(machine, start, v, np.zeros_like(v)).part(0)], [np.zeros(rows)]
    for step in steps_in_time(machine, v, np.array([start, start + duration]), h=h, tolerance=tolerance, stages=stages):
        state = step.at_end()
        times.append(float(state.t[0]))
        motions.append(state.motion.part(0))
        multipliers.append(state.others[0, :rows])
    return Course(np.array(times), motions, np.array(multipliers))
