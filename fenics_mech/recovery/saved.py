"""Datasets that are saved with a seal, by which damage is found when they are loaded."""

from __future__ import annotations

import hashlib
import io
import json
import logging
import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np
import xarray as xr
from pydantic import TypeAdapter, ValidationError
from typing_extensions import TypedDict

from fenics_mech._files import read_bounded, reason_of, write_whole
from fenics_mech._guard import memory
from fenics_mech._read_back import STRICT, NotNegative, refuse_strange
from fenics_mech.errors import ResultError, StrangeError, shortened

logger = logging.getLogger(__name__)
SEAL = b"fenics_mech sha256 "
SEAL_LENGTH = len(SEAL) + 64
HDF5 = b"\x89HDF"  # how files of NetCDF 4 begin
UNWRITABLE = (KeyError, TypeError, ValueError)  # what xarray raises where a format has no form
NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_\-]*")
OTHERS = "other_cases"  # attribute with the attributes of the other cases, as JSON
LARGEST_VARIABLE = 2**31 - 1  # bytes, in NetCDF 3


@dataclass(frozen=True)
class ResultLimits:
    """Limits of the files of results, which may come from a stranger."""

    largest_file: int = 2**40  # bytes
    largest_ratio: int = 4  # of the data to the file, as results are not compressed


RESULT = ResultLimits()


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
        """Write as NetCDF, with a seal behind it by which damage is found; the file appears whole or not at all.

        It is NetCDF 3, which takes a twentieth of the time of NetCDF 4, unless a variable is too large for that, or has
        no values, or something is stated that only the other has, such as a list of texts or an integer beyond 32 bits.
        Neither knows true and false, which become 1 and 0, nor arrays of texts, which become lists.
        The file is made in memory, because HDF5 ends the process when a disk is full. Readers of NetCDF pass
        over the seal.

        Parameters
        ----------
        path
            File to write; its folder must exist.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ResultError
            When the file cannot be written, or NetCDF has no form for an attribute.
        """
        try:
            content = _as_netcdf(_stated_plainly(self.stored))
        except UNWRITABLE as error:
            raise ResultError(
                f"{path}: NetCDF has no form for {_unwritable(self.data)} of this {self.KIND}: {error}. "
                "Attributes are numbers, texts, or lists of either, and variables are numbers or texts"
            ) from error
        write_whole(Path(path), lambda temporary: temporary.write_bytes(content + seal_of(content)))
        return Path(path)

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read what was saved.

        Parameters
        ----------
        path
            A file that `save` wrote.

        Raises
        ------
        ResultError
            When the file cannot be read or holds something else.
        """
        try:
            file = read_bounded(Path(path), min(RESULT.largest_file, memory() // 4))
        except (OSError, ValueError) as error:
            raise ResultError(f"{path}: cannot be read as a {cls.KIND}: {reason_of(error)}") from error
        content = file[:-SEAL_LENGTH]
        if file != content + seal_of(content):  # HDF5 may end the process over a damaged file
            raise ResultError(
                f"{path}: this file is not a {cls.KIND} of fenics_mech, or was cut or changed after it was written"
            )
        try:
            large = content.startswith(HDF5)
            size = _size_of_hdf5(content) if large else _size_of_plain(Path(path))
            if size > RESULT.largest_ratio * len(content):
                raise ValueError(f"its data would take {size:.3g} bytes, and it has {len(content)}")
            with xr.open_dataset(io.BytesIO(content), engine="h5netcdf" if large else "scipy") as data:
                loaded = data.load()
        except Exception as error:  # h5py, h5netcdf, SciPy and xarray raise many types for a file that is not theirs
            raise ResultError(f"{path}: cannot be read as a {cls.KIND}: {error}") from error
        if not set(cls.NEEDED) <= set(loaded.attrs):
            raise ResultError(f"{path}: this NetCDF file is not a {cls.KIND} of fenics_mech")
        try:
            found = cls.of_stored(loaded)
            for part in (found, *found.beside):
                refuse_strange(part.data, part.known_names)
        except (ValueError, KeyError, TypeError, RecursionError, ResultError) as error:
            raise StrangeError(f"{path}: cannot be used as a {cls.KIND}: {error}") from error
        return found

    @property
    def stored(self) -> xr.Dataset:
        """What a file holds."""
        return self.data

    @classmethod
    def of_stored(cls, stored: xr.Dataset) -> Self:
        """Give what a file holds."""
        return cls(stored)

    @property
    def beside(self) -> Sequence[Self]:
        """Others that its file holds too."""
        return ()

    def known_names(self) -> Collection[str]:
        """Names of which labels are made."""
        return ()


def _stated_plainly(data: xr.Dataset) -> xr.Dataset:
    """Give a dataset whose attributes, and those of its variables, are of kinds that NetCDF has a form for."""

    def plain(value: Any) -> Any:
        if isinstance(value, bool | np.bool_):
            return np.int8(value)
        return value.tolist() if isinstance(value, np.ndarray) and value.dtype.kind == "U" else value

    data = data.copy()
    parts: list[xr.Dataset | xr.Variable] = [data, *data.variables.values()]
    for part in parts:
        part.attrs = {name: plain(value) for name, value in part.attrs.items()}
    return data


def _as_netcdf(data: xr.Dataset) -> bytes:
    """Give the content of a file of NetCDF 3, or of NetCDF 4 where that has no form for something."""
    if all(0 < values.nbytes <= LARGEST_VARIABLE for values in data.variables.values()):
        try:
            return bytes(data.to_netcdf(engine="scipy"))
        except UNWRITABLE as error:
            logger.info("not written as NetCDF 3: %s", error)
    return _as_hdf5(data)


def _as_hdf5(data: xr.Dataset) -> bytes:
    """Give the content of a file of NetCDF 4."""
    from h5netcdf import CompatibilityError  # noqa: PLC0415  (few results need it)

    try:
        return bytes(data.to_netcdf(engine="h5netcdf"))
    except CompatibilityError as error:
        raise ValueError(str(error)) from error


def _unwritable(data: xr.Dataset) -> str:
    """Name the first attribute or variable that NetCDF 4 has no form for."""
    parts = {f"attribute {name!r}": xr.Dataset(attrs={name: value}) for name, value in data.attrs.items()}
    parts |= {f"variable {name!r}": xr.Dataset({"variable": values}) for name, values in data.variables.items()}
    for words, part in parts.items():
        try:
            _as_hdf5(part)
        except UNWRITABLE:
            return words
    return "its parts together"


def _size_of_plain(path: Path) -> int:
    """Size of the data of a file of NetCDF 3, whose variables may share one place in it (bytes)."""
    from scipy.io import netcdf_file  # noqa: PLC0415  (only where something is read)

    with netcdf_file(path, mmap=True) as file:  # which reads no data
        return sum(values.data.nbytes for values in file.variables.values())


def _size_of_hdf5(content: bytes) -> int:
    """Size of the data of an HDF5 file, before they were compressed (bytes)."""
    import h5py  # noqa: PLC0415  (few results need it)

    with h5py.File(io.BytesIO(content), "r") as file:
        total = 0
        for name in file:
            data = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
            if isinstance(data, h5py.Datatype):  # which has no data, as that of complex numbers
                continue
            if not isinstance(data, h5py.Dataset) or data.external or data.is_virtual:
                raise ValueError(f"{shortened(name)} is not in the file itself")
            total += data.nbytes
    return int(total)


def seal_of(content: bytes) -> bytes:
    """Give what stands behind a file's content."""
    return SEAL + hashlib.sha256(content).hexdigest().encode()


