"""All curves and tables of a result as one file for spreadsheets (.xlsx): a sheet for each group."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._constants import TINY
from fenics_mech._files import FORMULA, write_whole
from fenics_mech.errors import ResultError, ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.exports import KIND_OF
from fenics_mech.recovery.variables import ATTRIBUTES, STRAINS
from fenics_mech.scene import Prismatic, Slot
from fenics_mech.views.case_tables import case_sheets
from fenics_mech.views.judgements import SOURCES, headline, judgements, verdict
from fenics_mech.views.reading import SECTION_FORCES, ForceReading, Reading, reading_of, reading_of_a_file
from fenics_mech.views.safety_words import safety_sentences

Row = Sequence[str | float]
INSTALL = "an .xlsx needs the library openpyxl, which is not installed: pip install 'fenics_mech[tables]'"
MOST_CELLS = 5_000_000  # which openpyxl takes half a minute to write; a sheet of the format has 1 048 576 rows
MOST_COLUMNS = 16_384  # of a sheet of the format
WIDEST = 60  # letters of a column
GROUPS = {  # sheets of curves that are of no places along members, by the dimension that they have
    "joint": "joint curves",
    "support": "joint curves",
    "mode": "frequency curves",
    "member": "member curves",
    "link": "link curves",
    "point": "point curves",
    "freedom": "freedom curves",
}
OTHER = "drive and frame curves"
MIXED = {"indentation": "m or rad"}  # unit of a variable that is one or the other
PARTS = {"component": "{}", "s": "s = {:g}"}  # how a place along a dimension is named; others by their name


@dataclass(frozen=True)
class Sheet:
    """A table."""

    name: str  # name of the sheet
    head: tuple[str, ...]  # heads of its columns, with their units
    rows: Iterable[Row]  # its rows


def write_workbook(result: Result, path: str | Path, every: int = 1) -> Path:
    """Write all curves and tables of a result as one file for spreadsheets.

    Its sheets are the summary, the peaks of members and joints, frequencies and errors, and the curves over the drive
    angle and time by groups. Numbers are in the units of the result, as its summary and its report tell them. There are
    no formulas: names that begin like one are texts.

    Parameters
    ----------
    result
        The result; `Result.told_in` gives one in other units.
    path
        File to write, ending in .xlsx.
    every
        Of how many positions one is written.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ViewError
        When the ending is another, openpyxl is not installed, or the curves are too many for a sheet.
    ResultError
        When the result lacks what is told, or the file cannot be written.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> fm.write_workbook(result, "out/result.xlsx").name  # doctest: +SKIP
    'result.xlsx'
    """
    path = Path(path)
    if path.suffix.lower() != ".xlsx":
        raise ViewError(f"{path}: a file for spreadsheets must end in .xlsx, not in {path.suffix!r}")
    if every < 1:
        raise ResultError(f"every position that is written is one of {every}: it must be 1 or more")
    with reading_of_a_file():
        sheets = sheets_of(result, every)
    book = _book(sheets)
    write_whole(path, book.save)
    return path


def sheets_of(result: Result, every: int = 1) -> list[Sheet]:
    """Give the sheets of a result."""
    reading, data = reading_of(result), result.data.isel(theta=slice(None, None, every))
    tables = [Sheet("summary", ("", ""), _summary(reading))]
    if result.cases:
        tables += [Sheet(*table) for table in case_sheets(reading)]
    if isinstance(reading, Reading):
        tables.append(_members(reading))
    if reading.joints:
        tables.append(_joints(reading))
    if "frequency" in data:
        tables.append(_frequencies(result.data))
    if isinstance(reading, Reading) and "strain_error" in data:
        tables.append(_errors(reading))
    curves: dict[str, list[str]] = {}
    for name in filter(ATTRIBUTES.__contains__, map(str, data.data_vars)):
        if "theta" in (dims := data[name].dims) and data[name].dtype.kind in "fi":
            sheet = next((sheet for dimension, sheet in GROUPS.items() if dimension in dims), OTHER)
            curves.setdefault(name.replace("_", " ") if "s" in dims else sheet, []).append(name)
    _refuse_too_large(data, curves)
    return [*tables, *(_curves(reading, data, *group) for group in curves.items()), _values(reading, data)]


def _refuse_too_large(data: xr.Dataset, curves: dict[str, list[str]]) -> None:
    """Raise `ViewError` where sheets have too many columns, or all of them too many cells."""
    count = data.sizes["theta"]
    columns = {sheet: sum(data[name].size // count for name in names) + 2 for sheet, names in curves.items()}
    for sheet, wide in columns.items():
        if wide > MOST_COLUMNS:
            raise ViewError(
                f"the sheet {sheet!r} needs {wide} columns, and a file for spreadsheets has {MOST_COLUMNS} at most: "
                "write single variables as .csv"
            )
    if (cells := count * sum(columns.values())) > MOST_CELLS:
        raise ViewError(
            f"the curves have {cells} numbers at {count} positions, and a file for spreadsheets takes {MOST_CELLS}: "
            f"write one position of {-(-cells // MOST_CELLS)} with --every, or single variables as .csv"
        )


def _summary(reading: ForceReading) -> Iterator[Row]:
    """Tell the machine, the verdict and why, and what the other sheets are."""
    result = reading.result
    judged = judgements(result)
    yield "machine", reading.scene.name
    if result.cases:
        yield "load case", f"{result.case}, which governs of {', '.join(result.cases)}; curves are of it"
    if isinstance(reading, Reading):
        yield "safety", " ".join(safety_sentences(result, reading.units)[1])
    yield "driven", reading.driven()
    yield "found", " ".join(headline(reading))
    yield "verdict", verdict(judged)[1]
    yield from ((one.title, one.text) for one in judged)
    yield from (("warning", text) for text in result.warnings)
    yield from (("assumed", text) for text in result.notices)
    kinds = "stress", "strain", "length", "force", "moment"
    yield "units", ", ".join(reading.units.label(kind) for kind in kinds) + "; what these do not measure is in SI"
    yield "peaks", "Peaks of members and joints are sought between the positions too; curves are at the positions."
    yield "version", f"fenics_mech {result.data.attrs['fenics_mech']}"


def _at(reading: ForceReading) -> tuple[str, Array]:
    """Head and values of what the positions are along: the drive angle in its turn (degrees), or time (s)."""
    if reading.in_time:
        return "time (s)", reading.data["time"].to_numpy()
    return "drive angle (deg)", np.degrees(np.mod(np.round(reading.theta, 12), 2 * np.pi))


def _members(reading: Reading) -> Sheet:
    """Tabulate the peaks of the members, the most stressed first."""
    (at, places), units, data = _at(reading), reading.units, reading.result.data
    stress, strain, length = (units.label(kind) for kind in ("stress", "strain", "length"))
    head = ["member", f"peak stress ({stress})", f"strain there ({strain})", f"distance ({length})", "from", "side", at]
    more: dict[str, Any] = {}
    if "stress_range" in data:
        more[f"stress range ({stress})"] = data["stress_range"].max(("s", "fibre")).to_numpy() / units.size("stress")
    if "utilisation" in data:
        more["share of strength (%)"] = 100 * data["utilisation"].to_numpy()
    for name, (words, kind) in SECTION_FORCES.items():
        if name in data:
            most, least = (getattr(reading.section_force(name), of)(axis=(0, 2)) for of in ("max", "min"))
            more[f"largest {words} ({units.label(kind)})"] = np.where(most >= -least, most, least)
    if "strain_error" in data:
        more["error of strain (%)"] = 100 * _error_shares(reading).sum(axis=1)
    head += [f"largest deflection ({length})", f"its distance ({length})", f"its {at}", *more]
    rows = []
    for i in reading.ranked:
        (k, _, j, f), bent = reading.peaks[i], reading.peak(reading.bent, i)
        long = reading.lengths[i] / units.size("length")
        row = [reading.members[i], reading.stress[k, i, j, f], reading.strain[k, i, j, f], reading.s[j] * long]
        row += [reading.ends[i][0], reading.fibres[f], places[k]]
        row += [reading.bent[bent], reading.s[bent.j] * long, places[bent.k]]
        rows.append([*row, *(column[i] for column in more.values())])
    return Sheet("members", tuple(head), rows)


def _joints(reading: ForceReading) -> Sheet:
    """Tabulate the largest force of each joint, and that on the frame."""
    (at, places), unit = _at(reading), reading.units.label("force")
    force = reading.of("joint_force", "joint", "component") / reading.units.size("force")
    curves = dict(zip(reading.joints, np.moveaxis(force, 1, 0)))
    shaking = [] if reading.shaking is None else [("on the frame", reading.shaking[0])]
    rows = []
    for name, curve in [*curves.items(), *shaking]:
        size = np.linalg.norm(curve, axis=-1)
        k = int(size.argmax())
        rows.append([name, size[k], *curve[k], places[k]])
    return Sheet("joints", ("joint", f"largest force ({unit})", f"in x ({unit})", f"in y ({unit})", at), rows)


def _frequencies(data: xr.Dataset) -> Sheet:
    """Tabulate the range of each natural frequency."""
    frequency = data["frequency"].transpose("theta", "mode").to_numpy()
    wrong = 100 * data["frequency_error"].to_numpy()
    rows = zip(data["mode"].to_numpy(), frequency.min(axis=0), frequency.max(axis=0), wrong)
    return Sheet("frequencies", ("mode", "lowest (Hz)", "highest (Hz)", "error by the mesh (%)"), rows)


def _error_shares(reading: Reading) -> Array:
    """Errors of the members' strains by source, over their largest strain, ``(members, sources)``."""
    data = reading.result.data
    wrong = data["strain_error"].transpose("member", "source").to_numpy()
    return np.asarray(wrong / np.maximum(data["largest_strain"].to_numpy(), TINY)[:, None])


