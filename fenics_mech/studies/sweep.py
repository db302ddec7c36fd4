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
from fenics_mech.studies.saved_sweep import refuse_unlike
from fenics_mech.studies.sweep_axes import Axis, axes_of, stated_data
from fenics_mech.studies.sweep_gaps import fill_gaps
from fenics_mech.studies.sweep_peaks import Estimates, at_peaks_alone, largest_between
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
    values: Mapping[str, Sequence[float | str]] | Sequence[Axis],
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
        Values by dotted path: numbers (SI), or texts with a unit. `sweep_axes.parse_axes` gives them from texts.
    folder
        Where finished points are kept, so that a sweep that was ended goes on. Without one, nothing is written.
    gauge
        Where strains are split into harmonics.
    refine_peaks
        Largest number of points added where the peak strain is not resolved, for one field that is not a whole number.
    jobs
        Processes of this machine that compute the points. A point whose process is ended from outside is lost: it has
        the error "LostProcess", and the next sweep tries it again. Those of `mpirun` share the points too: all call
        this and get the same.
    estimates
        Where errors are estimated: at "all" points, or at the "peaks" of the strains and the ends of the ranges. These
        are then analysed again with estimates, and the sweep says of all others that there are none. Where a stated
        mesh or stated steps are too coarse, the text `too_coarse` says so. "auto" takes "peaks" for more than 24
        points, unless the scene chooses its effects or its mesh by estimates.
    progress
        Called before each point of this process with its number, from 0, and how many there are.

    Returns
    -------
    Sweep
        A dataset with one dimension per swept number.

    Raises
    ------
    SceneError
        When a path or a value is not valid, the folder holds another sweep, or nothing bends. When the points that are
        asked for at peaks, or the estimates there, are not possible.
    ResultError
        When a file cannot be written.
    MechanismError
        When another process ended with an error.

    Examples
    --------
    >>> scene = fm.load("demos/four_bar.toml").changed({"analysis.method": "quasi-static"})
    >>> found = fm.sweep(scene, {"drive.speed": ["100 rpm", "200 rpm"]})
    >>> small, large = found.data["peak_strain"].sel(member="coupler").values
    >>> bool(large > 3 * small)
    True
    """
    axes = axes_of(scene, values) if isinstance(values, Mapping) else values
    refuse_cases(scene, "a sweep")
    if not scene.members():
        raise SceneError("no link has a member, and a sweep compares strains", place="links")
    if refine_peaks and (len(axes) != 1 or axes[0].whole):
        message = "points can be added at peaks of a sweep over one field that is not a whole number"
        raise SceneError(message, place=", ".join(axis.path for axis in axes))
    at_peaks = at_peaks_alone(scene, estimates, math.prod(len(axis.values) for axis in axes))
    if jobs > 1 and MPI.COMM_WORLD.size > 1:
        raise MechanismError("the processes of mpirun share the points already: leave --jobs out, or mpirun")
    comm = MPI.COMM_WORLD
    with TemporaryDirectory() as made, Workers(jobs) as workers:
        place = Path(comm.bcast(made) if folder is None else folder)  # one for all processes
        run = SweepRun(stated_data(scene), tuple(axes), place, gauge or Gauge(), comm, progress, workers, at_peaks)
        run.at_root(run.claim_folder)
        taken = run.over([axis.values for axis in axes], refine_peaks)
        records, same, between = run.at_root(lambda: run.answers(taken)), run, ""
        if (one := OneEquation.of(run.any_scene, records)) is not None:
            unlike = [point for point, record in zip(grid(taken), records) if one.lacks(record)]
            same, its_own = replace(run, scene=one.scene(run.scene)), run.with_errors(taken)
            again = dict(zip(unlike, same.answers_of(unlike, its_own)))
            records = [one.chosen(again.get(point), record) for point, record in zip(grid(taken), records)]
        if len(axes) == 1 and not axes[0].whole:
            records = run.at_root(lambda: fill_gaps(run, taken[0], records))
            members = list(scene.members())
            if not refine_peaks:
                between = run.at_root(lambda: largest_between(taken[0], records, same.answer_at, members))
        return run.at_root(lambda: _written(run.finish(taken, records).assign_attrs(between=between), place))


def _written(data: xr.Dataset, folder: Path) -> Sweep:
    """Write the dataset of a sweep into its folder."""
    found = Sweep(data)
    found.save(folder / "sweep.nc")
    return found
