"""What the drive can reach: where it locks, where the motion is not unique, and where force is transmitted worst.

The smallest singular value of the rows' derivatives, made free of units, is 0 at a dead centre, where the drive cannot
go on, and at a change point, where the linkage can go on in two ways. Its minima tell where force is transmitted worst.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import TURN
from fenics_mech._guard import guarded
from fenics_mech.machine.assembly import left_open, units_of
from fenics_mech.machine.drawn_from_scene import put_together
from fenics_mech.machine.free_motions import describe, free_motions
from fenics_mech.machine.led_from_scene import BOUNDED, SINGULAR, Led, led_motion, links_moved
from fenics_mech.machine.linkage import as_motion, refuse_free
from fenics_mech.machine.transmission import transmission_angles
from fenics_mech.scene import Scene

FLAT = 1e-9  # relative change of the smallest singular value over the range that counts as none
SAMPLES, POINTS = 361, 21  # of the range; of each pass of a search for a minimum, which leaves a tenth of the interval


@dataclass(frozen=True)
class Critical:
    """A position where the smallest singular value of the rows' derivatives is 0 or has a minimum."""

    theta: float  # drive coordinate (rad)
    kind: str  # "dead centre", "change point" or "worst transmission"
    value: float  # the smallest singular value, 0 to about 1
    links: tuple[str, ...]  # the links that move there while the drive stands still, those that move most first


@dataclass(frozen=True)
class Transmission:
    """The worst transmission angle of a pair of links, or of a link in a slot."""

    joint: str  # where they meet
    links: tuple[str, ...]  # their names
    theta: float  # drive coordinate (rad), 0 to 2 pi
    angle: float  # the angle there (rad), 0 to pi/2


@dataclass(frozen=True)
class Range:
    """What the drive can reach from theta = 0."""

    low: float  # limits of the drive coordinate (rad), at most a whole cycle to either side
    high: float
    turns: bool  # whether the drive can run through a whole cycle
    critical: tuple[Critical, ...]  # singular positions, and the minima of the smallest singular value, by theta
    free: tuple[str, ...] = ()  # what can move where nothing is driven, in words
    transmission: tuple[Transmission, ...] = ()  # where the drive can run through a cycle, and all are known


@guarded()
def reachable_range(scene: Scene) -> Range:
    """Find how far the drive can go from theta = 0 in both directions, and the critical positions on the way.

    Dead centres are located to 1e-9 rad, minima to 1e-6 rad, change points that end the range to about 1e-5 rad.
    """
    if not scene.drives:
        bodies = put_together(scene, scene.constraints, scene.freedoms)
        return Range(0.0, 0.0, False, (), tuple(describe(scene, bodies.links, free_motions(bodies))))
    tight = scene.model_copy(update={"joint_laws": {}})  # how far a drive goes is that of tight pins
    bodies = put_together(tight, tight.joints, tight.freedoms)
    refuse_free(bodies)
    period = TURN / abs(scene.cycle_rate)
    led = led_motion(bodies, -period, period, to_the_end=True)
    reached = {float(led.t[k] * scene.cycle_rate): k for k in (0, -1)}
    limits = {theta: _limit(led, k) for theta, k in reached.items() if abs(theta) < TURN * (1 - 1e-12)}
    low, high = (limits[end].theta if end in limits else float(np.copysign(TURN, end)) for end in sorted(reached))
    turns = high - low >= TURN * (1 - 1e-12)
    found = [*limits.values(), *_minima(led, *((0.0, TURN) if turns else (low, high)), turns)]
    return Range(
        low,
        high,
        turns,
        tuple(sorted(found, key=lambda critical: critical.theta)),
        transmission=_worst_transmission(led) if turns else (),
    )


