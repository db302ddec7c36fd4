"""Errors of natural frequencies by the mesh, and the harmonics of a load that would be felt on a mode."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.eigenmodes import Modes
from fenics_mech.mechanism import System


@dataclass(frozen=True)
class FrequencyLimits:
    """How the errors of natural frequencies are estimated."""

    largest_known: float = 0.2  # of a natural frequency: beyond it the first order says no more
    positions: int = 8  # of the cycle, at which modes are looked at


FREQUENCY = FrequencyLimits()


def highest_felt(load: Array, static: Array, loss: float, enough: float) -> int:
    """Give the number of the highest harmonic of a load that would be felt on a mode; 0 where none would.

    Parameters
    ----------
    load, static
        The load and its static answer at equal steps of time, ``(angles, coordinates)`` each.
    loss
        Loss factor of the mode.
    enough
        Square root of an elastic energy, twice of it, that is felt.
    """
    spectrum = np.fft.rfft(np.stack([load, static]), axis=1) * (2 / len(load))
    harmonics = np.sqrt(np.abs(np.einsum("hi,hi->h", spectrum[0], spectrum[1].conj())))
    least = loss * enough + np.finfo(float).tiny
    return int(np.flatnonzero(harmonics > least).max(initial=0))


def frequency_error(system: System, modes: Modes) -> Array:
    """Give the share by which elements have natural frequencies wrong, ``(modes,)``, to `FREQUENCY.largest_known`.

    In bending that is ``omega^2 rho A h^4 / (1440 EI)``, along the axis ``omega^2 rho A h^2 / (24 EA)`` and in shear
    ``omega^2 rho A h^2 / (24 G A_s)``, weighted with the elements' kinetic energy. What lumps of mass add is given by
    Rayleigh's quotient with the mass along the elements.

    Source: Belytschko and Mullen, On dispersive properties of finite element solutions (1978), for the axis; in bending
    by the same expansion of the cubic element with consistent mass.

    Parameters
    ----------
    system
        The mechanism.
    modes
        Its modes at the same angles.
    """
    path, find = system.motion.path, partial(_share_of_error, system, modes)
    share = find() if path is None else path.once("frequency error", (system.beams, system.transformation, modes), find)
    return np.minimum(share, FREQUENCY.largest_known)


def largest_frequency_error(system: System, omega: float) -> float:
    """Give a bound of the `frequency_error` of modes up to a frequency; none for lumps of mass, which is infinite.

    Parameters
    ----------
    system
        The mechanism.
    omega
        The angular frequency (rad/s).
    """
    lumped = system.beams.inertia.spread is not None
    return np.inf if lumped else omega**2 * float(_error_per_square(system).max(initial=0.0))


def _error_per_square(system: System) -> Array:
    """Give the share of error of an element alone, over the square of the angular frequency, ``(elements,)``."""
    beams = system.beams.consistent or system.beams
    h = beams.mesh.cell_length
    flexibility = h**4 / (1440 * beams.rigidity.bending.mean) + h**2 / (24 * beams.rigidity.axial.mean)
    if beams.rigidity.shear is not None:
        flexibility += h**2 / (24 * beams.rigidity.shear.mean)
    per_square = beams.inertia.density.mean * flexibility
    if (reduction := system.beams.reduction) is not None:
        per_square *= reduction.fineness**-4.0
    return np.asarray(per_square)


def _share_of_error(system: System, modes: Modes) -> Array:
    """Give it without the limit: at positions, it depends on no rate of the drive and no load."""
    beams, count = system.beams.consistent or system.beams, modes.omega.shape[1]
    per_square, share = _error_per_square(system), np.zeros(count)
    at = np.unique(np.linspace(0, len(modes.theta), FREQUENCY.positions, endpoint=False).astype(int))
    for k in at:
        values = np.repeat(system.values[k : k + 1], count, axis=0)
        v = in_member_axes(beams.mesh, system.on_nodes(system.transformation.forward(values, modes.shapes[k])))
        energy = np.einsum("mei,eij,mej->me", v, beams.element_mass, v, optimize=True)
        share += modes.omega[k] ** 2 * (energy @ per_square) / len(at)
    if system.beams.inertia.spread is not None:
        along = replace(system, beams=beams)
        of_both = np.einsum("kmi,kmi->km", modes.shapes, along.mass_times(modes.shapes))
        share += np.abs(np.sqrt(of_both) - 1).mean(axis=0)
    return share
