"""What was found of a scene, and keeps that scene with it."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, Self

import xarray as xr

from fenics_mech.errors import ResultError, SceneError
from fenics_mech.recovery.saved import Saved
from fenics_mech.scene import Scene


class OfScene(Saved):
    """A saved dataset with the scene that it was made of, as the attribute "scene"."""

    @classmethod
    def with_scene(cls, scene: Scene, data: xr.Dataset) -> Self:
        """Give a dataset with the scene that it was made of, which need not be read from its attribute then.

        Parameters
        ----------
        scene
            The scene, which the dataset has as an attribute too.
        data
            The dataset.
        """
        found = cls(data)
        vars(found)["scene"] = scene  # as if it was read already
        return found

    @cached_property
    def scene(self) -> Scene:
        """The scene; of a sweep or a branch, that of its first point.

        Raises
        ------
        ResultError
            When there is none, one that is not valid, or one in space.
        """
        if self.data.attrs.get("dimension") == 3:
            raise ResultError(
                "it is a result in space: fm.SpatialResult.load reads it, and report, plot and animate show it"
            )
        try:
            return Scene.read(json.loads(self.data.attrs["scene"]))
        except (KeyError, TypeError, ValueError, RecursionError, SceneError) as error:
            raise ResultError(f"the file holds no scene that can be analysed: {error}") from error

    def known_names(self) -> frozenset[str]:
        """Names of the links, points, joints and so on of the scene, as it is written: plugins need not be there."""
        return frozenset({"ground", *_keys(json.loads(self.data.attrs["scene"]))})

    def told_in(self, units: Sequence[str]) -> Self:
        """Give the same, whose numbers are printed and drawn in other units.

        Parameters
        ----------
        units
            Names of units, such as "in", "psi", "lbf", "rpm". Quantities without one have their usual unit.

        Raises
        ------
        SceneError
            When a name is no unit of an answer.

        Examples
        --------
        >>> fm.Result.load("out/result.nc").told_in(["lbf in"]).plot("drive").get_ylabel()
        'torque (lbf in)'
        """
        scene = self.scene.changed(units=tuple(units))
        return type(self)(self.data.assign_attrs(scene=scene.model_dump_json()))


def _keys(part: Any) -> Iterator[str]:
    """Give the keys of nested tables."""
    if isinstance(part, dict):
        for key, value in part.items():
            yield key
            yield from _keys(value)
