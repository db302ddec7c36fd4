"""Parts that the summaries of results have in common: peaks of joint forces, and how a scene is damped."""

from __future__ import annotations

import numpy as np
from rich.markup import escape
from rich.table import Table

from fenics_mech._arrays import Array
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
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


def damping_of(scene: Scene) -> str:
    """Tell how the scene is damped.

    Parameters
    ----------
    scene
        The scene.
    """
    damping = scene.damping
    ratios = damping.ratio if isinstance(damping.ratio, tuple) else (damping.ratio,)
    modal = ", ".join(f"{100 * value:.4g} %" for value in ratios)
    parts = (
        [f"{modal} of critical in {'each mode' if len(ratios) == 1 else 'the modes in turn'}"] if any(ratios) else []
    )
    parts += [f"material with a retardation time of {damping.material:.4g} s"] if damping.material else []
    parts += [f"drag {damping.external:.4g} 1/s on the absolute velocity"] if damping.external else []
    parts += [f"drag {damping.relative:.4g} 1/s on the velocity relative to the links"] if damping.relative else []
    if (air := damping.air) is not None:
        parts += [f"air of {air.density:.4g} kg/m^3 with a drag coefficient of {air.coefficient:.4g}"]
    return ", ".join(parts) or "none"
