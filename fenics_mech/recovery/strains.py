"""Strains of the outer fibres from the forces in sections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.scene.sections import Rigidity


def stress_over_modulus(sections: Sequence[Rigidity], axial_force: Array, moment: Array) -> tuple[Array, Array]:
    """Give what stress over modulus an axial force and a moment make: the strain where the material does not damp."""
    # axial_force, moment: n (N) and M (N m), ``(angles, members, stations)``
    # Gives by the axial force N/EA, ``(angles, members, stations)``, and by the moment in both outer fibres, - M e/EI
    # with e the fibre's place on the normal's side, ``(angles, members, stations, 2)``. Their sum is (6.38).
    axial, bending, fibre = (np.stack([getattr(r, part) for r in sections]) for part in ("axial", "bending", "fibre"))
    return axial_force / axial, -moment[..., None] * fibre / bending[..., None]


def young_modulus(sections: Sequence[Rigidity]) -> Array:
    """Young's modulus (Pa) at both outer fibres, ``(members, stations, 2)``."""
    return np.stack([section.modulus for section in sections])


def without_vibration(sections: Sequence[Rigidity], axial_force: Array, moment: Array) -> dict[str, Any]:
    """Give strains and stresses of a static answer, as variables."""
    by_force, by_moment = stress_over_modulus(sections, axial_force, moment)
    strain, along = by_force[..., None] + by_moment, ("theta", "member", "s", "fibre")
    return {"strain_quasi_static": (along, strain), "stress_quasi_static": (along, young_modulus(sections) * strain)}
