"""Tables of measured runs."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from fenics_mech.recovery.result import Saved, write_whole


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
