"""The result of an analysis: a labelled dataset that saves, loads and exports."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, Self, TypeVar, TypeVarTuple

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._version import __version__
from fenics_mech.errors import ResultError
from fenics_mech.recovery.derived import DERIVED, derived
from fenics_mech.recovery.exports import to_mat, to_vtk, write_table
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.recovery.saved import names_of, packed, unpacked
from fenics_mech.scene import Scene

Made = TypeVar("Made")
About = TypeVarTuple("About")
PLOTS = (  # functions of the top level, which draw a result
    *("strain", "strain_map", "spectrum", "deflection", "section_forces"),
    *("joint_forces", "force_path", "point_path", "drive", "frequencies"),
)


@dataclass(frozen=True)
class Result(OfScene):
    """What an analysis found.

    Parameters
    ----------
    data
        Coordinates theta (rad), time (s), member, s (0..1), fibre ("+", "-"), joint, mode, component ("x", "y").
        Variables such as strain, stress, moment, axial_force, deflection, joint_force, input_torque and frequency.
        SI units in ``attrs["units"]``. What is made of it is kept: for other values make another `Result`.
    cases
        The results of the scene's load cases, by name, if it has some; then `data` is that of the governing one. In
        `data` the variables `case_stress` and so on tell the largest of every case, and ``attrs["case"]`` which it is.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> result.strain_at("coupler", s=0.5).shape
    (90,)
    """

    KIND: ClassVar[str] = "result"
    cases: Mapping[str, Result] = field(default_factory=dict, compare=False)

    @property
    def case(self) -> str:
        """Name of the load case that it is of: of several, of the governing one; "" where the scene has none."""
        return str(self.data.attrs.get("case", ""))

    @property
    def stated(self) -> Scene:
        """The scene as it was stated: with its load cases, where it has some."""
        told = self.data.attrs.get("cases")
        return self.scene if told is None else Scene.read(json.loads(json.loads(told)["scene"]))

    @property
    def cycles(self) -> dict[str, float]:
        """Cycles of the machine in each load case in its life, where the cases state them."""
        return dict(json.loads(self.data.attrs["cases"])["cycles"]) if "cases" in self.data.attrs else {}

    @property
    def stored(self) -> xr.Dataset:
        """What a file holds: the data, and those of the other load cases under names that begin with the case's."""
        return packed(self.data, {name: one.data for name, one in self.cases.items() if name != self.case})

    @classmethod
    def of_stored(cls, stored: xr.Dataset) -> Self:
        """Give the result that a file holds; see `stored`."""
        if "paths" in stored.attrs:
            raise ValueError("it holds a sweep, which `fenics-mech report` shows")
        data, others = unpacked(stored)
        found = cls(data)
        if "cases" not in data.attrs:
            return found
        own = data.drop_dims("case", errors="ignore")
        own.attrs = {key: value for key, value in data.attrs.items() if key != "cases"}
        names = names_of(data.attrs["cases"], {str(data.attrs.get("case")), *others})
        every = {name: cls(others.get(name, own)) for name in names}
        return cls(data, every)

    @property
    def beside(self) -> Sequence[Self]:
        """Results of the load cases, which its file holds too."""
        return list(self.cases.values())  # type: ignore[arg-type]

    def told_in(self, units: Sequence[str]) -> Self:
        """Give the same, whose numbers are printed and drawn in other units; see `OfScene`."""
        return replace(super().told_in(units), cases={name: one.told_in(units) for name, one in self.cases.items()})

    @property
    def warnings(self) -> tuple[str, ...]:
        """Tolerances not met, numbers of the scene that are hardly meant, strengths exceeded; see `implausible`."""
        return tuple(json.loads(self.data.attrs.get("warnings", "[]")))

    @property
    def notices(self) -> tuple[str, ...]:
        """What was assumed, as the scene does not state it."""
        return tuple(json.loads(self.data.attrs.get("notices", "[]")))

    def derived(self, name: str) -> xr.DataArray:
        """Give a quantity that follows from the result and is not kept in it.

        Parameters
        ----------
        name
            "deflection_in_link" (m): the deflection in the axes of the member's link. "deflection_from_chord" (m): the
            distance of the bent axis from the line between its ends. "relative_centre" (m): the point at which two
            links have the same velocity, of each pair of links. "shear_stress" and "von_mises" (Pa): the largest in
            each section of known shape. "positioning_error" (m): the distance of a point from its place in the rigid
            linkage.

        Returns
        -------
        xarray.DataArray
            Over theta; member and s, and `axis` "x", "y" of the link; or `linked`, the pair, and component.

        Raises
        ------
        ResultError
            When there is no such quantity, or the result lacks what it follows from.

        Examples
        --------
        >>> fm.Result.load("out/result.nc").derived("deflection_from_chord").sel(s=1.0).max().item() < 1e-12
        True
        """
        return derived(name, self.data, self.scene)

    def plot(self, what: str = "strain", *names: Any, axes: Any = None, **options: Any) -> Any:
        """Draw one quantity, as the function ``fm.plot_...`` of that name does.

        Parameters
        ----------
        what
            What is drawn: "strain", "strain_map", "spectrum", "section_forces" (each of a member), "deflection",
            "joint_forces", "force_path", "point_path", "drive" or "frequencies".
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

    def to_table(self, name: str, path: str | Path, units: Sequence[str] = ()) -> Path:
        """Write one variable, or one that `derived` gives, as a table: its coordinates, then its value.

        Parameters
        ----------
        name
            Name of the variable, such as "stress_range".
        path
            File to write.
        units
            Names of units, such as "in", "psi"; what they do not measure is in SI.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ResultError
            When there is no such variable, or the file cannot be written.
        SceneError
            When a name is no unit of an answer.

        Examples
        --------
        >>> path = fm.Result.load("out/result.nc").to_table("stress_range", "range.csv", ["psi"])
        >>> path.read_text().splitlines()[0]
        'member,s,fibre,stress_range (psi)'
        """
        if name not in {*self.data.data_vars, *DERIVED}:
            known = ", ".join(map(str, (*self.data.data_vars, *DERIVED)))
            raise ResultError(f"the result has no variable {name!r}; it has {known}")
        values = self.data[name] if name in self.data.data_vars else self.derived(name)
        return write_table(values, Path(path), units)

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


def kept(make: Callable[[Result, *About], Made]) -> Callable[[Result, *About], Made]:
    """Keep with a result what a function makes of it, as summary, page, plots and tables all ask for it."""
    name = f"{make.__module__}.{make.__qualname__}"

    @wraps(make)
    def found(result: Result, *about: *About) -> Made:
        known = vars(result).setdefault("_kept", {})
        if (name, about) not in known:
            known[name, about] = make(result, *about)
        return known[name, about]  # type: ignore[no-any-return]

    return found


def at_place(curves: Array, stations: Array, s: float | Array) -> Array:
    """Interpolate by Akima's curve between stations, ``(..., stations)`` to ``(...,)``, or to ``(..., places)``."""
    # Straight lines between few stations would be off by more than the strains are. A spline would carry the jump of
    # a moment and the corner of a force along the whole member.
    at = np.minimum(np.searchsorted(stations, s), len(stations) - 1)
    if np.array_equal(stations[at], s):  # to the last bit, and no jump elsewhere along the member is felt
        return curves[..., at]
    if len(stations) == 2:  # between which a curve of Akima is straight, but not every version of SciPy knows
        share = (np.asarray(s) - stations[0]) / (stations[1] - stations[0])
        return np.asarray(np.multiply.outer(curves[..., 0], 1 - share) + np.multiply.outer(curves[..., 1], share))
    from scipy.interpolate import Akima1DInterpolator  # noqa: PLC0415  (slow to import)

    found = np.asarray(Akima1DInterpolator(stations, np.moveaxis(curves, -1, 0))(s))
    return np.moveaxis(found, 0, -1) if np.ndim(s) else found


def stamp(scene: Scene) -> dict[str, str]:
    """Attributes that every result carries."""
    return {"fenics_mech": __version__, "title": scene.name, "scene": scene.model_dump_json()}
