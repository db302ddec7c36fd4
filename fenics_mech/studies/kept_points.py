"""What is kept of the points of sweeps: the files, and what may stand in them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NotRequired

import numpy as np
from pydantic import Field, TypeAdapter

from fenics_mech._read_back import LARGEST_STRAIN, Ended, Text, read_kept
from fenics_mech.scene.joints import joint_names
from fenics_mech.studies.kept_records import Record

if TYPE_CHECKING:
    from fenics_mech.scene import Scene

Variables = Mapping[str, tuple[tuple[str, ...], str, str]]

KEPT: Variables = {  # by variable: dimensions, unit, meaning
    "peak_strain": (("member",), "1", "largest strain of the outer fibres over the cycle, also between stations"),
    "peak_stress": (("member",), "Pa", "largest stress of the outer fibres over the cycle, at a station"),
    "peak_doubt": ((), "1", "share by which peaks between few positions are uncertain, of strains or joint forces"),
    "peak_strain_theta": (("member",), "rad", "drive angle of the largest strain at a station"),
    "peak_strain_s": (("member",), "1", "station of the largest strain"),
    "peak_strain_side": (("member",), "1", "fibre of the largest strain: 1 on the side of the normal, or -1"),
    "peak_deflection": (("member",), "m", "largest elastic displacement over the cycle"),
    "safety": (("member",), "1", "least factor of safety over the wanted one, of the modes that decide"),
    "safety_min": ((), "1", "the least of all members; the distance from critical speeds is not among its modes"),
    "peak_joint_force": (("joint",), "N", "largest force of the joint over the cycle"),
    "peak_input_torque": ((), "N m", "largest torque of the first drive over the cycle; force where it slides"),
    "strain_harmonic": (("member", "harmonic"), "1", "amplitude of the strain's harmonic; order 0 is its mean"),
    "drive_rate": ((), "rad/s", "rate of the drive coordinate"),
    "frequency_lowest": (("mode",), "Hz", "lowest natural frequency over the cycle"),
    "frequency_highest": (("mode",), "Hz", "highest natural frequency over the cycle"),
    "frequency_start": (("mode",), "Hz", "natural frequency at the start of the cycle"),
    "running_lowest": (("mode",), "Hz", "lowest natural frequency about the motion, by spin and axial forces too"),
    "running_highest": (("mode",), "Hz", "highest natural frequency about the motion"),
    "multiplier": (("disturbance",), "1", "magnitude of the Floquet multiplier, largest first"),
    "growth_rate": (("disturbance",), "1/s", "rate at which the disturbance grows"),
    "euler_ratio": (("member",), "1", "largest axial force over the Euler load"),
    "bow": (("member",), "1", "largest distance of the member's axis from its chord, over its length"),
    "rotation": (("member",), "rad", "largest rotation of the member's axis by deflection"),
    "theory_share": ((), "1", "share of the largest strain that linear theory leaves out"),
    "deflection_theory_share": ((), "1", "share of the largest deflection that linear theory leaves out"),
    "error_estimate": ((), "1", "estimated error of the strains by all sources, relative to the largest"),
    "deflection_error_estimate": ((), "1", "estimated error of the deflections, relative to the largest"),
    "joint_force_error_estimate": ((), "1", "estimated error of the joint forces, relative to the largest"),
    "drive_effort_error_estimate": ((), "1", "estimated error of the drives' efforts, relative to the largest"),
}
TEXTS = {
    "error": "kind of error that the point ended with",
    "message": "what it said",
    "effects": "effects that acted",
    "not_estimated": "what its error estimate leaves out",
    "warnings": "numbers that can hardly be meant, one a line",
    "too_coarse": "message about numerical errors that are too large, of a point whose answer is kept",
    "numbers": "mesh and steps that the program took in place of its usual ones, as JSON",
    "safety_member": "member that has the least factor of safety over the wanted one",
    "safety_mode": "mode of failure of that factor",
    "unstable": "why the motion is unstable, of a point whose numbers are kept nevertheless",
}
LONGEST_CURVES = 10_000_000  # letters: those of 400 members take 0.3 million
CURVES_TEXT = "curves"  # of a point that keeps its curves; see `point_curves`

INFINITE = "theory_share", "deflection_theory_share", "safety", "safety_min"  # no theory tells, or nothing acts
SIGNED = "peak_strain_theta", "peak_strain_side", "drive_rate", "growth_rate"
MOST = {"peak_strain": LARGEST_STRAIN, "peak_strain_s": 1.0, "peak_strain_side": 1.0}
Numbers = float | list[float] | list[list[float]]


class Point(Ended):
    """What is kept of a point."""

    effects: Text
    not_estimated: Text
    warnings: Text
    too_coarse: Text
    numbers: Text
    safety_member: Text
    safety_mode: Text
    unstable: Text
    curves: NotRequired[Annotated[str, Field(max_length=LONGEST_CURVES)]]
    values: NotRequired[Annotated[dict[str, Numbers], Field(max_length=len(KEPT))]]


POINT = TypeAdapter(Point)


def kept_point(path: Path, scene: Scene) -> Record | None:
    """Read a point that has been computed, also one that is to be tried again; None where there is none."""
    record = read_kept(path, POINT)
    return None if record is None or unlike(record.get("values", {}), scene) else dict(record)


def read_point(path: Path, scene: Scene) -> Record | None:
    """Read a finished point; None where there is none, or one that is to be tried again."""
    record = kept_point(path, scene)
    return None if record is None or record["again"] else record


def unlike(values: Mapping[str, Any], scene: Scene) -> str:
    """Say what is not as the points of a scene have it, or not possible at all; an empty text where all is."""
    sizes = {"member": len(scene.members()), "joint": len(joint_names(scene.joints))}
    for name, numbers in values.items():
        if name not in KEPT:
            return f"there is no {name} of a point"
        try:
            found = np.asarray(numbers, dtype=float)
        except ValueError:  # lists of several lengths
            return f"{name} is no table"
        dims = KEPT[name][0]
        if len(dims) != found.ndim or any(sizes.get(dim, n) != n for dim, n in zip(dims, found.shape)):
            return f"{name} is not one number for each {' and '.join(dims) or 'point'}"
        known = found[~np.isnan(found)]
        least, most = -math.inf if name in SIGNED else 0.0, MOST.get(name, math.inf)
        if (known < least).any() or (known > most).any():
            return f"{name} has values from {known.min():.6g} to {known.max():.6g}, which is not possible"
        if np.isinf(known).any() and name not in INFINITE:
            return f"{name} is not finite"
    return ""
