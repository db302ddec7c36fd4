"""The discretisation that meets a tolerance: elements, modes of the members, steps in time and stations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fenics_mech._guard import memory
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.base import SCENE
from fenics_mech.scene.bodies import MESH
from fenics_mech.scene.meshing import with_elements


@dataclass(frozen=True)
class DiscretisationLimits:
    """Limits of the meshes, steps and stations that a tolerance may take."""

    stages: int = 4  # 1e-4 takes 0.7 of the time that it takes with 3; 5 leave too few positions to see
    most_sparse: float = 5e6  # steps times the coordinates: 30 microseconds each, as a rough measure
    coordinate: int = 300  # numbers of a coordinate at a position, with its factors: rough
    damped: int = 1000  # the same with damping of modes
    beside_pin: int = 8  # of a coordinate for each other one, where pins travel, which pass all elements
    most_damped: float = 4e5  # the same with damping of modes: 350 microseconds each
    grew: float = 1.2  # ratio of two numbers, below which their errors show no convergence order
    least_order: float = 0.25  # measured, below which an observed order is none
    fewest_steps: int = 48  # of a cycle, to start with
    fewest_stations: int = 11  # of a member, to start with
    fewest_elements: int = 2  # in a member, to start with
    from_fewest: float = 1e-3  # tolerance, below which it starts with more elements, and a second trial is the last
    order_of_steps: int = 4  # that of stages, with which errors by vibration fall that is fast for the steps


REFINE = DiscretisationLimits()

# what a scene may state beside a tolerance: what it takes, or the default
TAKEN = {
    "solver": ("auto", "collocation", "poses"),
    "stages": (3, REFINE.stages),
}  # or the default
NUMBERS = {
    "time": "sub_intervals",
    "positions": "sub_intervals",
    "mesh": "elements",
    "stations": "stations",
}  # by the errors that they lessen


@dataclass(frozen=True)
class Discretisation:
    """Numbers that decide on the numerical errors."""

    elements: float  # per member
    sub_intervals: float  # sub_intervals, stations: of the analysis
    stations: float

    @property
    def steps(self) -> int:
        """Sub-intervals: an even number."""
        return 2 * math.ceil(self.sub_intervals / 2)

    def of(self, scene: Scene) -> Scene:
        """Give the scene with this discretisation; how coarse or unstable a motion is stays to be judged."""
        values: dict[str, Any] = {"stations": math.ceil(self.stations), "allow_coarse": True}
        if scene.analysis.method == "periodic":
            solver = "poses" if scene.analysis.solver == "poses" else "collocation"
            values |= {"solver": solver, "stages": REFINE.stages, "sub_intervals": self.steps}
        changes = {f"analysis__{name}": value for name, value in values.items()}
        return with_elements(scene, math.ceil(self.elements)).changed(**changes)

    def number(self, source: str) -> int:
        """Give the number that makes the error of a source smaller."""
        if source == "stations":
            return math.ceil(self.stations) - 1
        return self.steps if source in ("time", "positions") else math.ceil(self.elements)

    def finer(self, source: str, by: float) -> Discretisation:
        """Refine what makes an error smaller, so many times."""
        if source == "stations":
            return replace(self, stations=by * (self.stations - 1) + 1)
        if source == "time":
            return replace(self, sub_intervals=by * self.sub_intervals)
        return replace(self, elements=by * self.elements)


@dataclass(frozen=True)
class Trial:
    """A run with a discretisation."""

    discretisation: Discretisation  # what it was run with
    errors: Mapping[str, Mapping[str, float]]  # estimated relative errors, by quantity and then by source
    orders: Mapping[str, float]  # expected convergence order of each source
    dofs: int  # its degrees of freedom

    def too_large(self, discretisation: Discretisation, scene: Scene) -> str:
        """Say which number of a discretisation of a scene exceeds memory or time; empty if none."""
        # Where the response is not periodic, the steps are not limited.
        if discretisation.stations > SCENE.most_stations:
            return "stations"
        if discretisation.elements > MESH.most_unreduced:
            return "elements"
        dofs = self.dofs * discretisation.number("mesh") / self.discretisation.number("mesh")
        damped = bool(np.any(scene.damping.ratio))
        most = REFINE.most_damped if damped else REFINE.most_sparse
        numbers: float = REFINE.damped if damped else REFINE.coordinate
        if any(joint.member for joint in scene.joints.values()):
            numbers = max(numbers, REFINE.beside_pin * dofs)
        if scene.analysis.method == "periodic" and discretisation.sub_intervals * dofs > min(
            most, memory() / (8 * numbers * REFINE.stages)
        ):
            return "sub_intervals and elements"
        return ""


def slow_order(trials: Sequence[Trial], what: str, source: str) -> float | None:
    """Observed convergence order over the last two trials, where it is below half of the expected one."""
    # It is that of the error of a quantity by a source. None where the error falls as expected, or where the error or
    # its number hardly changed.
    if len(trials) < 2 or source not in trials[-2].errors[what]:
        return None
    before, last = trials[-2:]
    grew = last.discretisation.number(source) / before.discretisation.number(source)
    fell = before.errors[what][source] / max(last.errors[what][source], 1e-300)
    if grew < REFINE.grew or fell <= 1:
        return None
    order = math.log(fell) / math.log(grew)
    return order if REFINE.least_order < order < last.orders[source] / 2 else None


def refuse_stated(scene: Scene) -> None:
    """Raise `SceneError` where a scene asks for another method than its tolerance takes."""
    for name, values in (TAKEN if scene.analysis.method == "periodic" else {}).items():
        if (stated := getattr(scene.analysis, name)) not in values:
            raise SceneError(
                f"{stated!r} is stated beside a tolerance, which takes collocation with {REFINE.stages} Radau points",
                place=f"analysis.{name}",
                hint=f"Leave {name} or the tolerance out",
            )


def refuse_unknown(scene: Scene) -> None:
    """Raise `SceneError` where an error is not estimated, so that no tolerance can be promised."""
    damping = scene.damping
    damped = np.any(damping.ratio) or damping.material or damping.external or damping.relative or scene.dampers
    if damping.air is not None:
        what, hint = "the drag of the air, which is linearised about the rigid motion", "elements and sub_intervals"
    elif scene.analysis.method == "transient":
        what, hint = (
            "a motion in time, whose steps it does not choose",
            "analysis.time_tolerance and elements",
        )
    elif scene.impulses:
        what, hint = "impulses, as they move modes beyond any mesh", "elements and sub_intervals"
    elif scene.analysis.method == "periodic" and not damped:
        what, hint = "vibration that nothing damps: errors add up beyond their estimates", "some damping"
    elif "torque" in scene.tolerances and not scene.drives:
        what, hint = "the torque of a drive, as the scene drives nothing", "tolerances of other quantities"
    elif "joint_force" in scene.tolerances and not scene.joints:
        what, hint = "joint forces, as the scene has no joints", "tolerances of other quantities"
    else:
        return
    raise SceneError(
        f"a tolerance is not available for {what}", place="tolerance", hint=f"Leave it out, and give {hint}"
    )
