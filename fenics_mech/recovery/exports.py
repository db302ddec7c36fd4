"""Results for other programs: tables, a time series for ParaView, and a file for MATLAB and Octave."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from xml.sax.saxutils import quoteattr

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, Index
from fenics_mech._files import write_frame, write_whole
from fenics_mech.errors import ResultError
from fenics_mech.recovery.rigid_places import between_ends
from fenics_mech.recovery.variables import STRAINS
from fenics_mech.scene.answer_units import named_units

MEMBER_FIELDS = ("axial_force", "shear_force", "moment", "strain_axial")
FIBRE_FIELDS = ("strain", "stress")
SIDES = {"+": "plus", "-": "minus"}
LINE = 3  # VTK's number of a cell of two points
LONGEST_NAME = 63  # of MATLAB
KIND_OF = {"m": "length", "Pa": "stress", "N": "force", "N m": "moment", "rad/s": "speed"}  # of answers, by unit in SI


def write_table(values: xr.DataArray, path: Path, units: Sequence[str] = ()) -> Path:
    """Write a variable as a CSV: its coordinates, then its value, with units in the head."""
    named, table = named_units(units, "--units"), values.to_dataframe().reset_index()
    names = {}
    for name in table.columns:
        unit = str((values if name == values.name else values[name]).attrs.get("units", "1"))
        kind = "strain" if name in STRAINS else KIND_OF.get(unit, "")
        if kind in named:
            unit, size = named[kind]
            table[name] /= size
        names[name] = name if unit == "1" else f"{name} ({unit})"
    table = table.rename(columns=names)
    write_frame(path, table)
    return path


def to_vtk(data: xr.Dataset, path: Path, every: int = 1) -> Path:
    """Write a time series for ParaView; see `Result.to_vtk`."""
    if path.suffix != ".pvd":
        raise ResultError(f"{path}: a time series for ParaView must end in .pvd")
    if every < 1:
        raise ResultError(f"every position that is written is one of {every}: it must be 1 or more")
    if "member" not in data.coords:
        raise ResultError(
            "no link of this result bends, and a .pvd holds members that do: write a .mat, or run with --csv"
        )
    if "position" not in data:
        raise ResultError("the result has no position of its members, as of an older version: analyse its scene again")
    data = data.isel(theta=slice(None, None, every))
    return write_series(data, path, _places(data), _fields(data))


def write_series(data: xr.Dataset, path: Path, places: Array, fields: dict[str, Array]) -> Path:
    """Write fields at the stations ``(instants, points, ...)``, which are at places ``(instants, points, 3)`` (m)."""
    import pyvista  # noqa: PLC0415  (slow to import)

    cells = _cells(data)
    folder = path.with_suffix("")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise ResultError(f"{folder}: cannot make the folder: {error.strerror}") from error
    members = np.repeat(np.arange(data.sizes["member"]), data.sizes["s"] - 1)
    names = []
    for k in range(data.sizes["theta"]):
        grid = pyvista.UnstructuredGrid(cells, np.full(len(members), LINE, dtype=np.uint8), places[k])
        for name, values in fields.items():
            grid.point_data[name] = values[k]
        grid.cell_data["member"] = members
        grid.field_data["member names"] = [str(member) for member in data["member"].to_numpy()]
        grid.field_data["drive angle (rad)"] = [float(data["theta"][k])]
        file = folder / f"{path.stem}_{k:05d}.vtu"
        write_whole(file, lambda temporary, grid=grid: grid.save(temporary))  # type: ignore[misc]
        names.append(f"{folder.name}/{file.name}")
    collection = _collection(data["time"].to_numpy(), names)
    write_whole(path, lambda temporary: temporary.write_text(collection, encoding="utf-8"))
    return path


def _places(data: xr.Dataset) -> Array:
    """Places of all stations in the rigid linkage (m), ``(angles, members x stations, 3)``."""
    ends = data["position"].transpose("theta", "member", "end", "component").to_numpy()
    return _in_space(between_ends(ends, data["s"].to_numpy()))


def _in_space(vectors: Array) -> Array:
    """Vectors in the plane, ``(angles, members, stations, 2)``, as ``(angles, points, 3)``."""
    flat = vectors.reshape(len(vectors), -1, 2)
    return np.concatenate([flat, np.zeros((*flat.shape[:2], 1))], axis=-1)


def _fields(data: xr.Dataset) -> dict[str, Array]:
    """Fields at all stations, ``(angles, points)``, and the displacement, ``(angles, points, 3)``, with their units."""
    found = {
        "displacement (m)": _in_space(data["deflection"].transpose("theta", "member", "s", "component").to_numpy())
    }
    for name in FIBRE_FIELDS:
        for fibre, side in SIDES.items():
            values = data[name].sel(fibre=fibre).transpose("theta", "member", "s").to_numpy()
            found[_named(f"{name} {side}", data[name])] = values.reshape(len(values), -1)
    for name in MEMBER_FIELDS:
        values = data[name].transpose("theta", "member", "s").to_numpy()
        found[_named(name.replace("_", " "), data[name])] = values.reshape(len(values), -1)
    return found


def _named(name: str, variable: xr.DataArray) -> str:
    unit = variable.attrs.get("units", "1")
    return name if unit == "1" else f"{name} ({unit})"


def _cells(data: xr.Dataset) -> Index:
    """Lines between neighbouring stations, in the form of VTK."""
    members, stations = data.sizes["member"], data.sizes["s"]
    first = (stations * np.arange(members)[:, None] + np.arange(stations - 1)).ravel()
    return np.stack([np.full_like(first, 2), first, first + 1], axis=1).ravel()


def _collection(time: Array, names: list[str]) -> str:
    """Text of a file that names those of all times."""
    lines = [f'    <DataSet timestep="{t:.17g}" part="0" file={quoteattr(name)}/>' for t, name in zip(time, names)]
    head = '<VTKFile type="Collection" version="0.1" byte_order="LittleEndian">'
    return "\n".join(['<?xml version="1.0"?>', head, "  <Collection>", *lines, "  </Collection>", "</VTKFile>", ""])


def to_mat(data: xr.Dataset, path: Path) -> Path:
    """Write a file for MATLAB and Octave; see `Result.to_mat`."""
    from scipy.io import savemat  # noqa: PLC0415  (slow to import)

    if path.suffix != ".mat":
        raise ResultError(f"{path}: a file for MATLAB must end in .mat")
    variables = {str(name): _plain(data[name].to_numpy()) for name in data.variables}
    content = variables | {
        "dimensions": {str(name): ", ".join(map(str, data[name].dims)) for name in data.variables},
        "units": {str(name): str(data[name].attrs.get("units", "1")) for name in data.variables},
        "attributes": {str(name): value for name, value in data.attrs.items() if len(str(name)) <= LONGEST_NAME},
    }
    write_whole(
        path,
        lambda temporary: savemat(temporary, content, appendmat=False, long_field_names=True, do_compression=True),
    )
    return path


def _plain(values: np.ndarray) -> np.ndarray:
    """Texts as a cell array."""
    return values.astype(object) if values.dtype.kind in "UO" else values
