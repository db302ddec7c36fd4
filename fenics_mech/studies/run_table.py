"""Datasets that studies save and load, and tables of measured runs that are exported too."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Self

import xarray as xr

from fenics_mech.recovery.result import read_dataset, write_dataset, write_whole


@dataclass(frozen=True)
class Saved:
    """A dataset that saves and loads.

    Parameters
    ----------
    data
        The dataset; its attributes have the names in `NEEDED`.
    """

    KIND: ClassVar[str]
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech",)
    data: xr.Dataset

    def save(self, path: str | Path) -> Path:
        """Write as NetCDF 3, which has no times in it; the file appears whole or not at all.

        Raises
        ------
        ResultError
            When the file cannot be written.
        """
        write_dataset(Path(path), self.data, "scipy")
        return Path(path)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what was saved.

        Raises
        ------
        ResultError
            When the file cannot be read or holds something else.
        """
        return cls(read_dataset(path, "scipy", cls.KIND, cls.NEEDED))


@dataclass(frozen=True)
class RunTable(Saved):
    """Measured runs.

    Parameters
    ----------
    data
        Dimension "run"; units in ``attrs["units"]``.
    """

    KIND: ClassVar[str] = "table of runs"

    def to_csv(self, path: str | Path) -> Path:
        """Write the table, one run a line; the file appears whole or not at all.

        Raises
        ------
        ResultError
            When the file cannot be written.
        """
        table = self.data.to_dataframe()
        units = {str(name): variable.attrs.get("units", "1") for name, variable in self.data.data_vars.items()}
        table = table.rename(columns={name: f"{name} ({unit})" for name, unit in units.items() if unit != "1"})
        write_whole(Path(path), lambda temporary: table.to_csv(temporary, index=False))
        return Path(path)
