"""`fenics-mech fatigue`."""

from __future__ import annotations

from pathlib import Path

from fenics_mech._console import loading, make_folder, out, tell_written, warn
from fenics_mech.cli.common import OutFolder, SceneFile, Strict, Units, analysed


def fatigue(scene: SceneFile, folder: OutFolder = Path("out"), units: Units = None, strict: Strict = False) -> None:
    """Tell how long the members last by their stress-life curves: write fatigue.csv. SCENE may also be a result.nc."""
    with loading():
        from fenics_mech.recovery.stress_figures import fatigue as damaged  # noqa: PLC0415
        from fenics_mech.recovery.stress_figures import life_used  # noqa: PLC0415
        from fenics_mech.scene.plausibility import implausible  # noqa: PLC0415
        from fenics_mech.views.fatigue_table import cases_fatigue, fatigue_table, write_fatigue  # noqa: PLC0415
        from fenics_mech.views.reading import reading_of_a_file  # noqa: PLC0415

    result = analysed(scene, units, strict)
    with reading_of_a_file():
        found = life_used(result) if result.cases else damaged(result)
    make_folder(folder)
    written = write_fatigue(found, folder / "fatigue.csv")
    out.print((cases_fatigue if result.cases else fatigue_table)(result, found))
    tell_written([written], folder)
    stated = implausible(result.scene)  # told before the analysis
    warn([text for text in result.warnings if text not in stated or scene.suffix == ".nc"], strict)
