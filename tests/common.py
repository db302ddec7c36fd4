"""What tests of every kind share: where the demos are, and results that several tests look at."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from fenics_mech import Result, Scene

ROOT = Path(__file__).parents[1]
DEMOS = ROOT / "demos"

_results: dict[str, Result] = {}


def analysed(scene: Scene) -> Result:
    """Give the result of a scene, which is analysed once in a process: scenes of one content have one result."""
    from fenics_mech import analyse

    content = scene.model_dump_json()
    if content not in _results:
        _results[content] = analyse(scene)
    return _results[content]
