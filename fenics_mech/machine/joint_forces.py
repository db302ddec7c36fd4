"""Forces of joints: what the poses of a body need beside everything else that acts on them."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.machine.groups import Group
from fenics_mech.machine.motion import Motion
from fenics_mech.terms import Response


class Reactions:
    """What holds every pose of a motion."""

    # It is the residual of the same machine whose poses share nothing and rest nowhere. So where a pose shares its
    # place with others, or rests, it is the reaction there.

    def __init__(self, motion: Motion, beside: Array | float = 0.0) -> None:
        # beside (instants, poses, d + turns) (N, N m)
        machine = motion.machine
        apart = copy(machine)
        apart.forget_plan()
        size, count = machine.geometry.size, len(machine.r)
        numbers = np.arange(count * size).reshape(count, size)
        apart._places, apart._turns = (x.tolist() for x in np.split(numbers, [machine.geometry.d], axis=1))
        apart.n = numbers.size

        def spread(x: Array) -> Array:
            own = np.append(x[:, : machine.n], np.zeros((len(x), 1)), axis=1)[:, machine.places].reshape(len(x), -1)
            return np.concatenate([own, x[:, machine.n :]], axis=1)

        self._apart, self._pulls = apart, motion.a[:, machine.n : machine.n + len(machine.rows)]
        states = (spread(x) for x in (motion.q, motion.v, motion.a))
        self._found = apart.residual(
            motion.t, *states, moving=motion.moving, angles=motion.angles, tangents=False, known=True
        )
        own = self._found.force[:, : apart.n].reshape(len(motion.t), count, size)
        own += beside
        zero = np.zeros((len(motion.t), apart.pattern.entries))
        for group, here, stress in zip(apart.groups, self._found.terms, motion.added or ()):
            stressed = replace(here, response=Response(stress))
            group.spread(stressed, None, apart.pattern, False, (self._found.force, zero, zero, zero))

    def of(self, joint: str) -> Array:
        """Give what holds every pose without the rows of a joint, ``(instants, poses, d + turns)`` (N, N m)."""
        apart, found, force = self._apart, self._found, self._found.force.copy()
        own = [k for k, row in enumerate(apart.rows) if row.name == joint]
        if own:
            rows = [apart.rows[k] for k in own]
            group = Group(apart.geometry, apart.places, [row.pair for row in rows], [(row.measure,) for row in rows])
            measured = group.measure(found.at, None)
            pulls, zero = Response(-self._pulls[:, own, None]), np.zeros((len(force), apart.pattern.entries))
            group.spread(replace(measured, response=pulls), None, apart.pattern, False, (force, zero, zero, zero))
        return force[:, : apart.n].reshape(len(force), len(apart.r), -1)
