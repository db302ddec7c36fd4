"""The flexible manipulator: an open chain of arms with driven joints."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fenics_mech.scene.models import Scene


def manipulator(
    *,
    arms: Sequence[float | str],
    sections: Sequence[dict[str, Any]],
    material: dict[str, Any],
    laws: Sequence[dict[str, Any]],
    period: float | str,
    masses: Sequence[dict[str, Any]],
    **rest: Any,
) -> Scene:
    """Make the scene of a chain of arms arm1, arm2, ... with joints J1 (on the ground), J2, ..., all driven.

    Parameters
    ----------
    arms
        Lengths (m, or strings with a unit), from the ground on.
    sections
        Section of each arm, as in a scene file.
    material
        {"modulus": ..., "density": ...}.
    laws
        Angle of each arm against the one before it over the cycle, as in a scene file.
    period
        Duration of the cycle (s, or a string with a unit).
    masses
        {"mass": ..., "inertia": ...} at the end of each arm: the motor of the next, and the load.
    **rest
        Other keys of a scene: name, damping, mesh, analysis, measurements, petsc.

    Returns
    -------
    Scene
        The machine, to be analysed as it is or `changed`.

    Raises
    ------
    SceneError
        When a value is bad.

    Examples
    --------
    >>> scene = fm.manipulator(
    ...     arms=["0.5 m", "0.4 m"], sections=[fm.RectangleSection(width="30 mm", height="4 mm")] * 2,
    ...     material=fm.Material(modulus="71 GPa", density=2714), period="2 s",
    ...     masses=[{"mass": "0.5 kg"}] * 2, laws=[fm.Harmonics(sine=("30 deg",)), fm.Harmonics(cosine=("20 deg",))],
    ... )
    >>> len(scene.drive)
    2
    """
    numbers = range(1, len(arms) + 1)
    data: dict[str, Any] = {
        "name": "manipulator",
        "materials": {"material": material},
        "sections": {f"arm{i}": section for i, section in zip(numbers, sections, strict=True)},
        "ground": {"points": {"base": (0.0, 0.0)}},
        "links": {
            f"arm{i}": {
                "points": {"base": (0.0, 0.0), "tip": (length, 0.0)},
                "members": {"beam": {"ends": ("base", "tip"), "section": f"arm{i}", "material": "material"}},
            }
            for i, length in zip(numbers, arms)
        },
        "joints": {
            f"J{i}": {"connect": ("ground.base" if i == 1 else f"arm{i - 1}.tip", f"arm{i}.base")} for i in numbers
        },
        "masses": {f"mass{i}": {"at": f"arm{i}.tip"} | dict(mass) for i, mass in zip(numbers, masses, strict=True)},
        "drive": [{"joint": f"J{i}", "law": law, "period": period} for i, law in zip(numbers, laws, strict=True)],
    }
    return Scene.read(data | rest)
