"""Measured strains that a scene names."""

from __future__ import annotations

import csv
import io
import math
from pathlib import Path

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._files import read_bounded, reason_of
from fenics_mech.errors import SceneError

HINT = "Expected: a header line, then two columns, drive angle in degrees and strain"
LARGEST_FILE = 10_000_000  # bytes; half a million points
LARGEST_STRAIN = 0.2  # m/m; larger numbers are microstrain


def read_measurement(path: Path) -> tuple[Array, Array]:
    """Read a file of measured strains: a header, then drive angle (degrees) and strain in two columns.

    Returns
    -------
    tuple
        Drive angle (rad) and strain, both ``(points,)``.

    Raises
    ------
    SceneError
        When the file cannot be read or a line of it is not two finite numbers. The line's number is named, and not what
        it holds: a scene from a stranger may name any file.
    """
    points = []
    try:
        text = read_bounded(path, LARGEST_FILE).decode("utf-8-sig")
        lines = csv.reader(io.StringIO(text, newline=""))
        header = next(lines, [])
        if len(header) == 2 and all(map(_is_number, header)):
            raise SceneError("the header line is missing", place=str(path), line=1, hint=HINT)
        points = [_numbers(cells, path, lines.line_num) for cells in lines if any(map(str.strip, cells))]
    except (UnicodeDecodeError, csv.Error) as error:
        raise SceneError("it is not a CSV text in UTF-8", place=str(path), hint=HINT) from error
    except (OSError, ValueError) as error:
        reason = reason_of(error)
        raise SceneError(f"cannot read the measurements: {reason}", place=str(path), hint=HINT) from error
    if not points:
        raise SceneError("there are no measured points", place=str(path), hint=HINT)
    angle, strain = np.array(points).T
    if np.abs(strain).max() > LARGEST_STRAIN:
        raise SceneError(f"more than {LARGEST_STRAIN:g} is no strain", place=str(path), hint=f"{HINT}, in m/m")
    return np.radians(angle), strain


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def _numbers(cells: list[str], path: Path, line: int) -> list[float]:
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        numbers = []
    if len(numbers) != 2 or not all(map(math.isfinite, numbers)):
        raise SceneError("this line is not two finite numbers", place=str(path), line=line, hint=HINT)
    return numbers