def _errors(reading: Reading) -> Sheet:
    """Tabulate the estimated errors of the members' strains by their sources."""
    sources = [str(source) for source in reading.result.data["source"].to_numpy()]
    shares = 100 * _error_shares(reading)
    head = ("error of the strain of", *(f"{SOURCES.get(source, source)} (%)" for source in sources), "in all (%)")
    return Sheet("errors", head, [[name, *row, row.sum()] for name, row in zip(reading.members, shares)])


def _curves(reading: ForceReading, data: xr.Dataset, sheet: str, names: Sequence[str]) -> Sheet:
    """Give variables over the positions, a column for each place or name that they have."""
    head, columns = ["time (s)"], [data["time"].to_numpy()[:, None]]
    if reading.scene.drives:
        head, columns = ["drive angle (deg)", *head], [np.degrees(data["theta"].to_numpy())[:, None], *columns]
    for name in names:
        others = [str(dimension) for dimension in data[name].dims if dimension != "theta"]
        values = data[name].transpose("theta", *others).to_numpy().reshape(data.sizes["theta"], -1)
        unit, size = _units(reading, data[name])
        labels = [", ".join(filter(None, [name.replace("_", " "), *label])) for label in _labels(data[name], others)]
        head += [one if of == "1" else f"{one} ({of})" for one, of in zip(labels, np.resize(unit, len(labels)))]
        columns.append(values / size)
    return Sheet(sheet, tuple(head), np.concatenate(columns, axis=1))


