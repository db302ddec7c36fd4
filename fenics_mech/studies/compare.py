"""Curves of several results, or of measurements, against one another: difference, root mean square, phase shift."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY, TURN
from fenics_mech.recovery.result import at_place
from fenics_mech.studies.compared_curves import STEPS, ComparedCycle, Curves, Quantity, along_member, periodic

COLUMNS = ("peak_reference", "peak", "difference", "rms", "shift", "rms_shifted")
ANYWHERE = ("largest_difference", "largest_s", "largest_theta")  # along a member


def compare(sources: Sequence[Curves]) -> xr.Dataset:
    """Compare curves with those of the first source, wherever both have a quantity."""
    # Of a measurement that the first source is not, the first gives the curve at its place.
    first, *others = sources
    quantities = list(first.known)
    for other in others:
        if other.cycle is None:
            quantities += [quantity for quantity in other.known if quantity not in quantities]
    found = np.full((len(COLUMNS), len(others), len(quantities)), np.nan)
    anywhere = np.full((len(ANYWHERE), len(others), len(quantities)), np.nan)
    side = np.full((len(others), len(quantities)), "", dtype=object)
    for i, other in enumerate(others):
        for j, quantity in enumerate(quantities):
            if not other.has(quantity):
                continue
            found[:, i, j] = _compared(first.curve(quantity), other.curve(quantity), other.cycle is not None)
            if quantity in first.known and other.cycle and first.cycle and quantity.kind in ("strain", "deflection"):
                anywhere[:, i, j], side[i, j] = _anywhere(first.cycle, other.cycle, quantity)
    along = ("other", "quantity")
    values = dict(zip((*COLUMNS, *ANYWHERE), [*found, *anywhere]))
    data = xr.Dataset(
        {name: (along, value) for name, value in values.items()} | {"largest_fibre": (along, side)},
        {"other": [other.label for other in others], "quantity": [quantity.label for quantity in quantities]},
        {"reference": first.label},
    )
    return data.assign_coords(unit=("quantity", [first.unit(quantity) for quantity in quantities]))


def _anywhere(
    reference: ComparedCycle, other: ComparedCycle, quantity: Quantity
) -> tuple[tuple[float, float, float], str]:
    """Largest difference along a member, the place 0..1 and the drive angle (rad) where it is, and its side."""
    # Both are taken at the stations of the result that has fewer.
    stations = [cycle.data["s"].to_numpy() for cycle in (reference, other)]
    s, theta = min(stations, key=len), other.data["theta"].to_numpy()
    known, found = (
        at_place(along_member(cycle.data, quantity.kind, quantity.part), own, s)
        for cycle, own in zip((reference, other), stations)
    )
    off = found - periodic(reference.data["theta"].to_numpy(), known)(theta)
    k, f, j = np.unravel_index(np.abs(off).argmax(), off.shape)
    side = str(other.data["fibre"].to_numpy()[f]) if quantity.kind == "strain" else ""
    return (float(off[k, f, j]), float(s[j]), float(theta[k])), side


def _compared(reference: tuple[Array, Array], other: tuple[Array, Array], whole: bool) -> tuple[float, ...]:
    """Peaks of both, largest difference, root mean square of it, shift, and root mean square after the shift."""
    # That is over the cycle where the other one is `whole`, and elsewhere over its points. Later is what is farther
    # in the direction in which the drive of the reference turns.
    follow, (theta, values) = periodic(*reference), other
    forwards = np.sign(reference[0][1] - reference[0][0])
    off, weights = values - follow(theta), _parts_of_cycle(theta) if whole else None

    def rms(shift: float) -> float:
        return float(np.sqrt(np.average((values - follow(theta - forwards * shift)) ** 2, weights=weights)))

    shift = _least(rms)
    peaks = (curve[np.abs(curve).argmax()] for curve in (reference[1], values))
    return (*(float(peak) for peak in peaks), float(off[np.abs(off).argmax()]), rms(0.0), shift, rms(shift))


def _parts_of_cycle(theta: Array) -> Array:
    """Give the part of the cycle that each drive angle (rad) stands for, from midway to midway, ``(angles,)``."""
    distance = np.mod(np.roll(theta, -1) - theta + TURN / 2, TURN) - TURN / 2
    return np.abs(distance + np.roll(distance, 1)) / 2


def _least(rms: Callable[[float], float]) -> float:
    """Shift, between minus and plus half a turn, at which a root mean square is least."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415  (slow to import)

    shifts = TURN * (np.arange(STEPS) / STEPS - 0.5)
    sizes = np.array([rms(shift) for shift in shifts])
    if np.ptp(sizes) <= TINY:  # a constant curve has no phase
        return 0.0
    start, step = shifts[sizes.argmin()], TURN / STEPS
    found = minimize_scalar(rms, bounds=(start - step, start + step), method="bounded", options={"xatol": 1e-7})
    return float(found.x) if found.fun < rms(0.0) else 0.0
