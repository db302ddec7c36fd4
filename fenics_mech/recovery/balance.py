"""Balance of energy of a motion: what drives and loads give, what damping takes, and what is left over."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech.accuracy.quantities import MEASURE
from fenics_mech.effects.springs import spring_energy
from fenics_mech.forces.impulse_work import ImpulseWork
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.kinematics.influence import drive_rates
from fenics_mech.response.solution import CollocationSolution, FreeSolution, InTime, MotorSolution, Solution
from fenics_mech.terms.causes import LOSSES, OF_JOINT_LAWS, Cause, cause_of_efforts


def energy_balance(solution: Solution, forces: Forces, efforts: dict[str, Array], errors: Array) -> xr.Dataset:
    """Give the mean power of every cause over a cycle, or over a motion in time.

    Powers jump where loads jump and impulses strike. Their mean over a cycle by collocation is by the quadrature of its
    steps, which end there, and so is that over a motion with freedoms or joint laws.

    Parameters
    ----------
    solution
        The response.
    forces
        The forces of its motion over a whole cycle, or in time.
    efforts
        Effort of each drive (N m or N), ``(angles,)``.
    errors
        Estimated error of each drive's effort (N m or N), ``(drives,)``; NaN where none is known.

    Returns
    -------
    xarray.Dataset
        `mean_power` (W) by `cause`: what the cause gives to the mechanism, negative where it takes. "stored" is what
        the kinetic energy and that of links and springs take up. As attributes `power_residual`, the sum (W);
        `power_balance_error`, its size over the largest, or over `MEASURE.small_power` of a power's mean magnitude;
        `power_error` (W), what the errors of the efforts make of the drives' mean power at most. With impulses also
        `drive_impulse` (N m s or N s), the impulse of each drive's effort at each of them. Empty for a mechanism that
        is held, or struck in a motion in time.
    """
    scene, count, found = solution.scene, len(forces.system.motion.theta), xr.Dataset()
    in_time = isinstance(solution, InTime)
    struck_in_time = in_time and bool(scene.impulses)
    if not scene.moved_joints or scene.analysis.method == "static" or struck_in_time or count < 2:
        return found
    points = solution.points if isinstance(solution, CollocationSolution | FreeSolution) else None
    weights = np.full(count, 1 / count)
    ends = stored(forces.system.motion.time, stored_energy(forces)) if in_time else {}
    if points is not None:
        forces, weights = Forces(scene, points.system, points.response), points.weights
        efforts = forces.efforts()
    rates = drive_rates(scene, forces.system.motion)
    powers = _powers(forces, efforts, rates)
    if in_time and points is None:
        mean = mean_in_time(forces.system.motion.time, powers) | ends
    else:
        mean = {name: float(weights @ power) for name, power in powers.items()} | ends
    if points is not None and points.impulses is not None:
        impulses = ImpulseWork(scene, points.impulses)
        mean[next(iter(mean))] += float(impulses.by_drives.sum()) / scene.period
        mean[Cause.IMPULSES] = float(impulses.by_impulses.sum()) / scene.period
        found["drive_impulse"] = (("impulse", "drive"), impulses.efforts)
        found = found.assign_coords(impulse=list(scene.impulses), drive=list(efforts))
    passed = max(float(np.abs(power).mean()) for power in powers.values())
    balance = balance_of(mean, MEASURE.small_power * passed, float(errors @ np.abs(rates).mean(axis=0)))
    return found.merge(balance, combine_attrs="no_conflicts")


def balance_of(mean: Mapping[str, float], small: float, bound: float) -> xr.Dataset:
    """Label the mean power of every cause, and how far they are from a balance.

    Parameters
    ----------
    mean
        Mean power of each cause (W).
    small
        Power that the imbalance is relative to where all means are smaller (W).
    bound
        What the estimated errors of the efforts make of the drives' mean power at most (W).

    Returns
    -------
    xarray.Dataset
        `mean_power` (W) by `cause`, and the attributes that `energy_balance` names.
    """
    residual, largest = sum(mean.values()), max(abs(value) for value in mean.values())
    attributes = {
        "power_residual": residual,
        "power_balance_error": abs(residual) / max(largest, small, TINY),
        "power_error": bound,
    }
    return xr.Dataset({"mean_power": (("cause",), list(mean.values()))}, {"cause": list(map(str, mean))}, attributes)


def drive_figures(solution: Solution, forces: Forces, efforts: dict[str, Array]) -> xr.Dataset:
    """Give the root mean square of the drives' efforts over a cycle, and how much the energy fluctuates that they give.

    Parameters
    ----------
    solution
        The response.
    forces
        The forces of its motion over a whole cycle.
    efforts
        Effort of each drive (N m or N), ``(angles,)``.

    Returns
    -------
    xarray.Dataset
        `drive_effort_rms` by `drive`. As attributes `energy_fluctuation` (J), the range of the energy given less its
        mean rate, by which a flywheel is chosen (Norton, Design of Machinery, section 11.11), and with a motor's shaft
        `speed_fluctuation`, the range of the crank's rate over its mean. Empty for other than cycles.
    """
    scene, count = solution.scene, len(forces.system.motion.theta)
    if not scene.drives or scene.analysis.method not in ("periodic", "quasi-static") or count < 2 or scene.impulses:
        return xr.Dataset()
    each = np.stack(list(efforts.values()), axis=1)
    power = np.sum(each * drive_rates(scene, forces.system.motion), axis=1)
    surplus = np.append(power, power[0]) - power.mean()
    stored = np.cumsum((surplus[1:] + surplus[:-1]) / 2) * scene.period / count
    figures = {"energy_fluctuation": float(np.ptp(stored))}
    if isinstance(solution, MotorSolution):
        rate = scene.cycle_rate + solution.twist[1]
        figures["speed_fluctuation"] = float(np.ptp(rate) / abs(rate.mean()))
    rms = np.sqrt(np.mean(each**2, axis=0))
    return xr.Dataset({"drive_effort_rms": (("drive",), rms)}, {"drive": list(efforts)}, figures)


def _powers(forces: Forces, efforts: dict[str, Array], rates: Array) -> dict[str, Array]:
    """Power of drives and freedoms, which is first, of loads and of damping (W), ``(angles,)`` each."""
    given = sum((effort * rates[:, i] for i, effort in enumerate(efforts.values())), np.zeros(len(rates)))
    in_time = forces.scene.analysis.method == "transient"
    reported = (
        Cause.LOADS,
        *LOSSES,
        *OF_JOINT_LAWS,
        *((Cause.WEIGHT,) if in_time else ()),
    )  # that of weight is 0 over a cycle
    others = {name: power for name, power in forces.powers().items() if name in reported and power.any()}
    return {cause_of_efforts(forces.scene): given} | others


def mean_in_time(time: Array, powers: Mapping[str, Array]) -> dict[str, float]:
    """Give the mean of powers over a motion in time (W), by cubic splines.

    Parameters
    ----------
    time
        Times (s), ``(times,)``.
    powers
        Power of each cause (W), ``(times,)`` each.
    """
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import, and a cycle needs none)

    duration = float(np.ptp(time))
    return {
        name: float(CubicSpline(time, power).integrate(*time[[0, -1]])) / duration for name, power in powers.items()
    }


def stored(time: Array, energy: Array) -> dict[str, float]:
    """Give minus the mean rate of what motion, links and springs store (W), as the power of `Cause.STORED`.

    Parameters
    ----------
    time
        Times (s), ``(times,)``.
    energy
        The stored energy (J), ``(times,)``.
    """
    return {Cause.STORED: -float(energy[-1] - energy[0]) / float(np.ptp(time))}


def stored_energy(forces: Forces) -> Array:
    """Energy of motion, of links and of springs of the bent mechanism (J), ``(angles,)``, but for a constant.

    Parameters
    ----------
    forces
        The forces and rates of a motion.
    """
    system, rates, v = forces.system, forces.rates, forces.displacement
    mass, rotary, gyroscopic = system.nodal_mass, system.nodal_rotary_mass, system.nodal_gyroscopic
    velocity, swing = rates.rigid + rates.deformation, rates.turning * v
    momentum = (mass @ velocity.T / 2 + gyroscopic @ swing.T).T
    energy = np.sum(velocity * momentum + swing * ((mass - rotary) @ swing.T).T / 2, axis=1)
    energy += np.sum(v * (system.nodal_stiffness @ v.T).T, axis=1) / 2
    energy += spring_energy(forces.scene, system.beams.mesh, system.motion, v)
    if system.terms.law is not None:
        energy += system.terms.law.on_elements.energy(v).sum(axis=1)
    if system.spin is not None:
        energy += system.spin.on_elements.energy(v, rates.deformation, rates.motion.omega).sum(axis=1)
    if forces.shortening is not None:
        u, first, _ = forces.shortening.in_time
        energy += np.sum(rates.rigid * (mass @ first.T + gyroscopic @ (rates.turning * u).T).T, axis=1)
    if (shift := forces.inert_shift) is not None:
        energy += shift.momentum(rates.rigid, shift.in_time[1], rates.turning)
    return np.asarray(energy)
