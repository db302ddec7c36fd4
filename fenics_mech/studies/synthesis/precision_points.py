"""Four-bars through three precision points in closed form: of a function, and of the positions of a coupler.

Sources: Freudenstein, Trans. ASME 77 (1955) 853; Erdman and Sandor, Mechanism Design (1984), chapter 8.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fenics_mech.errors import SceneError
from fenics_mech.scene import FunctionTask, MotionTask
from fenics_mech.studies.synthesis.planar_four_bar import CLOSE, FourBar, three_point_circle

Found = tuple[FourBar, list[float], list[str]]  # the four-bar, its crank's angles at the points, and what is wrong


def function_generator(task: FunctionTask) -> Found:
    """Find the four-bar whose follower is at three angles when its crank is at three.

    Freudenstein's equation ``K1 cos(psi) - K2 cos(phi) + K3 = cos(phi - psi)`` is linear in ``K1 = d/a``,
    ``K2 = d/c`` and ``K3 = (a^2 - b^2 + c^2 + d^2)/(2 a c)``.

    Parameters
    ----------
    task
        The angles.

    Raises
    ------
    SceneError
        When no four-bar has them.
    """
    phi, psi, d = np.array(task.crank), np.array(task.follower), task.ground
    matrix = np.stack([np.cos(psi), -np.cos(phi), np.ones(3)], axis=1)
    if abs(np.linalg.det(matrix)) < CLOSE:
        raise _none("these angles leave Freudenstein's equation without an answer", "crank")
    k1, k2, k3 = np.linalg.solve(matrix, np.cos(phi - psi))
    if min(abs(k1), abs(k2)) < CLOSE:
        raise _none("these angles need a link of infinite length", "crank")
    a, c = float(d / k1), float(d / k2)
    square = a**2 + c**2 + d**2 - 2 * a * c * k3
    if square <= (CLOSE * d) ** 2:
        raise _none("these angles need a coupler of no length", "crank")
    bare = FourBar(0j, complex(d, 0), a, math.sqrt(square), c, 1.0)
    pins = [(a * cmath.exp(1j * x), d + c * cmath.exp(1j * y)) for x, y in zip(phi, psi)]
    return _assembled(bare, pins, phi.tolist())


def motion_generator(task: MotionTask) -> Found:
    """Find the four-bar whose coupler comes through three positions.

    A pin of the coupler is on a circle about its fixed pivot. So three of its places give the pivot; and the fixed
    pivot, seen from the coupler, gives the pin.

    Parameters
    ----------
    task
        The positions, and the pins or the pivots.

    Raises
    ------
    SceneError
        When the places of a pin are in line, or the coupler has no length.
    """
    poses = [(complex(*pose.at), cmath.exp(1j * pose.angle)) for pose in task.positions]
    stated = task.moving or task.fixed
    assert stated is not None
    pins, pivots = [], []
    for i, one in enumerate(stated):
        given = complex(*one)
        seen = [at + given * turn if task.moving else (given - at) / turn for at, turn in poses]
        centre = three_point_circle(seen)
        if centre is None:
            which = "moving" if task.moving else "fixed"
            raise _none("its three places are in line or the same, so that no circle goes through them", f"{which}.{i}")
        pins.append(given if task.moving else centre)
        pivots.append(centre if task.moving else given)
    places = [(at + pins[0] * turn, at + pins[1] * turn) for at, turn in poses]
    lengths = abs(places[0][0] - pivots[0]), abs(pins[1] - pins[0]), abs(places[0][1] - pivots[1])
    if min(*lengths, abs(pivots[1] - pivots[0])) <= CLOSE * max(lengths):
        raise _none("a link would have no length", "positions")
    origin_of_coupler = -pins[0] * cmath.exp(-1j * cmath.phase(pins[1] - pins[0]))
    bare = FourBar(pivots[0], pivots[1], *lengths, 1.0, origin_of_coupler)
    return _assembled(bare, places, [cmath.phase(first - pivots[0]) for first, _ in places])


def _assembled(bare: FourBar, pins: Sequence[tuple[complex, complex]], angles: list[float]) -> Found:
    """Take the side on which the first position is, and say where others are on the other one."""
    sides = [bare.side_of(first, second) for first, second in pins]
    side = next((one for one in sides if one), 1.0)
    wrong = [k + 1 for k, one in enumerate(sides) if one not in (0.0, side)]
    said = [f"branch: position {k} is reached with the links assembled the other way only" for k in wrong]
    return replace(bare, side=side), angles, said


def _none(message: str, place: str) -> SceneError:
    return SceneError(f"no four-bar does this: {message}", place=place, hint="Move one of the three a little")
