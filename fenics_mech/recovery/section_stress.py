"""Stresses inside sections: the largest shear stress, and the largest von Mises stress of any line in a section."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.scene import Scene
from fenics_mech.scene.sections.plain import ISection, PlainSection

LINES = 41  # in a section, at which stresses are compared
INSIDE = 1 - 1e-9  # of the distance of an I's flange, which is in its web
Combine = Callable[[Array, Array], Array]  # of normal and shear stress


def shear_stress(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Give the largest shear stress in each section (Pa), with the shear force's sign, over theta, member and s."""
    # It is ``Q S/(I b)`` of Zhuravskii. Sections whose shape is not known, of several materials or with tapers have
    # none.
    return _by_member(data, scene, lambda normal, shear: shear.max(axis=-1) + shear.min(axis=-1))  # one of them is 0


def von_mises(data: xr.Dataset, scene: Scene) -> xr.DataArray:
    """Give the largest von Mises stress of any line in each section (Pa), over theta, member and s."""
    # It is ``sqrt(sigma^2 + 3 tau^2)``, sigma linear between the outer fibres. It is known where `shear_stress` is.
    return _by_member(data, scene, lambda normal, shear: np.sqrt(normal**2 + 3 * shear**2).max(axis=-1))


def _by_member(data: xr.Dataset, scene: Scene, combined: Combine) -> xr.DataArray:
    """Combine normal and shear stress at lines of each member's section, ``(angles, stations, lines)``."""
    force = data["shear_force"].transpose("theta", "member", "s")
    stress = data["stress"].sel(fibre=["+", "-"]).transpose("theta", "member", "s", "fibre").to_numpy()
    found = np.full(force.shape, np.nan)
    for i, label in enumerate(force["member"].to_numpy()):
        section = scene.sections[scene.members()[str(label)][1].section]
        if not isinstance(section, PlainSection):
            continue
        y = _lines(section)
        if (over := section.moment_over_breadth(y)) is None:
            continue
        share = y / section.fibre
        normal = ((1 + share) * stress[:, i, :, :1] + (1 - share) * stress[:, i, :, 1:]) / 2
        shear = force.to_numpy()[:, i, :, None] * over / section.inertia
        found[:, i] = combined(normal, shear)
    return force.copy(data=found).drop_attrs()


def _lines(section: PlainSection) -> Array:
    """Distances from the neutral line (m) at which a section's stresses are compared: ends, middle, and joints."""
    y = np.linspace(-section.fibre, section.fibre, LINES)
    if isinstance(section, ISection):
        joint = INSIDE * (section.height / 2 - section.flange)
        y = np.concatenate([y, [-joint, joint]])
    return y
