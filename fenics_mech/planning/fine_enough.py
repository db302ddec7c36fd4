"""Mesh and steps that a scene leaves to the program: as fine as its answer needs.

Those that the scene states are kept. Where they are too coarse, the answer comes with its error.
"""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from fenics_mech.errors import MechanismError, TooLargeError
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
from fenics_mech.scene.bodies import MESH, Mesh
from fenics_mech.scene.meshing import with_meshes

logger = logging.getLogger(__name__)
Numbers = Mapping[str, float]  # of mesh and steps, by "elements" and keys of `analysis`
COUNTS = "sub_intervals", "modes", "harmonics"
KEYS = *COUNTS, "time_tolerance"  # of `analysis`, by which an answer becomes finer


@dataclass(frozen=True)
class FineLimits:
    """Limits of the search for a mesh and steps that are fine enough."""

    most_rounds: int = 6  # errors fall with powers of 2 and more: the demos need one or two
    most_times: float = 32.0  # as many as without it
    overshoot: float = 4.0  # times as many in a round: errors that are no longer small do not fall with their power


FINE = FineLimits()


def free_numbers(scene: Scene) -> dict[str, float]:
    """Give what a scene leaves to the program of mesh and steps, as it is without a need for finer ones."""
    stated, free = scene.analysis.model_fields_set, dict[str, float]()
    if not {"elements", "stations"} & scene.mesh.model_fields_set:
        free["elements"] = scene.mesh.elements
    for name in KEYS:
        if name not in stated and not isinstance(value := getattr(scene.analysis, name), str):
            free[name] = value
    return free


def with_numbers(scene: Scene, numbers: Numbers) -> Scene:
    """Give a scene with other numbers of mesh and steps; members with a mesh of their own keep it."""
    rest = dict(numbers)
    if (elements := rest.pop("elements", None)) is not None:
        count = int(elements)
        mesh = Mesh(elements=count, grading=scene.mesh.grading ** (scene.mesh.elements / count))
        scene = with_meshes(scene, mesh, lambda own: own)
    changes = {name: int(value) if name in COUNTS else value for name, value in rest.items()}
    return scene.model_copy(update={"analysis": scene.analysis.model_copy(update=changes)}) if changes else scene


def finer_numbers(numbers: Numbers, first: Numbers, error: MechanismError) -> dict[str, float]:
    """Give the numbers with which an analysis may be fine enough; the same ones where none is free, or at the limit."""
    found = dict(numbers)
    for name in found.keys() & error.finer.keys():
        now, begun, wanted = numbers[name], first[name], error.finer[name]
        if name == "time_tolerance":
            found[name] = max(min(wanted, now / 2), begun / FINE.most_times**2)
        else:
            wanted = math.ceil(now * wanted) if name == "elements" else wanted
            most = min(FINE.most_times * begun, MESH.most_unreduced if name == "elements" else math.inf)
            if wanted > most and not error.answered:  # which no finer one would cure
                continue
            found[name] = max(now, min(max(wanted, now + 1), FINE.overshoot * now, most))
    return found


def fine_enough(scene: Scene, analysed: Callable[[Scene], Result]) -> Result:
    """Analyse a scene as finely as its answer needs, by the numbers that it leaves to the program."""
    # Where stated numbers are too coarse, or finer ones do not suffice, the answer is kept: its errors are told, and
    # the attribute `coarse_because` says what is too coarse. `refined` holds the numbers that were made finer. With
    # `allow_coarse` all numbers are kept.
    if scene.analysis.allow_coarse:
        return analysed(scene)
    numbers = first = free_numbers(scene)
    refused: MechanismError | None = None

    def answer(**coarse: bool) -> Result:
        """Analyse with the present numbers, and say in the result which were made finer, and why."""
        finer = {name: value for name, value in numbers.items() if value != first[name]}
        taken = with_numbers(scene, finer)
        result = analysed(taken.changed(**coarse) if coarse else taken)
        if finer and refused is not None:
            why = str(refused).partition(". Take")[0].partition(". To avoid")[0]  # without what to do about it
            result.data.attrs.update(refined=json.dumps(finer), refined_because=why)
        return result

    for _ in range(FINE.most_rounds):
        try:
            return answer()
        except (TooLargeError, MemoryError):
            if refused is None:
                raise
            break  # what was found before it has an answer
        except MechanismError as error:
            refused, finer = error, finer_numbers(numbers, first, error)
            logger.info("too coarse: %s", error)
            if finer == numbers:
                break
            numbers = finer
    assert refused is not None
    if not refused.answered:
        raise refused
    result = answer(analysis__allow_coarse=True)
    result.data.attrs["coarse_because"] = str(refused).removesuffix("; analysis.allow_coarse lets it pass")
    return result
