"""What lies between the positions of a cycle: by how much its peaks differ from those that positions show.

Inertia of the rigid motion and loads are known everywhere. So is the motion without vibration that they cause, from a
linear static answer at any angle. It is found at many angles, closer together where the links turn sharply, where
loads have corners, and about its peaks. What is left of a response is its vibration, and what its theory adds. That is
known at the positions, and curves through them tell it between these. How certain they are, halves of the positions
show.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech._arrays import Array, norms
from fenics_mech._constants import TINY, TURN
from fenics_mech.accuracy.at_stations import AtStations
from fenics_mech.accuracy.missed_peaks import MissedPeaks, Owner
from fenics_mech.accuracy.quantities import Quantities
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.effects import EFFECTS
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.kinematics import Linkage, Motion
from fenics_mech.mechanism.beam_links import links
from fenics_mech.recovery.cycle_curves import CycleCurves
from fenics_mech.recovery.fields import Fields
from fenics_mech.recovery.peaks import CYCLIC, PEAK, curves_over_cycle, gained
from fenics_mech.response.few_nodes import FEW_NODES
from fenics_mech.response.setup import system_at
from fenics_mech.response.solution import Solution
from fenics_mech.response.static.quasi_static import solve_static
from fenics_mech.scene import Scene
from fenics_mech.scene.applied_loads import factor_pieces
from fenics_mech.scene.meshing import thinned

Values = dict[str, Array]  # by quantity, ``(places, owners, curves of each)``, vectors with another axis of 2
VECTORS = ("deflection", "joint_force")


@dataclass(frozen=True)
class BetweenLimits:
    """How closely a motion without vibration is looked at between positions."""

    angles: int = 360  # equal steps of a cycle, at least
    parts: int = 3  # of each step of the branch, over which rates are nearly straight, and of each between corners
    most_pieces: int = 200  # of a load's factor that are looked at; of more those about its largest value
    drop: float = 1e-4  # of a peak to a place beside it: where more, it is looked at more closely
    closer: int = 8  # times as closely
    rounds: int = 3  # of that
    nothing: float = 1e-9  # of the largest value: what is left of a response is rounding
    apart: float = 10.0  # times the largest value: beyond it a response is not the motion without vibration and a rest
    grows: float = 1.5  # times as many positions, until they show a peak
    most: int = 20_000  # of them that are tried


BETWEEN = BetweenLimits()


def with_missed_peaks(solution: Solution, fields: Fields) -> AtStations:
    """Give what was recovered at the stations, and by how much positions of a cycle miss the peaks between them.

    Parameters
    ----------
    solution
        The response.
    fields
        What was recovered from it.
    """
    scene, found = solution.scene, fields.at_stations
    if scene.analysis.method not in CYCLIC or scene.analysis.sub_intervals < 4 or not scene.drives:
        return found
    still = _WithoutVibration.of(scene, fields)
    return replace(found, missed=_missed(still, _known(solution, fields)))


@dataclass(frozen=True)
class _WithoutVibration:
    """A scene without effects by which axial forces act on bending, and its answer by linear statics at any angles.

    `motion` is that at the positions, and `s` are the stations.
    """

    scene: Scene
    beams: Beams
    motion: Motion
    s: Array

    @classmethod
    def of(cls, scene: Scene, fields: Fields) -> _WithoutVibration:
        """Take few nodes where a mesh has many: those of uniform members are right however few."""
        system = fields.system
        linear = [n for n in scene.named_effects if not (EFFECTS[n].stress_stiffening or EFFECTS[n].nonlinear)]
        straight, beams = scene.model_copy(update={"effects": tuple(linear)}), system.beams
        if scene.analysis.reduction == "none" and not system.transformation.constraints.contacts:
            few = thinned(straight, beams.mesh.members, FEW_NODES.kept)
            straight, beams = (straight, beams) if few is straight else (few, links(few))
        return cls(straight, beams, system.motion, fields.coordinates["s"])

    def at(self, theta: Array) -> Values:
        """Give the quantities at drive angles (rad)."""
        motion = self.motion
        if theta is not motion.theta:
            linkage = motion.linkage or Linkage(self.scene)  # whose branch is followed in steps of its own
            motion = linkage.motion(theta, self.scene.cycle_rate)
        system = system_at(self.scene, self.beams, motion)
        found = Quantities.of(self.scene, system, solve_static(system), s=self.s)
        strain = found.axial[..., None] + found.bending
        return {
            "strain": strain.reshape(*strain.shape[:2], -1),
            "deflection": found.deflection,
            "joint_force": found.force[:, :, None],
            "torque": found.effort[..., None],
        }

    def places(self) -> Array:
        """Give places of the cycle, in positions, that show what the rigid motion and the loads do."""
        count, found = len(self.motion.theta), list[Array]()
        times = math.ceil(BETWEEN.angles / count)
        if self.motion.path is not None:
            branch = self.motion.path.whole.over(self.motion.theta)
            found.append(_with_parts(np.unique(np.abs(branch.theta)) * count / TURN))
        for load in self.scene.loads.values():
            if load.over_cycle is not None:
                found.append(_with_parts(_corners(factor_pieces(load.over_cycle), load.factor_at) * count / TURN))
        places = np.concatenate([np.arange(count * times) / times, *found])
        return np.unique(places[places < count])


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


def _known(solution: Solution, fields: Fields) -> Values:
    """Give the quantities of a response at the positions."""
    strain, deflection, force = (fields.variables[name][1] for name in ("strain", "deflection", "joint_force"))
    efforts = Forces(solution.scene, fields.system, solution.response).efforts()
    return {
        "strain": strain.reshape(*strain.shape[:2], -1),
        "deflection": deflection,
        "joint_force": force[:, :, None],
        "torque": np.stack(list(efforts.values()), axis=1)[..., None],
    }


def _size(name: str, values: Array) -> Array:
    """Give the largest of each owner, ``(places, owners)``."""
    size = norms(values) if name in VECTORS else np.abs(values)
    return np.asarray(size.max(axis=-1, initial=0.0))


def _shown(scene: Scene, name: str, values: Array) -> Array:
    """Give the peaks of the curves through positions, ``(owners,)``."""
    curves = curves_over_cycle(scene, values, name)
    peaks = curves.longest()[1] if name in VECTORS else np.abs(curves.largest()[1])
    return np.asarray(peaks.max(axis=-1, initial=0.0))


@dataclass
class _Peaks:
    """Largest values so far, of each owner or of more, and their places in positions, of one shape."""

    value: Array
    place: Array

    def take(self, places: Array, size: Array) -> None:
        """Take in values at more places, along the first axis."""
        highest = size.max(axis=0, initial=0.0)
        self.place = np.where(highest > self.value, places[size.argmax(axis=0)], self.place)
        self.value = np.maximum(self.value, highest)


class _Response:
    """A response that is known at positions: its peaks by the motion without vibration and what is left.

    Parameters
    ----------
    still, known
        The motion without vibration, and the response at the positions.
    """

    def __init__(self, still: _WithoutVibration, known: Values) -> None:
        count = len(still.motion.theta)
        self.still, self.known, self.count = still, known, count
        self.unknown = set[str]()
        self.rest, self.halves = dict[str, CycleCurves](), dict[str, CycleCurves]()
        for name, without in still.at(still.motion.theta).items():
            left, largest = known[name] - without, float(np.abs(known[name]).max(initial=0.0))
            if np.abs(left).max(initial=0.0) > BETWEEN.apart * largest:  # a damper that blocks: nothing is known of it
                self.unknown.add(name)
            if np.abs(left).max(initial=0.0) > BETWEEN.nothing * largest:
                self.rest[name] = curves_over_cycle(still.scene, left, name)
                if count < PEAK.certain:
                    self.halves[name] = self.rest[name].others()
        self.best = {name: _Peaks(*np.zeros((2, values.shape[1]))) for name, values in known.items()}
        self.rough = {name: _Peaks(*np.zeros((2, 2, known[name].shape[1]))) for name in self.halves}

    def seek(self) -> None:
        """Look for the peaks, more closely about those that are sharp."""
        rate, places = self.still.motion.theta[1] - self.still.motion.theta[0], self.still.places()
        for _ in range(1 + BETWEEN.rounds):
            closer = list[Array]()
            for name, values in self.still.at(places * rate).items():
                size = _size(name, values + self.rest[name].at(places) if name in self.rest else values)
                self.best[name].take(places, size)
                closer += _closer(places, size, self.best[name].value, self.count)
                if name in self.halves:
                    both = _of_halves(self.halves[name], places, self.count)
                    self.rough[name].take(places, np.stack([_size(name, values + part) for part in both], axis=1))
            if not closer:
                return
            places = np.unique(np.concatenate(closer))

    def missed(self, name: str) -> Array:
        """Give by how much the peaks of a quantity differ from those that the positions show, ``(owners,)``."""
        if name in self.unknown:
            return np.zeros_like(self.best[name].value)
        return np.abs(self.best[name].value - _shown(self.still.scene, name, self.known[name]))

    def doubt(self, name: str) -> Array:
        """Give how uncertain what is left makes the peaks of a quantity, as halves of the positions show."""
        best = self.best[name].value
        if name not in self.halves or not best.size:
            return np.zeros_like(best)
        largest, curves = max(float(best.max()), TINY), self.rest[name]
        apart = np.abs(best - self.rough[name].value).max(axis=0) / largest
        cornered = None
        if curves.corners is not None:
            cornered = curves.corners.reshape(len(best), -1).any(axis=-1) | (not curves.of_harmonics)
        return np.asarray(largest * gained(apart, cornered, self.count))


def _missed(still: _WithoutVibration, known: Values) -> MissedPeaks:
    """Compare the peaks of a response with those of the curves through its positions."""
    response = _Response(still, known)
    response.seek()
    known_part = {name: response.missed(name) for name in known}
    rate = still.motion.theta[1] - still.motion.theta[0]

    def enough(owner: Owner, allowed: float) -> int | None:
        return _enough(still, owner, float(response.best[owner[0]].value[owner[1]]), allowed)

    return MissedPeaks(
        count=response.count,
        errors={name: known_part[name] + response.doubt(name) for name in known},
        known=known_part,
        peaks={name: part.value for name, part in response.best.items()},
        angles={name: part.place * rate for name, part in response.best.items()},
        enough=enough,
    )


def _enough(still: _WithoutVibration, owner: Owner, peak: float, allowed: float) -> int | None:
    """Give positions of the motion without vibration that show a peak, as one more of them do."""
    name, which = owner
    count = len(still.motion.theta)
    while count <= BETWEEN.most:
        count = math.ceil(BETWEEN.grows * count)
        shown = (
            _shown(still.scene, name, still.at(still.scene.drive_angles(more))[name][:, [which]])[0]
            for more in (count, count + 1)
        )
        if all(abs(one - peak) <= allowed for one in shown):
            return count
    return None


def _closer(places: Array, size: Array, best: Array, count: int) -> list[Array]:
    """Give places about the peaks of ``(places, owners)`` that fall off to the places beside them."""
    found, last = dict[int, Array](), len(places) - 1
    for k, values, highest in zip(size.argmax(axis=0).tolist(), size.T, best):
        before, after = k - 1, 0 if k == last else k + 1
        if k in found or values[k] < highest or (1 - BETWEEN.drop) * values[k] <= values[[before, after]].min():
            continue
        first = places[before] - (count if k == 0 else 0)
        end = places[after] + (count if k == last else 0)
        if values[k] > 0 and end - first < 2 * 1.01:
            found[k] = np.mod(np.linspace(first, end, 2 * BETWEEN.closer + 1), count)
    return list(found.values())


def _of_halves(halves: CycleCurves, places: Array, count: int) -> tuple[Array, Array]:
    """Give the curves through the even and the odd positions at places among all; see `CycleCurves.others`."""
    along = places * (count + count % 2) / count
    return halves.at(along / 2)[:, 0], halves.at((along - 1) / 2)[:, 1]
