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
from fenics_mech.recovery.cycle_curves import NEIGHBOURS, akima_over_cycle
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.signal import last_cycle, ripples, vibrating_mode
from fenics_mech.scene import Scene
from fenics_mech.scene.load_cases import refuse_cases

STEPS = 720  # of a cycle, in which curves are sampled
MID_SPAN = (0.5, "+")
THEORIES: dict[str, dict[str, Any]] = {  # by label: changes of a scene
    "rigid links": {"effects": (), "analysis.method": "quasi-static", "tolerance": None},
    "linear equation (5.1)": {"effects": ()},
    "all effects": {"effects": "auto"},
}


@dataclass(frozen=True)
class Quantity:
    """What is compared."""

    # "strain", "deflection", "joint_force", "input_torque" or "shaking_force": a strain or the size of the deflection
    # at a place of a member, the sizes of the others' vectors
    kind: str
    part: str = ""  # member or joint; nothing where the machine has one
    # s, fibre: place of a strain or a deflection; by default mid-span on the + side
    s: float = 0.5
    fibre: str = "+"

    @property
    def label(self) -> str:
        """Words for it in a file."""
        words = f"{self.kind.replace('_', ' ')} {self.part}".strip()
        if self.kind not in ("strain", "deflection") or (self.s, self.fibre) == MID_SPAN:
            return words
        return f"{words} s={self.s:g}{f' {self.fibre}' if self.kind == 'strain' else ''}"


@dataclass(frozen=True)
class ComparedCycle:
    """One cycle of a result."""

    data: xr.Dataset
    period: float  # its duration (s)
    still: xr.Dataset | None = None  # its strain without vibration, where the result has it
    frequency: Array | None = None  # natural frequencies (Hz), ``(angles, modes)``, where the result has them


@dataclass(frozen=True)
class Curves:
    """Curves over a cycle of one result, or what was measured at one place."""

    label: str  # words for the source
    known: tuple[Quantity, ...]  # the quantities that it has, each at the place where it is shown
    # gives drive angles (rad) and values of one of them, ``(angles,)`` each
    curve: Callable[[Quantity], tuple[Array, Array]]
    unit: Callable[[Quantity], str]  # gives the unit of one of them
    # frequency (Hz) with which the strain at mid-span of each member vibrates, where it does (section 7.4)
    vibration: Mapping[str, float] = field(default_factory=dict)
    cycle: ComparedCycle | None = None  # that of the result; none of a measurement

    def has(self, quantity: Quantity) -> bool:
        """Whether it has a quantity: a result at any place of a member, a measurement at its own place."""
        if self.cycle is None:
            return quantity in self.known
        return any((one.kind, one.part) == (quantity.kind, quantity.part) for one in self.known)


def curves_of_result(result: Result, label: str, place: tuple[float, str] | None = None) -> Curves:
    """Give the curves of a result over its cycle."""
    scene, data = result.scene, result.data
    closer = between_positions(result, STEPS).data  # between fewer, lengths of vectors are off at their corners
    part, closer_part = (last_cycle(scene.analysis, scene.drives, one) for one in (data, closer))
    if part is None or closer_part is None:
        raise ResultError(f"{label}: there is no cycle in it to compare: the motion is static or not periodic")
    cycle = closer.isel(theta=closer_part)
    bend = [str(member) for member in data["member"].to_numpy()] if "member" in data.coords else []
    names = [
        Quantity(kind, member, *(place or largest_at(cycle, kind, member)))
        for kind in ("strain", "deflection")
        for member in bend
    ]
    names += [Quantity("joint_force", str(joint)) for joint in data["joint"].to_numpy()]
    names += [Quantity(kind) for kind in ("input_torque", "shaking_force") if kind in data]

    def curve(quantity: Quantity) -> tuple[Array, Array]:
        return cycle["theta"].to_numpy(), _values(cycle, quantity)

    def unit(quantity: Quantity) -> str:
        return str(data[quantity.kind].attrs["units"])

    vibration = {}
    if "vibration_frequency" in data:
        rates = zip(data["member"].to_numpy(), data["vibration_frequency"].to_numpy())
        vibration = {str(member): float(rate) for member, rate in rates if np.isfinite(rate)}
    return Curves(label, tuple(names), curve, unit, vibration, _cycle_of(result, cycle, data.isel(theta=part)))


def _cycle_of(result: Result, cycle: xr.Dataset, coarse: xr.Dataset) -> ComparedCycle:
    """Give the cycle of a result, with its strain without vibration at the positions that were computed."""
    still = None
    if "strain_quasi_static" in coarse:
        still = coarse[["strain_quasi_static"]].rename(strain_quasi_static="strain")
    elif result.scene.analysis.method == "quasi-static" and "strain" in coarse:
        still = coarse[["strain"]]
    frequency = coarse["frequency"].transpose("theta", "mode").to_numpy() if "frequency" in coarse else None
    return ComparedCycle(cycle, result.scene.period, still, frequency)


