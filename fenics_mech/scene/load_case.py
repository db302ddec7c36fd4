"""A load case: what differs from the scene in it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import Field

from fenics_mech.scene.base import Name, Part
from fenics_mech.scene.units import Share

MOST_CASES = 100
TAGS = {"kind", "shape"}  # a table with one of them is whole by itself


class LoadCase(Part):
    """A load case: what differs from the scene. One run answers all cases, and tells the governing one.

    Parameters
    ----------
    name
        Its name.
    set
        Values of keys of the scene in this case, as the scene states them: of its drive, loads, impulses, gravity,
        masses, springs, dampers, joint laws, freedoms, damping, effects or analysis.
    off
        Names of loads and impulses that do not act in it.
    cycles
        Cycles of the machine that it runs in this case in its life. They count where a material states a stress-life
        curve.
    share
        Or the share of the running time, of `design.cycles` in all.

    Examples
    --------
    >>> case = fm.LoadCase(name="overspeed", set={"drive": {"speed": "400 rpm"}})
    >>> scene = fm.load("demos/four_bar.toml").changed(cases=[case])
    >>> round(fm.in_case(scene, "overspeed").drive.speed, 3)
    41.888
    """

    name: Name
    set: dict[str, Any] = Field(default_factory=dict)
    off: tuple[Name, ...] = ()
    cycles: Annotated[float, Field(ge=0, le=1e15)] | None = None
    share: Annotated[Share, Field(ge=0, le=1)] | None = None

    def _check_keys(self) -> None:
        if self.cycles is not None and self.share is not None:
            raise ValueError("give either `cycles` or `share`, not both")

    @property
    def values(self) -> dict[str, Any]:
        """The changed values by dotted path."""
        return dict(_leaves(self.set, ""))


Cases = Annotated[tuple[LoadCase, ...], Field(max_length=MOST_CASES)]


def _leaves(table: Mapping[str, Any], above: str) -> Iterator[tuple[str, Any]]:
    """Give what nested tables state, by dotted path; a table that says of which kind it is stays whole."""
    for key, value in table.items():
        if isinstance(value, Mapping) and value and not TAGS & value.keys():
            yield from _leaves(value, f"{above}{key}.")
        else:
            yield f"{above}{key}", value
