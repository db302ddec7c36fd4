"""Numbers of a result, by their names: "strain[coupler].max", "shaking_force.rms", "mass", "frequency[1].min"."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.errors import ResultError, SceneError, shortened
from fenics_mech.recovery import Result
from fenics_mech.recovery.cycle_curves import CycleCurves
from fenics_mech.recovery.peaks import CURVES, curves_over_cycle
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.signal import last_cycle
from fenics_mech.recovery.sound import sound
from fenics_mech.recovery.stress_figures import fatigue
from fenics_mech.recovery.variables import ATTRIBUTES
from fenics_mech.safety import KEYS, judge
from fenics_mech.scene import Scene
from fenics_mech.scene.study import Target
from fenics_mech.scene.units import EXAMPLES, in_unit

PATHS = ("point_position_bent", "point_position")  # of links that bend, and of those that do not


def tracer_error(result: Result, target: Target) -> xr.DataArray:
    """Distance of a point from each place of its target (m), ``(theta,)``, one entry for each place."""
    name = next((name for name in PATHS if name in result.data), PATHS[-1])
    points = [str(point) for point in result.data["point"].to_numpy()] if name in result.data else []
    if target.point not in points:
        raise SceneError(
            f"there is no point {target.point!r}", place="study.targets", hint=f"Known: {', '.join(points)}"
        )
    path = result.data[name].isel(point=points.index(target.point)).transpose("theta", "component").to_numpy()
    wanted = np.array(target.path)
    if target.angles:
        found = at_angles(result.data["theta"].to_numpy(), path, np.array(target.angles))
        return xr.DataArray(np.linalg.norm(found - wanted, axis=1), dims="theta")
    return xr.DataArray(nearest(path, wanted), dims="theta")


def at_angles(theta: Array, values: Array, angles: Array) -> Array:
    """Give values of a cycle at other drive angles, by a periodic cubic spline, ``(angles, ...)``."""
    from scipy.interpolate import CubicSpline  # noqa: PLC0415  (slow to import)

    turn = np.copysign(2 * np.pi, theta[1] - theta[0])
    order = np.argsort(whole := np.append(theta, theta[0] + turn))
    spline = CubicSpline(whole[order], np.concatenate([values, values[:1]])[order], bc_type="periodic")
    return spline(angles)


def nearest(path: Array, wanted: Array) -> Array:
    """Distance of each wanted place from a closed path (m), ``(places,)``."""
    along = np.roll(path, -1, axis=0) - path
    square = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)
    apart = wanted[:, None] - path
    share = np.clip((apart * along).sum(axis=2) / square, 0, 1)
    return np.linalg.norm(apart - share[..., None] * along, axis=2).min(axis=1)


NAME = re.compile(r"([A-Za-z_]+)((?:\[[^\[\]]+\])*)(?:\.([a-z]+))?")
ALIASES = {"torque": "input_torque"}
LABELLED = (
    *("member", "joint", "mode", "support", "point", "link", "drive", "pair", "spring", "damper", "cause"),
    *("fibre", "component", "disturbance", "gauge", "harmonic", "law", "freedom"),
)
OWN = {  # those that are not variables of a result: unit, meaning
    "mass": ("kg", "mass of the links and point masses, or of one link"),
    "stability": ("1", "margin: 1 less the largest magnitude of a Floquet multiplier"),
    "damage": ("1", "damage by fatigue of one cycle, largest of all places"),
    "safety": ("1", "least factor of safety over the wanted one, of all members and modes that decide, or of one"),
    "noise": ("dB", "A-weighted level of the links' sound at 1 m"),
    "tracer_error": ("m", "distance of a point from its target"),
}
REDUCTIONS: dict[str, Callable[[Array], Array]] = {  # of a curve over the positions, ``(positions, places)``
    "max": lambda curve: np.abs(curve).max(axis=0),
    "min": lambda curve: curve.min(axis=0),
    "mean": lambda curve: curve.mean(axis=0),
    "rms": lambda curve: np.sqrt((curve**2).mean(axis=0)),
    "range": lambda curve: np.ptp(curve, axis=0),
}
BETWEEN: dict[str, Callable[[CycleCurves], Array]] = {  # positions too; means over equal steps need no more
    "max": lambda curves: np.abs(curves.largest()[1]).max(),
    "min": lambda curves: curves.lowest()[1].min(),
    "range": lambda curves: (curves.highest()[1] - curves.lowest()[1]).max(),
}
FORM = "Write NAME[LABEL].REDUCTION, such as strain[coupler].max; reductions are " + ", ".join(REDUCTIONS)


@dataclass(frozen=True)
class Quantity:
    """A number of a result."""

    text: str  # what the user wrote
    name: str  # variable of the result, or one of `OWN`
    labels: tuple[str, ...]  # member, joint, mode or the like; all where there is none
    reduction: str  # what is taken over the cycle; "" of what is one number already

    @classmethod
    def read(cls, text: str) -> Quantity:
        """Read the name of a number."""
        match = NAME.fullmatch(text.strip())
        if match is None:
            raise SceneError(f"cannot read {shortened(text)} as a number of a result", place="study", hint=FORM)
        name, reduction = ALIASES.get(match[1], match[1]), match[3] or ""
        known = [*OWN, *ALIASES, *ATTRIBUTES]
        if name not in known:
            near = difflib.get_close_matches(name, known, n=3, cutoff=0.5)
            hint = f"Did you mean {' or '.join(near)}?" if near else FORM
            raise SceneError(f"{text!r}: a result has no {name!r}", place="study", hint=hint)
        allowed = {"stability": ("margin",), "mass": ("",), "noise": ("",), "safety": ("min",)}.get(
            name, ("", *REDUCTIONS)
        )
        if reduction not in allowed:
            near = difflib.get_close_matches(reduction, allowed, n=1, cutoff=0.4) or [part for part in allowed if part]
            hint = f"Did you mean {name}.{near[0]}? " + FORM if near else f"It is one number: leave .{reduction} out"
            raise SceneError(f"{text!r}: there is no reduction {reduction!r}", place="study", hint=hint)
        return cls(text, name, tuple(re.findall(r"\[([^\[\]]+)\]", match[2])), reduction)

    @property
    def unit(self) -> str:
        """SI unit."""
        return OWN[self.name][0] if self.name in OWN else str(ATTRIBUTES[self.name][0])

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers that it gives: its own."""
        return (self.text,)

    @property
    def needs_stability(self) -> bool:
        """Whether the analysis must judge stability."""
        return self.name == "stability" or self.name.startswith(("multiplier", "growth_rate"))

    @property
    def variables(self) -> tuple[str, ...]:
        """Variables of the result that the number is made from; those of a path stand for all that a result has."""
        made_from = {
            "mass": (),
            "stability": ("multiplier",),
            "damage": ("stress",),
            "safety": ("stress", "deflection", "joint_force"),
            "noise": ("deflection", "position"),
            "tracer_error": ("point_position_bent",),
        }
        return made_from.get(self.name, (self.name,))

    def in_si(self, value: float | str) -> float:
        """Read a limit on the number."""
        unit = self.unit.replace(" ", "*").replace("^", "**")
        try:
            return float(in_unit(unit)(value) if unit in EXAMPLES else value)
        except ValueError as error:
            raise SceneError(f"{self.text!r}: {error}", place="study.limits") from error

    def of(self, result: Result, targets: Mapping[str, Target] | None = None) -> float:
        """Give the number of a result."""
        if self.name == "mass":
            return total_mass(result.scene, self.labels)
        if result.cases and (self.name != "safety" or self.case_of(result)):
            return self._of_cases(result, targets)
        if self.needs_stability:
            _require_multipliers(self, result)
        if self.name == "stability":
            return 1.0 - float(np.sqrt((result.data["multiplier"] ** 2).sum("part")).max())
        if self.name == "tracer_error":
            return reduced(_tracer(self, result, targets or {}), self.reduction or "rms")
        if self.name == "noise":
            return float(sound(result).attrs["weighted_level"])
        if self.name == "safety":
            return _least_factor(self, result)
        if self.name == "damage":
            data = fatigue(result).assign_attrs(result.data.attrs)
            return reduced(self._selected(data["damage"]), "max")
        return self._of_variable(result)

    def case_of(self, result: Result) -> str:
        """Name the load case of a result that a label names; "" where none does."""
        return next((label for label in self.labels if label in result.cases), "")

    def _of_cases(self, result: Result, targets: Mapping[str, Target] | None) -> float:
        """Give the number of the case that is named, or else the worst: the largest, or of what is a min the least."""
        if case := self.case_of(result):
            labels = tuple(label for label in self.labels if label != case)
            return replace(self, labels=labels).of(result.cases[case], targets)
        found = [self.of(one, targets) for one in result.cases.values()]
        return min(found) if self.reduction == "min" or self.name == "stability" else max(found, key=abs)

    def numbers(self, result: Result, targets: Mapping[str, Target]) -> dict[str, float]:
        """Give the number of a result by its name; see `of`."""
        return {self.text: self.of(result, targets)}

    def variable(self, result: Result) -> xr.DataArray:
        """Give the variable of a result with the labels taken."""
        if self.name not in result.data:
            names = [str(name) for name, variable in result.data.data_vars.items() if variable.dtype.kind == "f"]
            said = f"{self.text!r}: this result has no {self.name!r}"
            raise SceneError(said, place="study", hint=f"It has {', '.join(names)}")
        return self._selected(result.data[self.name])

    def _of_variable(self, result: Result) -> float:
        """Reduce a variable of the result."""
        found = self.variable(result)
        if "theta" in found.dims:
            part = last_cycle(result.scene.analysis, result.scene.drives, result.data)
            found = found if part is None else found.isel(theta=part)
        if not self.reduction and found.size > 1:
            hint = f"Write {self.name}.max, or a label in brackets"
            raise SceneError(f"{self.text!r} is {found.size} numbers", place="study", hint=hint)
        between = self.reduction in BETWEEN and self.name in CURVES and "theta" in found.dims
        value = _between(result, found, self.reduction) if between else reduced(found, self.reduction or "mean")
        if self.name == "strain" and self.reduction == "max" and set(self.labels) <= {*result.scene.members()}:
            return max(value, reduced(self._selected(result.data["largest_strain"]), "max"))
        return value

    def _selected(self, found: xr.DataArray) -> xr.DataArray:
        """Take the labels of a variable."""
        for label in self.labels:
            found = _labelled(self.text, found, label)
        return found


