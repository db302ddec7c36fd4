"""Poses, terms, rows of joints, and the one residual of the coordinates, their rates, accelerations and multipliers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._kernels import call
from fenics_mech.geometry import Chart, End, Geometry, PoseMotion, Rest
from fenics_mech.geometry.charts import Path
from fenics_mech.joints import Ride, Riding, Row, kind_of
from fenics_mech.machine.evaluation import Evaluation
from fenics_mech.machine.groups import Drag, Group, InertiaPlan, Moved, Placed, Target
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.pattern import Pattern, Places
from fenics_mech.machine.rides import Rides
from fenics_mech.terms import Beams, Element, Look, Masses, PointLoad, Response, Shapes, Term

FIXED = ("", "place", "turn", "place and turn")


class Machine:
    """A machine in the plane or in space.

    Coordinates are deviations of poses from a chart. Multipliers of the rows follow them, then the sizes of modes of
    stress. Both stand among the accelerations: ``residual(t, q, v, a)`` and its tangents are all that a solver sees.

    Parameters
    ----------
    geometry
        The plane or space.
    gravity
        Acceleration of free fall ``(d,)`` (m/s^2).
    """

    def __init__(self, geometry: Geometry, gravity: Sequence[float] | None = None) -> None:
        self.geometry = geometry
        self.gravity = np.zeros(geometry.d) if gravity is None else np.asarray(gravity, dtype=float)
        self.r: list[Array] = []
        self.R: list[Array] = []
        self.led: dict[int, Path] = {}
        self.terms: list[Term] = []
        self.rows: list[Row] = []
        self.rides: list[Ride] = []  # their multipliers follow those of the rows
        self.masses = Masses()
        self.drag = Drag()
        self.blows: list[tuple[float, PointLoad]] = []  # instants of impulses (s), which are those of loads
        self.chart: Chart | None = None
        self.n = 0  # coordinates
        self._planned: tuple[int, ...] | None = None
        self._places: list[list[int]] = []
        self._turns: list[list[int]] = []
        self.ground = self.add_pose(np.zeros(geometry.d), fixed="place and turn")

    # ---- building ----
    def add_pose(
        self,
        place: Array,
        axes: Array | None = None,
        shared: int | None = None,
        fixed: str = "",
        led: Path | None = None,
    ) -> int:
        """Add a pose, and give its number."""
        # place (d,) (m); axes (d, d)
        d, turns = self.geometry.d, self.geometry.turns
        if fixed not in FIXED:
            raise ValueError(f"a pose cannot be fixed by {fixed!r}: expected one of {', '.join(map(repr, FIXED))}")
        if led is not None:
            fixed, self.led[len(self.r)] = "place and turn", led
        self.r.append(np.asarray(place, dtype=float))
        self.R.append(np.eye(d) if axes is None else np.asarray(axes, dtype=float))
        if shared is not None:
            self._places.append(self._places[shared])
        else:
            self._places.append([-1] * d if "place" in fixed else self._new(d))
        self._turns.append([-1] * turns if "turn" in fixed else self._new(turns))
        self.forget_plan()
        return len(self.r) - 1

    def add_scale(self, value: float) -> int:
        """Add a pose without mass that moves along the first axis of the fixed frame alone, and give its number."""
        # It shows the stroke of a ride, so that rows and terms can look at it (m).
        pose = self.add_pose(value * np.eye(self.geometry.d)[0], fixed="place and turn")
        self._places[pose][0] = self._new(1)[0]
        return pose

    def along(self, name: str) -> tuple[End, End]:
        """Give the ground and the scale of a ride by its name: the way between them is its stroke."""
        scale = next(ride.scale for ride in self.rides if ride.name == name and ride.look == Riding.STROKE)
        return self.at_ground(), self.end(scale)

    def _new(self, count: int) -> list[int]:
        self.n += count
        return list(range(self.n - count, self.n))

    def end(self, pose: int, place: Array | None = None, axes: Array | None = None) -> End:
        """Give the end that is fixed to a pose and is drawn at a place with some axes."""
        back = self.R[pose].T
        offset = np.zeros(self.geometry.d) if place is None else back @ (np.asarray(place, dtype=float) - self.r[pose])
        return End(pose, offset, np.eye(self.geometry.d) if axes is None else back @ axes)

    def at_ground(self, place: Array | None = None, axes: Array | None = None) -> End:
        """Give an end that rests."""
        return self.end(self.ground, np.zeros(self.geometry.d) if place is None else place, axes)

    def drawn(self, end: End) -> Array:
        """Give the place where an end is drawn ``(d,)`` (m)."""
        return np.asarray(self.r[end.pose] + self.R[end.pose] @ end.offset)

    def add_beams(
        self, pairs: Sequence[tuple[End, End]], elements: Sequence[Element], damping: Sequence[float] | float = 0.0
    ) -> None:
        """Add beam elements with their inertia, and with poses for the places inside, to those that there are."""
        # damping (s)
        inside = []
        for pair, element in zip(pairs, elements):
            one, other = map(self.drawn, pair)
            shares = Shapes(element.inner).places
            inside.append([self.add_pose(one + share * (other - one), fixed="turn") for share in shares])
        beams = Beams(pairs, elements, damping, inside)
        beams.add_to(self.masses)
        if any(isinstance(term, Beams) for term in self.terms):  # strains, modes and meshes look at all of a machine
            self.terms[self.terms.index(self.beams)] = beams.after(self.beams)
        else:
            self.terms.append(beams)
        self.forget_plan()

    @property
    def beams(self) -> Beams:
        """The term of all beam elements."""
        for term in self.terms:
            if isinstance(term, Beams):
                return term
        raise ValueError("the machine has no beams: add_beams() adds them")

    def join(self, kind: str, pair: tuple[End, End], *, slack: float = 0.0, name: str = "") -> None:
        """Hold two ends by a kind of joint; a place that their poses share needs no rows."""
        one, other = (self._places[end.pose] for end in pair)
        shared = one == other and not any(map(self._has_arm, pair))
        for measure in kind_of(kind, self.geometry).held:
            if not (shared and measure.look is Look.PLACE):
                self.rows.append(Row(pair, measure, slack=slack, name=name))
        self.forget_plan()

    def _has_arm(self, end: End) -> bool:
        """Say whether an end moves beside the place of its pose, when that turns."""
        return bool(end.offset.any()) and self._turns[end.pose][0] >= 0

    def drive(
        self, kind: str, freedom: str, pair: tuple[End, End], law: Callable[[Array], Array], name: str = ""
    ) -> int:
        """Lead the angle or the stroke of a joint by a law of time, and give the number of the row."""
        # law (instants,)
        self.rows.append(Row(pair, kind_of(kind, self.geometry).drives[freedom], law, name=name))
        self.forget_plan()
        return len(self.rows) - 1

    # ---- the plan: where everything lies ----
    def forget_plan(self) -> None:
        """Plan anew: what was evaluated before has got more poses, terms, rows or masses."""
        self._planned = None
        made = ["places", "groups", "row_group", "inertia", "pattern", "riders", "mode_numbers"]
        for name in [*made, "arm", "extent", "_row_at", "_chart_at", "_rest"]:
            self.__dict__.pop(name, None)

    @cached_property
    def extent(self) -> float:
        """Largest distance of its poses and ends along an axis of the fixed frame (m)."""
        pairs = [*(pair for term in self.terms for pair in term.pairs), *(row.pair for row in self.rows)]
        ends = list(chain.from_iterable(pairs))
        drawn = np.array([*self.r, *map(self.drawn, ends)])
        if not np.isfinite(drawn).all():
            poses = [*range(len(self.r)), *(end.pose for end in ends)]
            pose = poses[int(np.argmin(np.isfinite(drawn).all(axis=1)))]
            raise ValueError(f"pose {pose}, or what is fixed to it, is drawn at a place that is no number")
        return float(np.ptp(drawn, axis=0).max()) or 1.0

    @property
    def units(self) -> Array:
        """Sizes by which coordinates are judged ``(size,)``: the extent of the machine for places, 1 rad for turns."""
        unit = np.ones(self.size + 1)
        unit[self.places[:, : self.geometry.d]] = self.extent
        return unit[:-1]

    @cached_property
    def arm(self) -> float:
        """Longest coordinate of an end of a row in its pose (m), or 1 m where there is none."""
        return max((float(np.abs(end.offset).max()) for row in self.rows for end in row.pair), default=0.0) or 1.0

    @property
    def size(self) -> int:
        """Coordinates, rows and rides, and modes of stress."""
        return self.n + self.held + sum(term.modes for term in self.terms)

    @property
    def held(self) -> int:
        """Multipliers: of rows, and of pins that ride along members."""
        return len(self.rows) + len(self.rides)

    @cached_property
    def places(self) -> Places:
        """Coordinates of the place and the turn of every pose, -1 where it has none: ``(poses, d + turns)``."""
        return np.array([[*a, *b] for a, b in zip(self._places, self._turns)], dtype=np.int32)

    @cached_property
    def groups(self) -> list[Group]:
        """Elements of every term, where they lie."""
        return [Group.of(self.geometry, self.places, term) for term in self.terms]

    @cached_property
    def row_group(self) -> Group:
        """The rows, where they lie."""
        pairs, measures = [row.pair for row in self.rows], [(row.measure,) for row in self.rows]
        return Group(self.geometry, self.places, pairs, measures)

    @cached_property
    def riders(self) -> Rides:
        """The elements that pins ride on, where they lie."""
        if self.rides and any(isinstance(term, Beams) and term.inner for term in self.terms):
            raise ValueError("a pin rides on cubics: give the machine more elements, without places inside")
        return Rides(self.geometry, self.places, self.rides, self.n + len(self.rows))

    @cached_property
    def inertia(self) -> InertiaPlan:
        """The constant mass, where it lies."""
        return InertiaPlan(self.geometry, self.places, self.masses)

    @cached_property
    def pattern(self) -> Pattern:
        """Where tangents have entries."""
        of_rows = np.concatenate([self.row_group.dof, self._row_numbers], axis=1)
        of_terms = []
        for group, own, term in zip(self.groups, self.mode_numbers, self.terms):
            beside = np.array([*own, *(self.n + np.array(term.rows, dtype=int))], dtype=np.int32)
            of_terms.append(np.hstack([group.block, np.broadcast_to(beside, (len(group.block), len(beside)))]))
        of_rides = [self.riders.block] if self.rides else []
        return Pattern.of(self.size, [*of_terms, of_rows, *of_rides, self.inertia.dof, self.places])

    @property
    def _row_numbers(self) -> Places:
        return np.arange(self.n, self.n + len(self.rows), dtype=np.int32)[:, None]

    @cached_property
    def mode_numbers(self) -> list[Places]:
        """Numbers of the modes of stress of every term, after the multipliers."""
        ends = np.cumsum([term.modes for term in self.terms], dtype=int)
        return np.split(np.arange(self.n + self.held, self.size, dtype=np.int32), ends[:-1])

    @cached_property
    def _row_at(self) -> tuple[Places, Places, Places]:
        """Where derivatives of rows lie: by coordinates, of forces by multipliers, of rows by multipliers."""
        numbers, dof, pattern = self._row_numbers, self.row_group.dof, self.pattern
        by, on, own = pattern.at(numbers, dof)[:, 0], pattern.at(dof, numbers)[:, :, 0], pattern.at(numbers, numbers)
        return np.ascontiguousarray(by), np.ascontiguousarray(on), own[:, 0, 0]

    @cached_property
    def _chart_at(self) -> tuple[Places, Places]:
        """Entries of a row of the pattern in the columns of a turn ``(., turns)``, and the poses of these turns."""
        rows = np.arange(self.size, dtype=np.int32)
        entries = self.pattern.at(rows, self.places[:, self.geometry.d :])  # (poses, size, turns)
        pose, row = np.nonzero(entries[..., 0] >= 0)
        return entries[pose, row], pose.astype(np.int32)

    @cached_property
    def _rest(self) -> Rest:
        return Rest(self.geometry, np.array(self.r), np.array(self.R), self.led)

    @property
    def known(self) -> Chart:
        """The chart: a stated one, or the drawn poses at rest."""
        return self._rest if self.chart is None else self.chart

    def rebase(self, q: Array, v: Array, a: Array) -> tuple[Array, Array]:
        """Move a chart at rest to the poses of some coordinates, and give rates and accelerations in the new chart."""
        # q, v, a (size,)
        g = self.geometry
        place, turn = self.places[:, : g.d], self.places[:, g.d :]
        free = turn[:, 0] >= 0
        Q, V, A = np.pad([q, v, a], ((0, 0), (0, 1)))[:, turn]
        chart = self.known
        if not isinstance(chart, Rest):
            raise ValueError("the chart of the machine moves, and one at rest is to move along: set chart = None first")
        self.chart = Rest(g, chart.r + np.append(q, 0.0)[place], g.turn(Q) @ chart.R, self.led)
        v, a = v.copy(), a.copy()
        v[turn[free]], a[turn[free]] = g.spin(Q, V)[free], g.spin_rate(Q, V, A)[free]
        return v, a

    def with_rates(self, motion: PoseMotion, v: Array, a: Array) -> PoseMotion:
        """Add rates and accelerations of coordinates ``(instants, size)`` to a motion of all poses."""
        # In space the motion has to be that beside which the coordinates are 0, and to rest.
        d = self.geometry.d
        rates, seconds = (np.pad(x, ((0, 0), (0, 1)))[:, self.places] for x in (v, a))
        of_places = motion.v + rates[..., :d], motion.a + seconds[..., :d]
        of_turns = motion.w + rates[..., d:], motion.al + seconds[..., d:]
        return PoseMotion(motion.r, motion.R, of_places[0], of_turns[0], of_places[1], of_turns[1])

    def angles_as_drawn(self) -> list[Array]:
        """Give the measures of every term at the start, whole turns and all ``(1, elements, measures)``."""
        zero, t = np.zeros((1, self.size)), np.zeros(1)
        at = self.moved(t, zero, zero, zero, moving=False)
        return [group.measure(at, term.near(t)).x for term, group in zip(self.terms, self.groups)]

    def turned(self, angles: Sequence[Array] | None, q: Array) -> list[Array] | None:
        """Give angles near those of every term at some coordinates: in the plane given ones, and the turns beside."""
        # angles (1, elements, measures); q (instants, n)
        if angles is None:
            return None
        g, found = self.geometry, []
        turns = np.append(q[:, : self.n], np.zeros((len(q), 1)), axis=1)[:, self.places[:, g.d]] * (g.turns == 1)
        for group, near in zip(self.groups, angles):
            turned = turns[:, group.pose[:, 1]] - turns[:, group.pose[:, 0]]
            found.append(near + (turned[..., None] if turned.shape[1] == near.shape[1] else 0 * q[:, :1, None]))
        return found

    def predicted(self, found: Evaluation, dq: Array, dv: Array, da: Array) -> Sequence[Array]:
        """Predict the stresses of all terms after a step, to first order, for the next geometric stiffness."""
        # dq, dv, da (instants, size) each
        # That is Newton's method with the stresses as unknowns, condensed.
        return [
            measured.predicted(
                group.variables(dq), group.variables(dv), da[:, modes], da[:, self.n :][:, list(term.rows)]
            )
            for measured, group, modes, term in zip(found.terms, self.groups, self.mode_numbers, self.terms)
        ]

    # ---- the equation ----
    def moved(
        self, t: Array, q: Array, v: Array, a: Array, *, loads: float = 1.0, moving: bool = True, heavy: bool = True
    ) -> Moved:
        """Move all poses by coordinates, rates and accelerations beside the chart; arguments as of `residual`."""
        chart = self.known.at(t)
        if not moving:
            for rate in (chart.v, chart.w, chart.a, chart.al):
                rate[:] = 0.0
        Q, V, A = (np.append(x, np.zeros((len(t), 1)), axis=1)[:, self.places] for x in (q, v, a))
        return Moved.by(self.geometry, chart, Q, V, A, loads * heavy * self.gravity, self.drag)

    def placed(self, t: Array, q: Array) -> Placed:
        """Place all poses by coordinates beside a chart that rests ``(instants, n)``, for measures without rates."""
        d, chart = self.geometry.d, self.known.at(t)
        Q = np.concatenate([q, np.zeros((len(t), 1))], axis=1)[:, self.places]
        return Placed(chart.r + Q[..., :d], np.ascontiguousarray(Q[..., d:]), chart.R, np.zeros_like(Q))

    def rows_by_coordinates(self, by_variables: Array) -> Array:
        """Give derivatives of the rows by coordinates, by those by their variables ``(instants, rows, n)``."""
        (d, own), dof, x = (self.geometry.d, self.geometry.size), self.row_group.dof, by_variables[:, :, 0]
        whole = np.zeros((*x.shape[:2], self.n + 1))  # what rests has the last
        rows = np.arange(len(dof))[:, None]
        whole[:, rows, dof[:, :own]] = np.concatenate([-x[..., :d], x[..., d:own]], axis=-1)
        whole[:, rows, dof[:, own:]] += np.concatenate([x[..., :d], x[..., own:]], axis=-1)
        return whole[..., : self.n]

    def residual(
        self,
        t: Array,
        q: Array,
        v: Array,
        a: Array,
        *,
        predicted: Sequence[Array | None] | None = None,
        angles: Sequence[Array] | None = None,
        loads: float = 1.0,
        moving: bool = True,
        heavy: bool = True,
        turning: bool = True,
        tangents: bool = True,
        known: bool = False,
    ) -> Evaluation:
        """Evaluate the equation of motion and the rows of the joints."""
        # angles (instants, elements, measures)
        parts = self.n, len(self.r), len(self.terms), self.size, self.masses.changes
        if self._planned not in (None, parts):  # what was appended after the plan was made would be left out
            raise ValueError("the machine has got parts after it was evaluated. Call forget_plan() first")
        self._planned = parts
        g, at = self.geometry, self.moved(t, q, v, a, loads=loads, moving=moving, heavy=heavy)
        if not turning:
            at = replace(at, H=np.zeros_like(at.H))
        F = np.zeros((len(t), self.size))
        M, C, K = (np.zeros((len(t), self.pattern.entries)) for _ in range(3))
        target = F, M, C, K

        measured: list[Measured] = []
        for k, (term, group) in enumerate(zip(self.terms, self.groups)):
            found = group.measure(at, term.near(t) if angles is None else angles[k])
            rows = self.n + np.array(term.rows, dtype=np.int32)
            pulls = (a[:, rows], None if predicted is None else predicted[k]) if term.rows else ()
            response = term.respond(t, found.x, found.rate, *pulls)
            own = self.mode_numbers[k]
            if (modes := term.patterns(t)) is not None:
                sizes = np.einsum("temk,tem->tk", modes, found.rate) if known else a[:, own]
                response = replace(response, stress=response.stress + np.einsum("temk,tk->tem", modes, sizes))
            response = response if isinstance(term, Beams) else response.times(loads)
            found = replace(found, response=response, modes=modes)
            group.spread(found, None if predicted is None else predicted[k], self.pattern, tangents, target)
            if tangents and found.response.by_pulls is not None:
                group.add_pulls(found, found.response.by_pulls, rows, self.pattern, M)
            if modes is not None:
                group.add_modes(found, sizes, own, self.pattern, target)
            measured.append(found)
        if self.rows:
            self._add_rows(t, at, a, tangents, target)
        if self.rides:
            self.riders.add(at, a, self.pattern, tangents, target)
        if tangents and g.turns > 1 and not self.known.still:  # stresses depend on chart vectors by their rates too
            entries, pose = self._chart_at
            K[:, entries] += np.einsum("tik,tikl->til", C[:, entries], at.ways_c[:, pose])
        self.inertia.add(at, self.pattern, tangents, target, self.drag)
        return Evaluation(F, M, C, K, self.pattern, measured, at, t)

    def _add_rows(self, t: Array, at: Moved, a: Array, tangents: bool, target: Target) -> None:
        """Add the forces of the multipliers, and the gaps of the rows."""
        n, end, group = self.n, self.n + len(self.rows), self.row_group
        value = np.stack([row.at(t) for row in self.rows], axis=1)
        found = group.measure(at, value[..., None])
        group.spread(replace(found, response=Response(a[:, n:end, None])), None, self.pattern, tangents, target)
        slack = np.array([row.slack for row in self.rows])
        target[0][:, n:end] = found.x[..., 0] - value - slack * a[:, n:end]
        if tangents:
            by, on, at_own = self._row_at
            shape = len(t), len(self.rows), found.gradient, by, on, self.size, self.pattern.entries
            call(f"conditions_{self.geometry.name}", *shape, *target)
            target[1][:, at_own] = -slack
