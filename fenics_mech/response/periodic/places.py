"""A mechanism at the same places of all steps of a cycle."""

from __future__ import annotations

from fenics_mech._arrays import Array
from fenics_mech.errors import UnresolvedError
from fenics_mech.kinematics import solve_motion
from fenics_mech.mechanism import System
from fenics_mech.mechanism.turning_sliders import PointsInSteps, in_steps, turning_sliders
from fenics_mech.response.periodic.steps import Steps
from fenics_mech.response.periodic.tableau import Tableau
from fenics_mech.response.setup import system_at
from fenics_mech.scene import Scene


def system_at_places(scene: Scene, system: System, steps: Steps, places: Array) -> System:
    """Give a mechanism at the same places of all steps.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at the starts of the sub-intervals.
    steps
        The steps.
    places
        Where in each step, 0..1.

    Raises
    ------
    UnresolvedError
        When the points call for other independent coordinates than the starts.
    """
    theta = steps.angles(places)
    there = system_at(scene, system.beams, solve_motion(scene, theta, near=system.motion))
    if there.transformation.names != system.transformation.names:  # both choose their coordinates by their angles
        raise UnresolvedError(
            "no independent coordinates are well conditioned over the whole cycle. Take other sub_intervals"
        )
    return there


def system_at_points(scene: Scene, system: System, steps: Steps, tableau: Tableau) -> System:
    """Give a mechanism at the collocation points of all steps, as `system_at_places`.

    Parameters
    ----------
    scene, system, steps
        As of `system_at_places`.
    tableau
        The points in each step.
    """
    there = system_at_places(scene, system, steps, tableau.points)
    if not (there.terms.coupled and turning_sliders(there)):
        return there
    starts = solve_motion(scene, steps.start, near=system.motion)
    return in_steps(there, PointsInSteps(starts, steps.duration, tableau.points, tableau.inner, tableau.weights))
