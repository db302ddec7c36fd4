"""The result of an analysis: a labelled dataset that saves, loads and exports."""

from __future__ import annotations

import hashlib
import io
import json
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, Self

import h5py
import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._files import read_bounded, reason_of, write_whole
from fenics_mech._guard import memory
from fenics_mech._version import __version__
from fenics_mech.errors import ResultError, SceneError, shortened
from fenics_mech.recovery.exports import to_mat, to_vtk
from fenics_mech.scene import Scene

SEAL = b"fenics_mech sha256 "
SEAL_LENGTH = len(SEAL) + 64
PLOTS = (  # functions of the top level, which draw a result
    *("strain", "strain_map", "spectrum", "deflection"),
    *("joint_forces", "force_path", "point_path", "drive", "frequencies"),
)


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
    ENGINE: ClassVar[str] = "scipy"  # NetCDF 3, which has no times in it
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech",)
    data: xr.Dataset

    def save(self, path: str | Path) -> Path:
        """Write as NetCDF, with a seal behind it by which damage is found; the file appears whole or not at all.

        The file is made in memory, because HDF5 ends the process when a disk is full. Readers of NetCDF pass over the
        seal.

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
            When the file cannot be written.
        """
        content = bytes(self.data.to_netcdf(engine=self.ENGINE))  # type: ignore[call-overload]
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
            if cls.ENGINE == Result.ENGINE:
                _check_content(content)
            with xr.open_dataset(io.BytesIO(content), engine=cls.ENGINE) as data:
                loaded = data.load()
        except Exception as error:  # h5py, h5netcdf, SciPy and xarray raise many types for a file that is not theirs
            raise ResultError(f"{path}: cannot be read as a {cls.KIND}: {error}") from error
        if not set(cls.NEEDED) <= set(loaded.attrs):
            raise ResultError(f"{path}: this NetCDF file is not a {cls.KIND} of fenics_mech")
        return cls(loaded)


