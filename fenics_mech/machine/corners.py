"""Corners of a motion that the angles of a cycle miss, as at small transmission angles."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import Linkage
from fenics_mech.scene import Scene
from fenics_mech.scene.base import SCENE

BETWEEN = 3.0  # acceleration between the angles of a cycle over that at them, from which on they miss a corner
SHARP = 10.0  # acceleration over velocity, by the drive coordinate (1/rad): above it a velocity has a corner
AROUND = 101  # angles at which a corner is looked at


class Corner(NamedTuple):
    """Where a link's velocity turns sharply."""

    link: str
    theta: float  # drive coordinate (rad)
    peak: float  # angular acceleration of the link there, over the square of the cycle's rate
    enough: int  # equal steps of a cycle, of which one is as long as the turn


def missed_corner(linkage: Linkage, theta: Array, vibrates: bool) -> Corner | None:
    """Find the sharpest turn of a link's velocity, as at a small transmission angle, that angles of a cycle miss."""
    # Its acceleration is larger between the angles than at any of them. Where the links vibrate, a turn within one
    # step counts too.
    rate, led = linkage.scene.cycle_rate, linkage.led(theta)
    knots = np.clip(led.t * rate, theta.min(), theta.max())
    turned = np.abs(led.a[:, 2 : linkage.bodies.machine.n : 3]).max(axis=1)
    highest = int((turned * (led.t * rate == knots)).argmax())
    first, last = sorted((float(knots[max(highest - 1, 0)]), float(knots[min(highest + 1, len(knots) - 1)])))
    around, whole = linkage.motion(np.linspace(first, last, AROUND)), linkage.motion(theta)
    rates, turns = np.abs(around.omega / rate), np.abs(around.alpha / rate**2)
    place, link = np.unravel_index(int(turns.argmax()), turns.shape)
    peak, fastest = float(turns[place, link]), max(float(rates[:, link].max()), 1.0)
    if peak < SHARP * fastest:
        return None
    enough, count = int(np.ceil(TURN * peak / fastest)), len(theta)
    missed = peak > BETWEEN * np.abs(whole.alpha / rate**2).max() or (vibrates and count < enough)
    enough = 2 * count if count >= enough else enough  # as many may lie on both sides of it
    return Corner(around.links[link], float(around.theta[place]), peak, enough) if missed else None


def positions_for_corners(linkage: Linkage, angles: Callable[[int], Array], vibrates: bool, count: int) -> int:
    """Give a number of equal steps of a cycle, not below a count, that miss no corner of the motion."""
    while count < SCENE.most_sub_intervals:
        if (corner := missed_corner(linkage, angles(count), vibrates)) is None:
            break
        count = int(min(max(2 * count, corner.enough), SCENE.most_sub_intervals))
    return count


def refuse_unresolved(scene: Scene) -> None:
    """Raise `SceneError` where positions over a cycle miss a corner of the motion, unless coarse answers may pass."""
    analysis = scene.analysis
    if analysis.method not in ("periodic", "quasi-static") or not scene.drives or analysis.allow_coarse:
        return
    theta = scene.drive_angles(analysis.sub_intervals)
    if (corner := missed_corner(Linkage(scene), theta, vibrates=analysis.method == "periodic")) is not None:
        raise SceneError(
            f"link {corner.link} has a corner of its motion near drive angle "
            f"{np.degrees(corner.theta):.6g} deg, which {len(theta)} positions miss: its angular "
            f"acceleration there is {corner.peak:.3g} rad for each rad^2 of the drive",
            place="analysis.sub_intervals",
            hint=f"Take at least {corner.enough}, or lengths that keep away from dead centres; analysis.allow_coarse "
            "lets it pass",
        ).finer_by(sub_intervals=corner.enough)
