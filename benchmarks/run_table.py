"""Tables of measured runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import xarray as xr

from fenics_mech._files import write_frame
from fenics_mech.recovery.saved import Saved

FAILURE = {"failure": "kind of error that the run ended with", "message": "what it said"}


def labelled(
    rows: Sequence[Mapping[str, Any]], settings: Mapping[str, str], numbers: Mapping[str, tuple[str, str]]
) -> xr.Dataset:
    """Label what some runs gave."""
    data = xr.Dataset()
    for name, meaning in settings.items():
        column = np.array([row[name] for row in rows])
        data[name] = ("run", column.astype(object) if column.dtype.kind == "U" else column, {"long_name": meaning})
    for name, (unit, meaning) in numbers.items():
        column = np.array([row.get(name, np.nan) for row in rows])
        data[name] = ("run", column, {"units": unit, "long_name": meaning})
    return data


@dataclass(frozen=True)
class RunTable(Saved):
    """Measured runs."""

    KIND: ClassVar[str] = "table of runs"

    def to_csv(self, path: str | Path) -> Path:
        """Write the table, one run a line; the file appears whole or not at all."""
        table = self.data.to_dataframe()
        units = {str(name): variable.attrs.get("units", "1") for name, variable in self.data.data_vars.items()}
        table = table.rename(columns={name: f"{name} ({unit})" for name, unit in units.items() if unit != "1"})
        write_frame(Path(path), table)
        return Path(path)
