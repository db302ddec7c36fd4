"""Files of measured numbers: CSV with a header, and the measured strains that a scene names."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._files import read_bounded, reason_of
from fenics_mech.errors import SceneError

HINT = "Expected: a header line, then two columns, drive angle in degrees and strain"
LARGEST_FILE = 10_000_000  # bytes; half a million points
LARGEST_STRAIN = 0.2  # m/m; larger numbers are microstrain


def read_cells(path: Path, hint: str) -> tuple[list[str], dict[int, list[str]]]:
    """Read a CSV file with a header."""
    try:
        text = read_bounded(path, LARGEST_FILE).decode("utf-8-sig")
        lines = csv.reader(io.StringIO(text, newline=""))
        header = [cell.strip() for cell in next(lines, [])]
        if header and all(map(_is_number, header)):
            raise SceneError("the header line is missing", place=str(path), line=1, hint=hint)
        rows = dict(_filled(lines))
    except (UnicodeDecodeError, csv.Error) as error:
        raise SceneError("it is not a CSV text in UTF-8", place=str(path), hint=hint) from error
    except (OSError, ValueError) as error:
        reason = reason_of(error)
        raise SceneError(f"cannot read the measurements: {reason}", place=str(path), hint=hint) from error
    if not rows:
        raise SceneError("there are no measured points", place=str(path), hint=hint)
    return header, rows


def _filled(lines: Any) -> Iterator[tuple[int, list[str]]]:
    """Give the number and the cells of each line that is not empty; `lines` is a reader of CSV."""
    for cells in lines:
        if any(map(str.strip, cells)):
            yield lines.line_num, cells


def read_measurement(path: Path) -> tuple[Array, Array]:
    """Read a file of measured strains: a header, then drive angle (degrees) and strain in two columns."""
    # Gives drive angle (rad) and strain, both ``(points,)``.
    _, rows = read_cells(path, HINT)
    points = [finite_numbers(cells, 2, (path, line), HINT) for line, cells in rows.items()]
    angle, strain = np.array(points).T
    refuse_no_strain(strain, path, HINT)
    return np.radians(angle), strain


def refuse_no_strain(strain: Array, path: Path, hint: str) -> None:
    """Raise `SceneError` where numbers of a file are too large for strains."""
    if np.abs(strain).max() > LARGEST_STRAIN:
        raise SceneError(f"more than {LARGEST_STRAIN:g} is no strain", place=str(path), hint=f"{hint}, in m/m")


def _is_number(cell: str) -> bool:
    try:
        float(cell)
    except ValueError:
        return False
    return True


def finite_numbers(cells: list[str], count: int, place: tuple[Path, int], hint: str) -> list[float]:
    """Give so many finite numbers of a line."""
    try:
        numbers = [float(cell) for cell in cells]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        words = {2: "two", 3: "three"}.get(count, str(count))
        message = f"this line is not {words} finite numbers"
        raise SceneError(message, place=str(place[0]), line=place[1], hint=hint)
    return numbers
