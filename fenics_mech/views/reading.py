"""A result in the units and words in which people read it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import NamedTuple

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import ROUNDING
from fenics_mech.errors import ResultError, shortened
from fenics_mech.recovery.peaks import between_positions, smoothed
from fenics_mech.recovery.result import Result, kept
from fenics_mech.scene import Scene
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.views.prefixes import least_moment, prefixed
from fenics_mech.views.words import MINUS, in_degrees, short

SECTION_FORCES = {  # what each is, and its kind of unit
    "axial_force": ("axial force", "force"),
    "shear_force": ("shear force", "force"),
    "moment": ("bending moment", "moment"),
}
NEEDED = ("strain", "stress", "deflection", "joint_force", "position", "link_position", "link_angle")


class Peak(NamedTuple):
    """Where a quantity of a member is largest: the index of the value in its curves."""

    k: int  # number of the position
    i: int  # number of the member
    j: int  # number of the station
    f: int = 0  # number of the fibre; 0 where the quantity has none


class ForceReading:
    """Forces of a result in the units of people, of links that bend or that do not, and its positions in words."""

    arm = 1.0  # m, by which the largest joint force becomes a moment: torques far below it are rounding

    def __init__(self, result: Result, units: AnswerUnits | None = None) -> None:
        self.units = prefixed(result, units or AnswerUnits())
        _refuse_lacking(result.data, ("joint_force",))
        self.result, self.scene, self.data = result, result.scene, between_positions(result).data
        self.joints = [str(name) for name in result.data["joint"].to_numpy()]
        self.theta, self.in_time = self.data["theta"].to_numpy(), self.scene.analysis.method == "transient"

    def of(self, name: str, *dimensions: str) -> Array:
        """Give a variable as an array over theta and other dimensions."""
        return self.data[name].transpose("theta", *dimensions).to_numpy()

    @cached_property
    def force(self) -> Array:
        """Magnitude of the joints' forces (N), ``(angles, joints)``."""
        return np.linalg.norm(self.of("joint_force", "joint", "component"), axis=-1) / self.units.size("force")

    @cached_property
    def shaking(self) -> tuple[Array, Array] | None:
        """Force (N), ``(angles, 2)``, and moment (N m), ``(angles,)``, on the frame; None where nothing is held."""
        if "shaking_force" not in self.data:
            return None
        force, moment = self.of("shaking_force", "component"), self.of("shaking_moment")
        least = ROUNDING * self.arm * float(np.linalg.norm(force, axis=-1).max())
        seen = np.where(np.abs(moment) > least, moment, 0.0)
        return force / self.units.size("force"), seen / self.units.size("moment")

    @cached_property
    def effort(self) -> Array | None:
        """Torque (N m) or force (N) of the first drive, ``(angles,)``; None where there is none but rounding."""
        if "input_torque" not in self.data:
            return None
        effort, force = self.of("input_torque"), self.units.size("force") * self.force.max(initial=0.0)
        seen = float(np.abs(effort).max()) > max(ROUNDING * force * self.arm, least_moment(self.result))
        return effort / self.units.size(self._effort_kind) if seen else None

    @property
    def _effort_kind(self) -> str:
        return "force" if self.result.data["input_torque"].attrs.get("units") == "N" else "moment"

    @cached_property
    def effort_name(self) -> tuple[str, str]:
        """What the first drive gives, or the effort in the first freedom where nothing is driven, and its unit."""
        kind = self._effort_kind
        if not self.result.scene.drives:
            return "effort", self.units.label(kind)
        return ("drive force" if kind == "force" else "drive torque"), self.units.label(kind)

    def at(self, k: int) -> str:
        """Say at which drive angle a position is, to a degree, or at which time of a motion in time."""
        if self.in_time:
            return f"{short(float(self.data['time'][k]))} s"
        exact = len(self.theta) == 1
        return in_degrees(float(self.theta[k] if exact else np.radians(np.round(np.degrees(self.theta[k])))))

    def driven(self) -> str:
        """Say how the machine is driven, and how long a turn or the motion takes."""
        scene, drives = self.scene, self.scene.drives
        if not drives:
            seconds = short(float(np.ptp(self.data["time"].to_numpy())))
            return f"free motion of {seconds} s" if self.in_time else "nothing drives it"
        joints = " and ".join(drive.joint for drive in drives)
        if len(self.theta) == 1:
            return f"held by drive {joints} at {self.at(0)}"
        cycle = f"one cycle in {short(scene.period)} s"
        if len(drives) > 1:
            return f"drives {joints}, {cycle}"
        if drives[0].speed is None:
            return f"drive {joints} by a periodic law, {cycle}"
        if str(self.result.data["input_torque"].attrs.get("units")) == "N":
            return f"drive along {joints}, {cycle}"
        speed, unit = short(self.units.number(drives[0].speed, "speed")), self.units.label("speed")
        speed = f"{speed} {unit}" + ("" if unit == "rpm" else f" ({short(60 / scene.period)} rpm)")
        return f"drive {joints} at {speed}, one turn in {short(scene.period)} s"


