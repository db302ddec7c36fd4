"""The folder in which a study keeps its trials: one study at a time works in it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from fenics_mech._files import reason_of
from fenics_mech._system import alone_in
from fenics_mech.errors import ResultError


@contextmanager
def kept_folder(folder: str | Path | None) -> Iterator[Path]:
    """Give a folder in which no other study works meanwhile."""
    # The system lets it free with the process, however that ends.
    if folder is None:
        with TemporaryDirectory() as made:
            yield Path(made)
        return
    path = Path(folder)
    missing = [one for one in (path, *path.parents) if not one.exists()]
    try:
        path.mkdir(parents=True, exist_ok=True)
        os.scandir(path).close()  # who cannot read a folder cannot hold it against others
    except OSError as error:
        raise ResultError(f"{path}: cannot be used for trials: {reason_of(error)}") from error
    try:
        with alone_in(path) as alone:
            if not alone:
                said = f"{path}: another study works in this folder: wait for its end, or give another folder"
                raise ResultError(said)
            yield path
    finally:
        with suppress(OSError):  # one holds something
            for one in missing:
                one.rmdir()
