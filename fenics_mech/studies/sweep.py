"""The response over numbers of a scene: speed, damping, a length, or any other, on one process or several.

Finished points are files in the sweep's folder. A sweep that was ended goes on with the points that are missing, and
comes to the same result as one that was not: to the last bit, or where Newton's method begins from a neighbour's motion
to its tolerance. Processes of this machine, or of `mpirun`, share runs of points.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import ClassVar, Self

import xarray as xr

from fenics_mech._petsc import MPI
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.scene import Scene
from fenics_mech.scene.load_cases import refuse_cases
from fenics_mech.studies.gauge import Gauge
from fenics_mech.studies.one_equation import OneEquation
from fenics_mech.studies.peak_between import largest_between
from fenics_mech.studies.saved_sweep import refuse_unlike
from fenics_mech.studies.sweep_axes import Axis, axes_of, stated_data
from fenics_mech.studies.sweep_gaps import fill_gaps
from fenics_mech.studies.sweep_peaks import Estimates, at_peaks_alone
from fenics_mech.studies.sweep_run import SweepRun, grid
from fenics_mech.studies.worker_processes import Workers


@dataclass(frozen=True)
class Sweep(OfScene):
    """What a sweep found.

    Parameters
    ----------
    data
        One dimension per swept field, named by its path, in SI; then members, joints, modes, harmonics. Variables as in
        `kept_points.KEPT`, NaN where a point has none, and the texts `kept_points.TEXTS`. Units in
        ``attrs["units"]``.

    Examples
    --------
    >>> scene = fm.load("demos/four_bar.toml").changed({"analysis.method": "quasi-static"})
    >>> found = fm.sweep(scene, {"drive.speed": ["80 rpm"], "damping.ratio": ["2 %"]})
    >>> found.paths
    ['drive.speed', 'damping.ratio']
    """

    KIND: ClassVar[str] = "sweep"
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech", "paths")

    @classmethod
    def of_stored(cls, stored: xr.Dataset) -> Self:
        """Give the sweep that a file holds, if it is one that the program can have written."""
        found = cls(stored)
        refuse_unlike(stored, found.paths, found.scene)
        return found

    @property
    def paths(self) -> list[str]:
        """The swept fields."""
        return list(json.loads(self.data.attrs["paths"]))


def sweep(
    scene: Scene,
    values: Mapping[str, Sequence[float | str]],
    folder: str | Path | None = None,
    *,
    gauge: Gauge | None = None,
    refine_peaks: int = 0,
    jobs: int = 1,
    estimates: Estimates = "auto",
    progress: Callable[[int, int], None] = lambda done, points: None,
) -> Sweep:
    """Analyse a scene at given values of its numbers; several numbers make a grid.

    A point that fails ends nothing: the sweep holds its error and NaN for its numbers. What one point needs of mesh,
    steps and effects is taken for all. Motions are followed into stretches of points that have no stable one.

    Parameters
    ----------
    scene
        The scene.
    values
        Values by dotted path: numbers (SI), or texts with a unit.
    folder
        Where finished points are kept, so that a sweep that was ended goes on. Without one, nothing is written.
    gauge, refine_peaks, jobs, estimates, progress
        As of `run_sweep`.

    Returns
    -------
    Sweep
        A dataset with one dimension per swept number.

    Raises
    ------
    SceneError, ResultError, MechanismError
        As `run_sweep`, and when a path or a value is not valid.

    Examples
    --------
    >>> scene = fm.load("demos/four_bar.toml").changed({"analysis.method": "quasi-static"})
    >>> found = fm.sweep(scene, {"drive.speed": ["100 rpm", "200 rpm"]})
    >>> small, large = found.data["peak_strain"].sel(member="coupler").values
    >>> bool(large > 3 * small)
    True
    """
    axes = axes_of(scene, values)
    with TemporaryDirectory() as made:  # one for all processes: that of the first
        kept = Path(folder) if folder is not None else Path(MPI.COMM_WORLD.bcast(made))
        return run_sweep(
            scene,
            axes,
            kept,
            gauge=gauge,
            refine_peaks=refine_peaks,
            jobs=jobs,
            estimates=estimates,
            progress=progress,
        )


def run_sweep(
    scene: Scene,
    axes: Sequence[Axis],
    folder: Path,
    *,
    gauge: Gauge | None = None,
    refine_peaks: int = 0,
    jobs: int = 1,
    estimates: Estimates = "auto",
    progress: Callable[[int, int], None] = lambda done, points: None,
) -> Sweep:
    """Analyse a scene on a grid of values; every process of `MPI.COMM_WORLD` calls this and gets the sweep."""
    refuse_cases(scene, "a sweep")
    if not scene.members():
        raise SceneError("no link has a member, and a sweep compares strains", place="links")
    if refine_peaks and (len(axes) != 1 or axes[0].whole):
        message = "points can be added at peaks of a sweep over one field that is not a whole number"
        raise SceneError(message, place=", ".join(axis.path for axis in axes))
    at_peaks = at_peaks_alone(scene, estimates, math.prod(len(axis.values) for axis in axes))
    if jobs > 1 and MPI.COMM_WORLD.size > 1:
        raise MechanismError("the processes of mpirun share the points already: leave --jobs out, or mpirun")
    data, comm = stated_data(scene), MPI.COMM_WORLD
    with Workers(jobs) as workers:
        run = SweepRun(data, tuple(axes), folder, gauge or Gauge(), comm, progress, workers, at_peaks)
        run.at_root(run.claim_folder)
        values = run.over([axis.values for axis in axes], refine_peaks)
        records = run.at_root(lambda: run.answers(values))
        same = run
        if (one := OneEquation.of(run.any_scene, records)) is not None:
            unlike = [point for point, record in zip(grid(values), records) if one.lacks(record)]
            same, its_own = replace(run, scene=one.scene(run.scene)), run.with_errors(values)
            found = dict(zip(unlike, same.answers_of(unlike, its_own)))
            records = [one.chosen(found.get(point), record) for point, record in zip(grid(values), records)]
        between = ""
        if len(axes) == 1 and not axes[0].whole:
            records = run.at_root(lambda: fill_gaps(run, values[0], records))
            members = list(scene.members())
            if not refine_peaks:
                between = run.at_root(lambda: largest_between(values[0], records, same.answer_at, members))
    return run.at_root(lambda: _written(run.finish(values, records).assign_attrs(between=between), folder))


def _written(data: xr.Dataset, folder: Path) -> Sweep:
    """Write the dataset of a sweep into its folder."""
    found = Sweep(data)
    found.save(folder / "sweep.nc")
    return found
