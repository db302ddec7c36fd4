"""Positions of a linkage at drive angles, on the scene's assembly branch, and its motion at any rate of the drive."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, TypeVar

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import AssemblyError
from fenics_mech.kinematics.assembly import AssemblyBranch, coordinates_at, derivatives, follow_branch, side
from fenics_mech.kinematics.conditioning import refuse_singular
from fenics_mech.kinematics.freedom import free_motions
from fenics_mech.kinematics.loops import Loops
from fenics_mech.kinematics.motion import Motion, as_motion
from fenics_mech.kinematics.start import assemble
from fenics_mech.scene import Scene

Made = TypeVar("Made")


@dataclass(frozen=True)
class CacheLimits:
    """How many of the things that are costly to make are kept."""

    most_paths: int = 12  # sets of angles that a linkage keeps: an analysis takes 2 to 8, and 3 beside sharp peaks
    most_made: int = 2  # things of one kind that the positions at a set of angles keep


CACHE = CacheLimits()


class Branch:
    """The assembly branch of a linkage, followed as far as anyone asks."""

    def __init__(self, loops: Loops) -> None:
        self.loops = loops
        self._known: AssemblyBranch | None = None

    def over(self, theta: Array) -> AssemblyBranch:
        """Give points of the branch over the range of some drive angles (rad), or over more."""
        # theta (angles,) (rad)
        known = self._known
        if known is None or theta.min() < known.theta[0] or theta.max() > known.theta[-1]:
            self._known = known = follow_branch(self.loops, assemble(self.loops), theta)
        return known


class Linkage:
    """The links of a scene as its drives move them, at any rate.

    Its branch is followed once, and the positions at a set of angles are found once. Scenes that differ in the rate of
    their drives alone, in loads, sections or anything else that moves no link, have them in common.

    Parameters
    ----------
    scene
        The linkage and its drives, of which there is one or more.
    """

    def __init__(self, scene: Scene) -> None:
        self.loops = Loops.of(scene)
        self.branch = Branch(self.loops)
        self._paths: dict[tuple[bytes, bytes], Path] = {}

    def path(self, theta: Array, near: Path | None = None) -> Path:
        """Give the positions at drive angles (rad), ``(angles,)``; errors and `near` as of `solve_motion`."""
        # theta (angles,) (rad)
        key = theta.tobytes(), b"" if near is None else near.theta.tobytes()
        path = self._paths.pop(key, None)
        if path is None:
            q = coordinates_at(self.loops, theta, self.branch.over(theta) if near is None else near.branch)
            refuse_singular(self.loops, theta, q)
            path = Path(self.branch, theta, q, *derivatives(self.loops, q, theta))
        self._paths[key] = path
        if len(self._paths) > CACHE.most_paths:
            del self._paths[next(iter(self._paths))]
        return path

    def motion(self, theta: Array, rate: float, near: Path | None = None) -> Motion:
        """Give the motion at drive angles (rad), ``(angles,)``; errors and `near` as of `solve_motion`."""
        # theta (angles,) (rad); rate (rad/s)
        motion = self.path(theta, near).motion(rate)
        object.__setattr__(motion, "linkage", self)
        return motion


@dataclass(frozen=True, eq=False)
class Path:
    """Positions of the links at drive angles, and what is made from them without a rate of the drive."""

    # The linkage has its paths, and no path has the linkage: kept by each other, they would outlive their use.

    whole: Branch  # the branch that they are on
    theta: Array  # drive coordinate (rad), (angles,)
    q: Array  # coordinates of the loops and their two derivatives by theta, (angles, 3 links)
    slope: Array
    curvature: Array
    _made: dict[str, dict[Hashable, tuple[tuple[object, ...], Any]]] = field(init=False, default_factory=dict)

    @property
    def loops(self) -> Loops:
        """The loop equations."""
        return self.whole.loops

    @cached_property
    def branch(self) -> AssemblyBranch:
        """The positions as points of their branch."""
        order = np.argsort(self.theta)
        return AssemblyBranch(
            theta=self.theta[order],
            q=self.q[order],
            rate=self.slope[order],
            curvature=self.curvature[order],
            side=float(side(self.loops, self.q[:1])[0]),
        )

    def motion(self, rate: float) -> Motion:
        """Give the motion at a constant rate of the drive coordinate (rad/s)."""
        # rate (rad/s)
        velocity, acceleration = rate * self.slope, rate**2 * self.curvature
        motion = as_motion(self.loops, self.theta, self.theta / rate, self.q, velocity, acceleration)
        object.__setattr__(motion, "path", self)
        object.__setattr__(motion, "rate", rate)
        return motion

    def once(self, what: str, sources: tuple[object, ...], make: Callable[[], Made], key: Hashable = None) -> Made:
        """Make something from these positions, or give it as it was made before."""
        made = self._made.setdefault(what, {})
        place = (key, *map(id, sources))
        found = made.pop(place) if place in made else (sources, make())  # what keeps the sources keeps their identity
        made[place] = found
        if len(made) > CACHE.most_made:
            del made[next(iter(made))]
        return found[1]


def solve_motion(scene: Scene, theta: Array, near: Motion | None = None) -> Motion:
    """Solve the loop equations of a scene and their two time derivatives.

    Parameters
    ----------
    scene
        The linkage and its drives.
    theta
        Drive coordinates (rad), in any order, shape ``(angles,)``.
    near
        A motion of the same scene with angles close to these, which spares following the branch from the start.

    Returns
    -------
    Motion
        Positions by the loop equations, velocities by (6.2), accelerations by (6.3). Without a drive, the linkage at
        rest and the small motions that its joints leave.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at the start, or the drive cannot reach one of the angles.
    """
    theta = np.asarray(theta, dtype=float)
    if not scene.drives:
        return _at_rest(Loops.of(scene), theta)
    if near is None or near.linkage is None:
        return Linkage(scene).motion(theta, scene.cycle_rate)
    return near.linkage.motion(theta, scene.cycle_rate, near.path)


def start_motion(scene: Scene) -> Motion:
    """Give the positions of the links at the start, at rest, one angle.

    Joints with a clearance or a bushing are tight, where the links can be assembled so.

    Parameters
    ----------
    scene
        The linkage, with or without drives and freedoms.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled.
    """
    if not scene.open_joints:
        loops = Loops.of(scene)
        return _held_at(loops, assemble(loops), np.zeros(1))
    tight = Loops.of(scene.model_copy(update={"joint_laws": {}}))
    try:
        return _held_at(tight, assemble(tight), np.zeros(1))
    except AssemblyError:
        stated = {name: part for name, part in scene.freedoms.items() if part.start is not None}
        loose = Loops.of(scene.model_copy(update={"freedoms": stated}))
        return _held_at(loose, assemble(loose), np.zeros(1))


def _at_rest(loops: Loops, theta: Array) -> Motion:
    """Give the motion of a linkage that nothing drives; it may be held more often than it needs, or less."""
    q = assemble(loops)
    return replace(_held_at(loops, q, theta), free=free_motions(loops, q))


def _held_at(loops: Loops, q: Array, theta: Array) -> Motion:
    """Give the motion of links that rest at their coordinates ``(3 links,)``."""
    pose = np.broadcast_to(q, (len(theta), len(q)))
    still = np.zeros_like(pose)
    return as_motion(loops, theta, np.zeros_like(theta), pose, still, still)
