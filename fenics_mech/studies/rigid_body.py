"""The traditional method beside the elastic one: strains from the inertia of the rigid motion."""

from __future__ import annotations

import numpy as np

from fenics_mech.analysis import analyse
from fenics_mech.scene import Scene


def rigid_body_strains(scene: Scene, s: float = 0.5, fibre: str = "+") -> dict[str, tuple[np.ndarray, np.ndarray, str]]:
    """Strains that the rigid-body method gives (chapter 6), as the quasi-static answer.

    Returns
    -------
    dict
        By member: drive angles (rad), strains at `s` and `fibre`, and a label for plots.
    """
    result = analyse(scene.changed(analysis__method="quasi-static"))
    theta = result.data["theta"].to_numpy()
    return {
        str(member): (theta, result.strain_at(member, s, fibre), "rigid body (quasi-static)")
        for member in result.data["member"].to_numpy()
    }
