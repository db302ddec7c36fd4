"""What was measured: curves over the drive angle and single numbers, from CSV files or the measurements of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.recovery.measured import finite_numbers, read_cells, read_measurement, refuse_no_strain
from fenics_mech.scene import Scene
from fenics_mech.studies.design.result_curves import Curve, ResultNumbers
from fenics_mech.studies.design.result_numbers import Quantity

ANGLE = "angle_deg"
NUMBERS = ["number", "value", "deviation"]
FORM = (
    f"Write curves with the header {ANGLE},NAME,NAME... such as {ANGLE},strain[coupler][@0.5][+], "
    f"or single numbers with the header {','.join(NUMBERS)} and lines such as frequency[1].mean,43.7,0.5"
)


@dataclass(frozen=True)
class Observation:
    """Measured values of a curve or of a number.

    Parameters
    ----------
    of
        What was measured.
    values
        Measured values in SI, ``(points,)``.
    deviation
        Standard deviation of their noise; NaN where it is to be estimated.

    Examples
    --------
    >>> fm.Observation.number("frequency[1].mean", 43.7, 0.5).of.unit
    'Hz'
    """

    of: ResultNumbers
    values: Array
    deviation: float = np.nan

    @classmethod
    def curve(cls, name: str, angles: Sequence[float], values: Sequence[float]) -> Observation:
        """State a measured curve, whose noise is estimated.

        Parameters
        ----------
        name
            Its name, as "strain[coupler][@0.5][+]".
        angles
            Drive angles (rad), ``(points,)``.
        values
            Measured values in SI, ``(points,)``.

        Raises
        ------
        SceneError
            When there is no such curve.
        """
        return cls(Curve.read(name, np.asarray(angles, dtype=float)), np.asarray(values, dtype=float))

    @classmethod
    def number(cls, name: str, value: float, deviation: float) -> Observation:
        """State a measured number.

        Parameters
        ----------
        name
            Its name, as "frequency[1].mean".
        value, deviation
            Its value and standard deviation in SI.

        Raises
        ------
        SceneError
            When there is no such number, or the deviation is not positive.
        """
        if not deviation > 0:
            raise SceneError(f"the deviation {deviation:g} of {name!r} is not above 0", place="identify")
        return cls(Quantity.read(name), np.array([float(value)]), float(deviation))


def read_observations(path: Path) -> list[Observation]:
    """Read a CSV file of measured curves or numbers.

    Parameters
    ----------
    path
        The file. Its header is "angle_deg" and names of curves, or "number,value,deviation".

    Raises
    ------
    SceneError
        When it cannot be read.
    """
    header, rows = read_cells(path, FORM)
    if [cell.lower() for cell in header] == NUMBERS:
        return [_number(cells, path, line) for line, cells in rows.items()]
    if len(header) < 2 or header[0].lower() != ANGLE:
        raise SceneError("the header is not one of measured data", place=str(path), line=1, hint=FORM)
    table = np.array([finite_numbers(cells, len(header), (path, line), FORM) for line, cells in rows.items()])
    found = []
    for name, values in zip(header[1:], table[:, 1:].T):
        try:
            found.append(Observation.curve(name, np.radians(table[:, 0]).tolist(), values.tolist()))
        except SceneError as error:
            raise SceneError(error.message, place=str(path), line=1, hint=error.hint) from None
        if name.startswith("strain"):
            refuse_no_strain(values, path, "Write strains")
    return found


def _number(cells: list[str], path: Path, line: int) -> Observation:
    """Read a line of a measured number."""
    value, deviation = finite_numbers(cells[1:], 2, (path, line), FORM)
    try:
        return Observation.number(cells[0].strip(), value, deviation)
    except SceneError as error:
        raise SceneError(error.message, place=str(path), line=line, hint=error.hint) from None


def stated_observations(scene: Scene) -> list[Observation]:
    """Read the files of the measurements that a scene states.

    Parameters
    ----------
    scene
        The scene.

    Raises
    ------
    SceneError
        When there are none, or one cannot be read.
    """
    found = []
    for one in scene.measurements:
        angle, strain = read_measurement(one.file)
        found.append(
            Observation.curve(f"strain[{one.member}][@{one.s:g}][{one.fibre}]", angle.tolist(), strain.tolist())
        )
    if not found:
        hint = "Name a CSV file of measured data, or state [[measurements]] in the scene"
        raise SceneError("there are no measured data", place="identify", hint=hint)
    return found