def reduced(found: xr.DataArray, reduction: str) -> float:
    """Reduce a variable to one number: over the positions first, and then to the worst of the places."""
    # The worst is the largest size, or the least value of "min". Vectors count by their lengths.
    if "component" in found.dims:
        found = ((found**2).sum("component")) ** 0.5
    values = found.transpose("theta", ...).to_numpy() if "theta" in found.dims else found.to_numpy()[None]
    values = values.reshape(len(values), -1).astype(float)
    values = values[:, np.isfinite(values).any(axis=0)]
    if not values.size:
        return math.nan
    over_cycle = REDUCTIONS[reduction](values)
    if reduction == "min":
        return float(np.nanmin(over_cycle))
    return float(over_cycle[np.nanargmax(np.abs(over_cycle))]) if np.isfinite(over_cycle).any() else math.nan


def _between(result: Result, found: xr.DataArray, reduction: str) -> float:
    """Reduce curves over the cycle as `reduced` does, between the positions too."""
    vectors = ["component"] if "component" in found.dims else []
    values = found.transpose("theta", ..., *vectors).to_numpy().astype(float)
    curves = curves_over_cycle(result.scene, values, str(found.name))
    if vectors and reduction == "max":
        return float(curves.longest()[1].max())
    return float(BETWEEN[reduction](curves.lengths() if vectors else curves))


