"""The motion of a scene's links, which do not bend, where drives lead all of them.

It is followed from the start in steps that it allows, and refused where it is singular. Between the steps it is found
at any instants together. There the smallest singular value s of the rows' derivatives, without units, tells how well
the rows hold the links: it is about the sine of the transmission angle. Rounding e of places changes rates by e/s and
accelerations by e/s^2. At s = 0 the drive locks, which is a dead centre, or the links can go on in two ways, which is a
change point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array, solved
from fenics_mech._constants import TURN
from fenics_mech.errors import AssemblyError
from fenics_mech.machine.assembly import CLOSED, COARSELY_MET, MET, judged, left_open, rates_of, units_of
from fenics_mech.machine.drawn_from_scene import Bodies
from fenics_mech.machine.machine import Machine
from fenics_mech.scene import Scene

LONGEST = np.pi / 8  # step of the drive angle (rad): several in each swing of a link
SHORTEST = 1e-12  # step of the drive angle (rad): below it a step is rounding
MOST = 10_000  # steps in a cycle: linkages take 16 to 60, a law's 100th harmonic 2,600
CORRECTIONS = 12  # of Newton's method, which needs three near a motion that is known
STRAYED = 0.05  # correction of a predicted link angle (rad): beyond it a step may have left the motion
TURNED = 0.1  # change of a link's rate beyond that predicted, over the largest: a step may have passed a corner
RESTING = 1e-9  # rate of a link over that of the drive, that counts as none: in a dwell rates are rounding
SINGULAR = 3e-6  # smallest singular value: below it rounding changes accelerations by more than about 1e-4
BOUNDED = 1e-4  # that value times the rate of the fastest link over that of the drive: below it the drive does not lock
MOVED = 0.05  # of the largest turn in a motion: links that turn by more are named
SAME = 1e-9  # of the arm, or rad: what a cycle may leave between two positions that are the same
REMEDY = (
    "The program follows no motion through it: take a drive whose range keeps away from it, or other lengths. Where "
    "two equal cranks turn together, drive both, and let one pin of their rod slide in a slot along it"
)
Places = tuple[Array, Array, Array]  # of bodies, or of drives, and two derivatives by time ``(instants, ...)`` each


@dataclass(frozen=True)
class Led:
    """A motion that was followed, with drives at full speed from the start."""

    bodies: Bodies  # the links
    t: Array  # instants to which it was followed, ascending (s)
    q: Array  # coordinates, rates and accelerations there (instants, size)
    v: Array
    a: Array
    side: float  # sign of the determinant of the rows' derivatives, which is that of all of the motion

    def at(self, t: Array) -> Places:
        """Give coordinates, rates and accelerations at some instants ``(instants, size)`` each."""
        q, J = self.placed(t)
        refuse_singular(self.bodies, t, J)
        return q, *rates_of(self.bodies.machine, t, q, *_demanded(self.bodies, t), J)

    def placed(self, t: Array) -> tuple[Array, Array]:
        """Give coordinates ``(instants, size)``, and derivatives of the rows without units."""
        machine = self.bodies.machine
        q, missed, _ = _corrected(machine, t, self._between(t), CLOSED)
        J = left_open(machine, t, q)[1]  # next to a dead centre it is another one before the last correction
        gaps = np.abs(missed).max(axis=1, initial=0.0)
        if (gaps > MET).any():
            k = int(gaps.argmax())
            raise AssemblyError(
                f"the linkage cannot be assembled at drive angle {self._degrees(t[k])}: joint "
                f"{machine.rows[int(np.abs(missed[k]).argmax())].name} stays open"
            )
        if (strays := np.linalg.slogdet(J)[0] != self.side).any():
            where = self._degrees(t[int(strays.argmax())])
            raise AssemblyError(
                f"the linkage is at a change point at drive angle {where}: its motion is not unique there"
            )
        return q, J

    def over_cycles(self, t: Array) -> Places:
        """Give the same at instants of several cycles, after which the links are back."""
        period, whole = self.bodies.scene.period, np.zeros(self.q.shape[1])
        cycles = np.floor(t / period)
        turns = slice(2, self.bodies.machine.n, 3)
        whole[turns] = TURN * np.round((self.q[-1] - self.q[0])[turns] / TURN)
        q, v, a = self.at(t - period * cycles)
        return q + cycles[:, None] * whole, v, a

    def _between(self, t: Array) -> Array:
        """Give coordinates between the instants to which it was followed, by polynomials of degree 5, ``(., size)``."""
        if len(self.t) == 1:
            return np.repeat(self.q, len(t), axis=0)
        k = np.clip(np.searchsorted(self.t, t, side="right") - 1, 0, len(self.t) - 2)
        h = (self.t[k + 1] - self.t[k])[:, None]
        x = (t - self.t[k])[:, None] / h
        place, rate, half = self.q[k], h * self.v[k], h**2 / 2 * self.a[k]
        off = self.q[k + 1] - place - rate - half  # what they leave at the next instant, of places and both rates
        off_rate = h * self.v[k + 1] - rate - 2 * half
        off_second = h**2 * self.a[k + 1] - 2 * half
        cubic = 10 * off - 4 * off_rate + off_second / 2
        quartic, quintic = -15 * off + 7 * off_rate - off_second, 6 * off - 3 * off_rate + off_second / 2
        return np.asarray(place + x * (rate + x * (half + x * (cubic + x * (quartic + x * quintic)))))

    def _degrees(self, t: float) -> str:
        return _degrees(self.bodies.scene, t)


def led_motion(bodies: Bodies, first: float, last: float, to_the_end: bool = False) -> Led:
    """Follow the motion of links that drives lead, from the start to two instants, or `to_the_end` before them."""
    # first, last (s)
    start = _start(bodies)
    side = float(np.linalg.slogdet(start.J)[0])
    behind, ahead = (_followed(bodies, start, end, side, to_the_end) for end in (first, last))
    states = [*behind[::-1], start, *ahead]
    t, q, v, a = (np.array([getattr(x, name) for x in states]) for name in ("t", "q", "v", "a"))
    return Led(bodies, t, q, v, a, side)


def comes_back(led: Led) -> bool:
    """Say whether the links are after a cycle where they were, but for whole turns."""
    n = led.bodies.machine.n
    change = (led.q[-1] - led.q[0])[:n] / units_of(led.bodies.machine)
    change[2::3] -= TURN * np.round(change[2::3] / TURN)
    return bool(np.abs(change).max(initial=0.0) < SAME)


@dataclass(frozen=True)
class _State:
    """Coordinates, rates and accelerations at an instant ``(size,)`` each, and derivatives of the rows."""

    t: float
    q: Array
    v: Array
    a: Array
    J: Array

    @property
    def smallest(self) -> float:
        """Smallest singular value of the derivatives."""
        return float(np.linalg.svd(self.J, compute_uv=False)[-1])


def _start(bodies: Bodies) -> _State:
    t, q = np.zeros(1), bodies.q[None]
    J = left_open(bodies.machine, t, q)[1]
    refuse_singular(bodies, t, J)
    v, a = rates_of(bodies.machine, t, q, *_demanded(bodies, t), J)
    return _State(0.0, bodies.q, v[0], a[0], J[0])


def _followed(bodies: Bodies, start: _State, end: float, side: float, to_the_end: bool) -> list[_State]:
    """Follow a motion from its start to an instant, in steps as long as it allows."""
    rate, here, found = abs(bodies.scene.cycle_rate), start, list[_State]()
    longest, most, tried = LONGEST / rate, MOST * max(1.0, abs(end) * rate / TURN), 0
    step = longest
    while abs(here.t) < abs(end):
        tried += 1
        if tried > most:
            raise _too_rough(bodies, here, tried - 1)
        there = _stepped(bodies, here, float(np.copysign(min(step, abs(end - here.t)), end)), side)
        if there is not None:
            here, step = there, min(1.5 * step, longest)
            found.append(here)
            stuck = abs(here.t) < abs(end) and here.smallest < SINGULAR
        else:
            step /= 2
            stuck = step < SHORTEST / rate
        if stuck and to_the_end:
            break
        if stuck:
            raise _stuck(bodies, here)
    return found


def _stepped(bodies: Bodies, here: _State, h: float, side: float) -> _State | None:
    """Give the state a step ahead, or None where the step may have left the motion."""
    machine, turns = bodies.machine, slice(2, bodies.machine.n, 3)
    t, guess = np.array([here.t + h]), here.q + h * here.v + h**2 / 2 * here.a
    try:
        q, missed, J = _corrected(machine, t, guess[None], COARSELY_MET)
        if not np.abs(missed).max() < COARSELY_MET or np.abs((q[0] - guess)[turns]).max() > STRAYED:
            return None
        if np.linalg.slogdet(J)[0][0] != side:
            return None
        (v,), (a,) = rates_of(machine, t, q, *_demanded(bodies, t), J)
    except np.linalg.LinAlgError:
        return None
    least = RESTING * abs(bodies.scene.cycle_rate)
    fastest = max(least, np.abs(v[turns]).max(), np.abs(here.v[turns]).max())
    if np.abs((v - here.v - h * here.a)[turns]).max() > TURNED * fastest:
        return None
    return _State(float(t[0]), q[0], v, a, J[0])


def _corrected(machine: Machine, t: Array, q: Array, goal: float) -> tuple[Array, Array, Array]:
    """Meet all rows by Newton's method; give coordinates, and what rows missed before its end, with derivatives."""
    q = q.copy()
    for _ in range(CORRECTIONS):
        missed, J = left_open(machine, t, q)
        q[:, : machine.n] -= solved(J, missed) * units_of(machine)
        missed = judged(machine, t, missed)
        if (np.abs(missed) < goal).all():
            break
    return q, missed, J


