"""Meeting a tolerance: mesh, modes of the members and steps in time, chosen by the errors that results estimate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_mech.building import links
from fenics_mech.choice import choose
from fenics_mech.effects.effect import Choice
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import with_elements

MOST_ROUNDS = 12
SHARE = 0.2  # of the tolerance that each source is sent below, once it is above
ENOUGH = 0.7  # of the tolerance: estimates are 0.7 to 2 of the true error
LARGEST_STEP, MARGIN = 4.0, 1.05  # by which a number grows in a round, and by how much more than it should
MOST_WITHOUT_ANSWER = 1000  # sub-intervals, after which no answer is an answer
FEWEST_STEPS, FEWEST_STATIONS = 24, 11
REDUCED_ELEMENTS, FEWEST_ELEMENTS = 16, 2
NONLINEAR = ("moderate-rotations", "geometric-stiffness")
Analyse = Callable[[Scene, tuple[Choice, ...]], Result]


@dataclass(frozen=True)
class Knobs:
    """What is chosen.

    Parameters
    ----------
    elements
        Per member.
    sub_intervals, stations
        Of the analysis.
    cutoff
        Of the reduction (Hz); None where all nodes are kept.
    """

    elements: float
    sub_intervals: float
    stations: float
    cutoff: float | None

    def of(self, scene: Scene) -> Scene:
        """Give the scene with these choices."""
        values: dict[str, Any] = {"reduction": "none", "stations": math.ceil(self.stations), "allow_coarse": True}
        if self.cutoff is not None:
            values |= {"reduction": "craig-bampton", "cutoff": self.cutoff}
        if scene.analysis.method == "periodic":
            values |= {"solver": "collocation", "stages": 3, "scheme": "radau"}
            values["sub_intervals"] = 2 * math.ceil(self.sub_intervals / 2)
        changes = {f"analysis__{name}": value for name, value in values.items()}
        return with_elements(scene, math.ceil(self.elements)).changed(**changes)

    def finer(self, source: str, by: float) -> Knobs:
        """Give the choices with more of what makes an error smaller, so many times."""
        if source == "stations":
            return replace(self, stations=by * (self.stations - 1) + 1)
        if source == "time":
            return replace(self, sub_intervals=by * self.sub_intervals)
        if self.cutoff is not None:
            return replace(self, cutoff=by**2 * self.cutoff, elements=by * self.elements)
        return replace(self, elements=by * self.elements)


def within(scene: Scene, analyse: Analyse) -> Result:
    """Analyse a scene so that its strains are within its tolerance of the converged ones.

    Parameters
    ----------
    scene
        A scene with a tolerance. Effects that are its own to choose are chosen first; what is left out is not counted.
    analyse
        Analyses a scene as it states.

    Raises
    ------
    SolverError
        When the tolerance is not met, with the source of the largest error.
    SceneError
        When the motion is one in time, impulses strike, or nothing damps: their errors are not all estimated.
    """
    assert scene.tolerance is not None
    chosen, choices = choose(scene)
    _refuse_unknown(chosen)
    knobs, errors = _start(chosen), {"mesh": math.inf}
    for done in range(1, MOST_ROUNDS + 1):
        trial = knobs.of(chosen)
        try:
            result = analyse(trial, choices)
        except SolverError:  # steps or elements that are far too coarse may have no answer at all
            if knobs.sub_intervals > MOST_WITHOUT_ANSWER:
                raise
            knobs = knobs.finer("time", 2.0).finer("mesh", 1.5)
            continue
        found = result.data[["relative_error", "error_order"]].to_dataframe().drop("effects", errors="ignore")
        errors = {str(source): float(error) for source, error in found["relative_error"].items()}
        if sum(errors.values()) <= ENOUGH * scene.tolerance:
            result.data.attrs["chosen"] = _account(trial, result.data.attrs["elements"], errors, done)
            return result
        for source, error in errors.items():
            if error > SHARE * scene.tolerance:
                order = max(float(found["error_order"][source]), 1.0)
                by = (error / (SHARE * scene.tolerance)) ** (1 / order)
                knobs = knobs.finer(source, min(MARGIN * by, LARGEST_STEP))
    worst = max(errors, key=errors.__getitem__)
    raise SolverError(
        f"the tolerance of {scene.tolerance:g} is not met in {MOST_ROUNDS} rounds: the largest error left is "
        f"{errors[worst]:.2g}, by the {worst}, with {trial.analysis.sub_intervals} sub_intervals and "
        f"{trial.mesh.elements} elements a member. Give a larger tolerance"
    )


def _refuse_unknown(scene: Scene) -> None:
    """Raise `SceneError` where an error is not estimated, so that no tolerance can be promised."""
    damping = scene.damping
    damped = np.any(damping.ratio) or damping.material or damping.external or scene.dampers
    if scene.analysis.method == "transient":
        what, hint = (
            "a motion in time, whose steps it does not choose",
            "analysis.time_tolerance and elements",
        )
    elif scene.impulses:
        what, hint = "impulses, as they move modes beyond any mesh", "elements and sub_intervals"
    elif scene.analysis.method == "periodic" and not damped:
        what, hint = "vibration that nothing damps: errors add up beyond their estimates", "damping"
    else:
        return
    raise SceneError(
        f"a tolerance cannot be promised of {what}", place="tolerance", hint=f"Leave it out, and give {hint}"
    )


def _start(scene: Scene) -> Knobs:
    """Give the choices to begin with: coarse ones, from which the errors are told.

    Loads that change may do so between few positions: there the scene's own are the fewest.
    """
    analysis = scene.analysis
    sudden = bool(scene.impulses) or any(getattr(load, "factor", None) is not None for load in scene.loads.values())
    steps = FEWEST_STEPS if analysis.method == "periodic" and not sudden else analysis.sub_intervals
    nonlinear = any(name in scene.named_effects for name in NONLINEAR)
    if "coupling" not in scene.named_effects or nonlinear or analysis.method != "periodic":
        return Knobs(FEWEST_ELEMENTS, steps, FEWEST_STATIONS, None)
    reduced = scene.changed(analysis__reduction="craig-bampton", analysis__cutoff="auto")
    reduction = links(with_elements(reduced, REDUCED_ELEMENTS)).reduction
    assert reduction is not None
    if not reduction.spans:
        return Knobs(FEWEST_ELEMENTS, steps, FEWEST_STATIONS, None)
    return Knobs(REDUCED_ELEMENTS, steps, FEWEST_STATIONS, reduction.cutoff / (2 * math.pi))


def _account(scene: Scene, elements: int, errors: dict[str, float], rounds: int) -> str:
    """Say what was chosen, and why: the mesh has so many elements in all."""
    analysis = scene.analysis
    parts = [f"{elements} elements"]
    if analysis.method == "periodic":
        parts.insert(0, f"collocation in {analysis.sub_intervals} sub_intervals")
    if analysis.reduction != "none":
        parts.append(f"reduced to modes up to {analysis.cutoff:.4g} Hz")
    parts.append(f"{analysis.stations} stations")
    least = ", ".join(f"{source} {error:.1g}" for source, error in errors.items())
    trials = "first trial" if rounds == 1 else f"{rounds} trials"
    return f"strains to {scene.tolerance:g}, met by {', '.join(parts)} (errors: {least}; {trials})"
