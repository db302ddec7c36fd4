"""Position, velocity and acceleration of all links at all drive angles, on the scene's assembly branch."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.kinematics.assembly import Branch, assemble, derivatives, follow, follow_branch, side
from fenics_mech.kinematics.conditioning import refuse_singular
from fenics_mech.kinematics.freedom import free_motions
from fenics_mech.kinematics.loops import Loops
from fenics_mech.scene import Scene
from fenics_mech.scene.analysis_options import MOST_SUB_INTERVALS

LARGEST_BETWEEN = 3.0  # acceleration between the angles of a cycle over that at them
SHARP = 10.0  # acceleration over velocity, by the drive coordinate (rad), above which a velocity has a corner
AROUND = 101  # angles at which a corner is looked at


@dataclass(frozen=True)
class Motion:
    """Rigid-body motion of the links' frames. Arrays are ``(angles, links)``; vectors have x, y (fixed frame) last.

    Parameters
    ----------
    theta
        Drive coordinate (rad), shape ``(angles,)``.
    time
        Time (s), theta over the cycle's rate, shape ``(angles,)``.
    links
        Names of the links.
    position, velocity, acceleration
        Of the frames' origins (m, m/s, m/s^2), shape ``(angles, links, 2)``.
    angle, omega, alpha
        Angle, angular velocity and acceleration (rad, rad/s, rad/s^2); angles are continuous, not wrapped.
    free
        Small motions of the frames (m, m, rad) that the joints of a linkage at rest leave, ``(motions, links, 3)``; see
        `free_motions`. With drives there are none.
    """

    theta: Array
    time: Array
    links: tuple[str, ...]
    position: Array
    velocity: Array
    acceleration: Array
    angle: Array
    omega: Array
    alpha: Array
    free: Array = field(default_factory=lambda: np.zeros((0, 0, 3)))

    def part(self, angles: slice) -> Motion:
        """Give the motion at some of the angles."""
        arrays = {f.name: getattr(self, f.name)[angles] for f in fields(self) if f.name not in ("links", "free")}
        return replace(self, **arrays)

    def held(self) -> Motion:
        """Give the same positions at rest."""
        rates = {name: np.zeros_like(getattr(self, name)) for name in ("velocity", "acceleration", "omega", "alpha")}
        return replace(self, **rates)

    def of_point(self, link: str, point: tuple[float, float]) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration of a point of a link or the ground, each of shape ``(angles, 2)``."""
        if link == "ground":
            place = np.broadcast_to(np.array(point, dtype=float), (len(self.theta), 2))
            return place, np.zeros_like(place), np.zeros_like(place)
        i = self.links.index(link)
        c, s = np.cos(self.angle[:, i]), np.sin(self.angle[:, i])
        arm = np.stack([c * point[0] - s * point[1], s * point[0] + c * point[1]], axis=-1)
        normal = np.stack([-arm[:, 1], arm[:, 0]], axis=-1)
        omega, alpha = self.omega[:, i, None], self.alpha[:, i, None]
        return (
            self.position[:, i] + arm,
            self.velocity[:, i] + omega * normal,
            self.acceleration[:, i] + alpha * normal - omega**2 * arm,  # (6.29)
        )


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
    loops = Loops.of(scene)
    if not scene.drives:
        return _at_rest(loops, theta)
    rate = scene.cycle_rate
    q = follow(loops, theta, _branch(loops, near, rate) if near else follow_branch(loops, theta))
    refuse_singular(loops, theta, q)
    slope, curvature = derivatives(loops, q, theta)
    return as_motion(loops, theta, theta / rate, q, rate * slope, rate**2 * curvature)


@dataclass(frozen=True)
class Corner:
    """Where a link's velocity turns sharply.

    Parameters
    ----------
    link, theta
        Which link, and the drive coordinate (rad).
    peak
        Its angular acceleration there, over the square of the cycle's rate.
    enough
        Equal steps of a cycle, of which one is as long as the turn.
    """

    link: str
    theta: float
    peak: float
    enough: int