class Reading(ForceReading):
    """Curves of a result in the units of people, MPa, micrometres per metre, mm and N, and its places in words."""

    # Between few positions of a cycle the curves are those of `between_positions`, in which peaks are sought.

    def __init__(self, result: Result, units: AnswerUnits | None = None) -> None:
        _refuse_incomplete(result.data, result.scene)
        super().__init__(result, units)
        self.members = [str(name) for name in result.data["member"].to_numpy()]
        self.fibres = [str(name).replace("-", MINUS) for name in result.data["fibre"].to_numpy()]
        self.s = result.data["s"].to_numpy()
        known = self.scene.members()
        self.ends = [known[name][1].ends for name in self.members]
        self.lengths = np.array([math.dist(*self.scene.member_ends(name)) for name in self.members])
        self.arm = min(1.0, float(self.lengths.max()))

    @cached_property
    def stress(self) -> Array:
        """Stress (MPa), ``(angles, members, stations, fibres)``."""
        return self.of("stress", "member", "s", "fibre") / self.units.size("stress")

    @cached_property
    def strain(self) -> Array:
        """Strain (micrometres per metre), ``(angles, members, stations, fibres)``."""
        return self.of("strain", "member", "s", "fibre") / self.units.size("strain")

    @cached_property
    def bent(self) -> Array:
        """Magnitude of the deflection (mm), ``(angles, members, stations, 1)``."""
        deflection = self.of("deflection", "member", "s", "component")
        return np.linalg.norm(deflection, axis=-1, keepdims=True) / self.units.size("length")

    def section_force(self, name: str) -> Array:
        """Give a force in the sections (N) or their moment (N m), ``(angles, members, stations)``."""
        values = self.result.data[name].transpose("theta", "member", "s").to_numpy()
        return smoothed(self.result, values, name)[1] / self.units.size(SECTION_FORCES[name][1])

    def peak(self, curves: Array, i: int) -> Peak:
        """Find where the largest value of a member is."""
        # curves: values, ``(angles, members, stations, fibres)``
        k, j, f = np.unravel_index(np.abs(curves[:, i]).argmax(), curves[:, i].shape)
        return Peak(int(k), i, int(j), int(f))

    @cached_property
    def peaks(self) -> list[Peak]:
        """Where the stress of each member is largest."""
        return [self.peak(self.stress, i) for i in range(len(self.members))]

    @cached_property
    def ranked(self) -> list[int]:
        """Numbers of the members, the one of the largest stress first."""
        return [int(i) for i in np.argsort(-np.abs(self.stress).max(axis=(0, 2, 3)), kind="stable")]

    def place(self, peak: Peak) -> str:
        """Say where along its member a peak is: "at A", or "135 mm from C"."""
        return self.along(self.members[peak.i], float(self.s[peak.j]))

    def along(self, member: str, s: float) -> str:
        """Say where along a member a place is, as `place` does."""
        return place_along(self.scene, member, s, self.units)

    def side(self, peak: Peak) -> str:
        """Name the side of the member on which a peak is."""
        return f"{self.fibres[peak.f]} side"

    @property
    def still(self) -> float | None:
        """Largest stress without vibration (MPa), where the result has it."""
        data = self.result.data
        if "stress_quasi_static" not in data:
            return None
        return self.units.number(float(abs(data["stress_quasi_static"]).max()), "stress")


def place_along(scene: Scene, member: str, s: float, units: AnswerUnits) -> str:
    """Say where along a member a place is: "at A", or "135 mm from C"."""
    first, second = scene.members()[member][1].ends
    if s in (0, 1):
        return f"at {second if s else first}"
    distance = units.number(s * math.dist(*scene.member_ends(member)), "length")
    return f"{short(distance)} {units.label('length')} from {first}"


def change_by_vibration(result: Result) -> float | None:
    """By which share vibration changes the peak stress of a result; None where it was not solved without."""
    if "stress_quasi_static" not in result.data:
        return None
    peak, still = (
        float(abs(data[name]).max())
        for data, name in ((between_positions(result).data, "stress"), (result.data, "stress_quasi_static"))
    )
    return abs(peak - still) / peak if peak else None


def reading_of(result: Result, units: AnswerUnits | None = None) -> ForceReading:
    """Read a result of links that bend, or the forces of one of rigid links."""
    usual = result.scene.answer_units
    if not result.scene.members():
        return ForceReading(result, units or usual)
    return reading_of_members(result) if units in (None, usual) else Reading(result, units)


@kept
def reading_of_members(result: Result) -> Reading:
    """Read a result of links that bend, in the units of its scene."""
    return Reading(result, result.scene.answer_units)


@contextmanager
def reading_of_a_file() -> Iterator[None]:
    """Turn what a damaged or made-up result raises where it is read into one `ResultError`."""
    try:
        yield
    except (KeyError, IndexError, TypeError, ValueError, AttributeError, ZeroDivisionError) as error:
        text = f"the result lacks what is shown, or holds something else there: {shortened(error)}"
        raise ResultError(f"{text}. Analyse its scene again") from error


def _refuse_incomplete(data: xr.Dataset, scene: Scene) -> None:
    """Raise `ResultError` where variables are missing, or members are not those of the scene."""
    if not scene.members():
        raise ResultError("no link of this result bends: `run` shows its joint forces and freedoms")
    _refuse_lacking(data, NEEDED)
    members, links = ([str(name) for name in data[kind].to_numpy()] for kind in ("member", "link"))
    if sorted(members) != sorted(scene.members()) or not set(links) <= set(scene.links):
        raise ResultError("the members or links of the result are not those of the scene in it")


def _refuse_lacking(data: xr.Dataset, needed: tuple[str, ...]) -> None:
    """Raise `ResultError` where variables are missing."""
    if lacking := [name for name in needed if name not in data]:
        raise ResultError(
            f"the result has no {', '.join(lacking)}: an older version may have written it. Analyse its scene again"
        )
