"""Matrices of the equation of motion at any time, by interpolation.

They are computed at many times at once, a cycle of the drive at a time. Between these they are polynomials of degree 7
through the Chebyshev points of windows. Windows are halved until the polynomials are accurate. A window in which they
never are holds a jump, such as that of a load that sets in at once.

Source: Trefethen, Approximation Theory and Approximation Practice (2013), ch. 2-8.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.effects.nonlinear_law import ArcLength
from fenics_mech.effects.rotation_forces import RotationForces
from fenics_mech.effects.section_spin import SectionSpin
from fenics_mech.errors import SolverError
from fenics_mech.mechanism.equation import Equation
from fenics_mech.mechanism.modal_forces import NonlinearModalForces


@dataclass(frozen=True)
class TableLimits:
    """Nodes and limits of the interpolation of matrices in time."""

    nodes: int = 8  # in a window
    windows: int = 8  # in a cycle, before any is halved
    references: int = 64  # times at which the size of the motion is estimated
    narrowest: float = 1e-9  # of a cycle: windows of jumps
    jump: float = 1e-4  # of the largest value, from which on a step of the values is a jump
    most_windows: int = 5000  # in a cycle
    most_entries: int = 100_000_000  # of the matrices at the nodes of a cycle (0.8 GB)


TABLE = TableLimits()


@dataclass(frozen=True)
class _Table:
    """Values at the nodes of the windows of a cycle, ``(windows, nodes, entries)``.

    Times are from the cycle's start (s). A window holds from its edge on. At `jumps` values jump, or steps have to end.
    """

    start: Array
    width: Array
    values: Array
    edges: Array
    jumps: Array


@dataclass
class Coefficients:
    """Scaled matrices of an equation at any time.

    Coordinates are scaled by `weight`, so that a unit of each has about the same elastic energy.

    Parameters
    ----------
    equation_at
        Gives the equation at many ascending times.
    cycle
        Duration of a cycle (s).
    start
        Time from which the equation is needed (s).
    repeats_after
        Time from which the matrices repeat in each cycle (s).
    tolerance
        Largest error of the interpolation, relative to the largest value.
    windows
        In a cycle, before any is halved: as many as loads need to be seen at the nodes of all.
    corners
        Gives the times (s) in a cycle, by its number, at which a window and a step have to end.
    """

    equation_at: Callable[[Array], Equation]
    cycle: float
    start: float
    repeats_after: float
    tolerance: float
    windows: int = TABLE.windows
    corners: Callable[[int], Array] = lambda cycle: np.zeros(0)
    error: float = 0.0
    law: ArcLength | None = None
    rotation_forces: RotationForces | None = None
    between: tuple[float, float] = (-np.inf, np.inf)  # the stretch of time without jumps that is looked at
    _tables: dict[int, _Table] = field(default_factory=dict)
    _latest: tuple[float, list[Array]] = field(default=(np.nan, []))

    def __post_init__(self) -> None:
        """Place the nodes in a window, 0..1, with their barycentric weights, and look at the size of everything."""
        odd = np.pi * (2 * np.arange(TABLE.nodes) + 1) / (2 * TABLE.nodes)
        self.nodes = (1 - np.cos(odd)) / 2
        self.barycentric = (-1.0) ** np.arange(TABLE.nodes) * np.sin(odd)
        orders = np.arange(TABLE.nodes)[:, None]
        self.to_chebyshev = np.cos(orders * (np.pi - odd)) * np.where(orders, 2, 1) / TABLE.nodes
        last = max(self.start, self.repeats_after) + self.cycle
        count = max(TABLE.references, TABLE.nodes * min(self.windows, TABLE.most_windows) + 1)
        equation = self.equation_at(np.linspace(self.start, last, count))
        linear, self.law, self.coupled = equation.linear, equation.system.terms.law, equation.coupled
        self.rotation_forces = equation.system.rotation_forces
        self.growth = linear.growth
        diagonal = np.abs(linear.whole_stiffness.diagonal.mean(axis=0))
        self.weight = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        still = linear.stiffness.solve(linear.load)
        self.largest = float(np.abs(still * self.weight).max())
        self.energy = float(np.sqrt(np.abs(np.einsum("ti,ti->t", still, linear.load)).max()))
        self._shapes = [part.shape[1:] for part in self._parts(equation)]
        self._ends = np.cumsum([int(np.prod(shape)) for shape in self._shapes])

    def at(self, time: float) -> list[Array]:
        """Give what `_parts` has, at a time.

        Parameters
        ----------
        time
            Time (s).
        """
        if self._latest[0] != time:  # residual and tangents are asked for one after the other
            self._latest = time, self._interpolated(time)
        beside = 2 * ((self.rotation_forces is not None) + (self.spin is not None))
        return self._latest[1][: len(self._latest[1]) - beside]

    def on_sections(self, time: float) -> tuple[Array, Array]:
        """Give P'' and the angular acceleration of the links at a time, for the inertia of sections that turn far.

        Parameters
        ----------
        time
            Time (s).
        """
        self.at(time)
        first = -2 if self.rotation_forces is None else -4
        second, alpha = self._latest[1][first], self._latest[1][first + 1]
        return second, alpha

    def on_rotations(self, time: float) -> RotationForces | None:
        """Give what acts on rotations beyond its linear parts, at a time.

        Parameters
        ----------
        time
            Time (s).
        """
        if self.rotation_forces is None:
            return None
        self.at(time)
        (moment, turning), constant = self._latest[1][-2:], self.rotation_forces.given[0, 1:3]
        return replace(self.rotation_forces, given=np.stack([moment, *constant, turning])[None])

    @property
    def spin(self) -> SectionSpin | None:
        """Inertia of sections beyond linear theory, where axes turn far."""
        return None if self.law is None else self.law.spin

    def look(self, start: float, end: float) -> None:
        """Look at a stretch of time: a jump at an end of it is not seen.

        Parameters
        ----------
        start, end
            Its ends (s).
        """
        margin = TABLE.narrowest * self.cycle
        self.between, self._latest = (start + margin, end - margin), (np.nan, [])

    def repeats(self, cycle: int) -> bool:
        """Whether a cycle is as those after it.

        Parameters
        ----------
        cycle
            Its number, from 0 at time 0.
        """
        return cycle >= self._number(cycle + 1)

    def jumps(self, cycle: int) -> Array:
        """Times (s) at which the matrices or the load jump in a cycle.

        Parameters
        ----------
        cycle
            Its number, from 0 at time 0.
        """
        return cycle * self.cycle + self._table_of(cycle).jumps

    def _number(self, cycle: int) -> int:
        return min(cycle, int(np.ceil(self.repeats_after / self.cycle - 1e-9)))

    def _table_of(self, cycle: int) -> _Table:
        number = self._number(cycle)
        if number not in self._tables:
            self._tables = {old: table for old, table in self._tables.items() if old == number - 1}
            self._tables[number] = self._table(number)
        return self._tables[number]

    def _interpolated(self, time: float) -> list[Array]:
        seen = min(max(time, self.between[0]), self.between[1])
        cycle = int(seen // self.cycle)
        table, inside = self._table_of(cycle), seen - cycle * self.cycle
        window = max(int(np.searchsorted(table.edges, inside, side="right")) - 1, 0)
        place = (time - cycle * self.cycle - table.start[window]) / table.width[window]
        flat = self._weights(place) @ table.values[window]
        return [part.reshape(shape) for part, shape in zip(np.split(flat, self._ends[:-1]), self._shapes)]

    def _weights(self, place: float) -> Array:
        """Lagrange polynomials at a place 0..1 in a window, by the barycentric formula (Berrut and Trefethen, 2004)."""
        gap = place - self.nodes
        if abs(gap[hit := int(np.abs(gap).argmin())]) < 1e-14:
            return np.eye(TABLE.nodes)[hit]
        parts = self.barycentric / gap
        return parts / parts.sum()

    def _table(self, cycle: int) -> _Table:
        """Halve the windows of a cycle until all of them are good, or so narrow that they are a jump."""
        corners = self.corners(cycle) - cycle * self.cycle
        inside = corners[(corners > 0) & (corners < self.cycle)]
        edges = np.union1d(self.cycle / self.windows * np.arange(self.windows + 1), inside)
        start, width = edges[:-1], np.diff(edges)
        good: list[tuple[Array, Array, Array]] = []
        size: Array | None = None
        while len(start):
            self._check_size(cycle, start, sum(len(part[0]) for part in good) + len(start))
            values = self._values(cycle, start, width)
            size = self._sizes(values) if size is None else size
            error = self._error(values, size)
            weighed = error * width * TABLE.windows / self.cycle  # what acts for a short time only does little
            wrong = (weighed > self.tolerance) | (error > TABLE.jump)
            narrow = width < TABLE.narrowest * self.cycle
            self.error = max(self.error, float(weighed[~wrong | narrow].max(initial=0.0)))
            good.append((start[~wrong], width[~wrong], values[~wrong]))
            again = wrong & ~narrow
            half = width[again] / 2
            start, width = (np.stack([start[again], start[again] + half], -1).ravel(), np.repeat(half, 2))
        assert size is not None
        start, width, values = (np.concatenate(parts) for parts in zip(*good))
        order = np.argsort(start)
        table = self._with_jumps(cycle, start[order], width[order], values[order], size)
        return replace(table, jumps=np.union1d(table.jumps, corners))

    def _with_jumps(self, cycle: int, start: Array, width: Array, values: Array, size: Array) -> _Table:
        """Find the joins of windows at which values jump; where repeated, the cycle's start is such a join too."""
        edges = start.copy()
        edges[1:] = (start[1:] + (start + width)[:-1]) / 2  # in the middle of a window that was left out
        ends = np.stack([self._weights(0.0), self._weights(1.0)]) @ values
        before = np.roll(ends[:, 1], 1, axis=0)
        if not self.repeats(cycle):
            before[0] = ends[0, 0]
        step = np.abs(ends[:, 0] - before)
        difference = np.stack([part.max(axis=1) for part in np.split(step, self._ends[:-1], axis=1)], axis=1)
        edges[0] = 0.0
        return _Table(start, width, values, edges, edges[(difference > TABLE.jump * size).any(axis=1)])

    def _values(self, cycle: int, start: Array, width: Array) -> Array:
        times = (cycle * self.cycle + start[:, None] + width[:, None] * self.nodes).ravel()
        order = np.argsort(times, kind="stable")
        parts = [part.reshape(len(times), -1) for part in self._parts(self.equation_at(times[order]))]
        flat = np.concatenate(parts, axis=1)
        return flat[np.argsort(order, kind="stable")].reshape(len(start), TABLE.nodes, -1)

    def _sizes(self, values: Array) -> Array:
        """Largest value of each part, beside what would count: rounding is no change.

        Damping is compared with what would be critical, too. P' of a link on the ground is 0 but for rounding: it is
        compared with P times the rate of the cycle.
        """
        largest = [float(np.abs(part).max()) for part in np.split(values, self._ends[:-1], axis=2)]
        largest[1] = max(largest[1], 1e-3 * np.sqrt(largest[0] * largest[2]))
        if self.law is not None:
            largest[5] = max(largest[5], 1e-3 * largest[4] * 2 * np.pi / self.cycle)
        return np.maximum(largest, 1e-300)

    def _error(self, values: Array, size: Array) -> Array:
        """Last Chebyshev coefficients in every window, relative, ``(windows,)``."""
        last = np.abs(np.einsum("cn,wne->wce", self.to_chebyshev[-2:], values)).max(axis=1)
        parts = np.split(last, self._ends[:-1], axis=1)
        return np.max([part.max(axis=1) / whole for part, whole in zip(parts, size)], axis=0)

    def _check_size(self, cycle: int, start: Array, windows: int) -> None:
        if windows > TABLE.most_windows or windows * TABLE.nodes * int(self._ends[-1]) > TABLE.most_entries:
            raise SolverError(
                f"the matrices or loads change too fast to be interpolated, at {cycle * self.cycle + start[0]:.6g} s; "
                "or they are lost in rounding beside a far too stiff spring or damper. Give smoother loads and laws "
                "of the drive, or a larger time_tolerance"
            )

    def _parts(self, equation: Equation) -> list[Array]:
        """Scaled M, C, K, load, and with a nonlinear law P, P' and what modal damping needs, at all times."""
        linear, weight = equation.linear, self.weight
        square = np.outer(weight, weight)
        parts = [*(matrix / square for matrix in linear.full), linear.load / weight]
        if self.law is None:
            return parts
        parts += [equation.full_jet(values) / weight for values in (equation.jets[0], equation.turned)]
        if isinstance(modal := equation.modal, NonlinearModalForces):
            parts += [modal.linear.outward / weight, modal.linear.by_place / weight, modal.axial]
        if equation.system.spin is not None:
            second = equation.jets[2]
            height = equation.full_jet(equation.jets[0])
            parts += [np.zeros_like(height) if second is None else equation.full_jet(second) / weight]
            parts += [equation.system.motion.alpha]
        if (forces := equation.system.rotation_forces) is not None:
            parts += [forces.given[:, 0], forces.given[:, 3]]  # the others do not change
        return parts
