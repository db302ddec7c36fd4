"""Reading files that others have made, ordinary ones of a bounded size only, and writing files as a whole."""

from __future__ import annotations

import csv
import io
import logging
import os
import stat
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from fenics_mech._system import READ
from fenics_mech.errors import ResultError

logger = logging.getLogger(__name__)
FORMULA = "=+-@\t\r"  # how a formula begins


def read_bounded(path: Path, largest: int) -> bytes:
    """Read an ordinary file of at most so many bytes; pipes and devices may never end."""
    handle = os.open(path, READ)
    with open(handle, "rb") as file:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise ValueError("it is not an ordinary file")
        if found.st_size > largest:
            raise ValueError(f"it has {found.st_size} bytes, and at most {largest} are expected")
        content = file.read(largest + 1)  # files of the system have no size, and others may grow meanwhile
    if len(content) > largest:
        raise ValueError(f"it has more than {largest} bytes")
    return content


def reason_of(error: OSError | ValueError) -> str:
    """Say why a file cannot be read or written."""
    return (isinstance(error, OSError) and error.strerror) or str(error)


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Let `write` fill a temporary file beside `path`, then put it in its place."""
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
    except OSError as error:
        raise ResultError(f"{path}: cannot be written: {error.strerror}") from error
    os.close(handle)
    temporary = Path(name)
    try:
        write(temporary)
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(path)
        logger.info("wrote %s", path)
    except OSError as error:
        raise ResultError(f"{path}: cannot be written: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def plain_cell(cell: object) -> object:
    """Give a cell of a table, marked as a text where it begins like a formula, which spreadsheets would compute."""
    # Numbers stay as they are, and so do the marks "+" and "-" by themselves.
    return f"'{cell}" if isinstance(cell, str) and len(cell) > 1 and cell[0] in FORMULA and not _number(cell) else cell


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    """Give rows as the text of a CSV file, whose texts are no formulas."""
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerows(map(plain_cell, row) for row in rows)
    return text.getvalue()


def write_table(path: Path, rows: Sequence[Sequence[object]]) -> None:
    """Write a CSV file as a whole."""
    text = csv_text(rows)
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def write_frame(path: Path, table: Any) -> None:
    """Write a table of pandas as a CSV file as a whole, without its index."""
    columns = {name: column.map(plain_cell) for name, column in table.items() if column.dtype.kind == "O"}
    plain = table.assign(**columns).rename(columns=plain_cell)
    write_whole(path, lambda temporary: plain.to_csv(temporary, index=False))
