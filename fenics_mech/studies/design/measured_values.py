"""What was measured: curves over the drive angle and single numbers, from CSV files or the measurements of a scene."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.recovery.measured import finite_numbers, read_cells, read_measurement, refuse_no_strain
from fenics_mech.scene import Scene
from fenics_mech.studies.design.result_numbers import Curve, Quantity

ANGLE = "angle_deg"
NUMBERS = ["number", "value", "deviation"]
HUGE = 1e100  # a measured value in SI
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
    at
        Numbers of the scene that they were measured at, in SI, by dotted path; others are those of the scene.

    Examples
    --------
    >>> fm.Observation.number("frequency[1].mean", 43.7, 0.5).of.unit
    'Hz'
    """

    of: Quantity
    values: Array
    deviation: float = np.nan
    at: Mapping[str, float] = field(default_factory=dict)

    @property
    def text(self) -> str:
        """Its name, with what it was measured at."""
        where = ", ".join(f"{path} = {value:.6g}" for path, value in self.at.items())
        return f"{self.of.text} at {where}" if where else self.of.text

    @classmethod
    def curve(
        cls, name: str, angles: Sequence[float], values: Sequence[float], at: Mapping[str, float] | None = None
    ) -> Observation:
        """State a measured curve, whose noise is estimated.

        Parameters
        ----------
        name
            Its name, as "strain[coupler][@0.5][+]".
        angles
            Drive angles (rad), ``(points,)``.
        values
            Measured values in SI, ``(points,)``.
        at
            As of the class, such as ``{"drive.speed": 20.0}``.

        Raises
        ------
        SceneError
            When there is no such curve, or a value is out of all range.
        """
        found = np.asarray(values, dtype=float)
        _refuse_huge(name, found)
        return cls(Curve.at(name, np.asarray(angles, dtype=float)), found, at=dict(at or {}))

    @classmethod
    def number(cls, name: str, value: float, deviation: float, at: Mapping[str, float] | None = None) -> Observation:
        """State a measured number.

        Parameters
        ----------
        name
            Its name, as "frequency[1].mean".
        value, deviation
            Its value and standard deviation in SI.
        at
            As of the class.

        Raises
        ------
        SceneError
            When there is no such number, the deviation is not positive, or the value is out of all range.
        """
        _refuse_huge(name, np.array([value, deviation]))
        if not deviation > 0:
            raise SceneError(f"the deviation {deviation:g} of {name!r} is not above 0", place="identify")
        return cls(Quantity.read(name), np.array([float(value)]), float(deviation), dict(at or {}))


def read_observations(path: Path) -> list[Observation]:
    """Read a CSV file of measured curves or numbers."""
    header, rows = read_cells(path, FORM)
    names = [cell.lower() for cell in header]
    first = next((k for k, name in enumerate(names) if name in (ANGLE, NUMBERS[0])), len(names))
    curves = names[first : first + 1] == [ANGLE] and len(names) > first + 1
    if twice := next((name for name in header if header.count(name) > 1), ""):
        raise SceneError(f"the column {twice!r} is there twice", place=str(path), line=1, hint="Leave one of them out")
    if not curves and names[first:] != NUMBERS:
        raise SceneError("the header is not one of measured data", place=str(path), line=1, hint=FORM)
    found = []
    for at, lines in _by_place(header[:first], rows, path).items():
        where = dict(zip(header, at))
        if curves:
            found += _curves(header[first:], {line: rows[line][first:] for line in lines}, path, where)
        else:
            found += [_number(rows[line][first:], path, line, where) for line in lines]
    return found


def _by_place(paths: list[str], rows: dict[int, list[str]], path: Path) -> dict[tuple[float, ...], list[int]]:
    """Give the lines of a file by the numbers of the scene that they were measured at."""
    found: dict[tuple[float, ...], list[int]] = {}
    for line, cells in rows.items():
        at = finite_numbers(cells[: len(paths)], len(paths), (path, line), FORM)
        found.setdefault(tuple(at), []).append(line)
    return found


def _curves(header: list[str], rows: dict[int, list[str]], path: Path, at: dict[str, float]) -> list[Observation]:
    """Read the curves of a table."""
    table = np.array([finite_numbers(cells, len(header), (path, line), FORM) for line, cells in rows.items()])
    if len(table) > 1 and np.ptp(table[:, 0]) == 0:
        message = f"all angles of this curve are {table[0, 0]:g} deg"
        raise SceneError(message, place=str(path), line=next(iter(rows)), hint="Write the drive's angle in degrees")
    found = []
    for name, values in zip(header[1:], table[:, 1:].T):
        with _in_line(path, 1):
            found.append(Observation.curve(name, np.radians(table[:, 0]).tolist(), values.tolist(), at))
        if name.startswith("strain"):
            refuse_no_strain(values, path, "Write strains")
    return found


def _number(cells: list[str], path: Path, line: int, at: dict[str, float]) -> Observation:
    """Read a line of a measured number."""
    value, deviation = finite_numbers(cells[1:], 2, (path, line), FORM)
    with _in_line(path, line):
        return Observation.number(cells[0].strip(), value, deviation, at)


@contextmanager
def _in_line(path: Path, line: int) -> Iterator[None]:
    """Let errors name a line of a file."""
    try:
        yield
    except SceneError as error:
        raise SceneError(error.message, place=str(path), line=line, hint=error.hint) from None


def _refuse_huge(name: str, values: Array) -> None:
    """Raise `SceneError` where the square of a value would be no number."""
    if (np.abs(values) > HUGE).any():
        worst = values[int(np.abs(values).argmax())]
        raise SceneError(
            f"the value {worst:g} of {name!r} is out of all range", place="identify", hint="Write SI units"
        )


def stated_observations(scene: Scene) -> list[Observation]:
    """Read the files of the measurements that a scene states."""
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
