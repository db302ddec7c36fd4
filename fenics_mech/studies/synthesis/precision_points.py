"""Four-bars through precision points in closed form: of a function, of a path, and of the positions of a coupler.

Through three points there is one four-bar. Through five there are several or none, which the pins of a body in five
positions give.

Sources: Freudenstein, Trans. ASME 77 (1955) 853; Erdman and Sandor, Mechanism Design (1984), chapter 8; Sandor and
Erdman, Advanced Mechanism Design, volume 2 (1984), chapter 3.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations

import numpy as np

from fenics_mech.errors import SceneError
from fenics_mech.scene import FunctionTask, MotionTask, PathTask
from fenics_mech.scene.synthesis_tasks import THREE
from fenics_mech.studies.synthesis.five_positions import Dyad, dyads_of_five
from fenics_mech.studies.synthesis.planar_four_bar import CLOSE, Complex, FourBar, three_point_circle

Found = tuple[FourBar, list[float], list[str]]  # the four-bar, its crank's angles at the points, and what is wrong
FEW = "fewer than two pins move on circles, or a link has no length or 1000 times that between the points"
LONGEST = 1000.0  # link over the size of a task with five points


def function_generators(task: FunctionTask) -> list[Found]:
    """Find the four-bars whose follower is at given angles when their crank is."""
    # Of five angles only the turns from the first one count. Seen from the crank, the follower comes through five
    # positions then, in which its pivot is one pin on a circle; each other one is the coupler's.
    if len(task.crank) == THREE:
        return [_by_freudenstein(task)]
    phi, psi = (np.array(one) - one[0] for one in (task.crank, task.follower))
    seen = task.ground * np.exp(-1j * phi)
    found = []
    for dyad in dyads_of_five(seen, np.exp(1j * (psi - phi)), "crank"):
        crank, follower = dyad.pivot, dyad.pin
        coupler = abs(task.ground + follower - crank)
        if min(abs(crank), abs(follower), coupler) > CLOSE * max(abs(crank), abs(follower), task.ground):
            bare = FourBar(0j, complex(task.ground), abs(crank), coupler, abs(follower), 1.0)
            pins = [(crank * cmath.exp(1j * x), task.ground + follower * cmath.exp(1j * y)) for x, y in zip(phi, psi)]
            found.append(_assembled(bare, pins, (cmath.phase(crank) + phi).tolist()))
    few = "with these turns no pin of the follower stays at one distance from one of the crank"
    return _of_some_size(found, task.ground, "crank", few)


def _by_freudenstein(task: FunctionTask) -> Found:
    """Find the four-bar of three angles."""
    # Freudenstein's equation ``K1 cos(psi) - K2 cos(phi) + K3 = cos(phi - psi)`` is linear in ``K1 = d/a``, ``K2 =
    # d/c`` and ``K3 = (a^2 - b^2 + c^2 + d^2)/(2 a c)``.
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


def motion_generators(task: MotionTask) -> list[Found]:
    """Find the four-bars whose coupler comes through given positions."""
    # A pin of the coupler is on a circle about its fixed pivot. So three of its places give the pivot; and the fixed
    # pivot, seen from the coupler, gives the pin. Five positions leave no pin open: any two of those on circles are a
    # four-bar, with either as its crank's.
    at = np.array([complex(*pose.at) for pose in task.positions])
    turns = np.exp(1j * np.array([pose.angle for pose in task.positions]))
    of_three = len(at) == THREE
    couples = [_dyads_of_three(task, at, turns)] if of_three else list(permutations(dyads_of_five(at, turns), 2))
    found = [one for couple in couples if (one := _with_coupler(couple, at, turns))]
    return _of_some_size(found, np.inf if of_three else _size(at), "positions", FEW)


def _dyads_of_three(task: MotionTask, at: Complex, turns: Complex) -> tuple[Dyad, Dyad]:
    """Find the pivots of both pins of three positions, or the pins of both pivots."""
    stated, found = task.moving or task.fixed, []
    assert stated is not None
    for i, one in enumerate(stated):
        given = complex(*one)
        seen = at + given * turns if task.moving else (given - at) / turns
        centre = three_point_circle(seen.tolist())
        if centre is None:
            which = "moving" if task.moving else "fixed"
            raise _none("its three places are in line or the same, so that no circle goes through them", f"{which}.{i}")
        found.append(Dyad(given, centre) if task.moving else Dyad(centre, given))
    return found[0], found[1]


def _with_coupler(couple: tuple[Dyad, Dyad], at: Complex, turns: Complex) -> Found | None:
    """Give the four-bar whose coupler has two pins; None where a link would have no length."""
    first, second = couple
    places = [(complex(here + first.pin * turn), complex(here + second.pin * turn)) for here, turn in zip(at, turns)]
    along = second.pin - first.pin
    lengths = abs(places[0][0] - first.pivot), abs(along), abs(places[0][1] - second.pivot)
    if min(*lengths, abs(second.pivot - first.pivot)) <= CLOSE * max(lengths):
        return None
    bare = FourBar(first.pivot, second.pivot, *lengths, 1.0, -first.pin * cmath.exp(-1j * cmath.phase(along)))
    return _assembled(bare, places, [cmath.phase(pin - first.pivot) for pin, _ in places])


def path_generators(task: PathTask) -> list[Found]:
    """Find the four-bars whose coupler point is at five places when their crank has turned by given angles."""
    # A body that turns with the crank, and whose origin is at the places, comes through five positions. A four-bar
    # that guides it is a cognate of those that are sought: their cranks turn with its coupler (Roberts and
    # Chebyshev).
    at, turns = np.array([complex(*place) for place in task.path]), np.exp(1j * np.array(task.angles))
    couples = permutations(dyads_of_five(at, turns, "path"), 2)
    found = [one for couple in couples if (one := _cognate(couple, at, turns))]
    return _of_some_size(found, _size(at), "path", FEW)


def _cognate(couple: tuple[Dyad, Dyad], at: Complex, turns: Complex) -> Found | None:
    """Give the four-bar with the pivot of the first dyad, whose crank turns with the body; None without a length."""
    # Its crank is the line from the body's pin to the body's origin. Its coupler and its follower turn with the lines
    # from both pivots to their pins, times ``share``.
    first, second = couple
    if abs(second.pin - first.pin) <= CLOSE * max(abs(first.pin), abs(second.pin)):
        return None
    share = -first.pin / (second.pin - first.pin)
    pivot = first.pivot + share * (second.pivot - first.pivot)
    arms = at + first.pin * turns - first.pivot
    pins = [
        (first.pivot - first.pin * turn, first.pivot - first.pin * turn + share * arm) for turn, arm in zip(turns, arms)
    ]
    lengths = abs(first.pin), abs(share * arms[0]), abs(pins[0][1] - pivot)
    if min(*lengths, abs(pivot - first.pivot)) <= CLOSE * max(lengths):
        return None
    bare = FourBar(first.pivot, pivot, *lengths, 1.0, abs(share) * abs(arms[0]) / share)
    return _assembled(bare, pins, [cmath.phase(pin - first.pivot) for pin, _ in pins])


def _assembled(bare: FourBar, pins: Sequence[tuple[complex, complex]], angles: list[float]) -> Found:
    """Take the side on which the first position is, and say where others are on the other one."""
    sides = [bare.side_of(first, second) for first, second in pins]
    side = next((one for one in sides if one), 1.0)
    wrong = [k + 1 for k, one in enumerate(sides) if one not in (0.0, side)]
    said = [f"branch: position {k} is reached with the links assembled the other way only" for k in wrong]
    return replace(bare, side=side), angles, said


def _size(at: Complex) -> float:
    """Largest distance of places from their middle (m)."""
    return float(np.abs(at - at.mean()).max())


def _of_some_size(found: list[Found], size: float, place: str, message: str) -> list[Found]:
    """Give the four-bars without links that are nearly infinite beside a size (m), or raise where there is none."""
    near = [one for one in found if max(one[0].lengths) <= LONGEST * size]
    if not near:
        raise _none(message, place)
    return near


def _none(message: str, place: str) -> SceneError:
    return SceneError(f"no four-bar does this: {message}", place=place, hint="Move one of the points a little")
