"""Amplitude curves through folds: the periodic motions of a scene along a branch over one number, stable or not."""

from __future__ import annotations

import json
import logging
import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import ClassVar

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech._guard import guarded
from fenics_mech._version import __version__
from fenics_mech.answers.by_poses import result_of
from fenics_mech.answers.followed_by_poses import followable, followed
from fenics_mech.answers.solved_by_poses import Solved
from fenics_mech.errors import SceneError, SolverError, UnresolvedError
from fenics_mech.recovery import Result
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.recovery.peaks import curves_of
from fenics_mech.scene import Scene
from fenics_mech.scene.load_cases import refuse_cases
from fenics_mech.solve.continuation import FOLD
from fenics_mech.solve.stability_limits import STABILITY
from fenics_mech.studies.gauge import Gauge
from fenics_mech.studies.kept_points import KEPT
from fenics_mech.studies.kept_records import Record
from fenics_mech.studies.sweep_axes import placed, range_in_si, scene_data, unit_of
from fenics_mech.studies.sweep_points import reduced, tabulated

logger = logging.getLogger(__name__)
OWN = {  # by variable, beside those of a sweep: dimensions, unit, meaning
    "strain_highest": (("member",), "1", "highest strain of the outer fibres over the cycle"),
    "strain_lowest": (("member",), "1", "lowest strain of the outer fibres over the cycle"),
    "multiplier": (("disturbance", "part"), "1", "Floquet multiplier, largest magnitude first"),
    "strain_error": (("member",), "1", "error of the member's strain by all sources, estimated"),
    "stable": ((), "1", "1 where no disturbance grows, else 0"),
    "fold": ((), "1", "1 where the branch turns back in the number, else 0"),
    "iterations": ((), "1", "iterations of Newton's method"),
}
END = "the end of the range"
REAL = 1e-6  # imaginary part of a multiplier that counts as none


@dataclass(frozen=True)
class Branch(OfScene):
    """Periodic motions along a branch.

    Parameters
    ----------
    data
        One dimension "point" in the order of the branch, with the number as a coordinate named by its path, in SI; then
        members, joints, modes, harmonics, disturbances. Variables as in `kept_points.KEPT` and `OWN`, NaN where a
        point has none. ``attrs["ended"]`` says where the branch ended: at `END`, or why it was lost.

    Examples
    --------
    >>> scene = fm.load("demos/four_bar.toml").changed({"analysis.solver": "collocation", "analysis.sub_intervals": 36})
    >>> branch = fm.follow(scene, "drive.speed", ("100 rpm", "101 rpm"), points=1)
    >>> branch.whole, branch.changes()
    (True, [])
    """

    KIND: ClassVar[str] = "branch"
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech", "path", "ended")

    @property
    def path(self) -> str:
        """The number along which the branch was followed."""
        return str(self.data.attrs["path"])

    @property
    def values(self) -> Array:
        """The number at the points, ``(points,)``."""
        return self.data[self.path].to_numpy()

    @property
    def whole(self) -> bool:
        """Whether the branch was followed until it left the range."""
        return bool(self.data.attrs["ended"] == END)

    def changes(self) -> list[tuple[float, float, str]]:
        """Give the values of neighbouring points between which stability changes, and how.

        Returns
        -------
        list of tuple
            Both values (SI), and "fold", "branching", "period doubling" or "Neimark-Sacker".
        """
        stable, fold = (self.data[name].to_numpy() == 1 for name in ("stable", "fold"))
        found = []
        for k in np.flatnonzero(stable[1:] != stable[:-1]):
            leading = self.data["multiplier"].to_numpy()[k if stable[k + 1] else k + 1, 0]
            kind = "Neimark-Sacker" if abs(leading[1]) > REAL else "period doubling" if leading[0] < 0 else "branching"
            if kind == "branching" and fold[max(k - 1, 0) : k + 3].any():
                kind = "fold"
            found.append((float(self.values[k]), float(self.values[k + 1]), kind))
        return found

    def motions(self, value: float) -> list[tuple[float, bool]]:
        """Give every motion at a value of the number; between two points the number counts as linear.

        Parameters
        ----------
        value
            The number (SI).

        Returns
        -------
        list of tuple
            Place along the branch, in points from 0, and whether the motion is stable.
        """
        off, stable = self.values - value, self.data["stable"].to_numpy() == 1
        before = np.flatnonzero(off[:-1] * off[1:] < 0)
        places = [(k + off[k] / (off[k] - off[k + 1]), bool(stable[k] and stable[k + 1])) for k in before]
        return sorted(places + [(float(k), bool(stable[k])) for k in np.flatnonzero(off == 0)])


