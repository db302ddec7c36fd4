"""`fenics-mech balance`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fenics_mech._console import loading, make_folder, out, tell
from fenics_mech.cli.common import SceneFile, Strict, Units, answer_units, loaded_scene, quantity, refuse_own_source
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from fenics_mech.scene.answer_units import AnswerUnits
    from fenics_mech.studies.synthesis.balancing import Balanced

SHAKEN = {"force": "force", "moment": "moment", "torque": "moment"}  # kinds of the units of what balancing lowers


def balance(
    scene: SceneFile,
    file: Annotated[Path, typer.Option("-o", "--out", help="Scene file to write.")] = Path("balanced.toml"),
    on: Annotated[
        list[str] | None,
        typer.Option(
            help="Link with a counterweight and its distance from the pin: crank='50 mm'. Several are possible.",
            show_default="each link that is pinned to the ground, at 0.4 of its length",
        ),
    ] = None,
    moment: Annotated[float, typer.Option(min=0, help="Weight of the shaking moment; that of the force is 1.")] = 0.0,
    torque: Annotated[float, typer.Option(min=0, help="Weight of the torque of the drive.")] = 0.0,
    section: Annotated[
        str | None, typer.Option(help="Section of the bars that hold them.", show_default="that of the link")
    ] = None,
    units: Units = None,
    strict: Strict = False,
) -> None:
    """Find counterweights that make the forces on the frame least, and write the scene with them."""
    with loading():
        from fenics_mech.scene.writing import write_scene  # noqa: PLC0415
        from fenics_mech.studies.synthesis.balancing import balance as balanced  # noqa: PLC0415

    refuse_own_source(file, scene)
    radii = dict(map(_radius, on)) if on else None
    loaded = loaded_scene(scene, strict)
    told = loaded.answer_units if units is None else answer_units(units)
    found = balanced(loaded, radii, moment=moment, torque=torque, section=section)
    make_folder(file.parent)
    write_scene(found.scene, file, f"{found.scene.name} with counterweights, by fenics-mech balance")
    out.print(_table(found, told))
    tell(f"Wrote {file}")


def _radius(text: str) -> tuple[str, float]:
    """Read `LINK=RADIUS`."""
    link, equals, radius = (part.strip() for part in text.partition("="))
    if not equals:
        raise MechanismError(f"cannot read --on {text!r}: write a link and a distance, such as crank='50 mm'")
    return link, quantity(radius, "m", f"--on {text!r}")


def _table(found: Balanced, units: AnswerUnits) -> str:
    """Write the counterweights, and what inertia does to the frame before and after."""
    from math import degrees  # noqa: PLC0415

    from fenics_mech.views.prefixes import fitted  # noqa: PLC0415

    of_kinds: dict[str, float] = {}
    for what, kind in SHAKEN.items():
        of_kinds[kind] = max(of_kinds.get(kind, 0.0), found.before.rms[what], found.after.rms[what])
    units = fitted(of_kinds, units)
    lines = [
        f"{one.link}: {1e3 * one.mass:.4g} g at {units.text(one.radius, 'length')} from {one.pivot}, "
        f"{degrees(one.angle):.1f}\N{DEGREE SIGN} from the link's x axis"
        for one in found.counterweights
    ]
    lines.append("Root mean square over the cycle, links that do not bend:")
    for what, kind in SHAKEN.items():
        before, after = found.before.rms[what], found.after.rms[what]
        now = 0.0 if after < 1e-9 * before else after
        name = "torque" if what == "torque" else f"shaking {what}"
        lines.append(f"  {name}: {units.text(before, kind)} before, {units.text(now, kind)} after")
    return "\n".join(lines)
