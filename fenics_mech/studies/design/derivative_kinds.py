"""Which studies know derivatives from the linearised equation of a motion, and why others take differences."""

from __future__ import annotations

from collections.abc import Sequence

from fenics_mech.studies.design.design_variables import Design
from fenics_mech.studies.design.result_curves import ResultNumbers


def why_differences(design: Design, quantities: Sequence[ResultNumbers]) -> str:
    """Say why derivatives are differences of trials; nothing where the equation about a trial's motion gives them.

    Parameters
    ----------
    design
        The scene and its variables.
    quantities
        The numbers that are looked at.
    """
    scene = design.scene
    by_poses = scene.analysis.solver == "poses"
    methods = {"periodic", "quasi-static", "static"} if by_poses else {"periodic"}
    reasons = {
        f"the method is {scene.analysis.method!r}": scene.analysis.method not in methods,
        "effects are chosen for each trial": scene.effects == "auto",
        "a tolerance chooses the mesh of each trial": scene.tolerance is not None,
        "impulses act": scene.impulses and not by_poses,
        "joints move freely": scene.freedoms and by_poses,
        "the worst of several load cases counts": scene.cases,
        "a variable is a choice": any(variable.choices for variable in design.variables),
        "no link bends": not scene.members(),
    }
    return next((said for said, holds in reasons.items() if holds), "")
