"""Peaks of a response between the positions of a cycle: by how much they differ from those that positions show.

Inertia of the rigid motion and loads are known everywhere, and so is what they cause without vibration. It is found at
many angles, closer together where the links turn sharply, where loads have corners, and about peaks that positions
miss. What is left of a response is known at the positions, and curves through them tell it between these. How certain
they are, halves of the positions show.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import ClassVar

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech._constants import TINY, TURN
from fenics_mech.estimate.missed_peaks import ACCELERATIONS, MissedPeaks
from fenics_mech.kinematics import Motion as LinkMotion
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.motion import LinearMotion, Motion
from fenics_mech.recovery.cycle_curves import CycleCurves
from fenics_mech.recovery.link_motion import followed
from fenics_mech.recovery.of_linear import OfLinear
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.peaks import PEAK, curves_over_cycle, gained
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import factor_pieces
from fenics_mech.solve import quasi_static

Values = dict[str, Array]  # by quantity, ``(places, owners, curves of each)``, vectors with another axis of 2
VECTORS = ("deflection", "joint_force", *ACCELERATIONS)


@dataclass(frozen=True)
class BetweenLimits:
    """How closely a motion without vibration is looked at between positions."""

    angles: int = 360  # equal steps of a cycle, at least
    cheap: int = 3600  # the same of rigid links, of which so many take 0.1 s
    parts: int = 3  # of each step of the branch, over which rates are nearly straight, and of each between corners
    most_pieces: int = 200  # of a load's factor that are looked at; of more those about its largest value
    sharp: float = 0.05  # of the largest value: where what positions miss changes more to the next place, it is looked
    closer: int = 8  # so many times as closely
    rounds: int = 3  # at most
    nothing: float = 1e-9  # of the largest value: what is left of a response is rounding
    apart: float = 10.0  # times the largest value: beyond it a response is not the motion without vibration and a rest
    grows: float = 1.2  # times as many positions, until they show a peak
    phases: int = 4  # parts of a step after which they may begin, so that no peak is shown by luck
    least: int = 12  # of the positions that are tried, so that all answers of one machine get one number
    most: int = 20_000  # of them


BETWEEN = BetweenLimits()
FINE = 4  # times as many places as angles, at which the rigid motion is looked at
TURNS = 40  # places between which accelerations change alike, over all that they change in a cycle


@dataclass(frozen=True)
class OverCycle(ABC):
    """A motion without vibration over a cycle, which is known at any angles."""

    scene: Scene
    angles: ClassVar[int] = BETWEEN.angles
    least: ClassVar[int] = 1  # parts of the step from a position to the next, at least

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of the positions."""

    @abstractmethod
    def at(self, places: Array) -> Values:
        """Give the quantities at places of the cycle."""
        # places: the places, in positions, ``(places,)``

    def at_positions(self, times: int) -> Values:
        """Give the quantities at so many times as many even places as there are positions."""
        return self.at(np.arange(self.count * times) / times)

    @abstractmethod
    def turning(self) -> Array:
        """Give ascending places over the cycle, in positions, between which rates of the links are nearly straight."""

    @property
    def step(self) -> float:
        """Drive angle from one position to the next (rad)."""
        return TURN * math.copysign(1 / self.count, self.scene.cycle_rate)

    def places(self) -> Array:
        """Give places of the cycle, in positions, that show what the rigid motion and the loads do; no positions."""
        count, found = self.count, [_with_parts(self.turning())]
        times = max(math.ceil(self.angles / count), self.least)
        for load in self.scene.loads.values():
            if load.over_cycle is not None:
                found.append(_with_parts(_corners(factor_pieces(load.over_cycle), load.factor_at) * count / TURN))
        places = np.unique(np.concatenate([np.arange(count * times) / times, *found]))
        return places[(places < count) & (places > np.floor(places))]


