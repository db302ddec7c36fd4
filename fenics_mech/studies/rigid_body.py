"""The traditional method beside the elastic one: strains from the inertia of the rigid motion."""

from __future__ import annotations

import numpy as np

from fenics_mech._guard import guarded
from fenics_mech.analysis import solve
from fenics_mech.recovery.fields import recover
from fenics_mech.recovery.result import at_place
from fenics_mech.response.setup import CommonParts, mechanism
from fenics_mech.scene import Scene


@guarded()
def rigid_body_strains(
    scene: Scene, s: float = 0.5, fibre: str = "+", common: CommonParts | None = None
) -> dict[str, tuple[np.ndarray, np.ndarray, str]]:
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
    common
        What it may have in common with the elastic analysis.

    Returns
    -------
    dict
        By member: drive angles (rad), strains at `s` and `fibre`, and a label for plots.
    """
    rigid = scene.changed(effects=(), tolerance=None, analysis__method="quasi-static")
    fields = recover(solve(rigid, mechanism(rigid, common=common))[0])
    side = fields.coordinates["fibre"].index(fibre)
    strain = at_place(fields.variables["strain"][1][..., side], fields.coordinates["s"], s)
    return {
        member: (fields.coordinates["theta"], strain[:, i], "without vibration (quasi-static)")
        for i, member in enumerate(fields.coordinates["member"])
    }