@guarded()
def follow(
    scene: Scene,
    path: str,
    ends: tuple[float | str, float | str],
    *,
    points: int = 40,
    most_points: int = 2000,
    gauge: Gauge | None = None,
    progress: Callable[[float], None] = lambda value: None,
    keep: Callable[[Branch], object] = lambda branch: None,
) -> Branch:
    """Follow the steady state of a scene over a number of it, from one end of a range until it leaves the range.

    Parameters
    ----------
    scene
        The scene; its `effects` are chosen at the start of the range.
    path
        Dotted path of the number ("drive.speed").
    ends
        Where to start, and the other end of the range: numbers (SI), or texts with a unit.
    points
        Smallest number of points over the range.
    most_points
        Points after which a branch that does not leave the range is given up.
    gauge
        Where strains are split into harmonics.
    progress
        Called with the value of each point before its strains are recovered.
    keep
        Called with the branch as far as it is known when an error, or the user, ends the search.

    Returns
    -------
    Branch
        The motions in the order of the branch, as far as it was followed, and where it ended.

    Raises
    ------
    SceneError
        When the scene's steady state cannot be followed.
    SolverError
        When there is no motion at the start. A branch that is lost later is given as far as it goes.

    Examples
    --------
    >>> scene = fm.load("demos/four_bar.toml").changed({"analysis.solver": "collocation", "analysis.sub_intervals": 36})
    >>> branch = fm.follow(scene, "drive.speed", ("100 rpm", "101 rpm"), points=1)
    >>> bool(branch.data["stable"].all())
    True
    """
    refuse_cases(scene, "a branch of motions")
    if scene.tolerance is not None:
        raise SceneError(
            "a branch is followed with one mesh and one number of steps, which no tolerance chooses",
            place="tolerance",
            hint="Leave it out, and give elements and analysis.sub_intervals",
        )
    if scene.analysis.solver == "harmonic-balance":
        raise SceneError(
            "a branch is followed by steps, and not by harmonics",
            place="analysis.solver",
            hint="Write solver = 'poses'",
        )
    if not (1 <= points < math.inf and most_points >= 2):
        raise SceneError(f"a branch has a point or more; found {points}, at most {most_points}", place=path)
    range_si = range_in_si(scene, path, ends)
    at_start = Scene.read(placed(scene_data(scene), {path: range_si[0]}))
    first = followable(at_start)
    data = scene_data(first)
    at = lru_cache(maxsize=8)(lambda value: Scene.read(placed(data, {path: value})))
    records: list[Record] = []
    values: list[float] = []
    ended = END

    def found() -> Branch:
        data = xr.Dataset(coords={path: ("point", values, {"units": unit_of(first, path)})})
        data = tabulated(data, records, {**KEPT, **OWN}, first, {"point": len(values)})
        data = data.assign_coords({"part": ["real", "imaginary"]} if "part" in data.dims else {})
        data.attrs = {"fenics_mech": __version__, "title": first.name, "scene": first.model_dump_json()}
        data.attrs |= {"path": path, "ended": ended, "gauge": json.dumps(asdict(gauge or Gauge()))}
        return Branch(data)

    try:
        for point, solved in followed(at, path, range_si, points):
            progress(point.value)
            told = {"fold": point.kind == FOLD, "iterations": len(point.cycle.changes)}
            records.append(_record(_result(solved), gauge or Gauge(), told))
            values.append(point.value)
            if len(values) >= most_points:
                ended = f"{most_points} points, and the branch has not left the range: follow it over a smaller one"
                break
    except SolverError as error:
        if not values:
            raise
        ended = str(error)
    except BaseException as error:
        if values:
            ended = f"broken off: {str(error) or type(error).__name__}"
            keep(found())
        raise
    return found()


def _result(solved: Solved) -> Result:
    """Give the result of a motion, without its errors where none is near by: at a fold finer meshes have none there."""
    try:
        return result_of(solved)
    except UnresolvedError:
        raise
    except SolverError as error:
        logger.info("no errors are estimated: %s", error)
    return result_of(replace(solved, scene=solved.scene.changed({"analysis.error_estimates": False})))


def _record(result: Result, gauge: Gauge, told: Record) -> Record:
    """Keep of a motion what a sweep keeps, and what `OWN` lists, of which `told` is known."""
    record, data, strain = reduced(result, gauge), result.data, curves_of(result, "strain")
    multiplier = np.zeros((0, 2))  # no vibration is slow enough for the steps
    if "multiplier" in data:
        multiplier = data["multiplier"].transpose(..., "part").to_numpy()
    if "strain_error" in data:
        record["values"]["strain_error"] = data["strain_error"].sum("source").to_numpy()
    record["values"] |= told | {
        "strain_highest": strain.highest()[1].max(axis=(1, 2)),
        "strain_lowest": strain.lowest()[1].min(axis=(1, 2)),
        "multiplier": multiplier,
        "stable": np.hypot(*multiplier.T).max(initial=0) <= 1 + STABILITY.tolerance,
    }
    return record
