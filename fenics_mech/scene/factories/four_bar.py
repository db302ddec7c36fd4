"""The four-bar, and that of Kaminski (1989), chapter 7."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from typing import Any, Literal

from fenics_mech.errors import SceneError
from fenics_mech.scene.base import SCENE
from fenics_mech.scene.factories.bars import bars
from fenics_mech.scene.models import Scene
from fenics_mech.scene.units import in_unit


def four_bar(
    *,
    crank: float | str,
    coupler: float | str,
    follower: float | str,
    ground: float | str,
    sections: Sequence[dict[str, Any]],
    material: dict[str, Any],
    speed: float | str,
    masses: Sequence[float | str] = (0.0, 0.0),
    branch: Literal["open", "crossed"] = "open",
    **rest: Any,
) -> Scene:
    """Make the scene of a planar four-bar, named as in figure 6.2: crank OA, coupler AB, follower CB, ground OC.

    Parameters
    ----------
    crank, coupler, follower, ground
        Lengths (m, or strings with a unit).
    sections
        Sections of crank, coupler and follower, as in a scene file ({"area": ..., "inertia": ..., "fibre": ...}).
    material
        {"modulus": ..., "density": ...}.
    speed
        Speed of the crank (rad/s, or a string with a unit).
    masses
        Point masses at A (on the crank) and at B (on the follower) (kg).
    branch
        "open": the coupler does not cross the ground line at drive angle 0 with a counter-clockwise crank A, B, C;
        "crossed": the mirror image of B about the line AC.
    **rest
        Other keys of a scene: name, damping, mesh, analysis, measurements, petsc.

    Returns
    -------
    Scene
        The machine, to be analysed as it is or `changed`.

    Raises
    ------
    SceneError
        When the loop cannot be closed at drive angle 0, or a value is bad.

    Examples
    --------
    >>> strip = fm.RectangleSection(width="25 mm", height="2 mm")
    >>> scene = fm.four_bar(
    ...     crank="100 mm", coupler="280 mm", follower="270 mm", ground="250 mm", sections=[strip] * 3,
    ...     material=fm.Material(modulus="71 GPa", density=2714), speed="300 rpm",
    ... )
    >>> list(scene.links)
    ['crank', 'coupler', 'follower']
    """
    lengths = [in_unit("m")(value) for value in (crank, coupler, follower, ground)]
    names = ("crank", "coupler", "follower")
    joints = {
        "O": {"connect": ("ground.O", "crank.O")},
        "A": {"connect": ("crank.A", "coupler.A")},
        "B": {"connect": ("coupler.B", "follower.B")},
        "C": {"connect": ("ground.C", "follower.C")},
    }
    mass_a, mass_b = masses
    data: dict[str, Any] = {
        "name": "four-bar",
        "materials": {"material": material},
        "sections": dict(zip(names, sections, strict=True)),
        "ground": {"points": {"O": (0.0, 0.0), "C": (lengths[3], 0.0)}},
        "links": bars(names, ("OA", "AB", "CB"), lengths, (0.0, *_start_angles(lengths, branch))),
        "joints": joints,
        "masses": {"A": {"at": "crank.A", "mass": mass_a}, "B": {"at": "follower.B", "mass": mass_b}},
        "drive": {"joint": "O", "speed": speed},
    }
    return Scene.read(data | rest)


def _start_angles(lengths: Sequence[float], branch: str) -> tuple[float, float]:
    """Angles of coupler and follower at drive angle 0 (rad), by the cosine rule on the triangle ABC."""
    crank, coupler, follower, ground = lengths
    diagonal = ground - crank  # from A to C, along x
    cosine = (coupler**2 + diagonal**2 - follower**2) / (2 * coupler * diagonal) if diagonal else 2.0
    if abs(cosine) > 1 + SCENE.folded:
        what = f"lengths {crank:g}, {coupler:g}, {follower:g} and {ground:g} m do not close at drive angle 0"
        hint = "Any of the four must be shorter than the sum of the others"
        raise SceneError(what, hint=hint)
    cosine = max(-1.0, min(cosine, 1.0))  # where all lie in line
    side = 1 if branch == "open" else -1
    joint_b = crank + coupler * complex(cosine, side * (1 - cosine**2) ** 0.5)
    return cmath.phase(joint_b - crank), cmath.phase(joint_b - ground)


def seed_four_bar(**rest: Any) -> Scene:
    """Make the four-bar of chapter 7, with the lengths in inches from which table 7.1 was rounded."""
    strip = {"area": "0.406 cm^2", "inertia": "8.67e-4 cm^4", "fibre": "0.8 mm"}
    seed = four_bar(
        crank="4.25 in",
        coupler="11 in",
        follower="10.65 in",
        ground="10 in",
        sections=({"area": "1.07 cm^2", "inertia": "1.62e-2 cm^4", "fibre": "2.12 mm"}, strip, strip),
        material={"modulus": "71 GPa", "density": "2714 kg/m^3"},
        speed="32.3 rad/s",
        masses=("45.2 g", "37.55 g"),
        name="seed four-bar",
        damping={"ratio": 0.02},
    )
    return seed.changed(**rest)
