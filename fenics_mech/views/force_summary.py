"""What a summary tells of forces: peaks of the joints, of the drive and of the frame, and the figures of the drive."""

from __future__ import annotations

import numpy as np
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech._arrays import Array
from fenics_mech._constants import ROUNDING
from fenics_mech.errors import percent
from fenics_mech.recovery import Result
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.views.prefixes import least_moment
from fenics_mech.views.tables import number, table_of
from fenics_mech.views.words import sentence

ON_FRAME = "shaking: total on the frame; the moment is about the ground's origin"


def joints_table(result: Result, units: AnswerUnits, force: float = 0.0) -> Table:
    """Tabulate the peaks of the joint forces, the torque or force of the first drive, and the total on the frame."""
    # force: largest force in the links (N), beside which joints may have none but rounding
    data = result.data
    table = table_of("Peaks of the joint forces", "joint", "peak", at_head(result))
    forces = np.linalg.norm(values_of(result, "joint_force", "theta", "joint", "component"), axis=-1)
    peaks = [(escape(str(joint)), force, "force") for joint, force in zip(data["joint"].to_numpy(), forces.T)]
    if "input_torque" in data and (result.scene.drives or data["input_torque"].any()):
        name, kind = effort_of(result)
        peaks.append((name, data["input_torque"].to_numpy(), kind))
    if "shaking_force" in data:
        total = np.linalg.norm(values_of(result, "shaking_force", "theta", "component"), axis=-1)
        peaks += [("shaking force", total, "force"), ("shaking moment", data["shaking_moment"].to_numpy(), "moment")]
        table.caption = f"{ON_FRAME}\n"
    largest = max([force, *(float(np.abs(curve).max()) for _, curve, _ in peaks)])
    for name, curve, kind in peaks:
        (k,) = peak_of(curve)
        nothing = abs(curve[k]) < ROUNDING * largest
        table.add_row(name, shown(0.0 if nothing else curve[k], kind, units), "" if nothing else at(result, k))
    return table


def shown(value: float, kind: str, units: AnswerUnits) -> str:
    """Write a value in SI with its unit."""
    return f"{number(units.number(value, kind))} {units.label(kind)}"


def effort_of(result: Result) -> tuple[str, str]:
    """Name what the first drive gives, or the effort in the first freedom, and its kind of unit."""
    slides = str(result.data["input_torque"].attrs["units"]) == "N"
    if not result.scene.drives:
        return "effort", "force" if slides else "moment"
    return ("drive force", "force") if slides else ("input torque", "moment")


def drive_lines(result: Result, units: AnswerUnits) -> list[Text]:
    """Tell the root mean square of the first drive's effort, and the fluctuation of the energy that all drives give."""
    data = result.data
    if "drive_effort_rms" not in data or float(data["drive_effort_rms"].max()) <= least_moment(result):
        return []
    name, kind = effort_of(result)
    text = f"{sentence(name)}: {shown(float(data['drive_effort_rms'][0]), kind, units)} root mean square"
    text += f"; the energy given fluctuates by {number(data.attrs['energy_fluctuation'])} J over the cycle"
    if "speed_fluctuation" in data.attrs:
        text += f", and the speed of the crank by {percent(data.attrs['speed_fluctuation'])} of its mean"
    return [Text(f"{text}.")]


def values_of(result: Result, name: str, *dimensions: str) -> Array:
    """Give the values of a variable with its dimensions in an order."""
    return np.asarray(result.data[name].transpose(*dimensions).to_numpy())


def degrees_of(result: Result) -> Array:
    """Drive angles of a result, 0 to below 360 (deg), ``(angles,)``."""
    return np.degrees(result.data["theta"].to_numpy()) % 360


def at_head(result: Result) -> str:
    """Head of a column of drive angles, or of times of a motion in time."""
    return "at time" if result.scene.analysis.method == "transient" else "at angle"


def at(result: Result, k: int) -> str:
    """Write the drive angle of a position to a degree, or its time in a motion in time."""
    if result.scene.analysis.method == "transient":
        return f"{float(result.data['time'][k]):.4g} s"
    angles = degrees_of(result)
    return f"{angles[k] if len(angles) == 1 else round(angles[k]) % 360:.4g}\N{DEGREE SIGN}"


def peak_of(curves: Array) -> tuple[int, ...]:
    """Index of the value of largest magnitude."""
    return tuple(int(i) for i in np.unravel_index(np.abs(curves).argmax(), curves.shape))
