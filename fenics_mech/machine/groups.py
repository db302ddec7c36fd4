"""What the kernels take: elements, moved poses and masses of a machine, with the places of their coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._kernels import call
from fenics_mech.geometry import End, Geometry, PoseMotion
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.pattern import Pattern, Places
from fenics_mech.terms import Beams, Masses, Measure, Response, Shapes, Term

Target = tuple[Array, Array, Array, Array]  # forces, and the values of M, C and K


@dataclass(frozen=True)
class Drag:
    """Drag of the surroundings in proportion to all mass: minus it times a velocity."""

    external: float = 0.0  # against the velocity (1/s)
    relative: float = 0.0  # against that beside the chart's, which turns a body as a whole (1/s)

    @property
    def whole(self) -> float:
        """How it changes with a velocity (1/s)."""
        return self.external + self.relative


class Placed(NamedTuple):
    """All poses at rest at some instants: what measures look at, as of `Moved`."""

    r: Array
    c: Array
    R0: Array
    ways: Array


@dataclass(frozen=True)
class Moved:
    """All poses at some instants, by coordinates, rates and accelerations beside a chart."""

    r: Array  # places (instants, poses, d) and chart vectors (instants, poses, turns)
    c: Array
    R0: Array  # rotations of the chart, and of the poses
    R: Array
    ways: Array  # rates of places, and of chart vectors as if the chart rested (instants, poses, d + turns)
    acc: Array  # second rates of places, less gravity, and of the columns of rotations (instants, poses, 1 + d, d)
    J: Array  # derivatives of the columns by chart vectors (instants, poses, d, d, turns), and second ones
    H: Array
    acc_c: Array  # derivatives of the second rates of the columns by chart vectors and by their rates
    acc_v: Array
    ways_c: Array  # derivatives of the rates of chart vectors by chart vectors (instants, poses, turns, turns)
    rates: Array  # rates of places and of the columns of rotations, as `acc`
    own: Array  # the same beside the chart's motion, in which it turns every pose as a whole
    spin: Array  # that of the chart as a matrix (instants, poses, d, d)
    inert: Array  # `acc`, and what a drag of the mass adds

    @classmethod
    def by(cls, g: Geometry, chart: PoseMotion, Q: Array, V: Array, A: Array, gravity: Array, drag: Drag) -> Moved:
        """Move the poses of a chart by the coordinates of each, their rates and accelerations ``(..., d + turns)``."""
        lead, d, k = Q.shape[:2], g.d, g.turns
        shapes = [(d, d), (d, d, k), (d, d, k, k), (d, d), (d, d), (d, d, k), (d, d, k), (k,), (k, k)]
        made = [np.empty((*lead, *shape)) for shape in shapes]
        given = (Q[..., d:], V[..., d:], A[..., d:], chart.R, chart.w, chart.al)
        call(f"rotations_{g.name}", lead[0] * lead[1], *[np.ascontiguousarray(x) for x in given], *made)
        R, J, H, z1, z2, z2_c, z2_v, u, u_c = made
        acc = np.concatenate([(chart.a + A[..., :d] - gravity)[:, :, None], z2], axis=2)
        ways = np.concatenate([chart.v + V[..., :d], u], axis=-1)
        r, c = chart.r + Q[..., :d], np.ascontiguousarray(Q[..., d:])
        rates = np.concatenate([ways[:, :, None, :d], z1], axis=2)
        spin, own, inert = g.skew(chart.w), rates, acc
        if drag.whole:
            vectors = np.concatenate([Q[:, :, None, :d], np.swapaxes(R, -1, -2)], axis=2)
            own = rates - vectors @ np.swapaxes(spin, -1, -2)
            own[:, :, 0] -= chart.v
            inert = acc + drag.external * rates + drag.relative * own
        return cls(r, c, np.ascontiguousarray(chart.R), R, ways, acc, J, H, z2_c, z2_v, u_c, rates, own, spin, inert)


class Group:
    """Elements between pairs of ends: their poses, arms and coordinates."""

    def __init__(
        self,
        geometry: Geometry,
        places: Places,
        pairs: Sequence[tuple[End, End]],
        what: Sequence[Sequence[Measure]] | Beams,
    ) -> None:
        self.geometry, self.kernels = geometry, geometry.name
        self.pose = np.array([[e.pose for e in pair] for pair in pairs], dtype=np.int32).reshape(-1, 2)
        self.dof = np.ascontiguousarray(places[self.pose].reshape(len(self.pose), 2 * geometry.size))
        arms = np.array([[[*e.offset, *e.turn.ravel()] for e in pair] for pair in pairs], dtype=float)
        if isinstance(what, Beams):
            self.count, self._kernel = 3 * (geometry.d - 1), "beam_strains"
            self._elements: tuple[Array | Places, ...] = (self.pose, arms, what.parameters(geometry))
        else:
            self.count, self._kernel = len(what[0]) if what else 1, "relations"
            measures = [measure for own in what for measure in own]
            for measure in measures:
                if not {measure.axis, measure.other} <= set(range(geometry.d)):
                    raise ValueError(
                        f"{measure} looks at an axis that is not there: the {geometry.name} has 0 to {geometry.d - 1}"
                    )
            numbers = np.array(measures, dtype=np.int32).reshape(-1, 3)
            repeated = (np.repeat(self.pose, self.count, axis=0), np.repeat(arms, self.count, axis=0))
            self._elements = (*repeated, numbers)
        self._table: tuple[int, Array] | tuple[()] = ()  # of elements with places inside
        self.block = self.dof  # coordinates of the elements that respond together

    @staticmethod
    def of(geometry: Geometry, places: Places, term: Term) -> Group:
        """Give the elements of a term."""
        if not isinstance(term, Beams):
            made = Group(geometry, places, term.pairs, term.looks)
            made.block = made.dof.reshape(-1, term.together * made.dof.shape[1])
            return made
        return InnerGroup(geometry, places, term) if term.inner else Group(geometry, places, term.pairs, term)

    def measure(self, at: Moved | Placed, angles: Array | None) -> Measured:
        """Measure all elements, angles near to given ones ``(instants, elements, measures)``; no response yet."""
        g, T, E, m = self.geometry, len(at.r), len(self.pose), self.count
        ways = self.variables_of(at.ways)
        N = ways.shape[-1]
        x, gradient, hessian = (np.empty((T, E, m, *s)) for s in ((), (N,), (N * (N + 1) // 2,)))
        given = (T, len(self._elements[0]), at.r.shape[1], at.r, at.c, at.R0, *self._elements, *self._table)
        if self._kernel == "relations":
            near = np.zeros((T, E, m)) if angles is None else np.ascontiguousarray(angles)
            given = (*given, near)
        call(f"{self._kernel}_{g.name}", *given, x, gradient, hessian)
        rate = np.einsum("temn,ten->tem", gradient, ways)
        return Measured(x, rate, gradient, hessian, ways, Response(np.zeros_like(x)))

    def spread(
        self, found: Measured, predicted: Array | None, pattern: Pattern, tangents: bool, target: Target
    ) -> None:
        """Add forces and tangents of all elements."""
        T, E, m = found.x.shape
        response, F, K = found.response, target[0], target[3]
        D, by_rate = response.by_measure, response.by_rate
        if together := D is not None and D.shape[-1] != m:
            D = by_rate = None
        D = np.zeros((T, E, m, m)) if D is None else D
        given = (response.stress, response.stress if predicted is None else predicted, D, by_rate, found.ways)
        arrays = [None if x is None else np.ascontiguousarray(x) for x in given]
        call(
            f"spread_{self.kernels}", T, E, m, found.gradient, found.hessian, *arrays,
            self.dof, self.entries(pattern), int(tangents), F.shape[1], K.shape[1], *target,
        )  # fmt: skip
        if tangents and together:
            self._spread_together(found, pattern, target)

    def _spread_together(self, found: Measured, pattern: Pattern, target: Target) -> None:
        """Add the tangents of elements that respond together: K += G'(D G + B G'), C += G' B G, with rates G' of G."""
        from scipy.sparse import csr_matrix  # noqa: PLC0415  (slow to import, and few elements respond together)

        T, (sets, n) = len(found.x), self.block.shape
        one, rate = (self.on_coordinates(x, n) for x in (found.gradient, found.rate_by_variables))
        by_measure, by_rate = found.response.by_measure, found.response.by_rate
        assert by_measure is not None
        assert by_rate is not None
        forces = [np.einsum("tsia,tsij->tsaj", one, x) for x in (by_measure, by_rate)]
        by_q, by_v = forces[0] @ one + forces[1] @ rate, forces[1] @ one
        entries = pattern.at(self.block, self.block).ravel()
        there = np.flatnonzero(entries >= 0)
        to = csr_matrix((np.ones(len(there)), (there, entries[there])), shape=(sets * n * n, pattern.entries))
        target[3][:] += by_q.reshape(T, -1) @ to
        target[2][:] += by_v.reshape(T, -1) @ to

    def on_coordinates(self, by_variables: Array, n: int) -> Array:
        """Give derivatives of the measures of sets by their coordinates ``(instants, sets, measures, n)``."""
        d, own = self.geometry.d, self.geometry.size
        way, first, second = np.split(by_variables, [d, own], axis=-1)
        each = np.concatenate([-way, first, way, second], axis=-1)  # (T, E, m, coordinates)
        sets, k = len(self.block), n // each.shape[-1]
        made = np.zeros((len(each), sets, k, each.shape[2], k, each.shape[-1]))
        i = np.arange(k)
        made[:, :, i, :, i] = each.reshape(len(each), sets, k, *each.shape[2:]).transpose(2, 0, 1, 3, 4)
        return made.reshape(len(each), sets, -1, n)

    def add_modes(self, found: Measured, sizes: Array, numbers: Places, pattern: Pattern, target: Target) -> None:
        """Add the conditions of the modes of stress, E . rates less their sizes, with all tangents."""
        # Sizes are (instants, modes), and their numbers among the unknowns (modes,).
        E = found.modes
        assert E is not None
        F, M, C, K = target
        F[:, numbers] += np.einsum("temk,tem->tk", E, found.rate) - sizes
        by = pattern.at(numbers, self.dof)
        on = pattern.at(self.dof, numbers).swapaxes(1, 2)
        for variables, where, to in (
            (found.gradient, on, (F, M, C, C)),
            (found.rate_by_variables, np.full_like(on, -1), (F, M, C, K)),
        ):
            g = np.swapaxes(E, -1, -2) @ variables
            shape = len(g), E.shape[3] * len(self.dof), np.ascontiguousarray(g), by, np.ascontiguousarray(where)
            call(f"conditions_{self.kernels}", *shape, F.shape[1], K.shape[1], *to)
        M[:, pattern.at(numbers[:, None], numbers[:, None])[:, 0, 0]] -= 1.0

    def add_pulls(self, found: Measured, by_pulls: Array, numbers: Places, pattern: Pattern, M: Array) -> None:
        """Add derivatives of forces by multipliers, whose numbers among the unknowns are ``(rows,)``."""
        on = self.on_coordinates(found.gradient, self.dof.shape[1])
        entries, values = pattern.at(self.dof, numbers), np.einsum("tema,temr->tear", on, by_pulls)
        for place in np.argwhere(entries >= 0):
            M[:, entries[tuple(place)]] += values[:, *place]

    def entries(self, pattern: Pattern) -> Places:
        """Give the places of the entries between the coordinates of each element."""
        if not hasattr(self, "_entries"):
            self._entries = pattern.at(self.dof, self.dof)
        return self._entries

    def variables_of(self, motion: Array) -> Array:
        """Give the ways and turns of every element by those of all poses ``(instants, poses, d + turns)``."""
        return self._ways(motion[:, self.pose[:, 0]], motion[:, self.pose[:, 1]])

    def variables(self, changes: Array) -> Array:
        """Give the changes of the ways and turns of every element by those of the coordinates ``(instants, size)``."""
        own = np.concatenate([changes, np.zeros((len(changes), 1))], axis=1)[:, self.dof]
        return self._ways(own[..., : self.geometry.size], own[..., self.geometry.size :])

    def on_ends(self, forces: Array) -> tuple[Array, Array]:
        """Give forces on the places and the chart vectors of both poses by those on the variables."""
        d, own = self.geometry.d, self.geometry.size
        of_turns = np.stack([forces[..., d:own], forces[..., own:]], axis=2)
        return np.stack([-forces[..., :d], forces[..., :d]], axis=2), of_turns

    def _ways(self, one: Array, other: Array) -> Array:
        d = self.geometry.d
        return np.concatenate([other[..., :d] - one[..., :d], one[..., d:], other[..., d:]], axis=-1)


class InnerGroup(Group):
    """Beams with places inside, whose variables are the coordinates of their poses."""

    def __init__(self, geometry: Geometry, places: Places, beams: Beams) -> None:
        super().__init__(geometry, places, beams.pairs, beams)
        self.inside = np.array(beams.inside, dtype=np.int32)
        inner = self.inside.shape[1]
        if geometry.d > 2:
            raise ValueError("elements in space have no places inside: use Element.uniform, and more elements")
        self.kernels = f"inner_{inner}_{geometry.name}"
        of_inside = places[self.inside, : geometry.d].reshape(len(self.pose), -1)
        self.block = self.dof = np.ascontiguousarray(np.hstack([self.dof, of_inside]))
        table = Shapes(inner).table()
        poses = np.hstack([self.pose, self.inside])
        self.count, self._kernel = 3 + 2 * inner, f"inner_strains_{inner}"
        self._elements, self._table = (poses, *self._elements[1:]), (len(table), table)

    def variables_of(self, motion: Array) -> Array:
        """Give the variables of every element by those of all poses."""
        own = motion[:, self.pose].reshape(len(motion), len(self.pose), -1)
        inside = motion[:, self.inside, : self.geometry.d].reshape(*own.shape[:2], -1)
        return np.concatenate([own, inside], axis=-1)

    def variables(self, changes: Array) -> Array:
        """Give the changes of the variables of every element by those of the coordinates ``(instants, size)``."""
        return np.concatenate([changes, np.zeros((len(changes), 1))], axis=1)[:, self.dof]

    def on_ends(self, forces: Array) -> tuple[Array, Array]:
        """Give forces on the places and the chart vectors of both poses by those on the variables."""
        d, own = self.geometry.d, self.geometry.size
        both = forces[..., : 2 * own].reshape(*forces.shape[:-1], 2, own)
        return both[..., :d], both[..., d:]


class InertiaPlan:
    """The constant mass of a machine, as the kernel takes it."""

    def __init__(self, geometry: Geometry, places: Places, masses: Masses) -> None:
        kept = np.array([(*a, *b, m) for (a, b), m in masses.entries.items() if m]).reshape(-1, 5)
        self.geometry, self.places = geometry, places
        self.entries = kept[:, :4].astype(np.int32)
        self.mass = np.ascontiguousarray(kept[:, 4])

    def largest(self, at: Moved) -> float:
        """Give the size of the largest force of inertia (N)."""
        return float(self.mass.max(initial=0.0) * np.abs(at.acc[:, :, 0]).max())

    @cached_property
    def dof(self) -> Places:
        """Coordinates of both poses of every entry."""
        return self.places[self.entries[:, [0, 2]]].reshape(len(self.mass), 2 * self.geometry.size)

    def at(self, pattern: Pattern) -> tuple[Places, Places]:
        """Give where the tangents of every entry lie, and those of every pose."""
        if not hasattr(self, "_at"):
            one, other = self.places[self.entries[:, 0]], self.places[self.entries[:, 2]]
            self._at = pattern.at(one, other), pattern.at(self.places, self.places)
        return self._at

    def add(self, at: Moved, pattern: Pattern, tangents: bool, target: Target, drag: Drag) -> None:
        """Add the forces of inertia and of a drag of the mass, and their tangents."""
        T, P = at.acc.shape[:2]
        F, M, C, K = target
        acc_c, mass = at.acc_c, M
        if dragged := tangents and drag.whole != 0:
            columns = np.einsum("tpjiab,tpb->tpjia", at.H, at.ways[..., self.geometry.d :])
            columns = columns + np.einsum("tpjia,tpab->tpjib", at.J, at.ways_c)
            turned = np.einsum("tpil,tpjla->tpjia", at.spin, at.J)
            acc_c, mass = acc_c + drag.whole * columns - drag.relative * turned, np.zeros_like(M)
        call(
            f"inertia_{self.geometry.name}", T, P, len(self.mass), self.entries, self.mass, *self.at(pattern),
            self.places, np.ascontiguousarray(at.inert), at.J, at.H, acc_c, at.acc_v, int(tangents),
            np.zeros((P, 1 + self.geometry.d, self.geometry.d)), F.shape[1], K.shape[1], F, mass, C, K,
        )  # fmt: skip
        if dragged:
            M += mass
            C += drag.whole * mass
        if dragged and drag.relative:
            self._add_carried(at, pattern, drag.relative, K)

    def _add_carried(self, at: Moved, pattern: Pattern, relative: float, K: Array) -> None:
        """Add how a relative drag changes as places move across the velocity with which the chart turns them."""
        d, entries = self.geometry.d, self.at(pattern)[0]
        for (one, a, other, b), mass, where in zip(self.entries, self.mass, entries):
            if b == 0:
                left = np.eye(d) if a == 0 else np.swapaxes(at.J[:, one, a - 1], -1, -2)  # coordinates of a, d
                values = -relative * mass * left @ at.spin[:, other]
                rows = where[:d, :d] if a == 0 else where[d:, :d]
                for (i, j), entry in np.ndenumerate(rows):
                    if entry >= 0:
                        K[:, entry] += values[:, i, j]

    def taken(self, at: Moved, velocity: Array) -> Array:
        """Give the power that the mass times a velocity (m/s), as `Moved.rates`, takes as a force ``(instants,)``."""
        one, a, other, b = self.entries.T
        return np.asarray(np.einsum("l,tli,tli->t", self.mass, at.rates[:, one, a], velocity[:, other, b]))