def _limit(led: Led, last: int) -> Critical:
    """Give where a motion ends: at a dead centre the links meet, and the derivatives have a null vector of length 1."""
    bodies, machine, rate = led.bodies, led.bodies.machine, led.bodies.scene.cycle_rate
    n, units, q, t = machine.n, units_of(machine), led.q[last], float(led.t[last])
    _, values, right = np.linalg.svd(left_open(machine, t, q[None])[1][0])
    null, fastest = right[-1], np.abs(led.v[last, 2:n:3]).max() / abs(rate)
    if values[-1] * fastest <= BOUNDED:  # links do not turn without bound
        return Critical(t * rate, "change point", 0.0, links_moved(bodies, null))
    from scipy.optimize import root  # noqa: PLC0415  (slow to import, and few drives lock)

    def equations(x: Array) -> Array:
        place, vector = np.zeros((1, machine.size)), x[n : 2 * n]
        place[0, :n] = x[:n] * units
        missed, J = left_open(machine, x[-1:] / rate, place)
        return np.concatenate([missed[0], J[0] @ vector, [vector @ vector - 1]])

    answer = root(equations, np.concatenate([q[:n] / units, null, [t * rate]]), tol=1e-14)
    if abs(answer.x[-1] - t * rate) < 1e-3:
        return Critical(float(answer.x[-1]), "dead centre", 0.0, links_moved(bodies, answer.x[n : 2 * n]))
    return Critical(t * rate, "dead centre", 0.0, links_moved(bodies, null))


def _minima(led: Led, low: float, high: float, closed: bool) -> list[Critical]:
    """Give minima of the smallest singular value inside the range, a closed cycle or one that ends at dead centres."""
    inside = 0.0 if closed else 1e-9 * (high - low)

    def derivatives(theta: Array) -> Array:
        return led.placed(theta / led.bodies.scene.cycle_rate)[1]

    def smallest(theta: Array) -> Array:
        return np.linalg.svd(derivatives(theta), compute_uv=False)[:, -1]

    thetas = np.linspace(low + inside, high - inside, SAMPLES)
    values = smallest(thetas)
    if closed:  # the first sample again is the last
        values = values[:-1]
    if np.ptp(values) < FLAT * values.max():  # drives that move every link of a chain: minima are rounding
        return []
    lowest = (values < np.roll(values, 1)) & (values <= np.roll(values, -1))
    step, found = thetas[1] - thetas[0], []
    for i in np.flatnonzero(lowest) if closed else np.flatnonzero(lowest[1:-1]) + 1:
        theta, value = _minimum(smallest, thetas[i] - step, thetas[i] + step, 1e-9)
        theta = theta % TURN if closed else theta
        right = np.linalg.svd(derivatives(np.array([theta])))[2]
        kind = "change point" if value < SINGULAR else "worst transmission"
        found.append(Critical(theta, kind, value, links_moved(led.bodies, right[0, -1])))
    return found


def _worst_transmission(led: Led) -> tuple[Transmission, ...]:
    """Find the worst transmission angle of every pair over a turn of the drive; nothing where some are not known."""
    bodies, thetas = led.bodies, np.linspace(0.0, TURN, SAMPLES)

    def angles(theta: Array) -> dict[tuple[str, tuple[str, ...]], Array]:
        t = theta / bodies.scene.cycle_rate
        q = led.placed(t)[0]
        return transmission_angles(bodies.scene, as_motion(bodies, theta, t, q, 0 * q, 0 * q)) or {}

    def angle(pair: tuple[str, tuple[str, ...]], theta: Array) -> Array:
        return angles(theta)[pair]

    step, found = thetas[1] - thetas[0], []
    for pair, values in angles(thetas).items():
        middle = thetas[values.argmin()]
        theta, least = _minimum(partial(angle, pair), middle - step, middle + step, 1e-7)
        found.append(Transmission(*pair, theta % TURN, least))
    return tuple(found)


def _minimum(function: Callable[[Array], Array], low: float, high: float, within: float) -> tuple[float, float]:
    """Find the place and value of a minimum between two places by finer and finer samples."""
    while True:
        places = np.linspace(low, high, POINTS)
        values = function(places)
        i = int(values.argmin())
        low, high = places[max(i - 1, 0)], places[min(i + 1, POINTS - 1)]
        if high - low <= 2 * within:
            return float(places[i]), float(values[i])
