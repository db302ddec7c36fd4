"""How a linear equation of motion carries the state through the steps of a cycle, by collocation in each step.

The accelerations at the points of a step follow from the state at its start by a sparse matrix of blocks. It has one
row and column of blocks a coordinate. All steps have one pattern, so that each is factorised by the same compiled loop,
once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, times
from fenics_mech._sparse import LANES, FewModes, Stack, kernels, pointer
from fenics_mech.errors import SolverError
from fenics_mech.mechanism.matrices import Matrices, refuse_rigid_damping
from fenics_mech.response.periodic.closing import Closing, Passage
from fenics_mech.response.periodic.cyclic import CYCLIC, BlockCyclic
from fenics_mech.response.periodic.tableau import Tableau

Complex = NDArray[np.complex128]
NEAR = 20  # steps at a time, that several states are taken through
FEW_STATES = 80  # of which the transitions are kept: they take less memory than the factors that they are made with


@dataclass(frozen=True, eq=False)
class Flow:
    """The steps of a cycle. The state at a start is ``(q, h q')``, with h the mean duration of the steps.

    Parameters
    ----------
    matrices
        ``M q'' + C q' + K q = f`` at the collocation points of all steps; several loads are ``(points, n, loads)``.
    tableau
        The points.
    step
        Duration of all steps, or of each of them (s).
    options
        PETSc options with the prefix "periodic_".
    """

    matrices: Matrices
    tableau: Tableau
    step: float | Array
    options: Mapping[str, Any] = field(default_factory=dict)

    @property
    def cycle(self) -> Closing:
        """The system that closes the cycle: not kept, as this and it would hold each other, but what it finds is."""
        modal = self.matrices.modal
        if modal is not None and not modal.in_own_unknowns and 2 * self.size <= FEW_STATES:
            _ = self._few_transitions  # for a dozen marches: through full factors each takes six times as long
        return Closing(self)

    @cached_property
    def passage(self) -> Passage:
        """Parts of the cycle in which no state grows much."""
        return Passage.through(self)

    @cached_property
    def by_matrices(self) -> BlockCyclic:
        """The system of the cycle with its matrices, where marches round too much: a matrix rounds always alike."""
        return BlockCyclic(self.transitions, self.options)

    @cached_property
    def mean_step(self) -> float:
        """Mean duration of the steps (s)."""
        return float(np.mean(self.step))

    @cached_property
    def duration(self) -> Array:
        """Duration of each step (s), ``(steps,)``."""
        return np.full(len(self.matrices.load) // len(self.tableau.points), self.step)

    @property
    def size(self) -> int:
        """Number n of coordinates."""
        return self.matrices.mass.size

    @cached_property
    def unit(self) -> Array:
        """Root of a coordinate's stiffness and inertia in a step, ``(n,)``: times it, m and rad are alike."""
        parts = self.matrices.stiffness.diagonal, self.matrices.mass.diagonal / self.mean_step**2
        size = sum(np.abs(part).mean(axis=0) for part in parts)
        return np.sqrt(np.where(size, size, 1.0))

    def states(self, q: Array, rate: Array) -> Array:
        """Put q and q' into states, ``(steps, 2n)``.

        Parameters
        ----------
        q, rate
            q (m, rad) and q' (m/s, rad/s), ``(steps, n)`` each.
        """
        return np.concatenate([q, self.mean_step * rate], axis=1)

    def parts(self, states: Array) -> tuple[Array, Array]:
        """Take q and q' out of states, ``(steps, coordinates)`` each.

        Parameters
        ----------
        states
            States, ``(steps, 2n)``.
        """
        return states[:, : self.size], states[:, self.size :] / self.mean_step

    @cached_property
    def added(self) -> Array:
        """What the load adds to the state in each step, ``(steps, 2n)``, or with several ``(steps, 2n, loads)``."""
        if self.matrices.load.ndim == 2:
            return self.added_by(self.matrices.load)
        return np.stack([self.added_by(load) for load in np.moveaxis(self.matrices.load, -1, 0)], axis=-1)

    def added_by(self, load: Array) -> Array:
        """What another load adds to the state in each step, ``(steps, 2n)``.

        Parameters
        ----------
        load
            Load at the collocation points (N, N m), ``(points, n)``.
        """
        return self._stepped(np.zeros((len(self.duration), 2 * self.size)), load)

    def ends(self, starts: Array) -> Array:
        """Give the states at the ends of the steps from those at their starts, ``(steps, 2n)`` each.

        Parameters
        ----------
        starts
            States at the starts of the steps, ``(steps, 2n)``.
        """
        return self.carried(starts) + self.added

    def carried(self, starts: Array) -> Array:
        """Give the states at the ends of the steps from those at their starts, without load.

        Parameters
        ----------
        starts
            States at the starts of the steps, ``(steps, 2n)``.
        """
        return self._stepped(starts) if self._known is None else times(self._known, starts)

    def accelerations(self, starts: Array, load: Array) -> Array:
        """Give q'' at the points, ``(steps, s, n)``, from the states at the starts under a load.

        Parameters
        ----------
        starts
            States at the starts, ``(steps, 2n)``.
        load
            Load at the collocation points (N, N m), ``(points, n)``.
        """
        accelerations = np.empty((len(load), self.size))
        self._stepped(starts, load, accelerations)
        return accelerations.reshape(len(starts), -1, self.size)

    def march(self, start: Array, gain: Array | None = None, steps: slice = slice(None)) -> Array:
        """Carry a state through steps, one after the other.

        Parameters
        ----------
        start
            State at the first of their starts, ``(2n,)``.
        gain
            What is added to the state in each of them, ``(steps, 2n)``.
        steps
            Which steps.

        Returns
        -------
        numpy.ndarray
            States at the starts of the steps, and at the last end, ``(steps + 1, 2n)``.
        """
        first, last, _ = steps.indices(len(self.duration))
        if (known := self._known) is not None:
            return _passed_on(known[first:last], start, gain)
        states = np.empty((last - first + 1, 2 * self.size))
        states[0] = start
        self._run(first, last, states[:-1], states[1:], gain=gain)
        return states

    def passed(self, starts: Complex) -> tuple[Complex, Array]:
        """Carry complex states through the cycle, and keep them from being lost as they die out.

        Parameters
        ----------
        starts
            States at the start of the cycle, ``(disturbances, 2n)``.

        Returns
        -------
        tuple
            States at the starts of the steps and at the last end, ``(steps + 1, disturbances, 2n)``. The power of e by
            which each is to be multiplied, ``(steps + 1, disturbances)``.
        """
        count, done = len(self.duration), 0
        states, power = np.empty((count + 1, *starts.shape), complex), np.zeros((count + 1, len(starts)))
        states[0] = starts
        while done < count:
            parts = np.concatenate([states[done].real, states[done].imag]).T
            real, imaginary = np.split(np.moveaxis(self.march_several(parts, done), -1, 1), 2, axis=1)
            states[done:] = real + 1j * imaginary
            size = np.linalg.norm(states[done:], axis=-1)
            lost = np.flatnonzero((size[1:] < CYCLIC.smallest_state * size[0]).any(axis=1))
            if not len(lost):
                break
            first = max(1, int(lost[0]))
            done, norm = done + first, np.where(size[first], size[first], 1.0)
            states[done] /= norm[:, None]
            power[done:] += np.log(norm)
        return states, power

    def march_several(self, starts: Array, first: int = 0) -> Array:
        """Carry several states from a step to the end of the cycle, without load.

        Parameters
        ----------
        starts
            States at its start, ``(2n, states)``.
        first
            The step.

        Returns
        -------
        numpy.ndarray
            States at the starts of the steps, and at the last end, ``(steps + 1, 2n, states)``.
        """
        if (known := self._known) is not None:
            return _passed_on(known[first:], starts)
        size, many = starts.shape
        groups = -(-many // LANES)
        passed = np.zeros((groups, len(self.duration) - first + 1, size, LANES))
        passed[:, 0] = np.pad(starts, ((0, 0), (0, groups * LANES - many))).reshape(size, groups, LANES).swapaxes(0, 1)
        moving = [group for group in passed if group[0].any()]
        for begin, end in self._parts(first):
            for group in moving:
                self._run(begin, end, group[begin - first : end - first], group[begin - first + 1 : end - first + 1])
        return np.moveaxis(passed, 0, 2).reshape(passed.shape[1], size, groups * LANES)[..., :many]

    @property
    def monodromy(self) -> Array:
        """From the state at the start of the cycle to that at its end, ``(2n, 2n)``: for few coordinates.

        Neighbours are multiplied, two at a time: that rounds less than marches of single states.
        """
        parts = self.transitions
        while len(parts) > 1:
            even = len(parts) - len(parts) % 2
            parts = np.concatenate([parts[1:even:2] @ parts[:even:2], parts[even:]])
        return parts[0]

    @property
    def transitions(self) -> Array:
        """From the state at the start of each step to that at its end, ``(steps, 2n, 2n)``: for few coordinates."""
        return self._few_transitions if 2 * self.size <= FEW_STATES else self._columns()

    @cached_property
    def _few_transitions(self) -> Array:
        """Transitions that are kept."""
        return self._columns()

    @property
    def _known(self) -> Array | None:
        """Transitions, where they were made and kept: states pass through them faster than through the factors."""
        return vars(self).get("_few_transitions")

    def _columns(self) -> Array:
        """Give the transitions, by the ends of steps that begin with one number each."""
        count, size = len(self.duration), 2 * self.size
        found, starts = np.empty((count, size, size)), np.empty((count, size, LANES))
        ends = np.empty_like(starts)
        for begin, end in self._parts():
            for first in range(0, size, LANES):
                starts[begin:end] = np.eye(size, LANES, -first)
                self._run(begin, end, starts[begin:end], ends[begin:end])
                found[begin:end, :, first : first + LANES] = ends[begin:end, :, : size - first]
        return found

    def _parts(self, first: int = 0) -> list[tuple[int, int]]:
        """Parts of the steps whose factors stay near the processor, while states are taken through them in turn."""
        ends = [*range(first + NEAR, len(self.duration), NEAR), len(self.duration)]
        return list(zip([first, *ends], ends))

    def after_cycle(self, starts: Array) -> Array:
        """Carry states through the cycle, ``(2n, states)`` before and after.

        Parameters
        ----------
        starts
            States at the start of the cycle, ``(2n, states)``.
        """
        if self._known is not None:
            return self.march_several(starts)[-1]
        if starts.shape[1] == 1:
            return self.march(starts[:, 0])[-1][:, None]
        found, passed = np.empty_like(starts), np.zeros((len(self.duration) + 1, 2 * self.size, LANES))
        for first in range(0, starts.shape[1], LANES):
            some = starts[:, first : first + LANES]
            passed[0, :, : some.shape[1]] = some
            self._run(0, len(self.duration), passed, passed[1:])
            found[:, first : first + LANES] = passed[-1, :, : some.shape[1]]
        return found

    def _stepped(self, starts: Array, load: Array | None = None, accelerations: Array | None = None) -> Array:
        """Take each step from a start of its own to its end, and fill in the accelerations at the points."""
        ends = np.empty_like(starts)
        self._run(0, len(starts), np.ascontiguousarray(starts), ends, load=load, accelerations=accelerations)
        return ends

    def _run(
        self,
        first: int,
        last: int,
        starts: Array,
        ends: Array,
        load: Array | None = None,
        gain: Array | None = None,
        accelerations: Array | None = None,
    ) -> None:
        """Call the compiled march; see there. States have `LANES` beside each other where they have a third axis."""
        module, march, before, after, work = self._compiled[starts.ndim == 3]
        given = None if load is None else np.ascontiguousarray(load)
        more = None if gain is None else np.ascontiguousarray(gain)
        march(
            before[0],
            first,
            last,
            *before[1:],
            *(pointer(module, part) for part in (given, more)),
            *after,
            *(pointer(module, part) for part in (starts, ends, accelerations, work)),
        )

    @cached_property
    def _compiled(self) -> list[tuple[Any, Any, list[Any], list[Any], Array]]:
        """The compiled march of one state and of several: what it is called with, and numbers that it works in."""
        module, damping, stiffness, factors, modes = self._factorised
        stages, tableau = len(self.tableau.points), self.tableau
        rule = self.duration, tableau.inner, tableau.weights, tableau.square, tableau.points, factors
        before = [damping.pattern.layout.of(module), *(pointer(module, part.values) for part in (damping, stiffness))]
        after = [*(pointer(module, part) for part in rule), modes.record if modes else module.ffi.NULL, self.mean_step]
        numbers = (2 * stages + 2) * self.size
        if modes:
            numbers += 2 * stages * modes.count + (stages + 3) * modes.seen
        marches = (module.lib.march, 1), (module.lib.march_many, LANES)
        return [(module, march, before, after, np.empty(numbers * many)) for march, many in marches]

    @cached_property
    def _factorised(self) -> tuple[Any, Stack, Stack, Array, FewModes | None]:
        """The compiled loops, C and K with the damping of modes, the steps' factors, and modes that stand beside."""
        refuse_rigid_damping(self.matrices, self.mean_step)
        matrices, stages, modal = self.matrices, len(self.tableau.points), self.matrices.modal
        few = modal is not None and modal.in_own_unknowns
        mass, damping, stiffness = matrices.mass, matrices.damping, matrices.stiffness
        if not few:
            damping, stiffness = matrices.whole_damping, matrices.whole_stiffness
        pattern = damping.pattern.joined(stiffness.pattern).joined(mass.pattern)
        mass, damping, stiffness = (part.on(pattern) for part in (mass, damping, stiffness))
        module = kernels(stages)
        factors = np.empty((len(self.duration), pattern.elimination.blocks, stages, stages))
        tableau, layout = self.tableau, pattern.layout.of(module)
        work = np.empty(LANES * factors[0].size)
        matrix = mass.values, damping.values, stiffness.values, self.duration, tableau.inner, tableau.square
        parts = (*matrix, factors, work)
        singular = module.lib.factor(layout, len(self.duration), *(pointer(module, part) for part in parts))
        modes = None
        if modal is not None and few and singular < 0:
            given = modal.outward, modal.by_rate, modal.by_place
            modes = FewModes.of(module, given, len(self.duration), modal.seen)
            singular = modes.factorise(layout, self.duration, tableau.inner, tableau.square, factors)
        if singular >= 0:
            raise SolverError(f"the equations of step {singular + 1} of the cycle are singular")
        return module, damping, stiffness, factors, modes


def _passed_on(transitions: Array, start: Array, gain: Array | None = None) -> Array:
    """Carry a state, or several beside each other, through steps; `gain` is added to a single one in each of them."""
    passed = np.empty((len(transitions) + 1, *start.shape))
    passed[0] = start
    for k, transition in enumerate(transitions):
        np.dot(transition, passed[k], out=passed[k + 1])
        if gain is not None:
            passed[k + 1] += gain[k]
    return passed