def missed_corner(scene: Scene, motion: Motion) -> Corner | None:
    """Find a corner of the motion, as at a small transmission angle, that the angles of a cycle miss.

    A link's velocity turns sharply there, and its acceleration is larger between the angles than at any of them by
    `LARGEST_BETWEEN`, or the links are to vibrate and it turns within one step.

    Parameters
    ----------
    scene
        The linkage and its drives.
    motion
        Its motion at all angles of the cycle.

    Returns
    -------
    Corner or None
        The sharpest turn, where the angles miss it.
    """
    loops = Loops.of(scene)
    branch = follow_branch(loops, motion.theta)
    ends = motion.theta.min(), motion.theta.max()
    inside = np.clip(branch.theta, *ends)
    highest = int((np.abs(branch.curvature[:, 2::3]).max(axis=1) * (branch.theta == inside)).argmax())
    first, last = max(highest - 1, 0), min(highest + 1, len(inside) - 1)
    theta = np.linspace(float(inside[first]), float(inside[last]), AROUND)
    rates, turns = (np.abs(part[:, 2::3]) for part in derivatives(loops, follow(loops, theta, branch), theta))
    place, link = np.unravel_index(int(turns.argmax()), turns.shape)
    peak, rate = float(turns[place, link]), max(float(rates[:, link].max()), 1.0)
    if peak < SHARP * rate:
        return None
    missed = peak > LARGEST_BETWEEN * np.abs(motion.alpha).max() / scene.cycle_rate**2
    enough, count = int(np.ceil(2 * np.pi * peak / rate)), len(motion.theta)
    missed = missed or (scene.analysis.method == "periodic" and count < enough)
    enough = 2 * count if count >= enough else enough  # as many may lie on both sides of it
    return Corner(motion.links[link], float(theta[place]), peak, enough) if missed else None


def positions_for_corners(scene: Scene, count: int, most: int = MOST_SUB_INTERVALS) -> int:
    """Give a number of equal steps of a cycle that miss no corner of the motion; see `missed_corner`.

    Parameters
    ----------
    scene
        The linkage and its drives.
    count, most
        Steps to begin with, and the largest number of them.
    """
    while count < most and (corner := missed_corner(scene, solve_motion(scene, scene.drive_angles(count)))):
        count = int(min(max(2 * count, corner.enough), most))
    return count


def refuse_unresolved(scene: Scene, motion: Motion) -> None:
    """Refuse a motion whose angles miss a corner.

    Parameters
    ----------
    scene, motion
        As of `missed_corner`.

    Raises
    ------
    SceneError
        With the link, the place of the corner and the number of positions that it takes.
    """
    if (corner := missed_corner(scene, motion)) is not None:
        raise SceneError(
            f"link {corner.link} has a corner of its motion near drive angle "
            f"{np.degrees(corner.theta):.6g} deg, which {len(motion.theta)} positions miss: its angular "
            f"acceleration is there {corner.peak:.3g} rad for each rad^2 of the drive",
            place="analysis.sub_intervals",
            hint=f"Take at least {corner.enough}, or lengths that keep away from dead centres; analysis.allow_coarse "
            "lets it pass",
        )


def as_motion(loops: Loops, theta: Array, time: Array, q: Array, velocity: Array, acceleration: Array) -> Motion:
    """Label the coordinates of the loops and their time derivatives, each ``(angles, 3 links)``."""
    poses, rates, seconds = (array.reshape(len(q), -1, 3) for array in (q, velocity, acceleration))
    return Motion(
        theta=theta,
        time=time,
        links=loops.links,
        position=poses[..., :2],
        velocity=rates[..., :2],
        acceleration=seconds[..., :2],
        angle=poses[..., 2],
        omega=rates[..., 2],
        alpha=seconds[..., 2],
    )


def _at_rest(loops: Loops, theta: Array) -> Motion:
    """Give the motion of a linkage that nothing drives; it may be held more often than it needs, or less."""
    q = assemble(loops)
    pose = np.broadcast_to(q, (len(theta), len(q)))
    still = np.zeros_like(pose)
    motion = as_motion(loops, theta, np.zeros_like(theta), pose, still, still)
    return replace(motion, free=free_motions(loops, q))


def coordinates(vectors: Array, angles: Array) -> Array:
    """Put x, y ``(angles, links, 2)`` and angles ``(angles, links)``, or their rates, into ``(angles, 3 links)``."""
    return np.concatenate([vectors, angles[..., None]], axis=-1).reshape(len(angles), -1)


def _branch(loops: Loops, motion: Motion, rate: float) -> Branch:
    """Points of the assembly branch that a motion went through."""
    order = np.argsort(motion.theta)
    q = coordinates(motion.position, motion.angle)[order]
    return Branch(
        theta=motion.theta[order],
        q=q,
        rate=coordinates(motion.velocity, motion.omega)[order] / rate,
        curvature=coordinates(motion.acceleration, motion.alpha)[order] / rate**2,
        side=float(side(loops, q[:1])[0]),
    )
