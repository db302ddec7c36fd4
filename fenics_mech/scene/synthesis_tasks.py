"""What a four-bar is to do: a function of its crank, positions of its coupler, or the path of a point."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.base import Part
from fenics_mech.scene.bodies import Point
from fenics_mech.scene.files import read_toml, text_of
from fenics_mech.scene.units import Angle, AngularSpeed, Length

THREE, FIVE = 3, 5  # precision points for which there is a closed form


def _exact(count: int, what: str) -> None:
    """Raise where so many precision points have no closed form."""
    if count not in (THREE, FIVE):
        raise ValueError(f"there are {count} {what}: give {THREE} or {FIVE}")


class Task(Part):
    """What all tasks state.

    Parameters
    ----------
    speed
        Speed of the crank, or mean speed of one that swings (rad/s).
    least_transmission
        Smallest angle between coupler and follower that is not warned of (rad).
    """

    speed: Annotated[AngularSpeed, Field(gt=0)] = 2 * math.pi
    least_transmission: Annotated[Angle, Field(ge=0, le=math.pi / 2)] = math.radians(30)


class FunctionTask(Task):
    """A follower that is to be at three or five angles when the crank is at as many.

    Parameters
    ----------
    crank, follower
        Three angles from the line of the fixed pivots (rad), in the order in which they are passed. Of five only the
        turns from the first one count, and the synthesis finds where crank and follower begin.
    ground
        Distance of the fixed pivots (m).

    Examples
    --------
    >>> fm.FunctionTask(crank=("30 deg", "60 deg", "90 deg"), follower=("60 deg", "70 deg", "85 deg")).ground
    0.1
    """

    kind: Literal["function"] = "function"
    crank: tuple[Angle, ...]
    follower: tuple[Angle, ...]
    ground: Annotated[Length, Field(gt=0)] = 0.1

    def _check_keys(self) -> None:
        if len(self.crank) != len(self.follower):
            given = f"{len(self.crank)} angles of the crank and {len(self.follower)} of the follower"
            raise ValueError(f"there are {given}: give as many")
        _exact(len(self.crank), "angles")


class Pose(Part):
    """A position of a coupler.

    Parameters
    ----------
    at
        Place of the coupler's origin in the fixed frame (m).
    angle
        Angle of its x axis (rad).

    Examples
    --------
    >>> fm.Pose(at=("10 cm", 0), angle="30 deg").at
    (0.1, 0.0)
    """

    at: Point
    angle: Angle


class MotionTask(Task):
    """A coupler that is to come through three or five positions.

    Parameters
    ----------
    positions
        The positions, in the order in which they are passed.
    moving
        Of three positions: places of both pins on the coupler, in its frame (m), first that of the crank.
    fixed
        Instead, places of both fixed pivots (m): first that of the crank.

    Examples
    --------
    >>> poses = [{"at": (0, 0.1), "angle": 0}, {"at": (0.05, 0.12), "angle": 0.3}, {"at": (0.1, 0.11), "angle": 0.5}]
    >>> fm.MotionTask(positions=poses, moving=[(0, 0), (0.05, 0)]).kind
    'motion'
    """

    kind: Literal["motion"] = "motion"
    positions: tuple[Pose, ...]
    moving: tuple[Point, Point] | None = None
    fixed: tuple[Point, Point] | None = None

    def _check_keys(self) -> None:
        stated = (self.moving is not None) + (self.fixed is not None)
        _exact(len(self.positions), "positions")
        if len(self.positions) == FIVE and stated:
            raise ValueError("five positions leave no pin open: state neither `moving` nor `fixed`")
        if len(self.positions) == THREE and stated != 1:
            raise ValueError("three positions leave two pins open: state either `moving` or `fixed`")


class PathTask(Task):
    """A point of a coupler that is to follow a path.

    Parameters
    ----------
    path
        Places in the fixed frame (m), in the order in which they are passed. Five with their angles are met exactly.
    angles
        Angles that the crank turns from the first place to each one (rad), the first being 0. Without them any will do.
    closed
        Whether the crank turns once round for the whole path; five places do not ask for it.

    Examples
    --------
    >>> fm.PathTask(path=[(0.01 * k, 0.1) for k in range(10)], closed=False).angles
    ()
    """

    kind: Literal["path"] = "path"
    path: Annotated[tuple[Point, ...], Field(min_length=5, max_length=1000)]
    angles: tuple[Angle, ...] = ()
    closed: bool = True

    def _check_keys(self) -> None:
        if self.angles and len(self.angles) != len(self.path):
            raise ValueError(f"there are {len(self.path)} places and {len(self.angles)} angles: give as many")
        if len(self.path) == FIVE and not self.angles:
            raise ValueError("five places need `angles`: give them, or six places or more")

    @property
    def exact(self) -> bool:
        """Whether the places are met exactly."""
        return len(self.path) == FIVE


AnyTask = FunctionTask | MotionTask | PathTask
TASKS: dict[str, type[AnyTask]] = {"function": FunctionTask, "motion": MotionTask, "path": PathTask}


def load_task(path: str | Path) -> AnyTask:
    """Read the file of a task.

    Parameters
    ----------
    path
        A TOML file with the keys of one of the tasks.

    Raises
    ------
    SceneError
        When it cannot be read, or states no task.

    Examples
    --------
    >>> import pathlib
    >>> lines = ['kind = "function"', "crank = [0.5, 1.0, 1.5]", "follower = [1.0, 1.2, 1.5]"]
    >>> pathlib.Path("task.toml").write_text(chr(10).join(lines)) > 0
    True
    >>> fm.load_task("task.toml").crank
    (0.5, 1.0, 1.5)
    """
    path = Path(path)
    return read_toml(text_of(path, "task"), path.name, read_task)


def read_task(data: dict[str, Any]) -> AnyTask:
    """Make a task from plain data."""
    kind = data.get("kind")
    if not isinstance(kind, str) or kind not in TASKS:
        found = "a task needs its kind" if kind is None else f"there is no task {shortened(kind)}"
        raise SceneError(found, place="kind", hint=f'Write kind = "function"; known: {", ".join(TASKS)}')
    return TASKS[kind].read(data)