def _demanded(bodies: Bodies, t: Array) -> tuple[Array, Array]:
    """Give the rates and second rates of what rows demand, at full speed ``(instants, rows)`` each."""
    scene, rows = bodies.scene, bodies.machine.rows
    rate, found = scene.cycle_rate, np.zeros((2, len(t), len(rows)))
    first = len(rows) - len(scene.moved_joints)  # the rows of freedoms follow, which rest
    for number, drive in enumerate(scene.drives):
        jet = drive.jet(rate * t, rate)
        found[:, :, first + number] = rate * jet.first, rate**2 * jet.second
    return found[0], found[1]


def refuse_singular(bodies: Bodies, t: Array, J: Array) -> None:
    """Raise `AssemblyError` where rates follow from places to few digits; J are the rows' derivatives without units."""
    try:
        bound = 1 / np.linalg.norm(np.linalg.inv(J), axis=(1, 2))  # not above the smallest singular value
    except np.linalg.LinAlgError:
        bound = np.zeros(len(J))
    if not (near := np.flatnonzero(bound < SINGULAR)).size:
        return
    _, values, right = np.linalg.svd(J[near])
    worst = int(values[:, -1].argmin())
    if values[worst, -1] < SINGULAR:
        angle = np.degrees(bodies.scene.cycle_rate * t[near[worst]])
        moved = ", ".join(links_moved(bodies, right[worst, -1]))
        raise AssemblyError(
            f"the linkage is at a dead centre or change point at drive angle {angle:.10g} deg (smallest singular value "
            f"{values[worst, -1]:.1e}): the motion of {moved} is lost to rounding there. {REMEDY}"
        )


