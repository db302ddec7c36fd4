"""Peaks of joint forces, as a table."""

from __future__ import annotations

import numpy as np
from rich.markup import escape
from rich.table import Table

from fenics_mech._arrays import Array
from fenics_mech.recovery import Result
from fenics_mech.views.tables import number, table_of


def joint_table(result: Result) -> Table:
    """Tabulate the peak joint forces and, as the last row, the peak torque or force of the first drive.

    Parameters
    ----------
    result
        The result.
    """
    table = table_of("Peaks of the joint forces", "joint", "peak", "at angle")
    theta = degrees_of(result)
    forces = np.linalg.norm(values_of(result, "joint_force", "theta", "joint", "component"), axis=-1)
    for joint, force in zip(result.data["joint"].to_numpy(), forces.T):
        (k,) = peak_of(force)
        table.add_row(escape(str(joint)), f"{number(force[k])} N", f"{theta[k]:.4g}\N{DEGREE SIGN}")
    if "input_torque" not in result.data:
        return table
    torque = result.data["input_torque"].to_numpy()
    (k,) = peak_of(torque)
    unit = str(result.data["input_torque"].attrs["units"])
    what = "drive force" if unit == "N" else "input torque"
    table.add_row(what, f"{number(torque[k])} {unit}", f"{theta[k]:.4g}\N{DEGREE SIGN}")
    return table


def values_of(result: Result, name: str, *dimensions: str) -> Array:
    """Give a variable of a result with its dimensions in an order.

    Parameters
    ----------
    result
        The result.
    name
        Of the variable.
    dimensions
        Their order.
    """
    return result.data[name].transpose(*dimensions).to_numpy()


def degrees_of(result: Result) -> Array:
    """Drive angles of a result in degrees, 0 to 360, ``(angles,)``.

    Parameters
    ----------
    result
        The result.
    """
    return np.degrees(result.data["theta"].to_numpy()) % 360


def peak_of(values: Array) -> tuple[int, ...]:
    """Index of the value of largest magnitude.

    Parameters
    ----------
    values
        Any array.
    """
    return tuple(int(i) for i in np.unravel_index(np.abs(values).argmax(), values.shape))