@dataclass(frozen=True)
class Result(Saved):
    """What an analysis found.

    Parameters
    ----------
    data
        Coordinates theta (rad), time (s), member, s (0..1), fibre ("+", "-"), joint, mode, component ("x", "y").
        Variables such as strain, stress, moment, axial_force, deflection, joint_force, input_torque and frequency.
        SI units in ``attrs["units"]``.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> result.strain_at("coupler", s=0.5).shape
    (90,)
    """

    KIND: ClassVar[str] = "result"
    ENGINE: ClassVar[str] = "h5netcdf"

    @cached_property
    def scene(self) -> Scene:
        """The scene that was analysed."""
        return stored_scene(self.data)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Numbers of the scene that are hardly meant, and strengths that are exceeded; see `implausible`."""
        return tuple(json.loads(self.data.attrs.get("warnings", "[]")))

    def plot(self, what: str = "strain", *names: Any, axes: Any = None, **options: Any) -> Any:
        """Draw one quantity, as the function ``fm.plot_...`` of that name does.

        Parameters
        ----------
        what
            What is drawn: "strain", "strain_map", "spectrum" (each of a member), "deflection", "joint_forces",
            "force_path", "point_path", "drive" or "frequencies".
        names
            The member, joint or points that are drawn.
        axes
            Where to draw; without them a figure is made.
        options
            Others of that function, such as the place ``s``.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        ResultError
            When there is no such plot.
        ViewError
            When the result lacks what is drawn.

        Examples
        --------
        >>> fm.Result.load("out/result.nc").plot("drive").get_ylabel()
        'torque (N m)'
        """
        if what not in PLOTS:
            raise ResultError(f"there is no plot {what!r}; there are {', '.join(PLOTS)}")
        return getattr(import_module("fenics_mech"), f"plot_{what}")(self, *names, axes=axes, **options)

    def to_csv(self, folder: str | Path) -> list[Path]:
        """Write every variable as a table of its own, ``folder/variable.csv``: its coordinates, then its value.

        Parameters
        ----------
        folder
            Where to write; it is made when it is not there.

        Returns
        -------
        list of Path
            The files.

        Raises
        ------
        ResultError
            When the folder cannot be made or a file cannot be written.
        """
        folder = Path(folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ResultError(f"{folder}: cannot make the folder: {error.strerror}") from error
        return [self.to_table(str(name), folder / f"{name}.csv") for name in self.data.data_vars]

    def to_table(self, name: str, path: str | Path) -> Path:
        """Write one variable as a table: its coordinates, then its value, in SI.

        Parameters
        ----------
        name
            Name of the variable, such as "stress_range".
        path
            File to write.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ResultError
            When there is no such variable, or the file cannot be written.
        """
        if name not in self.data.data_vars:
            raise ResultError(f"the result has no variable {name!r}; it has {', '.join(map(str, self.data.data_vars))}")
        table = self.data[name].to_dataframe().reset_index()
        units = {key: self.data[key].attrs.get("units", "1") for key in (*self.data[name].coords, name)}
        table = table.rename(columns={key: f"{key} ({unit})" for key, unit in units.items() if unit != "1"})
        write_whole(Path(path), lambda temporary: table.to_csv(temporary, index=False))
        return Path(path)

    def to_vtk(self, path: str | Path, every: int = 1) -> Path:
        """Write a time series for ParaView: ``motion.pvd``, and beside it a folder with a file for each position.

        Points are the stations of the members in the rigid linkage. They have the displacement, by which ParaView's
        filter "Warp By Vector" bends them, strains and stresses of both sides, and the section forces, in SI.

        Parameters
        ----------
        path
            File to write, ending in ".pvd".
        every
            Of how many positions one is written.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ResultError
            When the name has another ending, or a file cannot be written.
        """
        return to_vtk(self.data, Path(path), every)

    def to_mat(self, path: str | Path) -> Path:
        """Write all variables as a file for MATLAB and Octave, with `dimensions`, `units` and `attributes` by name.

        Parameters
        ----------
        path
            File to write, ending in ".mat".

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ResultError
            When the name has another ending, or the file cannot be written.
        """
        return to_mat(self.data, Path(path))

    def strain_at(self, member: str, s: float = 0.5, fibre: str = "+") -> Array:
        """Strain over the drive angles at a place of a member, interpolated between stations.

        Parameters
        ----------
        member
            Label of the member.
        s
            Place along it, 0..1.
        fibre
            "+" (on the side of the member's normal) or "-".

        Returns
        -------
        numpy.ndarray
            Strain (m/m), ``(angles,)``.

        Raises
        ------
        ResultError
            When there is no such member, fibre or place.
        """
        for dimension, name in (("member", member), ("fibre", fibre)):
            known = [str(label) for label in self.data[dimension].to_numpy()]
            if name not in known:
                raise ResultError(f"the result has no {dimension} {name!r}; it has {', '.join(known)}")
        if not 0 <= s <= 1:
            raise ResultError(f"s = {s} is no place of a member: along it s goes from 0 to 1")
        strain = self.data["strain"].sel(member=member, fibre=fibre).transpose("theta", "s")
        return at_place(strain.to_numpy(), self.data["s"].to_numpy(), s)


def at_place(curves: Array, stations: Array, s: float) -> Array:
    """Interpolate linearly between stations, ``(..., stations)`` to ``(...,)``.

    Parameters
    ----------
    curves
        Values at the stations.
    stations
        Ascending places along the member, 0..1.
    s
        The place, 0..1.
    """
    i = np.clip(np.searchsorted(stations, s) - 1, 0, len(stations) - 2)
    share = (s - stations[i]) / (stations[i + 1] - stations[i])
    return (1 - share) * curves[..., i] + share * curves[..., i + 1]


def _check_content(content: bytes) -> None:
    """Raise `ValueError` where an HDF5 file takes data from other files, or holds more than its size, compressed."""
    with h5py.File(io.BytesIO(content), "r") as file:
        total = 0
        for name in file:
            data = file[name] if isinstance(file.get(name, getlink=True), h5py.HardLink) else None
            if not isinstance(data, h5py.Dataset) or data.external or data.is_virtual:
                raise ValueError(f"{shortened(name)} is not in the file itself")
            total += data.nbytes
    if total > RESULT.largest_ratio * len(content):
        raise ValueError(f"its data would take {total:.3g} bytes, and it has {len(content)}")


def stored_scene(data: xr.Dataset) -> Scene:
    """Give the scene whose analysis a dataset holds.

    Parameters
    ----------
    data
        A dataset with the attribute "scene".

    Raises
    ------
    ResultError
        When it holds none, or one that is not valid.
    """
    try:
        return Scene.read(json.loads(data.attrs["scene"]))
    except (KeyError, TypeError, ValueError, RecursionError, SceneError) as error:
        raise ResultError(f"the file holds no scene that can be analysed: {error}") from error


def seal_of(content: bytes) -> bytes:
    """Give what stands behind a file's content.

    Parameters
    ----------
    content
        The content, before the seal.
    """
    return SEAL + hashlib.sha256(content).hexdigest().encode()


def stamp(scene: Scene) -> dict[str, str]:
    """Attributes that every result carries.

    Parameters
    ----------
    scene
        The scene that was analysed.
    """
    return {"fenics_mech": __version__, "title": scene.name, "scene": scene.model_dump_json()}
