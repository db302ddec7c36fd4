"""Pins and blocks that ride along bent members: rows of which each looks at one element at a time."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._kernels import call
from fenics_mech.geometry import Geometry
from fenics_mech.joints import Ride, Riding
from fenics_mech.machine.groups import Moved, Target
from fenics_mech.machine.pattern import Pattern, Places


class Rides:
    """The elements that pins may ride on, where they lie."""

    # The axis is the cubic over each chord with the slopes of both first axes, so that its tangent goes on from
    # element to element. The multiplier is the force normal to it, the moment that turns a block, or the force along
    # the chord.

    def __init__(self, geometry: Geometry, places: Places, rides: Sequence[Ride], first: int) -> None:
        self.geometry, self.rides, self.first = geometry, list(rides), first
        ends = [(*pair, ride.pin) for ride in rides for pair in ride.elements]
        self.pose = np.array([[end.pose for end in own] for own in ends], dtype=np.int32).reshape(-1, 3)
        self.arms = np.array([[[*end.offset, *end.turn.ravel()] for end in own] for own in ends], dtype=float)
        self.look = np.array([ride.look for ride in rides for _ in ride.elements], dtype=np.int32)
        marks = [ride.marks or (0.0,) * (1 + len(ride.elements)) for ride in rides]
        self.marks = np.array([pair for own in marks for pair in pairwise(own)]).reshape(-1, 2)
        bends = [ride.bends or ((0.0, 0.0),) * len(ride.elements) for ride in rides]
        self.bends = np.array([pair for own in bends for pair in own]).reshape(-1, 2)
        self.partner = np.array(  # that looks at the other of force and couple of the same pin, or -1
            [
                next((k for k, other in enumerate(rides) if other.pin is ride.pin and other.look == 1 - ride.look), -1)
                for ride in rides
            ],
            dtype=int,
        )
        self.dof = np.ascontiguousarray(places[self.pose].reshape(len(self.pose), 3 * geometry.size))
        self.scale = np.array([ride.scale for ride in rides], dtype=int)
        self.on_scale = np.where(self.scale[:, None] > 0, places[self.scale, :1], -1)  # coordinate; the ground shows 0
        self.starts = np.cumsum([0, *(len(ride.elements) for ride in rides)])
        self.of = np.repeat(np.arange(len(self.rides)), np.diff(self.starts))
        self._entries: tuple[Places, Places, Places, Places] | None = None
        self.row = (first + self.of).astype(np.int32)[:, None]

    @property
    def block(self) -> Places:
        """Coordinates that meet in each element, the row, and its scale."""
        there = self.partner[self.of, None]
        partner = np.where(there < 0, -1, self.first + there).astype(np.int32)
        return np.concatenate([self.dof, self.row, self.on_scale[self.of], partner], axis=1)

    def add(self, at: Moved, a: Array, pattern: Pattern, tangents: bool, target: Target) -> None:
        """Add the forces of the multipliers, and what the rows miss."""
        gap, gradient, works, hessian, soft, ridden, _ = self._measured(at, a)
        (T, E), g = gap.shape, self.geometry
        rows = np.arange(self.first, self.first + len(self.rides))
        slack = np.array([ride.slack for ride in self.rides])
        shown = at.r[:, self.scale, 0]
        target[0][:, rows] = np.add.reduceat(gap, self.starts[:-1], axis=1) - shown - slack * a[:, rows]
        led = self.on_scale[:, 0] >= 0
        target[0][:, self.on_scale[led, 0]] -= a[:, rows[led]]
        force = np.ascontiguousarray(a[:, self.row[:, 0], None] * ridden[..., None])
        sizes = target[0].shape[1], target[3].shape[1]
        call(
            f"spread_ride_{g.name}", T, E, 1, works, hessian, force, force, np.zeros((T, E, 1, 1)), None, works,
            self.dof, self._at(pattern)[0], int(tangents), *sizes, *target,
        )  # fmt: skip
        if tangents:
            _, by, on, own = self._at(pattern)
            call(f"conditions_ride_{g.name}", T, E, gradient, by, on, *sizes, *target)
            softness = np.add.reduceat(soft, self.starts[:-1], axis=1)
            target[1][:, own] = -slack - softness[..., 0]
            two = np.flatnonzero(self.partner >= 0)
            target[1][:, pattern.at(rows[two, None], rows[self.partner[two], None])[:, 0, 0]] = -softness[:, two, 1]
            numbers = rows[led, None].astype(np.int32)
            for values, one, other in (
                (target[3], numbers, self.on_scale[led]),
                (target[1], self.on_scale[led], numbers),
            ):
                values[:, pattern.at(one, other)[:, 0, 0]] = -1.0

    def stiffen(self, M: Array, pattern: Pattern) -> None:
        """Let no element give way under a pin, in derivatives of the rows by their multipliers."""
        rows = np.arange(self.first, self.first + len(self.rides), dtype=np.int32)
        M[:, self._at(pattern)[3]] = [-ride.slack for ride in self.rides]
        two = np.flatnonzero(self.partner >= 0)
        M[:, pattern.at(rows[two, None], rows[self.partner[two], None])[:, 0, 0]] = 0.0

    def loads(self, at: Moved, a: Array) -> Array:
        """Give what the pins exert on both poses of every element, ``(instants, elements, 2, d + turns)`` (N, N m)."""
        load = self._measured(at, a)[2] * a[:, self.row[:, 0], None]
        return load.reshape(*load.shape[:2], 3, -1)[:, :, :2]

    def pushes(self, at: Moved, a: Array) -> tuple[Array, Array, Array]:
        """Give where along every element a pin is, 0..1, and the force and moment that it exerts there."""
        # They are (instants, elements, d) (N) and (instants, elements, turns) (N m).
        g, (_, _, works, *_, share) = self.geometry, self._measured(at, a)
        there = works.reshape(*share.shape, 3, -1)[:, :, 2] * a[:, self.row[:, 0], None]
        force, pose = there[..., : g.d], self.pose[:, 2]
        arm = (at.R[:, pose] @ self.arms[:, 2, : g.d, None])[..., 0]
        return share, force, g.from_chart(at.c[:, pose], there[..., g.d :]) - g.moment(arm, force)

    def _measured(self, at: Moved, a: Array) -> tuple[Array, ...]:
        """Give what rows look at, gradients of it and of its work, and softness, all 0 where a pin is not."""
        # Before the softness comes the Hessian of the work; after it 1 where a pin is, else 0, and the shares.
        g, (T, poses), (E, N) = self.geometry, at.r.shape[:2], self.dof.shape
        sizes = (), (N,), (N,), (N * (N + 1) // 2,), (2,), ()
        gap, gradient, works, hessian, soft, share = (np.empty((T, E, *s)) for s in sizes)
        own = a[:, self.first : self.first + len(self.rides)]
        other = np.where(self.partner >= 0, own[:, self.partner], 0.0)
        turned = np.array([ride.look == Riding.TURNED for ride in self.rides])
        pulls = np.stack([np.where(turned, other, own), np.where(turned, own, other)], axis=2)[:, self.of]
        given = (T, E, poses, at.r, at.c, at.R0, self.pose, self.arms, self.look, self.marks, self.bends)
        call(f"rides_{g.name}", *given, np.ascontiguousarray(pulls), gap, gradient, works, hessian, soft, share)
        ridden = self._ridden(share)
        on = ridden[..., None]
        return gap * ridden, gradient * on, works * on, hessian, soft * on, ridden, share

    def _at(self, pattern: Pattern) -> tuple[Places, Places, Places, Places]:
        """Give where derivatives lie: of forces, of rows, of forces by multipliers, of rows by multipliers."""
        if self._entries is None:
            own = np.arange(self.first, self.first + len(self.rides), dtype=np.int32)[:, None]
            by, on = pattern.at(self.row, self.dof)[:, 0], pattern.at(self.dof, self.row)[:, :, 0]
            by, on = np.ascontiguousarray(by), np.ascontiguousarray(on)
            self._entries = pattern.at(self.dof, self.dof), by, on, pattern.at(own, own)[:, 0, 0]
        return self._entries

    def _ridden(self, share: Array) -> Array:
        """Say on which element each pin is: the first whose end it has not passed ``(instants, elements)``."""
        ridden = np.zeros(share.shape)
        for start, stop in zip(self.starts, self.starts[1:]):
            before = share[:, start : stop - 1] < 1
            on = np.where(before.any(axis=1), before.argmax(axis=1), stop - start - 1) if stop - start > 1 else 0
            ridden[np.arange(len(share)), start + on] = 1.0
        return ridden
