"""`fenics-mech sound`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fenics_mech._console import loading, make_folder, tell
from fenics_mech.cli.common import loaded_result


def sound(
    result: Annotated[Path, typer.Argument(help="Result file (NetCDF).", show_default=False)],
    distance: Annotated[float, typer.Option(min=1e-3, max=1e6, help="Distance of the levels (m).")] = 1.0,
    draw: Annotated[Path | None, typer.Option(help="Draw the spectrum: a PNG, PDF or SVG file.")] = None,
) -> None:
    """Estimate the sound that the vibrating links radiate: power, and A-weighted level at a distance."""
    with loading():
        from fenics_mech.recovery.sound import sound as estimated  # noqa: PLC0415
        from fenics_mech.views.judgements import judgements, verdict  # noqa: PLC0415

    loaded = loaded_result(result)
    found = estimated(loaded, distance)
    levels = found.attrs
    loudest = int(found["sound_power"].to_numpy()[1:].argmax()) + 1
    tell(f"Sound power of the links: {levels['power_level']:.1f} dB re 1 pW")
    tell(f"At {distance:g} m: {levels['pressure_level']:.1f} dB, {levels['weighted_level']:.1f} dB(A)")
    tell(f"Most power at {float(found['sound_frequency'][loudest]):.4g} Hz, harmonic {loudest} of the drive")
    tell(f"Strips are thin up to {levels['thin_to']:.4g} Hz. Frame, joints and drive are not in these numbers.")
    level, said = verdict(judgements(loaded))
    if level in ("bad", "warn"):
        tell(f"Of the motion itself: {said}")
    if draw is not None:
        from fenics_mech.views.figures import save  # noqa: PLC0415
        from fenics_mech.views.sound_plots import sound_figure  # noqa: PLC0415

        make_folder(draw.parent)
        tell(f"Wrote {save(sound_figure(found), draw)}")