def read_all(names: Sequence[str]) -> tuple[Quantity, ...]:
    """Read several names, each once; see `Quantity.read`."""
    return tuple(Quantity.read(name) for name in dict.fromkeys(names))


def _labelled(text: str, found: xr.DataArray, label: str) -> xr.DataArray:
    """Take one label of a variable, along the dimension that has it, or a place 0..1 along members ("@0.5")."""
    if label.startswith("@") and "s" in found.dims:
        try:
            place = float(label[1:])
        except ValueError:
            place = math.nan
        if 0 <= place <= 1:
            along = found.transpose(..., "s")
            return along.isel(s=0, drop=True).copy(data=at_place(along.to_numpy(), along["s"].to_numpy(), place))
        hint = "Write a share of the length, such as @0.5 for its middle"
        raise SceneError(f"{text!r}: {label!r} is no place from 0 to 1 along a member", place="study", hint=hint)
    known: list[str] = []
    for dim in (dim for dim in found.dims if dim in LABELLED):
        names = [str(name) for name in found[dim].to_numpy()]
        if label in names:
            return found.isel({dim: names.index(label)})
        known += names
    near = difflib.get_close_matches(label, known, n=3, cutoff=0.5)
    hint = f"Did you mean {' or '.join(near)}?" if near else f"Known: {', '.join(known) or 'none'}"
    raise SceneError(f"{text!r}: there is no {label!r}", place="study", hint=hint)


def _require_multipliers(quantity: Quantity, result: Result) -> None:
    """Refuse a result without the multipliers that a number is made from: other trials may have them."""
    data, said = result.data, f"{quantity.text!r}: "
    if "stability_limit" not in data.attrs:
        raise SceneError(said + "stability was not judged", place="study", hint="It needs a periodic response")
    count = data.sizes.get("disturbance", 0)
    if not count:
        raise ResultError(
            said + "all vibrations are too fast for these sub_intervals: whether they decay is not known. Take more"
        )
    if any(label.isdigit() and int(label) > count for label in quantity.labels):
        raise ResultError(f"{said}the result has {count} multipliers: those that its sub_intervals can follow")


