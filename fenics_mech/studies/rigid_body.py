"""The traditional method beside the elastic one: strains from the inertia of the rigid motion."""

from __future__ import annotations

import numpy as np

from fenics_mech.analysis import analyse
from fenics_mech.scene import Scene


def rigid_body_strains(scene: Scene, s: float = 0.5, fibre: str = "+") -> dict[str, tuple[np.ndarray, np.ndarray, str]]:
    """Compute the strains of the rigid-body method (Kaminski 1989, chapter 6).

    The links move as rigid bodies and bear the inertia of that motion, weight and loads. No effect of their
    deflection acts, whatever effects the scene names.

    Parameters
    ----------
    scene
        The scene.
    s
        Place along each member, 0..1.
    fibre
        "+" or "-".

    Returns
    -------
    dict
        By member: drive angles (rad), strains at `s` and `fibre`, and a label for plots.
    """
    rigid = scene.changed(effects=(), tolerance=None, analysis__method="quasi-static")
    # Deflections do not enter this method: their size and their mesh error are no reason to refuse it.
    result = analyse(rigid.changed(analysis__allow_coarse=True, analysis__allow_large=True))
    theta = result.data["theta"].to_numpy()
    return {
        str(member): (theta, result.strain_at(member, s, fibre), "rigid body (quasi-static)")
        for member in result.data["member"].to_numpy()
    }
