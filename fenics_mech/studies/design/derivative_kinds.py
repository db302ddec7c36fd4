"""Which studies know derivatives from the linearised equation of a motion, and why others take differences."""

from __future__ import annotations

from collections.abc import Sequence

from fenics_mech.answers.by_poses import has_poses
from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.result_curves import ResultNumbers


def why_differences(design: Design, quantities: Sequence[ResultNumbers]) -> str:
    """Say why derivatives are differences of trials; nothing where the equation about a trial's motion gives them."""
    scene = design.scene
    reasons = {
        f"the method is {scene.analysis.method!r}": scene.analysis.method == "transient",
        "a tolerance chooses the mesh of each trial": scene.tolerance is not None,
        "joints move freely": scene.freedoms,
        "the worst of several load cases counts": scene.cases,
        "a variable is a choice": any(variable.choices for variable in design.variables),
        "no link bends": not scene.members(),
        "the scene does not go by the equation of poses": not has_poses(scene),
    }
    return next((said for said, holds in reasons.items() if holds), "")