def links_moved(bodies: Bodies, motion: Array) -> tuple[str, ...]:
    """Name the links that turn in a motion ``(coordinates,)``, the most turned first."""
    turned, names = np.abs(motion[2::3]), list(bodies.scene.links)
    return tuple(names[k] for k in np.argsort(-turned) if turned[k] > MOVED * turned.max())


def _stuck(bodies: Bodies, here: _State) -> AssemblyError:
    """Say what keeps a motion from going on."""
    scene, where = bodies.scene, _degrees(bodies.scene, here.t)
    rates = np.abs(here.v[2 : bodies.machine.n : 3]) / abs(scene.cycle_rate)
    if here.smallest * rates.max() > BOUNDED:
        return AssemblyError(
            f"the drive cannot turn beyond {where}: the linkage locks there ({list(scene.links)[int(rates.argmax())]} "
            f"turns {rates.max():.3g} times as fast as the drive)"
        )
    return AssemblyError(
        f"the linkage is at a change point at drive angle {where}: its motion is not unique there, as "
        f"{', '.join(links_moved(bodies, np.linalg.svd(here.J)[2][-1]))} can go on in two ways. {REMEDY}"
    )


def _too_rough(bodies: Bodies, here: _State, tried: int) -> AssemblyError:
    """Say that a motion changes too fast to be followed."""
    fastest = list(bodies.scene.links)[int(np.abs(here.v[2 : bodies.machine.n : 3]).argmax())]
    return AssemblyError(
        f"the motion cannot be followed over the cycle: after {tried} steps the drive is at "
        f"{_degrees(bodies.scene, here.t)} only, where link {fastest} turns fastest. Give a drive law that changes "
        "less often in a cycle"
    )


def _degrees(scene: Scene, t: float) -> str:
    return f"{np.degrees(scene.cycle_rate * t):.6g} deg"
