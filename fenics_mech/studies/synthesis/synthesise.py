"""Dimensions of a four-bar from what it is to do, with what may be wrong with it, as a scene."""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech.errors import MechanismError
from fenics_mech.scene import FunctionTask, MotionTask, PathTask, Scene
from fenics_mech.studies.synthesis.path_search import fits
from fenics_mech.studies.synthesis.planar_four_bar import COURSE, TURN, Course, FourBar, course_of
from fenics_mech.studies.synthesis.precision_points import (
    function_generators,
    motion_generators,
    path_generators,
)

AnyTask = FunctionTask | MotionTask | PathTask
MATERIAL = {"modulus": 71e9, "density": 2700.0}  # aluminium
WIDTH, HEIGHT = 1 / 10, 1 / 40  # of the bars, over the longest link that is not the ground
SAME = 1e-6  # share of a path's size: errors below it are one
WORSE = 2.0  # times the least error, up to which a linkage with nothing wrong is taken instead


@dataclass(frozen=True)
class Synthesised:
    """A four-bar that does what a task asks for.

    Parameters
    ----------
    task
        The task.
    linkage
        Its dimensions.
    course
        How its crank passes the positions.
    error
        Largest distance from the asked places (m); 0 in closed form.
    defects
        What is wrong with it, in words: order, branch and transmission angle.

    Examples
    --------
    >>> task = fm.FunctionTask(crank=("30 deg", "60 deg", "90 deg"), follower=("60 deg", "70 deg", "85 deg"))
    >>> found = fm.synthesise(task)
    >>> [round(length, 4) for length in found.linkage.lengths]
    [0.0259, 0.1071, 0.0502, 0.1]
    """

    task: AnyTask
    linkage: FourBar
    course: Course
    error: float
    defects: tuple[str, ...]

    @property
    def scene(self) -> Scene:
        """The four-bar as a scene: bars of aluminium, whose crank turns, or swings where it cannot turn."""
        linkage, start = self.linkage, self.course.start
        first, second = (complex(pin[0]) for pin in linkage.pins(np.array([start])))
        ends = {"crank": ("O", "A", linkage.crank), "coupler": ("A", "B", linkage.coupler)}
        ends["follower"] = ("C", "B", linkage.follower)
        angles = (start, cmath.phase(second - first), cmath.phase((second - linkage.pivot) / linkage.follower))
        longest = max(linkage.lengths[:3])
        data: dict[str, Any] = {
            "name": f"four-bar for a {self.task.kind}",
            "materials": {"aluminium": MATERIAL},
            "sections": {"bar": {"shape": "rectangle", "width": WIDTH * longest, "height": HEIGHT * longest}},
            "ground": {"points": {"O": _pair(linkage.origin), "C": _pair(linkage.pivot)}},
            "links": {
                name: {
                    "points": {one: (0.0, 0.0), other: (length, 0.0)},
                    "members": {one + other: {"ends": (one, other), "section": "bar", "material": "aluminium"}},
                    "angle": angle,
                }
                for (name, (one, other, length)), angle in zip(ends.items(), angles)
            },
            "joints": {
                "O": {"connect": ("ground.O", "crank.O")},
                "A": {"connect": ("crank.A", "coupler.A")},
                "B": {"connect": ("coupler.B", "follower.B")},
                "C": {"connect": ("ground.C", "follower.C")},
            },
            "drive": _drive(self),
            "damping": {"ratio": 0.01},
            "effects": "auto",  # slow links of bars do not vibrate
        }
        if not isinstance(self.task, FunctionTask):
            data["points"] = {"P": {"at": "coupler.A", "offset": _pair(linkage.point)}}
        return Scene.read(data)

    @property
    def transmission(self) -> float:
        """Smallest angle between coupler and follower in the motion (rad)."""
        angles = self.course.start + np.linspace(0, TURN, COURSE) if self.linkage.turns else self.course.angles
        return float(np.nanmin(self.linkage.transmission(angles)))


