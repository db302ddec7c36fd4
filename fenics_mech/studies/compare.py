"""Curves of several results, or of measurements, against one another: difference, root mean square, phase shift."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY, TURN
from fenics_mech.analysis import analyse
from fenics_mech.errors import ResultError, SceneError
from fenics_mech.recovery import Result
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.signal import last_cycle, ripples
from fenics_mech.response.setup import CommonParts
from fenics_mech.scene import Scene

SHIFTS = 720  # of a cycle, among which the shift is sought before it is refined
THEORIES: dict[str, dict[str, Any]] = {  # by label: changes of a scene
    "rigid links": {"effects": (), "analysis.method": "quasi-static", "tolerance": None},
    "linear equation (5.1)": {"effects": ()},
    "all effects": {"effects": "auto"},
}


@dataclass(frozen=True)
class Quantity:
    """What is compared.

    Parameters
    ----------
    kind
        "strain", "deflection", "joint_force", "input_torque" or "shaking_force": a strain at a place of a member, the
        sizes of the others' vectors, deflections at mid-span.
    part
        Member or joint; nothing where the machine has one.
    s, fibre
        Place of a strain; by default mid-span on the + side.
    """

    kind: str
    part: str = ""
    s: float = 0.5
    fibre: str = "+"

    @property
    def label(self) -> str:
        """Words for it."""
        words = f"{self.kind.replace('_', ' ')} {self.part}".strip()
        if self.kind != "strain" or (self.s, self.fibre) == (0.5, "+"):
            return words
        return f"{words} s={self.s:g} {self.fibre}"

    @property
    def title(self) -> str:
        """A heading for it."""
        words = f"{self.kind.replace('_', ' ').capitalize()}{f' of {self.part}' if self.part else ''}"
        if self.kind != "strain":
            return words
        place, sign = "mid-span" if self.s == 0.5 else f"s = {self.s:g}", self.fibre.replace("-", "\N{MINUS SIGN}")
        return f"{words} at {place}, {sign} side"


@dataclass(frozen=True)
class Curves:
    """Curves over a cycle of one result, or what was measured at one place.

    Parameters
    ----------
    label
        Words for the source.
    known
        The quantities that it has.
    curve
        Gives drive angles (rad) and values of one of them, ``(angles,)`` each.
    unit
        Gives the unit of one of them.
    vibration
        Frequency (Hz) with which the strain at mid-span of each member vibrates, where it does (section 7.4).
    still
        Gives drive angles (rad) and the values of a strain without vibration; None where they are not known.
    period
        Duration of the cycle (s).
    """

    label: str
    known: tuple[Quantity, ...]
    curve: Callable[[Quantity], tuple[Array, Array]]
    unit: Callable[[Quantity], str]
    vibration: Mapping[str, float] = field(default_factory=dict)
    still: Callable[[Quantity], tuple[Array, Array]] | None = None
    period: float = np.nan


def curves_of_result(result: Result, label: str) -> Curves:
    """Give the curves of a result over its cycle.

    Parameters
    ----------
    result
        A periodic or quasi-static result, or one in time whose last cycle repeats the one before.
    label
        Words for it.

    Raises
    ------
    ResultError
        When it has no cycle.
    """
    scene, data = result.scene, result.data
    part = last_cycle(scene.analysis, scene.drives, data)
    if part is None:
        raise ResultError(f"{label}: there is no cycle in it to compare: the motion is static or not periodic")
    cycle = data.isel(theta=part)
    bend = [str(member) for member in data["member"].to_numpy()] if "member" in data.coords else []
    names = [Quantity(kind, member) for kind in ("strain", "deflection") for member in bend]
    names += [Quantity("joint_force", str(joint)) for joint in data["joint"].to_numpy()]
    names += [Quantity(kind) for kind in ("input_torque", "shaking_force") if kind in data]

    def curve(quantity: Quantity) -> tuple[Array, Array]:
        return cycle["theta"].to_numpy(), _values(cycle, quantity)

    vibration = {}
    if "vibration_frequency" in data:
        vibration = dict(zip(data["member"].to_numpy(), data["vibration_frequency"].to_numpy()))
    quiet = cycle.assign(strain=cycle["strain_quasi_static"]) if "strain_quasi_static" in data else cycle
    known = "strain_quasi_static" in data or scene.analysis.method == "quasi-static"

    def still(quantity: Quantity) -> tuple[Array, Array]:
        return quiet["theta"].to_numpy(), _values(quiet, quantity)

    def unit(quantity: Quantity) -> str:
        return str(data[quantity.kind].attrs["units"])

    return Curves(label, tuple(names), curve, unit, vibration, still if known and bend else None, scene.period)


def _values(data: xr.Dataset, quantity: Quantity) -> Array:
    """Values of a quantity of a result, ``(angles,)``."""
    if quantity.kind == "strain":
        strain = data["strain"].sel(member=quantity.part, fibre=quantity.fibre).transpose("theta", "s")
        return at_place(strain.to_numpy(), data["s"].to_numpy(), quantity.s)
    if quantity.kind == "deflection":
        vectors = data["deflection"].sel(member=quantity.part).transpose("theta", "component", "s").to_numpy()
        return np.linalg.norm(at_place(vectors, data["s"].to_numpy(), 0.5), axis=-1)
    if quantity.kind == "input_torque":
        return data["input_torque"].to_numpy()
    forces = data[quantity.kind]
    forces = forces.sel(joint=quantity.part) if quantity.part else forces
    return np.linalg.norm(forces.transpose("theta", "component").to_numpy(), axis=-1)


def curves_of_measurement(theta: Array, strain: Array, quantity: Quantity, label: str) -> Curves:
    """Give what was measured at one place.

    Parameters
    ----------
    theta, strain
        Drive angles (rad) and strains, ``(points,)`` each.
    quantity
        The place.
    label
        Words for it.
    """
    return Curves(label, (quantity,), lambda quantity: (theta, strain), lambda quantity: "1")


def with_vibration(measured: Curves, reference: Curves) -> Curves:
    """Give a measurement with the frequency of its vibration, counted as that of the computed strains.

    Ripples are counted about the reference's strain without vibration at the same place, as section 7.4 counts those of
    figures 7.7 and 7.8. Where the reference does not know it the measurement stays as it is.

    Parameters
    ----------
    measured
        A measurement at one place.
    reference
        A result.
    """
    (quantity,) = measured.known
    if reference.still is None:
        return measured
    theta = TURN / SHIFTS * np.arange(SHIFTS)
    wave = _periodic(*measured.curve(quantity))(theta) - _periodic(*reference.still(quantity))(theta)
    return replace(measured, vibration={quantity.part: ripples(wave) / reference.period})


def by_theories(scene: Scene, progress: Callable[[str], None] = lambda name: None) -> list[Curves]:
    """Analyse a scene by the theories of the dissertation: rigid links, its equation (5.1), and all effects.

    Parameters
    ----------
    scene
        The scene.
    progress
        Called with the name of each theory.

    Raises
    ------
    SceneError
        When no link bends.
    MechanismError
        When one of the analyses fails.
    """
    if not scene.members():
        raise SceneError("no link has a member: the theories differ by how links bend. Name two files", place="links")
    found, common = [], CommonParts()
    for label, changes in THEORIES.items():
        progress(label)
        found.append(curves_of_result(analyse(scene.changed(changes), common=common), label))
    return found


def compare(sources: Sequence[Curves]) -> xr.Dataset:
    """Compare curves with those of the first source, wherever both have a quantity.

    Of a measurement that the first source is not, the first gives the curve at its place.

    Parameters
    ----------
    sources
        The first, and one or more others.

    Returns
    -------
    xarray.Dataset
        By `other` and `quantity`, NaN where a source does not have it: `peak`, `peak_reference`, `difference`, the
        largest one at the angles of the other; `rms` of the difference; `shift` (rad), by which the other is later, and
        `rms_shifted`, what is left if it is moved back. Units by `unit`.

    Examples
    --------
    >>> from fenics_mech.studies.compare import compare, curves_of_result
    >>> source = curves_of_result(fm.Result.load("out/result.nc"), "a")
    >>> float(compare([source, source])["rms"].max())
    0.0
    """
    first, *others = sources
    quantities = list(first.known)
    for other in others:
        if len(other.known) == 1:  # measured
            quantities += [quantity for quantity in other.known if quantity not in quantities]
    columns = ("peak_reference", "peak", "difference", "rms", "shift", "rms_shifted")
    found = np.full((len(columns), len(others), len(quantities)), np.nan)
    for i, other in enumerate(others):
        for j, quantity in enumerate(quantities):
            if quantity in other.known:
                found[:, i, j] = _compared(first.curve(quantity), other.curve(quantity))
    along = ("other", "quantity")
    data = xr.Dataset(
        {name: (along, values) for name, values in zip(columns, found)},
        {"other": [other.label for other in others], "quantity": [quantity.label for quantity in quantities]},
        {"reference": first.label},
    )
    return data.assign_coords(unit=("quantity", [first.unit(quantity) for quantity in quantities]))


def _compared(reference: tuple[Array, Array], other: tuple[Array, Array]) -> tuple[float, ...]:
    """Peaks of both, largest difference, root mean square of it, shift, and root mean square after the shift."""
    follow, (theta, values) = _periodic(*reference), other
    off = values - follow(theta)

    def rms(shift: float) -> float:
        return float(np.sqrt(np.mean((values - follow(theta - shift)) ** 2)))

    shift = _least(rms)
    peaks = (curve[np.abs(curve).argmax()] for curve in (reference[1], values))
    return (*(float(peak) for peak in peaks), float(off[np.abs(off).argmax()]), rms(0.0), shift, rms(shift))


def _least(rms: Callable[[float], float]) -> float:
    """Shift, between minus and plus half a turn, at which a root mean square is least."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415  (slow to import)

    shifts = TURN * (np.arange(SHIFTS) / SHIFTS - 0.5)
    sizes = np.array([rms(shift) for shift in shifts])
    if np.ptp(sizes) <= TINY:  # a constant curve has no phase
        return 0.0
    start, step = shifts[sizes.argmin()], TURN / SHIFTS
    found = minimize_scalar(rms, bounds=(start - step, start + step), method="bounded", options={"xatol": 1e-7})
    return float(found.x) if found.fun < rms(0.0) else 0.0


def _periodic(theta: Array, values: Array) -> Callable[[Array], Array]:
    """Interpolate a periodic curve, by Akima's curves, which do not swing beyond the points at corners."""
    from scipy.interpolate import Akima1DInterpolator  # noqa: PLC0415  (slow to import)

    angle, first = np.unique(np.mod(theta, TURN), return_index=True)
    values, around = values[first], min(4, len(angle))
    knots = np.concatenate([angle[-around:] - TURN, angle, angle[:around] + TURN])
    curve = Akima1DInterpolator(knots, np.concatenate([values[-around:], values, values[:around]]))
    return lambda wanted: np.asarray(curve(np.mod(wanted, TURN)))
