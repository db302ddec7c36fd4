"""Time steps of a motion with freedoms, from impulse to impulse, by PETSc's TS."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from fenics_mech._arrays import Array
from fenics_mech._petsc import PETSc, configured, name_of
from fenics_mech.errors import SolverError
from fenics_mech.response.transient.stepping import Collocation
from fenics_mech.response.transient.strikes import Strikes

MOST_STEPS = 1_000_000  # of a motion: an hour or so


def stepped(
    context: Collocation,
    start: tuple[Array, Array],
    times: Array,
    petsc: Mapping[str, Any],
    strikes: tuple[Strikes | None, Callable[[float], None]],
) -> int:
    """Integrate a free motion from the first of some times on; give the number of time steps.

    Parameters
    ----------
    context
        The steps, which keep the motion.
    start
        Unknowns and their rates there, ``(unknowns,)`` each.
    times
        Times at which the motion is wanted (s), ``(times,)``: the first step is no longer than between two of them.
    petsc
        Options of PETSc from the scene.
    strikes
        Impulses between the first and the last time, and what forgets a sample at the time of one.

    Raises
    ------
    SolverError
        When the time steps fail.
    """
    first, last, count = float(times[0]), float(times[-1]), 0
    longest = min(float(times[1] - times[0]), context.longest)
    impulses, forget = strikes
    for strike in impulses.due if impulses is not None else ():
        if strike.time > first:
            (place, rate), steps = _stepped_to(context, start, (first, strike.time), longest, petsc)
            assert impulses is not None
            forget(strike.time)
            start, first, count = (place, impulses.struck(strike, place, rate)), strike.time, count + steps
    return count + _stepped_to(context, start, (first, last), longest, petsc)[1]


def _stepped_to(
    context: Collocation,
    start: tuple[Array, Array],
    ends: tuple[float, float],
    longest: float,
    petsc: Mapping[str, Any],
) -> tuple[tuple[Array, Array], int]:
    """Integrate between two times (s); give the unknowns and rates at the end, and the number of time steps."""
    ts = PETSc.TS().create(comm=PETSc.COMM_SELF)
    context.begin(ts, *start, longest)
    ts.setTime(ends[0])
    ts.setMaxTime(ends[1])
    defaults = {"ts_exact_final_time": "matchstep", "ts_max_steps": MOST_STEPS}
    with configured(ts, "transient_", defaults, petsc):
        ts.solve(ts.getSolution())
        reason, steps = ts.getConvergedReason(), ts.getStepNumber()
        place, rate = ts.getSolution().array_r.copy().reshape(2, -1)
    reasons = PETSc.TS.ConvergedReason
    if reason not in (reasons.CONVERGED_TIME, reasons.CONVERGED_USER):
        raise SolverError(f"the time steps of the free motion failed ({name_of(reasons, reason)})")
    return (place, rate), steps