def _corners(pieces: Array, factor: Callable[[Array], Array]) -> Array:
    """Give ends of the pieces of a load's factor, or where these are many, those about its largest value."""
    if len(pieces) <= BETWEEN.most_pieces:
        return pieces
    middle = int(np.abs(factor(pieces)).argmax())
    return pieces[max(middle - BETWEEN.most_pieces // 2, 0) : middle + BETWEEN.most_pieces // 2]


def _with_parts(ends: Array) -> Array:
    """Cut every part between ascending ends into equal ones."""
    share = np.arange(BETWEEN.parts) / BETWEEN.parts
    return np.append((ends[:-1, None] + np.diff(ends)[:, None] * share).ravel(), ends[-1:])


def accelerations_of(scene: Scene, motion: LinkMotion) -> Array:
    """Give the accelerations of all points of the links, and of those that the scene adds (m/s^2)."""
    return np.stack([motion.of_point(*place)[2] for place in followed(scene).values()], axis=1)[:, :, None]


def _size(name: str, values: Array) -> Array:
    """Give the largest of each owner, ``(places, owners)``."""
    size = norms(values) if name in VECTORS else np.abs(values)
    return np.asarray(size.max(axis=-1, initial=0.0))


class PeaksBetween:
    """A response that is known at positions: its peaks by the motion without vibration and what is left."""

    def __init__(self, still: OverCycle, known: Values, times: int = 1) -> None:
        self.still, self.count, self.times = still, still.count, times
        self.places = np.arange(self.count * times) / times
        at_positions = still.at_positions(times)
        self.found = {name: at_positions[name] for name in known}
        self.curves = {
            name: CycleCurves.of_positions(values[::times])  # nothing tells their peaks but the positions themselves
            if name in ACCELERATIONS
            else curves_over_cycle(still.scene, values[::times], name)
            for name, values in known.items()
        }
        self.unknown = set[str]()
        self.rest, self.halves = dict[str, CycleCurves](), dict[str, CycleCurves]()
        for name, without in self.found.items():
            left, largest = known[name] - without, float(np.abs(known[name]).max(initial=0.0))
            if np.abs(left).max(initial=0.0) > BETWEEN.apart * largest:  # a damper that blocks: nothing is known of it
                self.unknown.add(name)
            if np.abs(left).max(initial=0.0) > BETWEEN.nothing * largest:
                self.rest[name] = curves_over_cycle(still.scene, left, name)
                if times == 1 and self.count < PEAK.certain:
                    self.halves[name] = self.rest[name].others()
        self._compare()

    def _seek(self) -> None:
        """Look for the peaks, more closely about those that are sharp."""
        places = self.still.places()
        for _ in range(1 + BETWEEN.rounds):
            if not len(places):
                break
            order = np.argsort(whole := np.concatenate([self.places, places]))
            more, self.places = self.still.at(places), whole[order]
            self.found = {name: np.concatenate([part, more[name]])[order] for name, part in self.found.items()}
            self._compare()
            places = self._closer()

    def _compare(self) -> None:
        """Compare the response with what the curves through the positions show at the places."""
        left = {name: rest.at(self.places * self.times) for name, rest in self.rest.items()}
        self.response = {name: part + left.get(name, 0.0) for name, part in self.found.items()}
        self.sizes = {name: _size(name, part) for name, part in self.response.items()}
        self.shown = {name: _size(name, curves.at(self.places)) for name, curves in self.curves.items()}

    def _closer(self) -> Array:
        """Give places about sharp peaks that the positions miss, between the places beside them."""
        around = np.append(self.places[-1:] - self.count, self.places), np.append(self.places, self.count)
        whole = [np.zeros(0)]
        for k in self._sharp():
            for end in (around[0][k], around[1][k + 1]):
                whole.append(np.linspace(self.places[k], end, BETWEEN.closer + 1)[1:-1])
        return np.setdiff1d(np.mod(np.concatenate(whole), self.count), self.places)

    def _sharp(self) -> set[int]:
        """Give where peaks are that change much to the places beside them, in what the positions miss of them."""
        found = set[int]()
        for name, sizes in self.sizes.items():
            between = sizes - self.shown[name]
            change = np.maximum(*(np.abs(between - np.roll(between, way, axis=0)) for way in (1, -1)))
            peaks, owners = sizes.argmax(axis=0), np.arange(sizes.shape[1])
            found |= set(peaks[change[peaks, owners] > BETWEEN.sharp * sizes.max(initial=0.0)].tolist())
        return found

    def _missed(self) -> Values:
        """Give by how much the peaks of each quantity differ from those that the positions show, ``(owners,)``."""
        return {
            name: np.abs(sizes.max(axis=0) - self.shown[name].max(axis=0)) * (name not in self.unknown)
            for name, sizes in self.sizes.items()
        }

    def _doubt(self, name: str) -> Array:
        """Give how uncertain what is left makes the peaks of a quantity, as halves of the positions show."""
        best = self.sizes[name].max(axis=0)
        if name not in self.halves or not best.size:
            return np.zeros_like(best)
        largest, curves = max(float(best.max()), TINY), self.rest[name]
        along, curves_of = self.places * (self.count + self.count % 2) / self.count, self.halves[name]
        both = curves_of.at(along / 2)[:, 0], curves_of.at((along - 1) / 2)[:, 1]  # see `CycleCurves.others`
        rough = np.stack([_size(name, self.found[name] + part).max(axis=0) for part in both])
        apart = np.abs(best - rough).max(axis=0) / largest
        if name in ACCELERATIONS:
            return largest * self._of_all_points(apart, curves, largest)
        cornered = None
        if curves.corners is not None:
            cornered = curves.corners.reshape(len(best), -1).any(axis=-1) | (not curves.of_harmonics)
        return np.asarray(largest * gained(apart, cornered, self.count))

    def _of_all_points(self, apart: Array, curves: CycleCurves, largest: float) -> Array:
        """Give to each point the share of what is left of it, by which that of the worst point is uncertain."""
        # Vibration moves all points, and at one of them peaks may agree by luck. Halves of the positions count in
        # full, as the harmonics of accelerations fade more slowly than those for which `gained` was measured.
        moved = _size("point_acceleration", curves.values).max(axis=0) / largest
        worst = np.divide(apart, moved, out=np.zeros_like(moved), where=moved > BETWEEN.nothing).max()
        return np.asarray(moved * worst)

    def missed_peaks(self) -> MissedPeaks:
        """Give by how much the positions miss the peaks."""
        self._seek()
        known = self._missed()
        angles = {name: self.places[sizes.argmax(axis=0)] * self.still.step for name, sizes in self.sizes.items()}
        return MissedPeaks(
            count=self.count,
            points=tuple(followed(self.still.scene)),
            errors={name: part + self._doubt(name) for name, part in known.items()},
            known=known,
            peaks={name: sizes.max(axis=0) for name, sizes in self.sizes.items()},
            angles=angles,
            enough=self._enough,
        )

    def _enough(self, allowed: Mapping[str, Array]) -> int | None:
        """Give a number of positions that show all peaks to errors of each owner, wherever in a step they begin."""
        count = BETWEEN.least
        while (count := math.ceil(BETWEEN.grows * count)) <= BETWEEN.most:
            if count > self.count and all(
                (self._missed_by(some, name, phase) <= most).all()
                for name, most in allowed.items()
                if name not in self.unknown
                for some in (count, count + 1)  # of an even and an odd number curves may be of other kinds
                for phase in np.arange(BETWEEN.phases) / BETWEEN.phases
            ):
                return count
        return None

    def _missed_by(self, count: int, name: str, phase: float) -> Array:
        """Give by how much so many positions miss peaks of a quantity, on the curves that have them, ``(owners,)``."""
        # Between the places that were looked at, the curves are straight. `phase` is the part of a step at which the
        # positions begin.
        values, owners = self.response[name], np.arange(self.sizes[name].shape[1])
        each = norms(values) if name in VECTORS else np.abs(values)
        highest = values[:, owners, each.max(axis=0).argmax(axis=1)]  # of each owner
        at, places = (np.arange(count) + phase) * (self.count / count), np.append(self.places, self.count)
        k = np.searchsorted(places, at, side="right") - 1
        share = ((at - places[k]) / (places[k + 1] - places[k])).reshape(-1, *(1,) * (highest.ndim - 1))
        sampled = (1 - share) * highest[k] + share * highest[(k + 1) % len(highest)]
        curves = curves_over_cycle(self.still.scene, sampled, name)
        shown = curves.longest()[1] if name in VECTORS else np.abs(curves.largest()[1])
        return np.asarray(np.abs(self.sizes[name].max(axis=0) - shown))


def missed_peaks(
    made: SceneMachine,
    at: Callable[[float], OfPoses],
    bent: bool,
    shares: int,
    still: Callable[[Array], OfPoses] | None = None,
) -> MissedPeaks:
    """Give by how much the positions of a cycle miss the peaks between them."""
    # still: gives what is read off the static answer at instants (s); None for that of the machine
    times = min(shares, math.ceil(PEAK.certain / made.scene.analysis.sub_intervals))
    parts = [_values(at(share / times), bent) for share in range(times)]
    known = {name: np.stack([part[name] for part in parts], axis=1) for name in parts[0]}
    whole = {name: value.reshape(-1, *value.shape[2:]) for name, value in known.items()}
    return PeaksBetween(
        _WithoutVibration(made.scene, made, still or partial(_at_rest, made)), whole, times
    ).missed_peaks()


def _values(found: OfPoses, bent: bool) -> Values:
    """Give the quantities whose peaks are compared ``(instants, owners, curves of each)``."""
    axial, bending, deflection, force, effort = found.quantities
    strain = axial[..., None] + bending
    values = {"strain": strain.reshape(*strain.shape[:2], -1), "deflection": deflection}
    values |= {"joint_force": force[:, :, None], "torque": effort[..., None]}
    ways = (found.motion.chart.of_end, found.moved) if bent else (found.motion.chart.of_end,)
    for name, moved in zip(ACCELERATIONS, ways):
        values[name] = np.stack([moved(end)[2] for end in found.traced.values()], axis=1)[:, :, None]
    return values


def _at_rest(made: SceneMachine, t: Array) -> OfPoses:
    """Read off the linear static answer of a machine at some instants (s)."""
    machine, zero = made.machine, np.zeros((len(t), made.machine.size))
    answer = quasi_static(machine, t)
    rigid = Motion(machine, t, zero, zero, zero)
    return OfLinear.by(made, LinearMotion(rigid, answer.change, moving=False, stresses=answer.stresses))


@dataclass(frozen=True)
class _WithoutVibration(OverCycle):
    """The linear static answer to loads and rigid inertia of a machine at any angles."""

    made: SceneMachine
    still: Callable[[Array], OfPoses]

    @property
    def count(self) -> int:
        """Number of the positions."""
        return self.scene.analysis.sub_intervals

    def at(self, places: Array) -> Values:
        """Give the quantities at places of the cycle, in positions."""
        values = _values(self.still(places * (self.scene.period / self.count)), bent=False)
        return values | {ACCELERATIONS[1]: values[ACCELERATIONS[0]]}

    def turning(self) -> Array:
        """Give places over the cycle between which accelerations of the rigid links change alike."""
        fine = np.linspace(0.0, 1.0, self.angles * FINE + 1)
        change = np.abs(np.diff(self.made.machine.known.at(fine * self.scene.period).a, axis=0)).max(axis=(1, 2))
        sum_of = np.append(0.0, np.cumsum(change))
        even = np.linspace(0.0, sum_of[-1], TURNS + 1)
        return np.asarray(self.count * np.unique(np.interp(even, sum_of, fine)))
