"""What each effect does to the strains and what it costs: effects added one at a time, and the program's own choice."""

from __future__ import annotations

import re
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import numpy as np

from fenics_mech import _fenicsx
from fenics_mech._petsc import PETSc
from fenics_mech.analysis import analyse
from fenics_mech.effects import EFFECTS
from fenics_mech.effects.known import COUPLING, EXACT_STRAINS, STIFFENING, VIBRATION
from fenics_mech.errors import SceneError
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene

ADDED = (COUPLING, STIFFENING, EXACT_STRAINS)


@dataclass(frozen=True)
class Count:
    """What a run made."""

    forms: int  # UFL forms compiled (or found in the cache) and assembled
    matrices: int  # PETSc matrices created
    seconds: float  # time


@dataclass(frozen=True)
class Run:
    """A run with some effects."""

    name: str  # what was added last
    # result, count: what came out, and what it took
    result: Result
    count: Count
    # largest difference of the strains from the last run's, over the largest strain of the member in the last run
    difference: float


def added_one_by_one(scene: Scene) -> list[Run]:
    """Run a scene quasi-statically, then with vibration, then with effects added one at a time."""
    # All runs have the mesh and the steps that the scene states, whatever its tolerance. An effect that another one
    # replaces goes when that one comes. The last run is what the others are compared with.
    if scene.analysis.method != "periodic":
        raise SceneError(
            f"--compare needs a periodic response, and the method is {scene.analysis.method}",
            place="analysis.method",
            hint="Write method = 'periodic', or leave --compare out",
        )
    scene = scene.changed(tolerance=None)
    scenes = {VIBRATION: scene.changed(effects=(), analysis__solver="collocation")}
    if not (scene.impulses or any(drive.motor for drive in scene.drives)):  # these are nothing without vibration
        scenes = {"quasi-static": scene.changed(effects=(), analysis__method="quasi-static")} | scenes
    acting: tuple[str, ...] = ()
    for name in ADDED:
        acting = (*(other for other in acting if other != EFFECTS[name].replaces), name)
        scenes[name] = scene.changed(effects=acting)
    runs = {name: _counted_run(changed) for name, changed in scenes.items()}
    last = runs[ADDED[-1]][0]
    return [Run(name, result, count, largest_difference(result, last)) for name, (result, count) in runs.items()]


def _counted_run(scene: Scene) -> tuple[Result, Count]:
    """Analyse a scene twice, and count what the second run makes (the first one fills the caches)."""
    analyse(scene)
    before = _matrices_created()
    with (
        mock.patch.object(_fenicsx, "_assembled", wraps=_fenicsx._assembled) as bilinear,
        mock.patch.object(_fenicsx, "assemble_vector", wraps=_fenicsx.assemble_vector) as linear,
    ):
        start = time.perf_counter()
        result = analyse(scene)
        seconds = time.perf_counter() - start
    return result, Count(bilinear.call_count + linear.call_count, _matrices_created() - before, seconds)


def largest_difference(result: Result, other: Result) -> float:
    """Largest difference of strains, over each member's largest in `other`; the angles of both must be the same."""
    mine, theirs = (r.data["strain"].transpose("theta", "member", "s", "fibre").to_numpy() for r in (result, other))
    largest = np.abs(theirs).max(axis=(0, 2, 3))
    return float((np.abs(mine - theirs).max(axis=(0, 2, 3)) / np.maximum(largest, 1e-6 * largest.max())).max())


def _matrices_created() -> int:
    """Number of PETSc matrices that this process has made since PETSc's log began."""
    PETSc.Log.begin()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "log.txt"
        viewer = PETSc.Viewer().createASCII(str(path))
        PETSc.Log.view(viewer)
        viewer.destroy()
        return sum(int(number) for number in re.findall(r"^\s+Matrix\s+(\d+)", path.read_text(), re.MULTILINE))
