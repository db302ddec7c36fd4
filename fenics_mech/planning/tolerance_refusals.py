"""What scenes may not state beside a tolerance."""

from __future__ import annotations

import numpy as np

from fenics_mech.errors import SceneError
from fenics_mech.planning.discretisation import REFINE, TAKEN
from fenics_mech.scene import Scene


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
