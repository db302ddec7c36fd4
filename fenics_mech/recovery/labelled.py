"""What comes after a solution: its fields, their errors, and the result that holds both."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

import numpy as np

from fenics_mech._guard import ADVICE
from fenics_mech.accuracy.estimate import Errors, estimate
from fenics_mech.accuracy.validity import refuse_far
from fenics_mech.effects.effect import Choice
from fenics_mech.errors import SolverError
from fenics_mech.recovery.between_positions import with_missed_peaks
from fenics_mech.recovery.dataset import collect
from fenics_mech.recovery.fields import Fields, recover
from fenics_mech.recovery.result import Result
from fenics_mech.response.setup import CommonParts
from fenics_mech.response.solution import Solution


def recovered(
    solution: Solution,
    choices: Sequence[Choice],
    progress: Callable[[str], None],
    elsewhere: Errors | None = None,
    theory: bool = True,
) -> tuple[Fields, Errors | None]:
    """Recover the fields of a solution, and estimate their errors.

    Parameters
    ----------
    solution
        What a solver of `response` gave.
    choices
        What was decided about each effect.
    progress
        Called with the name of a step as it begins.
    elsewhere
        Errors of the same motion at other stations.
    theory
        Whether errors are told of what is left out of the equation, too.

    Returns
    -------
    tuple
        The fields, and their errors where the scene asks for them.

    Raises
    ------
    UnresolvedError
        When a numerical error is too large.
    """
    progress("recovery")
    fields = recover(solution)
    if not solution.scene.analysis.error_estimates:
        return fields, None
    progress("errors")
    if elsewhere is None:
        return fields, errors_of(solution, fields, choices, theory)
    errors = elsewhere.at_stations(fields.at_stations)
    errors.judge(solution.scene)
    return fields, _with_joints(errors, fields)


def errors_of(solution: Solution, fields: Fields, choices: Sequence[Choice], theory: bool = True) -> Errors:
    """Estimate the errors of what was recovered from a solution.

    Parameters
    ----------
    solution, choices, theory
        As of `recovered`.
    fields
        What was recovered.

    Raises
    ------
    UnresolvedError
        When a numerical error is too large.
    """
    found = with_missed_peaks(solution, fields)
    return _with_joints(estimate(solution, fields.system, found, choices, theory), fields)


def _with_joints(errors: Errors, fields: Fields) -> Errors:
    return errors if fields.joints is None else fields.joints.added_to(errors)


def labelled(
    solution: Solution,
    fields: Fields,
    errors: Errors | None,
    choices: Sequence[Choice],
    names: Collection[str] | None = None,
    common: CommonParts | None = None,
) -> Result:
    """Put what was recovered and its errors into a result.

    Parameters
    ----------
    solution, fields, errors
        A solution, and what `recovered` gives of it.
    choices
        What was decided about each effect.
    names
        Variables that the result is to hold, with those that come with them; None for all.
    common
        What it may have in common with other analyses of a study.

    Raises
    ------
    SolverError
        When deflections are beyond the theory, or something is not finite.
    """
    refuse_far(solution.scene, fields.system, fields.members)
    if fields.joints is not None:
        fields.joints.refuse(solution.scene)
    result = collect(solution, fields, errors, choices, names, common)
    _refuse_infinite(result)
    return result


def _refuse_infinite(result: Result) -> None:
    """Raise `SolverError` where a result holds what is no number."""
    for name in ("strain", "deflection", "joint_force", "input_torque"):
        if name in result.data and not np.isfinite(result.data.variables[name].to_numpy()).all():
            raise SolverError(f"the {name.replace('_', ' ')} is not finite: the equations have no answer. {ADVICE}")
