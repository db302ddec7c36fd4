"""Names of a result's variables: what each means, and its unit, as `variables.csv` beside it states them."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from itertools import islice
from pathlib import Path

import xarray as xr

from fenics_mech.estimate.frequencies import FREQUENCY
from fenics_mech.scene import Prismatic, Scene, Slot
from fenics_mech.scene.joint_laws import OPEN
from fenics_mech.scene.joints import effort_units
from fenics_mech.scene.springs_dampers import Hinge

with Path(__file__).with_suffix(".csv").open(encoding="utf-8", newline="") as file:
    ATTRIBUTES = {  # unit and meaning of each variable
        name: (unit, meaning.format(largest_known=FREQUENCY.largest_known))
        for name, unit, meaning in islice(csv.reader(file), 1, None)
    }

STRAINS = (  # of the variables of unit 1 those that are told in units of strain
    "strain",
    "strain_axial",
    "strain_bending",
    "strain_quasi_static",
    "strain_error",
    "largest_strain",
    "strain_amplitude",
    "vibration_amplitude",
    "case_strain",
)


def with_units(scene: Scene, data: xr.Dataset) -> xr.Dataset:
    """Say of every variable what it means, in ``attrs["long_name"]``, and its unit, in ``attrs["units"]``."""
    units = _units(scene, [str(name) for name in data["law"].to_numpy()] if "law" in data else [])
    for name, (unit, meaning) in ATTRIBUTES.items():
        if name in data:
            data.variables[name].attrs.update(units=units.get(name, unit), long_name=meaning)
    data.variables["theta"].attrs.update(units="rad", long_name="drive angle")
    data.variables["time"].attrs.update(units="s", long_name="time")
    if "s" in data:
        data.variables["s"].attrs.update(
            units="1", long_name="place along the member, from its first to its second end"
        )
    return data


def _units(scene: Scene, laws: Sequence[str]) -> dict[str, str]:
    """Give the units of variables that hold forces or moments by the scene; one for each where these are mixed."""
    efforts = effort_units(scene.moved_joints, scene.joints)
    found = {"input_torque": efforts[:1], "input_torque_amplitude": efforts[:1]}
    found |= dict.fromkeys(("drive_effort", "drive_effort_error", "drive_effort_rms"), efforts)
    found["law_effort"] = found["largest_law_effort"] = [unit_of_law(scene, name) for name in laws]
    found["drive_impulse"] = [f"{unit} s" for unit in efforts]
    for name, parts in (("spring_force", scene.springs), ("damper_force", scene.dampers)):
        found[name] = ["N m" if isinstance(part, Hinge) else "N" for part in parts.values()]
    return {name: units[0] if len(set(units)) == 1 else ", ".join(units) for name, units in found.items() if units}


def unit_of_law(scene: Scene, name: str) -> str:
    """Give the unit of what a joint law exerts."""
    stated, _, driven = name.partition(":")
    law = scene.joint_laws[stated]
    slides = isinstance(scene.joints[driven or law.joint], Slot | Prismatic)
    return "N" if slides or isinstance(law, OPEN) else "N m"
