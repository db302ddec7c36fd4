"""Sound of vibrating links in free air, by dipoles along strips.

A thin strip of width b that moves across its face with the acceleration a gives the air a force of ``rho pi b^2 a/4``
on each length: the inertia of the air that flows about it. Each such force radiates as a dipole. Those of all members
are summed with their phases, for each harmonic of the drive, at their mean places.

Source: Howe, Acoustics of Fluid-Structure Interactions, 1998, section 3.2; Blake, Mechanics of Flow-Induced Sound and
Vibration, 1986, volume 1, section 2.1 (dipoles); IEC 61672-1 (A-weighting).
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech.errors import ResultError
from fenics_mech.joints.link_states import quarter
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.rigid_places import bent_axes
from fenics_mech.recovery.signal import harmonics, last_cycle
from fenics_mech.scene import PolygonSection, Scene, TaperSection

Waves = NDArray[np.complex128]
DENSITY, SPEED = 1.204, 343.2  # of air at 20 degrees Celsius (kg/m^3, m/s)
REFERENCE = 1e-12  # of sound power (W)
QUIET = 1e-30  # W, which stands for none
RINGS = 12  # directions from pole to pole of the integral over a sphere, beside one for each 1 of k times the size
EVEN = 1e-6  # difference of time steps from equal ones, relative
THIN = 1.0  # width times the wave number, to which a strip is thin


def sound(result: Result, distance: float = 1.0, widths: Mapping[str, float] | None = None) -> xr.Dataset:
    """Estimate the sound that the vibrating links radiate, and its A-weighted level at a distance.

    It holds for thin strips with their faces across the plane of motion, up to where the wave number times the width is
    1, in free air. The frame, joints and the drive make sound too, and often more of it: that is not in the number.

    Parameters
    ----------
    result
        A periodic result with a drive of constant speed.
    distance
        Of the level (m); the mean over all directions.
    widths
        Widths of members (m), by name. By default those of their sections: area over height where they state none.

    Returns
    -------
    xarray.Dataset
        `sound_power` (W) and `sound_frequency` (Hz) by harmonic of the drive. Attributes: `power_level` (dB re 1 pW),
        `pressure_level` and `weighted_level` (dB and dB(A) re 20 uPa, at the distance), `thin_to` (Hz).

    Raises
    ------
    ResultError
        When the result is no cycle in equal steps of time.

    Examples
    --------
    >>> found = fm.sound(fm.analyse(fm.load("demos/four_bar.toml").changed(effects=["coupling"])))
    >>> found.attrs["weighted_level"] < found.attrs["pressure_level"]
    True
    """
    data, scene = result.data, result.scene
    place, period = _path(result)
    members, s = [str(member) for member in data["member"].to_numpy()], data["s"].to_numpy()
    wide = _widths(scene, members, s, widths or {})
    along = place[:, :, -1] - place[:, :, 0]
    normal = quarter(along / np.linalg.norm(along, axis=-1, keepdims=True))[:, :, None]
    speed = 2 * np.pi / period * np.arange((len(place) - 1) // 2 + 1, dtype=np.float64)
    acceleration = _accelerated(place, speed)
    across = (acceleration * normal).sum(axis=-1, keepdims=True) * normal
    inertia = DENSITY * math.pi / 4 * wide**2  # of the air, on each length
    force = (inertia * _shares(scene, members, s))[..., None] * across
    waves = harmonics(force.reshape(len(force), -1, 2))
    power = radiated_power(waves, place.mean(axis=0).reshape(-1, 2), speed / SPEED)
    return _told(power, speed / (2 * np.pi), distance, float(wide.max()))


def radiated_power(forces: Waves, places: Array, wave_number: Array) -> Array:
    """Sound power of dipoles in a plane (W), ``(frequencies,)``."""
    # forces: amplitudes of the forces on the air (N), ``(frequencies, places, 2)``; places: where they act (m),
    # ``(places, 2)``; wave_number: angular frequency over the speed of sound (1/m), ``(frequencies,)``
    directions, weight = _sphere(RINGS + math.ceil(wave_number.max() * np.ptp(places, axis=0).max()))
    # far pressure of a dipole: i k exp(-ikr) F.n/(4 pi r); its intensity |p|^2/(2 rho c)
    found = np.zeros(len(wave_number))
    for k, (number, force) in enumerate(zip(wave_number, forces)):
        phase = np.exp(1j * number * directions @ places.T)
        heard = (phase * (directions @ force.T)).sum(axis=1)
        found[k] = number**2 / (32 * math.pi**2 * DENSITY * SPEED) * (weight @ np.abs(heard) ** 2)
    return found


def _sphere(rings: int) -> tuple[Array, Array]:
    """Directions, by their parts in the plane, and their weights in an integral over a sphere."""
    height, share = np.polynomial.legendre.leggauss(rings)
    turn = np.pi * np.arange(2 * rings) / rings
    flat = np.sqrt(1 - height**2)[:, None, None] * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    return flat.reshape(-1, 2), np.repeat(share * np.pi / rings, 2 * rings)


def a_weighting(frequency: Array) -> Array:
    """A-weighting (dB), of the shape of the frequencies."""
    # frequency: frequencies (Hz)
    f2 = np.maximum(frequency, 1e-3) ** 2
    top = 12194.0**2 * f2**2
    below = (f2 + 20.6**2) * np.sqrt((f2 + 107.7**2) * (f2 + 737.9**2)) * (f2 + 12194.0**2)
    return np.asarray(20 * np.log10(top / below) + 2.0)


def _path(result: Result) -> tuple[Array, float]:
    """Places of the members' bent axes over one cycle (m), ``(steps, members, s, 2)``, and its period (s)."""
    data, scene = result.data, result.scene
    part = last_cycle(scene.analysis, scene.drives, data)
    if part is None or "deflection" not in data:
        raise ResultError("sound needs a periodic motion of links that bend, with a drive that turns")
    path = bent_axes(data.isel(theta=part))
    steps = np.diff(data["time"].to_numpy()[part])
    if np.ptp(steps) > EVEN * steps.mean():
        raise ResultError("sound needs positions in equal steps of time: a drive of constant speed")
    return path, float(steps.mean() * len(path))


