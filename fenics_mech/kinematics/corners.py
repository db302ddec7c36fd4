"""Corners of a motion that the angles of a cycle miss, as at small transmission angles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.kinematics.assembly import coordinates_at, derivatives
from fenics_mech.kinematics.linkage import Linkage, Path
from fenics_mech.scene import Scene
from fenics_mech.scene.base import SCENE


@dataclass(frozen=True)
class CornerLimits:
    """When the motion of a linkage has corners that positions miss."""

    largest_between: float = 3.0  # acceleration between the angles of a cycle over that at them
    sharp: float = 10.0  # acceleration over velocity, by the drive coordinate (1/rad): above it a velocity has a corner
    around: int = 101  # angles at which a corner is looked at


CORNERS = CornerLimits()


@dataclass(frozen=True)
class Corner:
    """Where a link's velocity turns sharply."""

    link: str  # which link, and the drive coordinate (rad)
    theta: float
    peak: float  # its angular acceleration there, over the square of the cycle's rate
    enough: int  # equal steps of a cycle, of which one is as long as the turn


def missed_corner(path: Path, vibrates: bool) -> Corner | None:
    """Find a corner of a motion, as at a small transmission angle, that the angles of a cycle miss.

    A link's velocity turns sharply there. Its acceleration is larger between the angles than at any of them by
    `CORNERS.largest_between`. Where the links vibrate, a turn within one step counts too.

    Parameters
    ----------
    path
        Positions at all angles of the cycle.
    vibrates
        Whether the links vibrate, as in a periodic response.

    Returns
    -------
    Corner or None
        The sharpest turn, where the angles miss it.
    """
    return path.once("corner", (), lambda: _missed_corner(path, vibrates), key=vibrates)


def _missed_corner(path: Path, vibrates: bool) -> Corner | None:
    loops, branch = path.loops, path.whole.over(path.theta)
    inside = np.clip(branch.theta, path.theta.min(), path.theta.max())
    highest = int((np.abs(branch.curvature[:, 2::3]).max(axis=1) * (branch.theta == inside)).argmax())
    first, last = max(highest - 1, 0), min(highest + 1, len(inside) - 1)
    theta = np.linspace(float(inside[first]), float(inside[last]), CORNERS.around)
    rates, turns = (np.abs(part[:, 2::3]) for part in derivatives(loops, coordinates_at(loops, theta, branch), theta))
    place, link = np.unravel_index(int(turns.argmax()), turns.shape)
    peak, rate = float(turns[place, link]), max(float(rates[:, link].max()), 1.0)
    if peak < CORNERS.sharp * rate:
        return None
    missed = peak > CORNERS.largest_between * np.abs(path.curvature[:, 2::3]).max()
    enough, count = int(np.ceil(2 * np.pi * peak / rate)), len(path.theta)
    missed = missed or (vibrates and count < enough)
    enough = 2 * count if count >= enough else enough  # as many may lie on both sides of it
    return Corner(loops.links[link], float(theta[place]), peak, enough) if missed else None


def positions_for_corners(
    linkage: Linkage, angles: Callable[[int], Array], vibrates: bool, count: int, most: int = SCENE.most_sub_intervals
) -> int:
    """Give a number of equal steps of a cycle that miss no corner of the motion; see `missed_corner`.

    Parameters
    ----------
    linkage
        The links as their drives move them.
    angles
        Drive angles (rad) of so many equal steps of the cycle, as `Scene.drive_angles`.
    vibrates
        As of `missed_corner`.
    count, most
        Steps to begin with, and the largest number of them.
    """
    while count < most:
        if (corner := missed_corner(linkage.path(angles(count)), vibrates)) is None:
            break
        count = int(min(max(2 * count, corner.enough), most))
    return count


def refuse_unresolved(scene: Scene) -> None:
    """Refuse a scene whose positions over a cycle miss a corner of its motion, unless it lets coarse answers pass.

    Parameters
    ----------
    scene
        The scene.

    Raises
    ------
    SceneError
        With the link, the place of the corner and the number of positions that it takes.
    """
    analysis = scene.analysis
    if analysis.method not in ("periodic", "quasi-static") or not scene.drives or analysis.allow_coarse:
        return
    path = Linkage(scene).path(scene.drive_angles(analysis.sub_intervals))
    if (corner := missed_corner(path, vibrates=analysis.method == "periodic")) is not None:
        raise SceneError(
            f"link {corner.link} has a corner of its motion near drive angle "
            f"{np.degrees(corner.theta):.6g} deg, which {len(path.theta)} positions miss: its angular "
            f"acceleration there is {corner.peak:.3g} rad for each rad^2 of the drive",
            place="analysis.sub_intervals",
            hint=f"Take at least {corner.enough}, or lengths that keep away from dead centres; analysis.allow_coarse "
            "lets it pass",
        ).finer_by(sub_intervals=corner.enough)
