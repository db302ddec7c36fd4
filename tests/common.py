"""What tests of every kind share: where the demos are, and results that several tests look at."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:
    from fenics_mech import Result, Scene
    from fenics_mech.answers.in_time_by_poses import InTime
    from fenics_mech.answers.modes_by_poses import HeldMachine
    from fenics_mech.answers.solved_by_poses import AtRest, Solved
    from fenics_mech.estimate.error_sources import Errors

ROOT = Path(__file__).parents[1]
DEMOS = ROOT / "demos"

_results: dict[str, Result] = {}
_references: dict[str, Result] = {}


def _content(scene: Scene) -> str:
    """Give what a scene states, and which of its mesh and steps it leaves to the program."""
    return f"{scene.model_dump_json()} {sorted(scene.mesh.model_fields_set)} {sorted(scene.analysis.model_fields_set)}"


def analysed(scene: Scene) -> Result:
    """Give the result of a scene, which is analysed once in a process: scenes of one content have one result."""
    from fenics_mech import analyse

    content = _content(scene)
    if content not in _results:
        _results[content] = analyse(scene)
    return _results[content]


def too_coarse(scene: Scene) -> str:
    """Give what the answer of a scene with a stated mesh and stated steps says of their being too coarse.

    The answer is kept, its verdict says that it is not to be used, and so do its warnings.
    """
    from fenics_mech.views.judgements import judgements

    result = analysed(scene)
    said = str(result.data.attrs.get("coarse_because", ""))
    assert not said or f"too coarse: {said}" in result.warnings
    assert not said or any(judged.level == "bad" for judged in judgements(result))
    return said


def response_of(scene: Scene) -> Result:
    """Give the result of a scene without estimates of its errors, which take half of the time; analysed once as well.

    For references, and for tests of the response alone.
    """
    from fenics_mech import Result, analyse

    content = _content(scene)
    if content not in _references:
        with pytest.MonkeyPatch.context() as patch:
            for module in ("by_poses", "in_time_by_poses"):
                patch.setattr(f"fenics_mech.answers.{module}.estimated", _no_errors)
            _references[content] = Result(analyse(scene).data.drop_dims("source"))
    return _references[content]


def modes_of(scene: Scene) -> HeldMachine:
    """Give a scene's machine held at its positions, whose `modes` are followed and whose `frequency` is in Hz."""
    from fenics_mech.answers.modes_by_poses import HeldMachine, at_rest
    from fenics_mech.answers.solved_by_poses import with_effects

    return HeldMachine.of(at_rest(with_effects(scene)))


def bending(held: HeldMachine) -> Any:
    """Give the frequencies (rad/s) that bend a straight member along X, which is free to stretch, from the lowest."""
    machine, squares = held.made.machine, held.modes.shapes[0] ** 2
    along = [k for k in machine.places[:, 0] if k >= 0]
    return sorted(held.modes.omega[0, squares[along].sum(axis=0) < squares.sum(axis=0) / 2])


def _no_errors(solution: Solved | AtRest | InTime, *_: object) -> Errors:
    """Take all errors for 0."""
    import numpy as np

    from fenics_mech.estimate.error_sources import Errors
    from fenics_mech.estimate.quantities import places_of

    sizes = {
        name: np.ones(len(parts))
        for name, parts in places_of(solution.scene.members(), solution.scene.joints, solution.scene.drives).items()
    }
    return Errors({name: {"time": 0 * size} for name, size in sizes.items()}, {"time": 0.0}, sizes)


def with_all_effects(scene: Scene) -> Scene:
    """Give a scene the effects that matter to linkages; those of thick links where it states what they need."""
    from fenics_mech.effects import EFFECTS

    thick = () if EFFECTS["shear"].missing_data(scene) else ("rotary-inertia", "shear")
    return scene.changed(effects=("coupling", "large-rotations", *thick))
