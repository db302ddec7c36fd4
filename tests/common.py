"""What tests of every kind share: where the demos are, and results that several tests look at."""

from pathlib import Path

from fenics_mech import Result, Scene, analyse

ROOT = Path(__file__).parents[1]
DEMOS = ROOT / "demos"

_results: dict[str, Result] = {}


def analysed(scene: Scene) -> Result:
    """Give the result of a scene, which is analysed once in a process: scenes of one content have one result."""
    content = scene.model_dump_json()
    if content not in _results:
        _results[content] = analyse(scene)
    return _results[content]
