"""The crank shaper: a quick return whose crank pin travels along a flexible rocker."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from fenics_mech.errors import SceneError
from fenics_mech.scene.factories.bars import bars
from fenics_mech.scene.models import Scene
from fenics_mech.scene.units import in_unit


def quick_return(
    *,
    crank: float | str,
    centres: float | str,
    rocker: float | str,
    coupler: float | str,
    guide: float | str,
    sections: Sequence[dict[str, Any]],
    material: dict[str, Any],
    speed: float | str,
    masses: Sequence[float | str] = (0.0, 0.0),
    **rest: Any,
) -> Scene:
    """Make the scene of a crank shaper: crank OA above the rocker's pivot C, rocker CD, coupler DE, ram E.

    The pin A of the crank travels along the rocker. The guide of the ram is horizontal, and the ram on the right.

    Parameters
    ----------
    crank, rocker, coupler
        Lengths (m, or strings with a unit).
    centres
        Height of the crank's bearing O above the rocker's pivot C (m).
    guide
        Height of the ram's guide above C (m).
    sections
        Sections of crank, rocker and coupler, as in a scene file.
    material
        {"modulus": ..., "density": ...}.
    speed
        Speed of the crank (rad/s, or a string with a unit).
    masses
        Mass of the sliding block at A, and of the ram (kg).
    **rest
        Other keys of a scene: name, damping, mesh, analysis, measurements, petsc.

    Returns
    -------
    Scene
        The machine, to be analysed as it is or `changed`.

    Raises
    ------
    SceneError
        When the pin would leave the rocker, or the coupler does not reach the guide.

    Examples
    --------
    >>> bar = fm.RectangleSection(width="20 mm", height="8 mm")
    >>> scene = fm.quick_return(
    ...     crank=0.1, centres=0.25, rocker=0.5, coupler=0.2, guide=0.48, sections=[bar] * 3,
    ...     material=fm.Material(modulus="210 GPa", density=7850), speed="60 rpm",
    ... )
    >>> scene.joints["A"].member
    'CD'
    """
    lengths = [in_unit("m")(value) for value in (crank, rocker, coupler)]
    r, long, link = lengths
    bearing, height = in_unit("m")(centres), in_unit("m")(guide)
    if not (r < bearing and bearing + r <= long):
        raise SceneError(
            f"the crank pin must stay between 0 and {long:g} m of the rocker, and moves from {bearing - r:g} to "
            f"{bearing + r:g} m",
            hint="Change crank, centres or rocker",
        )
    swing = math.atan2(bearing, r)
    rise = (height - long * math.sin(swing)) / link  # sine of the coupler's angle at drive angle 0
    if abs(rise) > 1:
        raise SceneError(f"the coupler of {link:g} m does not reach the guide at {height:g} m", hint="Make it longer")
    names = ("crank", "rocker", "coupler")
    data: dict[str, Any] = {
        "name": "quick return",
        "materials": {"material": material},
        "sections": dict(zip(names, sections, strict=True)),
        "ground": {"points": {"C": (0.0, 0.0), "O": (0.0, bearing), "G": (0.0, height)}},
        "links": bars(names, ("OA", "CD", "DE"), lengths, (0.0, swing, math.asin(rise))),
        "joints": {
            "O": {"connect": ("ground.O", "crank.O")},
            "C": {"connect": ("ground.C", "rocker.C")},
            "A": {"kind": "slot", "connect": ("rocker.C", "crank.A"), "member": "CD"},
            "D": {"connect": ("rocker.D", "coupler.D")},
            "E": {"kind": "slot", "connect": ("ground.G", "coupler.E")},
        },
        "masses": {"block": {"at": "crank.A", "mass": masses[0]}, "ram": {"at": "coupler.E", "mass": masses[1]}},
        "drive": {"joint": "O", "speed": speed},
    }
    return Scene.read(data | rest)
