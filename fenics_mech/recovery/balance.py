"""Balance of energy of a motion: what drives and loads give, what damping takes, and what is left over."""

from __future__ import annotations

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from fenics_mech._arrays import each
from fenics_mech.beams.layout import element_dofs
from fenics_mech.effects.springs import spring_energy
from fenics_mech.kinematics.influence import drive_rates
from fenics_mech.mechanism import System
from fenics_mech.recovery.virtual_work import LOSSES, Forces

Array = NDArray[np.float64]
TINY = float(np.finfo(float).tiny)


def energy_balance(forces: Forces, efforts: dict[str, Array]) -> xr.Dataset:
    """Give the mean power of every cause over a cycle, or over a motion in time.

    Parameters
    ----------
    forces
        The forces of a motion over a whole cycle, or in time.
    efforts
        Effort of each drive (N m or N), ``(angles,)``.

    Returns
    -------
    xarray.Dataset
        `mean_power` (W) by `cause`: what the cause gives to the mechanism, negative where it takes. "stored" is what
        the kinetic energy and that of links and springs take up. As attributes `power_residual`, the sum (W), and
        `power_balance_error`, its size over the largest of them. Empty for a mechanism that is held or struck.
    """
    scene, motion = forces.scene, forces.system.motion
    if not scene.drives or scene.analysis.method == "static" or scene.impulses or len(motion.theta) < 2:
        return xr.Dataset()
    rates = drive_rates(scene, motion)
    given = sum((effort * rates[:, i] for i, effort in enumerate(efforts.values())), np.zeros(len(rates)))
    powers = {"drives" if len(efforts) > 1 else "drive": given}
    in_time = scene.analysis.method == "transient"
    told = ("loads", *LOSSES, *(("weight",) if in_time else ()))  # that of weight is 0 over a cycle
    powers |= {name: power for name, power in forces.powers().items() if name in told and power.any()}
    if in_time:
        duration = float(np.ptp(motion.time))
        mean = {
            name: float(CubicSpline(motion.time, power).integrate(*motion.time[[0, -1]])) / duration
            for name, power in powers.items()
        }
        energy = stored_energy(forces)
        mean["stored"] = -float(energy[-1] - energy[0]) / duration
    else:
        mean = {name: float(power.mean()) for name, power in powers.items()}
    residual = sum(mean.values())
    largest = max(abs(value) for value in mean.values())
    return xr.Dataset(
        {"mean_power": (("cause",), list(mean.values()))},
        {"cause": list(mean)},
        {"power_residual": residual, "power_balance_error": abs(residual) / max(largest, TINY)},
    )


def stored_energy(forces: Forces) -> Array:
    """Energy of motion, of links and of springs of the bent mechanism (J), ``(angles,)``, but for a constant."""
    system, rates, v = forces.system, forces.rates, forces.displacement
    mass, rotary, gyroscopic = system.nodal_mass, system.nodal_rotary_mass, system.nodal_gyroscopic
    velocity, swing = rates.rigid + rates.deformation, rates.turning * v
    momentum = (mass @ velocity.T / 2 + gyroscopic @ swing.T).T
    energy = np.sum(velocity * momentum + swing * ((mass - rotary) @ swing.T).T / 2, axis=1)
    energy += np.sum(v * (system.nodal_stiffness @ v.T).T, axis=1) / 2
    energy += spring_energy(forces.scene, system.beams.mesh, system.motion, v)
    if system.terms.law is not None:
        energy += _of_bowing(system, v)
    if forces.shortening is not None:
        u, first, _ = forces.shortening.in_time
        energy += np.sum(rates.rigid * (mass @ first.T + gyroscopic @ (rates.turning * u).T).T, axis=1)
    return np.asarray(energy)


def _of_bowing(system: System, v: Array) -> Array:
    """Strain energy of stretching by bending, beyond that of the linear law (J), ``(angles,)``."""
    beams = system.beams
    ends = v[:, element_dofs(beams.mesh)]
    straight = np.einsum("ei,tei->te", beams.stretching.line, ends)
    whole = straight + np.sum(ends * each(beams.stretching.bow, ends), axis=-1) / 2
    return np.asarray(np.sum(beams.axial_rigidity / beams.mesh.cell_length * (whole**2 - straight**2), axis=1) / 2)
