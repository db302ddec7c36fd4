"""Kinds of joints: what each holds of its two ends, and what a drive may lead.

Both ends are drawn with the same axes: the last, in the plane its normal, is the axis about which they turn. Guides lie
along the first, but for that of a cylinder. Of a universal joint each end has as its last axis its own hinge.
A new kind is a function here and a line in `KINDS`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from fenics_mech.geometry import Geometry
from fenics_mech.terms import Look, Measure

Measures = tuple[Measure, ...]
ANGLE, STROKE = Measure(Look.ANGLE), Measure(Look.ALONG, 0)


@dataclass(frozen=True)
class Kind:
    """A kind of joint.

    Parameters
    ----------
    held
        Measures of its ends that are 0.
    drives
        Measures that a drive may lead: "angle" and "stroke".
    """

    held: Measures
    drives: Mapping[str, Measure] = field(default_factory=dict)


def place(g: Geometry) -> Measures:
    """Both places are one."""
    return tuple(Measure(Look.PLACE, i) for i in range(g.d))


def line(g: Geometry) -> Measures:
    """The second place lies on the first axis of the first end."""
    return tuple(Measure(Look.ALONG, i) for i in range(1, g.d))


def axis(g: Geometry) -> Measures:
    """Both last axes are parallel, as they always are in the plane."""
    return tuple(Measure(Look.ALIGNED, i, 2) for i in range(2)) if g.d == 3 else ()


def turn(g: Geometry) -> Measures:
    """All axes are parallel."""
    return (*axis(g), Measure(Look.ALIGNED, 1, 0))


def ball(g: Geometry) -> Kind:
    """Hold one place: a ball in its socket, in the plane a pin."""
    return Kind(place(g))


def revolute(g: Geometry) -> Kind:
    """Hold a place and an axis, about which it turns: a hinge, in the plane a pin."""
    return Kind((*place(g), *axis(g)), {"angle": ANGLE})


def universal(g: Geometry) -> Kind:
    """Hold a place, and the hinges of both sides at a right angle: a cross between two forks."""
    return Kind((*place(g), Measure(Look.ALIGNED, 2, 2)))


def cylinder(g: Geometry) -> Kind:
    """Hold an axis, along which it slides and about which it turns."""
    across = (Measure(Look.ALONG, 0), Measure(Look.ALONG, 1))
    return Kind((*across, *axis(g)), {"angle": ANGLE, "stroke": Measure(Look.ALONG, 2)})


def slider(g: Geometry) -> Kind:
    """Hold a line, along which it slides and does not turn."""
    return Kind((*line(g), *turn(g)), {"stroke": STROKE})


def slot(g: Geometry) -> Kind:
    """Hold a place on a line, along which it slides and may turn: a pin in a slot, in space a ball in a groove."""
    return Kind(line(g), {"stroke": STROKE})


def plane(g: Geometry) -> Kind:
    """Hold a plane, in which it slides along both first axes, and turns."""
    return Kind((Measure(Look.ALONG, 2), *axis(g)), {"angle": ANGLE, "stroke": STROKE})


def weld(g: Geometry) -> Kind:
    """Hold place and axes."""
    return Kind((*place(g), *turn(g)))


KINDS: dict[str, Callable[[Geometry], Kind]] = {
    "revolute": revolute,
    "ball": ball,
    "slider": slider,
    "prismatic": slider,
    "slot": slot,
    "weld": weld,
}
IN_SPACE: dict[str, Callable[[Geometry], Kind]] = {"universal": universal, "cylinder": cylinder, "plane": plane}


def kind_of(name: str, g: Geometry) -> Kind:
    """Give a kind of joint by its name.

    Parameters
    ----------
    name
        A key of `KINDS`, or in space of `IN_SPACE`.
    g
        The plane or space.

    Raises
    ------
    ValueError
        When there is no such kind.
    """
    kinds = KINDS | IN_SPACE if g.d == 3 else KINDS
    if name not in kinds:
        raise ValueError(f"{name!r} is no kind of joint in {g.name}: expected one of {', '.join(kinds)}")
    return kinds[name](g)