class _Told(TypedDict):
    """What a result says of its load cases."""

    __pydantic_config__ = STRICT  # type: ignore[misc]
    names: list[str]
    cycles: dict[str, NotNegative]
    scene: str


TOLD = TypeAdapter(_Told)


def names_of(told: str, known: set[str]) -> list[str]:
    """Give the names of the load cases that a file holds."""
    try:
        names = TOLD.validate_json(told)["names"]
    except ValidationError as error:
        raise ValueError("it does not tell its load cases") from error
    if sorted(names) != sorted(known) or not all(map(NAME.fullmatch, names)):
        raise ValueError("it tells of other load cases than it holds")
    return names


def packed(data: xr.Dataset, others: Mapping[str, xr.Dataset]) -> xr.Dataset:
    """Put the datasets of other load cases into that of the governing one."""
    if not others:
        return data
    found = data.copy()
    for case, other in others.items():
        names = {str(name): f"{case}.{name}" for name in {*other.variables, *other.dims}}
        renamed = {names[str(name)]: _renamed(variable, names) for name, variable in other.variables.items()}
        coords = {names[str(name)] for name in other.coords}
        found = found.assign_coords({name: one for name, one in renamed.items() if name in coords})
        found = found.assign({name: one for name, one in renamed.items() if name not in coords})
    attributes = {case: other.attrs for case, other in others.items()}
    return found.assign_attrs({OTHERS: json.dumps(attributes, default=_plain)})


def _renamed(variable: xr.Variable, names: Mapping[str, str]) -> xr.Variable:
    return xr.Variable([names[str(dim)] for dim in variable.dims], variable.to_numpy(), variable.attrs)


def _plain(value: Any) -> Any:
    return value.tolist() if isinstance(value, np.ndarray | np.generic) else str(value)


def unpacked(stored: xr.Dataset) -> tuple[xr.Dataset, dict[str, xr.Dataset]]:
    """Take apart what `packed` has put together."""
    if OTHERS not in stored.attrs:
        return stored, {}
    attributes = json.loads(str(stored.attrs[OTHERS]))
    if not isinstance(attributes, dict) or not all(map(NAME.fullmatch, attributes)):
        raise ValueError("it does not tell its load cases")
    found = {}
    for case, of_case in attributes.items():
        begin = f"{case}."
        names = {name: name.removeprefix(begin) for name in map(str, {*stored.variables, *stored.dims})}
        own = [name for name in map(str, stored.variables) if name.startswith(begin)]
        parts = {names[name]: _renamed(stored.variables[name], names) for name in own}
        coords = {names[name] for name in own if name in stored.coords}
        found[case] = xr.Dataset(
            {name: part for name, part in parts.items() if name not in coords},
            {name: part for name, part in parts.items() if name in coords},
            of_case,
        )
    of_others = [name for name in stored.variables if any(str(name).startswith(f"{case}.") for case in attributes)]
    data = stored.drop_vars(of_others)
    data.attrs = {key: value for key, value in stored.attrs.items() if key != OTHERS}
    return data, found