def synthesise(task: AnyTask, *, starts: int = 200, seed: int = 0) -> Synthesised:
    """Find a four-bar that does what a task asks for.

    Functions, positions, and five places of a path with angles have a closed form; of several four-bars it gives the
    first of `four_bars`. Other paths are searched for by least squares from random starts.

    Parameters
    ----------
    task
        The task.
    starts
        Number of searches for a path.
    seed
        Of their starts.

    Raises
    ------
    SceneError
        When no four-bar does it.
    MechanismError
        When no search for a path comes to an end.

    Examples
    --------
    >>> poses = [((0, 0.04), "20 deg"), ((-0.02, 0.033), "22 deg"), ((-0.036, 0.015), "30 deg")]
    >>> poses = [fm.Pose(at=place, angle=angle) for place, angle in poses]
    >>> found = fm.synthesise(fm.MotionTask(positions=poses, moving=[(0, 0), (0.06, 0)]))
    >>> found.linkage.kind, found.defects
    ('triple rocker', ())
    """
    return four_bars(task, starts=starts, seed=seed)[0]


def four_bars(task: AnyTask, *, starts: int = 200, seed: int = 0) -> list[Synthesised]:
    """Find all four-bars that do what a task asks for in closed form, or one where it is searched for.

    Five angles have three four-bars at most, five positions and five places of a path twelve at most.

    Parameters
    ----------
    task, starts, seed
        As of `synthesise`.

    Returns
    -------
    list
        First those with the fewest defects; of these those with the largest transmission angle.

    Raises
    ------
    SceneError, MechanismError
        As `synthesise`.

    Examples
    --------
    >>> crank = ("0 deg", "11 deg", "28 deg", "46 deg", "57 deg")
    >>> follower = ("0 deg", "15.1 deg", "34.8 deg", "50.7 deg", "58.2 deg")
    >>> [one.linkage.kind for one in fm.four_bars(fm.FunctionTask(crank=crank, follower=follower))]
    ['triple rocker']
    """
    if isinstance(task, PathTask) and not task.exact:
        return [_best_of_paths(task, starts, seed)]
    if isinstance(task, PathTask):
        generators = path_generators(task)
    else:
        generators = function_generators(task) if isinstance(task, FunctionTask) else motion_generators(task)
    found = [_judged(task, linkage, angles, wrong, 0.0) for linkage, angles, wrong in generators]
    return sorted(found, key=lambda one: (len(one.defects), -one.transmission))


def _judged(task: AnyTask, linkage: FourBar, angles: Sequence[float], wrong: list[str], error: float) -> Synthesised:
    """Add what is wrong with the course and with the transmission angle."""
    course, hindered = course_of(linkage, angles)
    found = Synthesised(task, linkage, course, error, ())
    least, asked = np.degrees(found.transmission), np.degrees(task.least_transmission)
    poor = [f"transmission angle: it falls to {least:.1f} deg, below {asked:.4g} deg"] if least < asked else []
    return Synthesised(task, linkage, course, error, (*wrong, *hindered, *poor))


def _best_of_paths(task: PathTask, starts: int, seed: int) -> Synthesised:
    """Take the linkage of the least error, or one with nothing wrong that is nearly as good."""
    places = np.array([complex(*place) for place in task.path])
    size = float(np.abs(places - places.mean()).max())
    if size == 0:
        raise MechanismError("all places of the path are one: give a path of some length")
    found = []
    for linkage, angles in fits(task, starts, seed):
        error = float(np.abs(linkage.points(angles) - places).max())
        if np.isfinite(error):
            found.append(_judged(task, linkage, angles.tolist(), [], error))
            if error <= SAME * size and not found[-1].defects:
                break
    if not found:
        raise MechanismError("no four-bar was found for this path: take more --starts, or another path")
    least = min(one.error for one in found)
    good = [one for one in found if one.error <= max(WORSE * least, SAME * size)]
    return min(good, key=lambda one: (len(one.defects), round(one.error / size, 9)))


def _drive(found: Synthesised) -> dict[str, Any]:
    """Turn the crank as the positions follow, or let it swing over them where it cannot turn."""
    course, speed = found.course, found.task.speed
    turned = course.turned[-1]
    if found.linkage.turns:
        return {"joint": "O", "speed": float(np.copysign(speed, turned)), "start": course.start}
    law = {"kind": "harmonics", "mean": course.start + turned / 2, "cosine": (-turned / 2,)}
    return {"joint": "O", "law": law, "period": 2 * abs(turned) / speed}


def _pair(place: complex) -> tuple[float, float]:
    return float(place.real), float(place.imag)
