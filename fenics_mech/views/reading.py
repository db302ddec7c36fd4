"""A result in the units and words in which people read it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import MEGA, MICRO, MILLI, TURN
from fenics_mech.errors import ResultError
from fenics_mech.recovery import Result
from fenics_mech.recovery.peaks import between_positions
from fenics_mech.scene import Scene
from fenics_mech.views.words import DEGREE, MINUS, short

ROUNDING = 1e-9  # of the largest joint force, below which an effort is nothing
NEEDED = ("strain", "stress", "deflection", "joint_force", "position", "link_position", "link_angle")


@dataclass(frozen=True)
class Peak:
    """Where a quantity of a member is largest.

    Parameters
    ----------
    k
        Number of the position.
    i
        Number of the member.
    j
        Number of the station.
    f
        Number of the fibre; 0 where the quantity has none.
    """

    k: int
    i: int
    j: int
    f: int = 0


class Reading:
    """Curves of a result in MPa, micrometres per metre, mm and N, and its places in words.

    Between few positions of a cycle the curves are those of `between_positions`, in which peaks are sought.

    Parameters
    ----------
    result
        The result.

    Raises
    ------
    ResultError
        When it lacks what is read, or its members are not those of its scene.
    """

    def __init__(self, result: Result) -> None:
        self.result, self.scene = result, result.scene
        _refuse_incomplete(result.data, self.scene)
        self.data = between_positions(result).data
        self.members = [str(name) for name in result.data["member"].to_numpy()]
        self.joints = [str(name) for name in result.data["joint"].to_numpy()]
        self.fibres = [str(name).replace("-", MINUS) for name in result.data["fibre"].to_numpy()]
        self.s = result.data["s"].to_numpy()
        known = self.scene.members()
        self.ends = [known[name][1].ends for name in self.members]
        self.lengths = np.array([math.dist(*self.scene.member_ends(name)) for name in self.members])
        self.theta, self.in_time = self.data["theta"].to_numpy(), self.scene.analysis.method == "transient"

    def of(self, name: str, *dimensions: str) -> Array:
        """Give a variable as an array over theta and other dimensions.

        Parameters
        ----------
        name
            Its name.
        dimensions
            Its dimensions behind theta.
        """
        return self.data[name].transpose("theta", *dimensions).to_numpy()

    @cached_property
    def stress(self) -> Array:
        """Stress (MPa), ``(angles, members, stations, fibres)``."""
        return MEGA * self.of("stress", "member", "s", "fibre")

    @cached_property
    def strain(self) -> Array:
        """Strain (micrometres per metre), ``(angles, members, stations, fibres)``."""
        return MICRO * self.of("strain", "member", "s", "fibre")

    @cached_property
    def bent(self) -> Array:
        """Magnitude of the deflection (mm), ``(angles, members, stations, 1)``."""
        deflection = self.of("deflection", "member", "s", "component")
        return MILLI * np.linalg.norm(deflection, axis=-1, keepdims=True)

    @cached_property
    def force(self) -> Array:
        """Magnitude of the joints' forces (N), ``(angles, joints)``."""
        return np.linalg.norm(self.of("joint_force", "joint", "component"), axis=-1)

    @cached_property
    def effort(self) -> Array | None:
        """Torque (N m) or force (N) of the first drive, ``(angles,)``; None where there is none but rounding."""
        if "input_torque" not in self.data:
            return None
        effort, least = self.of("input_torque"), ROUNDING * self.force.max(initial=0.0)
        return effort if float(np.abs(effort).max()) > least * min(1.0, float(self.lengths.max())) else None

    @cached_property
    def effort_name(self) -> tuple[str, str]:
        """What the first drive gives, and its unit."""
        unit = str(self.result.data["input_torque"].attrs.get("units", "N m"))
        return ("drive force" if unit == "N" else "drive torque"), unit

    def peak(self, curves: Array, i: int) -> Peak:
        """Find where the largest value of a member is.

        Parameters
        ----------
        curves
            Values, ``(angles, members, stations, fibres)``.
        i
            Number of the member.
        """
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
        """Say where along its member a peak is: "at A", or "135 mm from C".

        Parameters
        ----------
        peak
            The peak.
        """
        first, second = self.ends[peak.i]
        if peak.j in (0, len(self.s) - 1):
            return f"at {second if peak.j else first}"
        return f"{short(MILLI * self.s[peak.j] * self.lengths[peak.i])} mm from {first}"

    def side(self, peak: Peak) -> str:
        """Name the side of the member on which a peak is.

        Parameters
        ----------
        peak
            The peak.
        """
        return f"{self.fibres[peak.f]} side"

    def at(self, k: int) -> str:
        """Say at which drive angle a position is, or at which time of a motion in time.

        Parameters
        ----------
        k
            Number of the position.
        """
        if self.in_time:
            return f"{short(float(self.data['time'][k]))} s"
        angle = round(math.degrees(float(np.mod(np.round(self.theta[k], 12), TURN))), 1)
        return f"{0 if angle == 360 else angle:g}{DEGREE}"

    @property
    def still(self) -> float | None:
        """Largest stress without vibration (MPa), where the result has it."""
        data = self.result.data
        return MEGA * float(abs(data["stress_quasi_static"]).max()) if "stress_quasi_static" in data else None


def _refuse_incomplete(data: xr.Dataset, scene: Scene) -> None:
    """Raise `ResultError` where variables are missing, or members are not those of the scene."""
    if lacking := [name for name in NEEDED if name not in data]:
        raise ResultError(
            f"the result has no {', '.join(lacking)}: an older version may have written it. Analyse its scene again"
        )
    members, links = ([str(name) for name in data[kind].to_numpy()] for kind in ("member", "link"))
    if sorted(members) != sorted(scene.members()) or not set(links) <= set(scene.links):
        raise ResultError("the members or links of the result are not those of the scene in it")
