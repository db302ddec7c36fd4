"""The result of an analysis in space."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import ClassVar, Self

import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.errors import ResultError, SceneError
from fenics_mech.recovery.exports import to_mat, write_series, write_table
from fenics_mech.recovery.saved import Saved
from fenics_mech.scene.in_space import SpatialScene

MEANINGS = {
    "stress": ("Pa", "normal stress at each corner of the section"),
    "strain": ("1", "strain along the member at each corner of the section"),
    "torsion_stress": ("Pa", "largest shear stress of torsion in the section"),
    "von_mises": ("Pa", "upper bound of the equivalent stress: largest normal stress with largest shear stress"),
    "corner_place": ("m", "place of each corner along both principal axes of the section"),
    "section_force": ("N", "axial force, and shear forces along both principal axes"),
    "section_moment": ("N m", "torsion, and bending moments about both principal axes"),
    "section_axes": ("1", "axes of the section: along the member, and both principal axes"),
    "place": ("m", "place on the axis of the bent member"),
    "deflection": ("m", "how far it is from the place that it has in the rigid motion"),
    "joint_force": ("N", "force of the joint on its second link"),
    "joint_moment": ("N m", "moment of the joint on its second link, about the joint"),
    "joint_base": ("m", "place of the joint's point on its first link"),
    "joint_place": ("m", "place of the joint's point on its second link"),
    "input_torque": (
        "N m",
        "what the drive exerts on the joint's second link: a torque, or along a stroke a force (N)",
    ),
    "holding_moment": ("N m", "moment that holds a link's turn about its own line, which nothing drives"),
    "frequency": ("Hz", "natural frequency, held in the position by the drives"),
    "multiplier": ("1", "Floquet multiplier: factor on a small disturbance in a cycle, largest magnitude first"),
    "growth_rate": ("1/s", "rate at which the disturbance grows; it decays where negative"),
    "multiplier_frequency": ("Hz", "frequency of the disturbance"),
    "strain_relative_error": ("1", "estimated error of the strains by each source, over the largest"),
    "deflection_relative_error": ("1", "estimated error of the deflections by each source, over the largest"),
    "joint_force_relative_error": ("1", "estimated error of the joint forces by each source, over the largest"),
    "torque_relative_error": ("1", "estimated error of the drives' efforts by each source, over the largest"),
    "theta": ("rad", "drive angle"),
    "time": ("s", "time"),
    "s": ("1", "place along the member, from its first to its second end"),
}


class SpatialResult(Saved):
    """What an analysis in space found.

    Parameters
    ----------
    data
        Coordinates theta (rad), time (s), member, s (0..1), corner, component ("x", "y", "z"), section_axis ("along",
        "first", "second"), joint, drive, mode. Variables such as stress, section_moment, deflection, joint_force,
        input_torque, frequency and multiplier, with SI units in ``attrs["units"]``.

    Examples
    --------
    >>> result = fm.analyse(fm.load("demos/space/rssr.toml").changed({"analysis.positions": 30}))
    >>> sorted(result.data["component"].values.tolist())
    ['x', 'y', 'z']
    """

    KIND: ClassVar[str] = "result"

    @classmethod
    def with_scene(cls, scene: SpatialScene, data: xr.Dataset) -> Self:
        """Give a dataset with the scene that it was made of.

        Parameters
        ----------
        scene
            The scene, which the dataset has as an attribute too.
        data
            The dataset.
        """
        found = cls(data)
        vars(found)["scene"] = scene
        return found

    @cached_property
    def scene(self) -> SpatialScene:
        """The scene.

        Raises
        ------
        ResultError
            When there is none, or one that is not valid.
        """
        try:
            return SpatialScene.read(json.loads(self.data.attrs["scene"]))
        except (KeyError, TypeError, ValueError, RecursionError, SceneError) as error:
            raise ResultError(f"the file holds no scene that can be analysed: {error}") from error

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is doubtful."""
        return tuple(json.loads(self.data.attrs.get("warnings", "[]")))

    @property
    def notices(self) -> tuple[str, ...]:
        """What was assumed."""
        return tuple(json.loads(self.data.attrs.get("notices", "[]")))

    def told_in(self, units: Sequence[str]) -> Self:
        """Give the same result, whose answers are told in other units.

        Parameters
        ----------
        units
            Names of units, as a scene states them.
        """
        scene = self.scene.changed(units=tuple(units))
        return self.with_scene(scene, self.data.assign_attrs(scene=scene.model_dump_json(by_alias=True)))

    def known_names(self) -> frozenset[str]:
        """Names of links, points, joints and so on of the scene."""
        scene = self.scene
        points = [*scene.ground.points, *(point for link in scene.links.values() for point in link.points)]
        names = [*scene.links, *scene.joints, *scene.members(), *points, "ground"]
        return frozenset(part for name in names for part in (name, *name.split(".")))

    def to_table(self, name: str, path: str | Path, units: Sequence[str] = ()) -> Path:
        """Write one variable as a table.

        Parameters
        ----------
        name
            Its name.
        path
            File to write.
        units
            Names of units, such as "in", "psi"; what they do not measure is in SI.

        Raises
        ------
        ResultError
            When there is no such variable, or the file cannot be written.
        """
        if name not in self.data:
            raise ResultError(f"the result has no variable {name!r}; it has {', '.join(map(str, self.data.data_vars))}")
        return write_table(self.data[name], Path(path), units)

    def to_mat(self, path: str | Path) -> Path:
        """Write a file for MATLAB and Octave.

        Parameters
        ----------
        path
            File to write, ending in ".mat".

        Raises
        ------
        ResultError
            When it ends otherwise, or cannot be written.
        """
        return to_mat(self.data, Path(path))

    def to_vtk(self, path: str | Path, every: int = 1) -> Path:
        """Write a time series for ParaView: bent members with displacement, stress, forces and moments.

        Parameters
        ----------
        path
            File to write, ending in ".pvd"; a folder of the same name holds a file of each position.
        every
            Of how many positions one is written.

        Raises
        ------
        ResultError
            When it ends otherwise, no link bends, or a file cannot be written.
        """
        path = Path(path)
        if path.suffix != ".pvd":
            raise ResultError(f"{path}: a time series for ParaView must end in .pvd")
        if every < 1 or "member" not in self.data.coords:
            raise ResultError(f"{path}: it holds members that bend, of every so many positions: 1 or more")
        data = self.data.isel(theta=slice(None, None, every))
        count = data.sizes["theta"]

        def points(name: str) -> Array:
            return data[name].to_numpy().reshape(count, data.sizes["member"] * data.sizes["s"], -1)

        deflection = points("deflection")
        fields = {"displacement (m)": deflection}
        for name in ("von_mises", "section_force", "section_moment"):
            fields[f"{name.replace('_', ' ')} ({data[name].attrs['units']})"] = points(name)
        return write_series(data, path, points("place") - deflection, fields)

    def to_csv(self, folder: str | Path) -> list[Path]:
        """Write every variable as a table of its own, ``folder/variable.csv``.

        Parameters
        ----------
        folder
            Where to write; it is made when it is not there.

        Raises
        ------
        ResultError
            When a file cannot be written.
        """
        folder = Path(folder)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ResultError(f"{folder}: cannot make the folder: {error.strerror}") from error
        return [write_table(self.data[str(name)], folder / f"{name}.csv") for name in self.data.data_vars]


def described(data: xr.Dataset) -> xr.Dataset:
    """Say of every variable what it means, and its unit.

    Parameters
    ----------
    data
        A result; the attributes are added in place.
    """
    for name, (unit, meaning) in MEANINGS.items():
        if name in data.variables:
            data.variables[name].attrs.update(units=unit, long_name=meaning)
    return data
