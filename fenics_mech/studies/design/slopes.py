"""Derivatives of the numbers of an answer by the variables of a study, without another search for an answer.

Beside a machine are two whose variable is a little more and a little less. Their answers are that of the machine with
what changes in it to first order; see `solve/derivatives.py`. The numbers are read off both, as off any answer. So the
derivative of a largest value is that at the peak, and no formula is written twice.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.answers.by_poses import collected, planned, stability_of
from fenics_mech.answers.solved_by_poses import AtRest, Solved
from fenics_mech.errors import DerivativeError
from fenics_mech.recovery.of_linear import OfLinear
from fenics_mech.scene import Scene
from fenics_mech.studies.design.trial import Trials, read_numbers

STEP = 6e-5  # of differences, as a share of a variable: of less rounding shows, of more its third power
OF_LINEAR = 1e-3  # the same where what is read off is linear, by differences of its own that are rounded to 1e-8
SMALL = 1e-2  # share of a variable's range, below which its own size is no measure of a step


def slopes(trials: Trials, values: Sequence[float]) -> dict[str, Array]:
    """Give the derivatives of all numbers of a trial by the variables."""
    known, here = trials.solution(values), np.array(values, dtype=float)
    if not isinstance(known, Solved | AtRest):
        raise DerivativeError("the answer is not found by the equation of poses")
    columns = []
    for k, variable in enumerate(trials.design.variables):
        span = variable.upper - variable.lower
        share = OF_LINEAR if isinstance(known.positions, OfLinear) else STEP
        step = share * min(span, max(abs(here[k]), SMALL * span))
        beside = (here + sign * step * np.eye(len(here))[k] for sign in (1.0, -1.0))
        scenes = [planned(Scene.read(trials.data_at(one.tolist()))) for one in beside]
        answers = known.beside(*scenes)
        results = [collected(one, None, stability_of(one), trials.variables) for one in answers]
        more, less = (read_numbers(trials.quantities, result, trials.design.study.targets) for result in results)
        columns.append({name: (more[name] - less[name]) / (2 * step) for name in more})
    return {name: np.array([column[name] for column in columns]) for name in columns[0]}