def largest_at(cycle: xr.Dataset, kind: str, member: str) -> tuple[float, str]:
    """Give the place, 0..1, and the side where the stress of a member is largest, or its deflection."""
    sizes = np.abs(along_member(cycle, "stress" if kind == "strain" else kind, member))
    _, f, j = np.unravel_index(sizes.argmax(), sizes.shape)
    side = str(cycle["fibre"].to_numpy()[f]) if kind == "strain" else "+"
    return float(cycle["s"].to_numpy()[j]), side


def along_member(cycle: xr.Dataset, kind: str, member: str) -> Array:
    """Give strain or stress of a member, or the size of its deflection, ``(angles, sides, stations)``."""
    values = cycle[kind].sel(member=member)
    if kind == "deflection":
        return np.linalg.norm(values.transpose("theta", "component", "s").to_numpy(), axis=1, keepdims=True)
    return values.transpose("theta", "fibre", "s").to_numpy()


def _values(data: xr.Dataset, quantity: Quantity) -> Array:
    """Values of a quantity of a result, ``(angles,)``."""
    if quantity.kind == "strain":
        strain = data["strain"].sel(member=quantity.part, fibre=quantity.fibre).transpose("theta", "s")
        return at_place(strain.to_numpy(), data["s"].to_numpy(), quantity.s)
    if quantity.kind == "deflection":
        vectors = data["deflection"].sel(member=quantity.part).transpose("theta", "component", "s").to_numpy()
        return np.linalg.norm(at_place(vectors, data["s"].to_numpy(), quantity.s), axis=-1)
    if quantity.kind == "input_torque":
        return data["input_torque"].to_numpy()
    forces = data[quantity.kind]
    forces = forces.sel(joint=quantity.part) if quantity.part else forces
    return np.linalg.norm(forces.transpose("theta", "component").to_numpy(), axis=-1)


def curves_of_measurement(theta: Array, strain: Array, quantity: Quantity, label: str) -> Curves:
    """Give what was measured at one place."""
    return Curves(label, (quantity,), lambda quantity: (theta, strain), lambda quantity: "1")


def with_vibration(measured: Curves, reference: Curves) -> Curves:
    """Give a measurement with the frequency of its vibration, counted as that of the computed strains."""
    # Ripples are counted about the reference's strain without vibration at the same place, as section 7.4 counts
    # those of figures 7.7 and 7.8. Where the reference lacks it or natural frequencies, or none of these is near, the
    # measurement stays as it is.
    cycle, (quantity,) = reference.cycle, measured.known
    if cycle is None or cycle.still is None or cycle.frequency is None:
        return measured
    theta, still = TURN / STEPS * np.arange(STEPS, dtype=np.float64), _values(cycle.still, quantity)
    wave = periodic(*measured.curve(quantity))(theta) - periodic(cycle.still["theta"].to_numpy(), still)(theta)
    rate = ripples(wave) / cycle.period
    if np.isnan(vibrating_mode(np.array([rate]), cycle.frequency, cycle.period)[0]):
        return measured
    return replace(measured, vibration={quantity.part: rate})


def by_theories(
    scene: Scene, progress: Callable[[str], None] = lambda name: None, place: tuple[float, str] | None = MID_SPAN
) -> list[Curves]:
    """Analyse a scene by the theories of the dissertation: rigid links, its equation (5.1), and all effects."""
    if not scene.members():
        raise SceneError("no link has a member: the theories differ by how links bend. Name two files", place="links")
    refuse_cases(scene, "a comparison of theories")
    found = []
    for label, changes in THEORIES.items():
        progress(label)
        found.append(curves_of_result(analyse(scene.changed(changes)), label, place))
    return found


def periodic(theta: Array, values: Array) -> Callable[[Array], Array]:
    """Interpolate periodic curves, by Akima's curves, which do not swing beyond the points at corners."""
    angle, first = np.unique(np.mod(theta, TURN), return_index=True)
    curve = akima_over_cycle(angle, values[first], TURN, min(NEIGHBOURS, len(angle)))
    return lambda wanted: curve(np.mod(wanted, TURN))


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
    off, distance = values - follow(theta), np.mod(np.roll(theta, -1) - theta + TURN / 2, TURN) - TURN / 2
    weights = np.abs(distance + np.roll(distance, 1)) / 2 if whole else None  # from midway to midway between angles

    def rms(shift: float) -> float:
        return float(np.sqrt(np.average((values - follow(theta - forwards * shift)) ** 2, weights=weights)))

    shift = _least(rms)
    peaks = (curve[np.abs(curve).argmax()] for curve in (reference[1], values))
    return (*(float(peak) for peak in peaks), float(off[np.abs(off).argmax()]), rms(0.0), shift, rms(shift))


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