def _accelerated(place: Array, speed: Array) -> Array:
    """Accelerations of periodic places (m/s^2), by their Fourier series."""
    series = np.fft.rfft(place, axis=0)
    rates = np.zeros(len(series))
    rates[: len(speed)] = -(speed**2)  # the last one of an even number has no phase
    return np.asarray(np.fft.irfft(series * rates.reshape(-1, 1, 1, 1), n=len(place), axis=0))


def _shares(scene: Scene, members: list[str], s: Array) -> Array:
    """Lengths that the stations stand for (m), ``(members, stations)``, by the trapezoidal rule."""
    share = np.zeros(len(s))
    share[1:] += np.diff(s) / 2
    share[:-1] += np.diff(s) / 2
    lengths = np.array([math.dist(*scene.member_ends(member)) for member in members])
    return np.outer(lengths, share)


def _widths(scene: Scene, members: list[str], s: Array, stated: Mapping[str, float]) -> Array:
    """Widths of the sections across the plane of motion (m), ``(members, stations)``."""
    own = [_width(scene, member, s) if member not in stated else stated[member] for member in members]
    return np.stack([np.broadcast_to(width, s.shape) for width in own])


def _width(scene: Scene, member: str, s: Array) -> Array | float:
    """Width of a member's section across the plane of motion (m), along it where it varies."""
    of_member = scene.members()[member][1]
    stated = scene.sections[of_member.section]
    section = stated.along(s, scene.sections) if isinstance(stated, TaperSection) else stated
    for quantity in ("width", "diameter"):
        if (found := getattr(section, quantity, None)) is not None:
            return np.asarray(found)
    if isinstance(section, PolygonSection):
        return float(np.ptp([z for part in section.parts or (section,) for _, z in part.outline or ()]))
    assert of_member.material is not None  # laminates and polygons alone have several
    here = scene.rigidity(member, s)
    return np.asarray(here.axial / scene.materials[of_member.material].modulus / np.ptp(here.fibre, axis=-1))


def _told(power: Array, frequency: Array, distance: float, widest: float) -> xr.Dataset:
    """Label the power of each harmonic, and sum it up."""
    spread = 10 * math.log10(4 * math.pi * distance**2)  # over a sphere; 1 pW on 1 m^2 are 0 dB re 20 uPa, to 0.2 dB
    level = 10 * math.log10(max(power.sum(), QUIET) / REFERENCE)
    weighted = 10 * math.log10(max(float(power @ 10 ** (a_weighting(frequency) / 10)), QUIET) / REFERENCE)
    found = xr.Dataset(
        {
            "sound_power": ("harmonic", power, {"units": "W"}),
            "sound_frequency": ("harmonic", frequency, {"units": "Hz"}),
        },
        {"harmonic": np.arange(len(power))},
    )
    levels = {"power_level": level, "pressure_level": level - spread, "weighted_level": weighted - spread}
    return found.assign_attrs(levels | {"distance": distance, "thin_to": THIN * SPEED / (2 * math.pi * widest)})
