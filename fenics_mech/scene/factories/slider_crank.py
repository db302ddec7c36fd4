"""The slider-crank."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

from fenics_mech.errors import SceneError
from fenics_mech.scene.factories.bars import bars
from fenics_mech.scene.models import Scene
from fenics_mech.scene.units import in_unit


def slider_crank(
    *,
    crank: float | str,
    rod: float | str,
    sections: Sequence[dict[str, Any]],
    material: dict[str, Any],
    speed: float | str,
    offset: float | str = 0.0,
    guide_angle: float | str = 0.0,
    masses: Sequence[float | str] = (0.0, 0.0),
    rigid_crank: dict[str, Any] | None = None,
    branch: Literal["right", "left"] = "right",
    **rest: Any,
) -> Scene:
    """Make the scene of a slider-crank: crank OA, rod AB, and a slider at B on a straight guide of the ground.

    Parameters
    ----------
    crank, rod
        Lengths (m, or strings with a unit).
    sections
        Sections of crank and rod, as in a scene file; that of the crank is not used when it is rigid.
    material
        {"modulus": ..., "density": ...}.
    speed
        Speed of the crank (rad/s, or a string with a unit).
    offset
        Distance of the guide from the crank's bearing O, to the left as seen along the guide (m).
    guide_angle
        Direction of the guide (rad).
    masses
        Mass of the crank pin A and of the slider B (kg).
    rigid_crank
        {"mass": ..., "inertia": ..., "centre": ...} of a crank that does not bend; A's mass is to be in it.
    branch
        "right": the slider is ahead of the crank, in the guide's direction; "left": behind it.
    **rest
        Other keys of a scene: name, damping, mesh, analysis, measurements, petsc.

    Returns
    -------
    Scene
        The machine, to be analysed as it is or `changed`.

    Raises
    ------
    SceneError
        When the crank cannot turn fully, or a value is bad.

    Examples
    --------
    >>> strip = fm.RectangleSection(width="25 mm", height="3 mm")
    >>> steel = fm.Material(modulus="210 GPa", density=7850)
    >>> list(fm.slider_crank(crank=0.05, rod=0.2, sections=[strip] * 2, material=steel, speed="600 rpm").joints)
    ['O', 'A', 'B']
    """
    r, length, aside = (in_unit("m")(value) for value in (crank, rod, offset))
    direction = in_unit("rad")(guide_angle)
    if length <= r + abs(aside):
        what = f"a crank of {r:g} m cannot turn fully with a rod of {length:g} m and an offset of {aside:g} m"
        hint = "The rod must be longer than crank and offset together"
        raise SceneError(what, hint=hint)
    lean = math.asin((aside + r * math.sin(direction)) / length)  # of the rod in the guide's axes, at drive angle 0
    angle = direction + (lean if branch == "right" else math.pi - lean)
    names = ("crank", "rod")
    links = bars(names, ("OA", "AB"), (r, length), (0.0, angle))
    weights = {"A": {"at": "crank.A", "mass": masses[0]}, "slider": {"at": "rod.B", "mass": masses[1]}}
    if rigid_crank is not None:
        del links["crank"]["members"], weights["A"]
        links["crank"]["rigid"] = rigid_crank
    data: dict[str, Any] = {
        "name": "slider-crank",
        "materials": {"material": material},
        "sections": dict(zip(names, sections, strict=True)),
        "ground": {"points": {"O": (0.0, 0.0), "G": (-aside * math.sin(direction), aside * math.cos(direction))}},
        "links": links,
        "joints": {
            "O": {"connect": ("ground.O", "crank.O")},
            "A": {"connect": ("crank.A", "rod.A")},
            "B": {"kind": "slot", "connect": ("ground.G", "rod.B"), "angle": direction},
        },
        "masses": weights,
        "drive": {"joint": "O", "speed": speed},
    }
    return Scene.read(data | rest)