def _least_factor(quantity: Quantity, result: Result) -> float:
    """Give the least factor of safety over the wanted one, of a member, a mode, both or all."""
    # Of all modes those that rest on an assumed grade or pin do not count; a mode that is named counts in any case.
    found, said = judge(result), f"{quantity.text!r}: "
    modes = [label for label in quantity.labels if label in KEYS]
    members = [label for label in quantity.labels if label in found.checks]
    if other := [label for label in quantity.labels if label not in (*modes, *members)]:
        known = ", ".join([*found.checks, *KEYS])
        raise SceneError(f"{said}there is no {other[0]!r}", place="study", hint=f"Known members and modes: {known}")
    checks = [check for member in members or found.checks for check in found.checks[member]]
    counted = [check for check in checks if (check.mode in modes and check.known if modes else check.decides)]
    if not counted:
        reasons = {check.missing for check in checks if check.mode in modes and check.missing}
        why = "; ".join(sorted(reasons)) or "every mode rests on an assumption"
        raise SceneError(f"{said}no factor of safety is known: {why}", place="study")
    return min(check.share for check in counted)


def _tracer(quantity: Quantity, result: Result, targets: Mapping[str, Target]) -> xr.DataArray:
    known = ", ".join(targets) or "none"
    if len(quantity.labels) != 1 or quantity.labels[0] not in targets:
        hint = f"Write tracer_error[NAME].rms with the name of a target of the study; known: {known}"
        raise SceneError(f"{quantity.text!r} names no target", place="study", hint=hint)
    return tracer_error(result, targets[quantity.labels[0]])


def total_mass(scene: Scene, links: Sequence[str] = ()) -> float:
    """Mass of the links and of the point masses on them (kg)."""
    counted = set(links or scene.links)
    if unknown := sorted(counted - set(scene.links)):
        known = ", ".join(scene.links)
        raise SceneError(f"mass[{unknown[0]}]: there is no such link", place="study", hint=f"Known: {known}")
    places, weights = np.polynomial.legendre.leggauss(8)
    s: Array = (1 + places) / 2
    found = [body.rigid.mass for name, body in scene.links.items() if body.rigid is not None and name in counted]
    found += [mass.mass for mass in scene.masses.values() if mass.at.split(".")[0] in counted]
    for label, (link, _) in scene.members().items():
        if link in counted:
            length = math.dist(*scene.member_ends(label))
            found.append(length * float(weights @ scene.rigidity(label, s).line_density) / 2)
    return float(sum(found))


@dataclass(frozen=True)
class Curve(Quantity):
    """A quantity of a result at drive angles."""

    angles: tuple[float, ...] = ()  # drive angles (rad)

    @classmethod
    def at(cls, text: str, angles: Array | list[float]) -> Curve:
        """Read the name of a curve."""
        of = Quantity.read(text)
        if of.reduction or of.name in OWN:
            hint = "Write a variable of the result and its labels, such as strain[coupler][@0.5][+] or torque"
            raise SceneError(f"{text!r} is one number, and no curve over the drive angle", place="study", hint=hint)
        return cls(of.text, of.name, of.labels, of.reduction, tuple(float(angle) for angle in angles))

    @cached_property
    def names(self) -> tuple[str, ...]:
        """Names of its values."""
        return tuple(f"{self.text} at {math.degrees(angle):.9g} deg" for angle in self.angles)

    def numbers(self, result: Result, targets: Mapping[str, Target]) -> dict[str, float]:
        """Give its values in a result, by their names."""
        if result.cases:
            if not (case := self.case_of(result)):
                hint = f"Name one in brackets: {', '.join(result.cases)}"
                raise SceneError(f"{self.text!r} is a curve of each load case", place="study", hint=hint)
            labels = tuple(label for label in self.labels if label != case)
            told = replace(self, labels=labels).numbers(result.cases[case], targets)
            return dict(zip(self.names, told.values()))
        found = self.variable(result)
        part = last_cycle(result.scene.analysis, result.scene.drives, result.data)
        if found.dims != ("theta",) or part is None:
            more = " and ".join(str(dim) for dim in found.dims if dim != "theta")
            hint = f"Name its {more} in brackets, such as [@0.5] for a place" if more else "It needs a drive that turns"
            raise SceneError(f"{self.text!r} is no single curve over a cycle", place="study", hint=hint)
        theta, values = found["theta"].to_numpy()[part], found.to_numpy()[part]
        return dict(zip(self.names, at_angles(theta, values, np.array(self.angles)).tolist()))

    def values(self, numbers: Mapping[str, float]) -> Array:
        """Give its values of the numbers of a trial, ``(angles,)``."""
        return np.array([numbers[name] for name in self.names])