def _labels(values: xr.DataArray, dimensions: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Name every place along some dimensions, the last of which varies first."""
    names = [
        [PARTS.get(dimension, "{}").format(at) for at in values[dimension].to_numpy()]
        if dimension in values.coords
        else [str(number + 1) for number in range(values.sizes[dimension])]
        for dimension in dimensions
    ]
    return product(*names)


def _units(reading: ForceReading, values: xr.DataArray) -> tuple[list[str], Array]:
    """Units in which a variable is told, one for all or one for each column, and their sizes in SI."""
    name = str(values.name)
    in_si = MIXED.get(name, str(values.attrs.get("units", "1")))
    units = in_si.split(", ")  # of drives, springs and the like that differ: one for each
    if "freedom" in values.dims and in_si.startswith("rad"):
        slides = [isinstance(reading.scene.joints[str(one)], Slot | Prismatic) for one in values["freedom"].to_numpy()]
        units = [in_si.replace("rad", "m") if slide else in_si for slide in slides]
    kinds = ["strain" if name in STRAINS else KIND_OF.get(unit, "") for unit in units]
    sizes = np.array([reading.units.size(kind) if kind else 1.0 for kind in kinds])
    labels = [reading.units.label(kind) if kind else unit for kind, unit in zip(kinds, units)]
    return labels, sizes if len(kinds) > 1 else sizes[0]


def _values(reading: ForceReading, data: xr.Dataset) -> Sheet:
    """Give all numbers that are not over the positions, one a row, with what they are of."""
    rows: list[Row] = []
    for name in filter(ATTRIBUTES.__contains__, map(str, data.data_vars)):
        values = data[name]
        if "theta" in values.dims or values.dtype.kind not in "fi" or name == "state":
            continue
        unit, size = _units(reading, values)
        told = np.atleast_1d(values.to_numpy()).ravel() / size
        labels = _labels(values, [str(dimension) for dimension in values.dims])
        for label, value, one in zip(labels, told, np.resize(unit, len(told))):
            rows.append((name.replace("_", " "), ", ".join(label), float(value), "" if one == "1" else str(one)))
    return Sheet("values", ("value", "of", "number", "unit"), rows)


def _book(sheets: Sequence[Sheet]) -> Any:
    """Make the file's content in openpyxl."""
    try:
        from openpyxl import Workbook  # noqa: PLC0415  (an extra that few need)
    except ImportError as error:
        raise ViewError(INSTALL) from error
    book = Workbook(write_only=True)
    for table in sheets:
        sheet = book.create_sheet(table.name)
        sheet.freeze_panes = "B2"
        for n, text in enumerate(table.head[:2]):
            sheet.column_dimensions["AB"[n]].width = min(WIDEST, max(18, len(text) + 2))
        if any(table.head):
            sheet.append([_text(sheet, text, bold=True) for text in table.head])
        for row in table.rows:
            cells = (_text(sheet, cell) if isinstance(cell, str) else float(cell) for cell in row)
            sheet.append([None if isinstance(cell, float) and not isfinite(cell) else cell for cell in cells])
    return book


def _text(sheet: Any, text: str, bold: bool = False) -> Any:
    """Give a cell that holds a text, whatever it begins with; what no file can hold is replaced."""
    from openpyxl.cell import WriteOnlyCell  # noqa: PLC0415
    from openpyxl.cell.cell import ILLEGAL_CHARACTERS_RE  # noqa: PLC0415
    from openpyxl.styles import Font  # noqa: PLC0415

    cell = WriteOnlyCell(sheet, ILLEGAL_CHARACTERS_RE.sub("\N{REPLACEMENT CHARACTER}", text))
    cell.data_type = "s"  # openpyxl takes what begins with "=" for a formula
    if text[:1] in tuple(FORMULA):
        cell.quotePrefix = True  # so that no spreadsheet makes it one where the cell is edited
    if bold:
        cell.font = Font(bold=True)
    return cell
