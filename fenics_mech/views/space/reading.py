"""A result in space as people read it: units, peaks, places and angles in words, places to draw, what is judged."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import percent
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.drives import Drive
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.views.frames import DEFLECTED, ROUND
from fenics_mech.views.judgements import Judgement, Level
from fenics_mech.views.prefixes import fitted
from fenics_mech.views.tables import drive_of
from fenics_mech.views.words import in_degrees, sentence, short

EXACT, ROUGH = 0.03, 0.1  # estimated errors up to which numbers are accurate, and up to which they may be used
ERRORS = {"strain": "strains", "deflection": "deflections", "joint_force": "joint forces", "torque": "drive efforts"}
NEAR = 1.5  # factor of safety below which a member is called near its limit


@dataclass(frozen=True)
class Limit:
    """How far a member is from the yield strength, or else the allowed stress, of its material (SI)."""

    factor: float
    member: int
    stress: float
    what: str


class SpatialReading:
    """What views show of a result in space, in the units of its answers."""

    def __init__(self, result: SpatialResult, units: AnswerUnits | None = None) -> None:
        self.result, self.scene, self.data = result, result.scene, result.data
        self.theta = self.data["theta"].to_numpy()
        self.time = self.data["time"].to_numpy()
        self.moves, self.in_time = len(self.theta) > 1, self.scene.analysis.method == "transient"
        self.members = [str(name) for name in self.data["member"].to_numpy()] if "member" in self.data else []
        self.joints = [str(name) for name in self.data["joint"].to_numpy()] if "joint" in self.data else []
        self.s = self.data["s"].to_numpy() if self.members else np.zeros(0)
        stress = self.values("von_mises", "member", "s")
        force = np.linalg.norm(self.values("joint_force", "joint", "component"), axis=-1)
        moments = self.values("section_moment", "member", "s", "section_axis")
        largest = {kind: float(np.abs(of).max(initial=0.0)) for kind, of in zip(("stress", "force"), (stress, force))}
        largest["moment"] = float(np.abs(moments).max(initial=0.0))
        self.units = fitted(largest, units or self.scene.answer_units)
        self.stress = stress / self.units.size("stress")  # (T, M, S)
        self.force = force / self.units.size("force")  # (T, J)
        self.moments = moments / self.units.size("moment")  # (T, M, S, 3)
        self.bent = np.linalg.norm(self.values("deflection", "member", "s", "component"), axis=-1)
        self.bent /= self.units.size("length")  # (T, M, S)
        self.drives = [str(name) for name in self.data["drive"].to_numpy()] if "drive" in self.data else []
        self.effort_kinds = ["force" if by_stroke(self.scene, drive) else "moment" for drive in self.scene.drives]
        sizes = np.array([self.units.size(kind) for kind in self.effort_kinds if self.drives])
        self.efforts = self.values("input_torque", "drive") / sizes if self.drives else np.zeros((len(self.theta), 0))
        stated = self.scene.members()
        self.ends = [stated[name][1].ends for name in self.members]
        points = [self.scene.links[stated[name][0]].points for name in self.members]
        self.lengths = [math.dist(of[a], of[b]) for of, (a, b) in zip(points, self.ends)]

    def values(self, name: str, *dims: str) -> Array:
        """Give a variable over the positions ``(positions, *dims)`` in SI; an empty one without it."""
        if name not in self.data:
            return np.zeros(
                (len(self.theta), 0, *(3 if dim in ("component", "section_axis") else 1 for dim in dims[1:]))
            )
        return self.data[name].transpose("theta", *dims).to_numpy()

    @property
    def driven(self) -> str:
        """How it is driven, in words."""
        if self.scene.analysis.method == "static":
            return "at rest as drawn"
        if not self.in_time:
            return drive_of(self.scene, self.units)
        seconds = f"motion of {short(float(self.time[-1]))} s"
        return f"{drive_of(self.scene, self.units)}; {seconds}" if self.scene.drives else f"free {seconds}"

    def at(self, k: int) -> str:
        """Drive angle of a position, or its time in a motion in time, in words."""
        if self.in_time:
            return f"{short(float(self.time[k]))} s"
        return in_degrees(float(self.theta[k])) if self.moves else "at rest"

    def place(self, i: int, j: int) -> str:
        """Place of a station on a member in words."""
        if j in (0, len(self.s) - 1):
            return f"at {self.ends[i][1 if j else 0]}"
        length = self.units.number(float(self.s[j]) * self.lengths[i], "length")
        return f"{short(length)} {self.units.label('length')} from {self.ends[i][0]}"

    def peak(self, values: Array, i: int | None = None) -> tuple[int, int, int]:
        """Position, member and station at which ``(T, M, S)`` is largest, on one member or on all."""
        of = values if i is None else values[:, i : i + 1]
        k, m, j = map(int, np.unravel_index(np.abs(of).argmax(), of.shape))
        return k, m if i is None else i, j

    def words(self, peak: tuple[int, int, int]) -> str:
        """Say which member, where on it and when."""
        k, i, j = peak
        return f"{self.members[i]}, {self.place(i, j)}, {self.when(k)}"

    def when(self, k: int) -> str:
        """Drive angle or time of a position in words, after others."""
        return f"at {self.at(k)}" if self.moves else "at rest"

    @cached_property
    def limit(self) -> Limit | None:
        """The member that is nearest to its limit; None where no material states one."""
        found = []
        for i, name in enumerate(self.members):
            material = self.scene.materials[self.scene.members()[name][1].material]
            most = material.yield_ or material.strength
            if most is not None:
                stress = float(self.stress[:, i].max()) * self.units.size("stress")
                what = "yield strength" if material.yield_ else "allowed stress"
                found.append(Limit(most / stress if stress else math.inf, i, most, what))
        return min(found, key=lambda one: one.factor, default=None)

    @cached_property
    def safety(self) -> tuple[Level, str]:
        """Whether the stresses are below yield, in a sentence."""
        if not self.members:
            return "note", "No link bends: there are forces, and no stresses."
        if self.limit is None:
            return "warn", "Whether it holds is not known: state the yield strength of its materials (yield)."
        one, name = self.limit, self.members[self.limit.member]
        against = f"the {one.what} of {self.units.text(one.stress, 'stress', 3)}"
        if one.factor < 1:
            return "bad", f"Not safe: {name} has {short(1 / one.factor)} times {against}."
        level: Level = "warn" if one.factor < NEAR else "good"
        return level, f"Factor of safety {short(one.factor)} against {against}, in {name}."

    @property
    def headline(self) -> tuple[str, str]:
        """The largest stress, or of rigid links the largest joint force, with its member, place and angle."""
        if self.members:
            peak = self.peak(self.stress)
            value = f"{short(self.stress[peak])} {self.units.label('stress')}"
            return f"Largest von Mises stress {value}", f"in {self.words(peak)}."
        if not self.force.size:
            return "No joint", "holds a link."
        k, n = map(int, np.unravel_index(self.force.argmax(), self.force.shape))
        value = f"{short(self.force[k, n])} {self.units.label('force')}"
        return f"Largest joint force {value}", f"at {self.joints[n]}, {self.when(k)}."

    @property
    def most_bent(self) -> str:
        """The largest deflection in a sentence; nothing of rigid links."""
        if not self.members:
            return ""
        peak = self.peak(self.bent)
        value = f"{short(self.bent[peak])} {self.units.label('length')}"
        return f"Largest deflection {value} in {self.words(peak)}."

    @property
    def errors(self) -> dict[str, float]:
        """Estimated error of each quantity over its largest, by its words."""
        names = {words: f"{name}_error_estimate" for name, words in ERRORS.items()}
        return {words: float(self.data.attrs[name]) for words, name in names.items() if name in self.data.attrs}

    @property
    def judged(self) -> list[Judgement]:
        """Judgements of the computation, the worst first."""
        found = []
        if self.errors:
            what, most = max(self.errors.items(), key=lambda pair: pair[1])
            level: Level = "good" if most <= EXACT else "warn" if most <= ROUGH else "bad"
            found.append(Judgement(level, f"error at most {percent(most)}", f"It is that of the {what}."))
        elif self.scene.analysis.error_estimates:
            found.append(
                Judgement("good", "no error of elements or steps", "Nothing is meshed and nothing is stepped.")
            )
        else:
            found.append(Judgement("warn", "errors not estimated", "analysis.error_estimates leaves them out."))
        if "multiplier" in self.data:
            most = float(self.data["multiplier"].max())
            said = f"A small disturbance is multiplied by {short(most)} in each cycle."
            found.append(Judgement("good" if most < 1 else "bad", "stable" if most < 1 else "unstable", said))
        if warned := [f"{sentence(text)}." for text in self.result.warnings]:
            count = f"{len(warned)} warning{'s' * (len(warned) > 1)}"
            found.append(Judgement("warn", count, " ".join(warned)))
        return sorted(found, key=lambda one: ("bad", "warn", "good", "note").index(one.level))

    @property
    def frequency_ranges(self) -> list[tuple[float, float]]:
        """Lowest and highest of each natural frequency over the cycle (Hz)."""
        frequency = self.values("frequency", "mode")
        return [(float(one.min()), float(one.max())) for one in frequency.T]

    def paths(self, times: float) -> Array:
        """Places of the stations with the deflection magnified ``(T, M, S, 3)`` (m)."""
        place, bent = (self.values(name, "member", "s", "component") for name in ("place", "deflection"))
        return np.asarray(place + (times - 1) * bent)

    def joint_points(self, times: float) -> Array:
        """Places of each joint's point on its first and on its second link, moved as drawn ``(T, J, 2, 3)`` (m)."""
        paths = self.paths(times)
        both = [self.values(name, "joint", "component") for name in ("joint_base", "joint_place")]
        found = np.stack(both, axis=2)
        links = [self.scene.members()[name][0] for name in self.members]
        ends = {f"{link}.{end}": (i, -j) for i, link in enumerate(links) for j, end in enumerate(self.ends[i])}
        shifts: dict[str, Array] = {}  # of rigid links, by the deflections of members at their joints
        waiting = []
        for n, name in enumerate(self.joints):
            points = self.scene.joints[name].connect
            drawn = [ends.get(point) for point in points]
            meets = np.allclose(found[:, n, 0], found[:, n, 1], atol=1e-9)
            for side in (0, 1):
                if end := drawn[side] or (drawn[1 - side] if meets else None):
                    shifts[points[side].split(".")[0]] = paths[:, end[0], end[1]] - found[:, n, side]
                    found[:, n, side] = paths[:, end[0], end[1]]
                elif not (meets and points[1 - side].startswith("ground.")):
                    waiting.append((n, side, points[side].split(".")[0]))
        for n, side, link in waiting:
            if link != "ground":
                found[:, n, side] += shifts.get(link, 0.0)
        return found

    @property
    def bars(self) -> list[list[int]]:
        """Rigid links, each by the numbers of its points among those of `joint_points`, flat."""
        connect = [self.scene.joints[name].connect for name in self.joints]
        rigid = [name for name, link in self.scene.links.items() if not link.members]
        return [
            [2 * n + side for n, pair in enumerate(connect) for side in (0, 1) if pair[side].startswith(f"{name}.")]
            for name in rigid
        ]

    @property
    def magnify(self) -> float:
        """Round factor that draws the largest deflection at a share of the linkage's size."""
        largest = float(self.bent.max(initial=0.0)) * self.units.size("length")
        if largest == 0:
            return 1.0
        places = np.concatenate([self.paths(0.0).reshape(-1, 3), self.joint_points(0.0).reshape(-1, 3)])
        wanted = DEFLECTED * float(np.linalg.norm(np.ptp(places, axis=0))) / largest
        decade = 10.0 ** np.floor(np.log10(wanted))
        return float(decade * ROUND[np.abs(np.log(ROUND * decade / wanted)).argmin()])

    @property
    def peak_position(self) -> int:
        """Number of the position at which the stress, or else a joint force, is largest."""
        of = self.stress if self.members else self.force
        return int(np.unravel_index(of.argmax(), of.shape)[0]) if of.size else 0


def by_stroke(scene: SpatialScene, drive: Drive) -> bool:
    """Whether a drive leads a stroke, so that its effort is a force."""
    kind = scene.joints[drive.joint].kind
    return kind == "slider" or (kind == "cylinder" and drive.speed is None)
