"""Analysis by the dissertation's method: sub-intervals of a cycle, or modes in time, then errors and a result.

What the answer exerts is read off the machine of poses, in the rigid motion, under the stresses of its strains.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Collection, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, summed
from fenics_mech.answers.by_poses import FEWEST, choices_of, collected, judged_errors, of_modes, read_off
from fenics_mech.answers.in_time_by_poses import labelled_in_time
from fenics_mech.answers.solved_by_poses import Solved, instants_of
from fenics_mech.classical.bodies import Bodies
from fenics_mech.classical.joints import turns
from fenics_mech.classical.known import unknown_part
from fenics_mech.classical.mechanism import Mechanism, Transformation
from fenics_mech.classical.modes import Modes, slowest
from fenics_mech.classical.resonances import Vibration, frequency_error, missed_vibrations, slower_than
from fenics_mech.classical.response import JOINED, Response, SubIntervals, rates, ratios_of
from fenics_mech.classical.strains import deflection, end_forces, section_forces
from fenics_mech.effects.known import COUPLING, EXACT_STRAINS, VIBRATION
from fenics_mech.errors import MechanismError, SceneError, SolverError
from fenics_mech.estimate.accepted_errors import VALIDITY
from fenics_mech.estimate.error_sources import Errors
from fenics_mech.estimate.missed_peaks import BETWEEN
from fenics_mech.estimate.quantities import MEASURE, Quantities
from fenics_mech.estimate.remarks import between_points
from fenics_mech.geometry import End
from fenics_mech.machine.corners import refuse_unresolved
from fenics_mech.machine.energy import energy_of_terms, energy_of_weight, kinetic_energy
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.joint_forces import Reactions
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.section_forces import EndForces, Sections
from fenics_mech.planning.sampling_checks import refuse_undersampled, require_positions
from fenics_mech.recovery.balance import balance_of, given_by, mean_in_time
from fenics_mech.recovery.dataset import decisions
from fenics_mech.recovery.of_poses import OfPoses
from fenics_mech.recovery.peaks_between import missed_peaks
from fenics_mech.recovery.result import Result
from fenics_mech.recovery.rigid_places import between_ends
from fenics_mech.recovery.strains import stress_over_modulus, without_vibration
from fenics_mech.scene import Scene
from fenics_mech.scene.meshing import with_halves
from fenics_mech.terms.causes import Cause

logger = logging.getLogger(__name__)
SAFETY, OF_MODES = 2.0, 1.25  # factors on differences by sub-intervals, and by modes left out
STEPS, STEPS_OF_LOADS = 60, 120  # of a cycle by poses, and where loads act: the error is that of the theory to 1 %
COARSE = 60  # sub-intervals of a finer mesh: the error is that of the mesh
MOST_HALVED = 3  # times that elements are halved: a frequency that one has 58 % too high is then 0.04 % off
MOST_JOINED = 5e8  # numbers in the joins of the modes that are sought: memory
DAMPED_AT, MOST_DAMPED = 24, 300  # positions at which all modes are found, for their damping; and modes at most
ORDERS = {"time": 1.0, "modes": 2.0, BETWEEN: 2.0, "stations": 2.0, "theory": 0.0}  # measured
IN_TIME = ("what the mesh does to modes that are superposed in time", "what the theory leaves out")


def by_sub_intervals(scene: Scene, names: Collection[str] | None = None) -> Result:
    """Analyse a periodic motion by sub-intervals, or one in time by its modes, from rest with straight links."""
    if scene.effects == "auto":
        scene = scene.changed(effects=())  # it has no others
    if place := unknown_part(scene):
        raise SceneError(
            "solver = 'sub-intervals' knows driven links of uniform symmetric sections on pins, welds and guides, "
            "their inertia and weight, loads at points, and damping ratios of modes",
            place=place,
            hint="Leave it out, or write solver = 'poses' or 'collocation'",
        )
    answer = ByModes.of(scene)
    answer.refuse_far()
    errors = answer.errors() if scene.analysis.error_estimates else None
    return answer.result(errors, names)


@dataclass(frozen=True)
class OfModes(OfPoses):
    """What a response exerts in the rigid motion, where nothing else of it acts, and where it moves the links."""

    found: Response

    @property
    def P(self) -> Transformation:  # noqa: N802  (of (4.41))
        """What joins the links."""
        return self.found.by.mechanism.P

    @cached_property
    def _nodal(self) -> Array:
        """Displacements of the nodes in link axes (m, rad), ``(positions, nodal dofs)``."""
        return self.P.to_nodes(self.found.q)

    def _inertia(self, elastic: Array) -> Array:
        """Accelerations of the nodes with those of the rigid motion, in link axes, ``(positions, nodal dofs)``."""
        if not self.made.scene.analysis.static_correction:  # then rigid inertia is not in balance with the strains
            return self.P.to_nodes(elastic)
        return self.P.to_nodes(elastic) + self.P.acceleration

    @cached_property
    def _damped(self) -> tuple[Array, Array]:
        """Displacements of the nodes by which links and dampers act together, and their accelerations."""
        strained, elastic = self.found.damped
        return self.P.to_nodes(strained), self._inertia(elastic)

    @cached_property
    def sections(self) -> Sections:
        """Forces in sections at the stations."""
        forces = section_forces(self.P, *self._damped, self.stations)
        ends = np.stack([self._places(which) for which in (0, -1)], axis=2)
        place = self.deflection + between_ends(ends, self.stations)
        return Sections(*forces, place, np.zeros_like(place))

    @cached_property
    def strains(self) -> tuple[Array, Array]:  # type: ignore[override]
        """Strains of the axes ``(instants, members, stations)``, and by bending of both fibres ``(..., 2)`` (6.38)."""
        axial, _, moment = section_forces(self.P, self._nodal, self._inertia(self.found.elastic), self.stations)
        return stress_over_modulus(self.made.scene.rigidities(self.stations), axial, moment)

    @cached_property
    def deflection(self) -> Array:
        """Displacement of the members' axes from the rigid motion ``(instants, members, stations, 2)`` (m)."""
        return deflection(self.P, self._nodal, self._inertia(self.found.elastic), self.stations)

    @cached_property
    def _ends(self) -> EndForces:
        """Forces on the ends of the elements in the fixed frame."""
        forces, mesh = end_forces(self.P, *self._damped).reshape(len(self.P.t), -1, 2, 3), self.mesh
        angle = (self.P.motion.angle[:, mesh.member_link] + mesh.member_angle)[:, mesh.cell_member]
        axes = np.repeat(turns(angle)[:, :, None], 2, axis=2)
        place = np.stack([[self.motion.of_end(end)[0] for end in ends] for ends in self.made.element_ends])
        return EndForces((axes @ forces[..., :2, None])[..., 0], forces[..., 2:], np.moveaxis(place, 2, 0), axes)

    @cached_property
    def on_poses(self) -> Array:
        """What poses need for the strains and the inertia of their nodes, ``(instants, poses, 3)`` (N, N m)."""
        links = self.made.links
        assert links is not None
        strained, inertia = self._damped
        forces = self.P.in_fixed_axes((links.stiffness @ strained.T + links.mass @ inertia.T).T)
        found, mesh = np.zeros((len(forces), len(self.made.machine.r), 3)), links.mesh
        place = self.P.motion.position[:, mesh.node_link]
        place = place + (turns(self.P.motion.angle[:, mesh.node_link]) @ mesh.node_xy[..., None])[..., 0]
        arm = place - self.motion.found.at.r[:, self.made.node_pose]  # of nodes that rigid links carry
        forces[..., 2] += arm[..., 0] * forces[..., 1] - arm[..., 1] * forces[..., 0]
        for node, pose in enumerate(self.made.node_pose):
            found[:, pose] += forces[:, node]
        return found

    @cached_property
    def _reactions(self) -> Reactions:
        """What holds poses beside loads: the inertia of the nodes is that of the links' own forms."""
        machine = copy(self.made.machine)
        machine.gravity = np.zeros(2)
        a = self.motion.a * (np.arange(machine.size) >= machine.n)
        return Reactions(Motion(machine, self.motion.t, 0 * a, 0 * a, a, moving=False), self.on_poses)

    def _rotations(self) -> Array:
        """Give the largest rotation of each member's nodes from the rigid motion (rad)."""
        mesh = self.mesh
        turned = np.abs(self._nodal[:, 2::3]).max(axis=0)[mesh.cell_nodes].max(axis=1)
        return np.array([turned[mesh.cell_member == member].max() for member in range(len(mesh.members))])

    def moved(self, end: End) -> tuple[Array, ...]:
        """Give the place of an end (m), and its velocity and acceleration in the rigid motion."""
        place, velocity, acceleration = self.motion.of_end(end)
        q = np.pad(self.P.to_machine(self._nodal), ((0, 0), (0, 1)))[:, self.made.machine.places[end.pose]]
        arm = place - self.motion.found.at.r[:, end.pose]
        return place + q[:, :2] + q[:, 2:] * np.stack([-arm[:, 1], arm[:, 0]], axis=1), velocity, acceleration

    @property
    def displaced(self) -> Array:
        """Coordinates of the machine ``(instants, size)``."""
        return self.P.to_machine(self._nodal)

    @cached_property
    def rates(self) -> Array:
        """Rates of the coordinates of the machine, by differences ``(instants, size)``."""
        moved = self.P.of_nodes(self.P.in_fixed_axes(self._nodal))
        if self.made.scene.analysis.method == "periodic":
            return rates(moved, self.found.by.duration)
        return np.asarray(np.gradient(moved, self.motion.t, axis=0))

    @cached_property
    def measured(self) -> Sequence[Measured]:
        """Measures, with their rates, and stresses of every term."""
        return replace(self.motion, v=self.rates).found.terms

    def powers(self) -> dict[str, Array]:
        """Give what drives, loads and damping give to the machine ``(instants,)`` (W)."""
        found, taken = super().powers(), self.found.power
        drive = next(iter(found))
        return {drive: found[drive]} | ({Cause.MODAL_DAMPING: -taken} if taken.any() else {}) | found


def read(found: Response) -> OfModes:
    """Read off what a response exerts, in balance with the joints, and where it moves the links."""
    P, made = found.by.mechanism.P, found.by.mechanism.P.made
    machine, n, zero = made.machine, made.machine.n, np.zeros((len(P.t), made.machine.size))
    accelerated = P.to_machine(P.to_nodes(found.damped[1]))
    answer = OfModes(made, Motion(machine, P.t, zero, zero, accelerated), found, bent=False)
    still = machine.residual(P.t, zero, zero, zero, moving=False, heavy=False)
    there = machine.places >= 0
    force = still.force[:, :n] + summed(answer.on_poses[:, there], machine.places[there].astype(np.int64), n)
    pulls = np.linalg.pinv(machine.pattern.dense(still.M)[:, :n, n:])
    accelerated[:, n:] = -(pulls @ force[..., None])[..., 0]
    return answer


def _machine(scene: Scene, like: SceneMachine | None = None) -> SceneMachine:
    """Build the machine of a scene, whose chart is its rigid motion, without damping."""
    made = machine_of(scene.changed({"damping.material": 0.0, "damping.ratio": 0.0}))
    made.machine.chart = Bodies(made, like)
    return replace(made, scene=scene)


def _instants(scene: Scene) -> tuple[Array, Array]:
    """Give the middles of the sub-intervals, and where they begin and end (s). In time the first begins at rest."""
    step = scene.period / scene.analysis.sub_intervals
    if scene.analysis.method == "periodic":
        times = instants_of(scene)
        return times, np.append(times, times[-1] + step) - step / 2
    run_up = max((drive.run_up or 0.0) for drive in scene.drives)
    count = math.ceil(run_up / step - 1e-6) + scene.analysis.cycles * scene.analysis.sub_intervals + 1
    times = step * np.arange(float(count))
    edges = np.append(times, times[-1] + step) - step / 2
    edges[0] = 0.0
    return times, edges


@dataclass(frozen=True)
class ByModes:
    """The answer of a scene, as `by_poses.collected` takes it."""

    scene: Scene
    found: Response
    change: float | None = None  # difference of the last two cycles in time; None of a periodic motion
    untold = ("point_velocity_bent", "point_acceleration_bent")
    left_out = None

    @classmethod
    def of(cls, scene: Scene) -> ByModes:
        """Solve for the response of a scene."""
        refuse_undersampled(scene, scene.analysis.sub_intervals)
        times, edges = _instants(scene)
        require_positions(scene, len(times))
        refuse_unresolved(scene)
        by = SubIntervals.of(scene, _machine(scene), times, edges)
        if scene.analysis.method == "periodic":
            return cls(scene, by.cycle())
        found = by.march()
        count, change = _settled(scene, found.q)
        return cls(scene, found.part(slice(0, count)), change)

    @property
    def made(self) -> SceneMachine:
        """The machine."""
        return self.found.by.mechanism.P.made

    @cached_property
    def positions(self) -> OfModes:
        """What is read off at the positions."""
        return read(self.found)

    @property
    def weighed(self) -> tuple[OfPoses, Array]:
        """Instants by which means over the cycle are taken, and their shares of it."""
        count = len(self.found.q)
        return self.positions, np.full(count, 1 / count)

    def refuse_far(self) -> None:
        """Raise `SolverError` where deflections are far beyond small ones, unless the scene lets them pass."""
        members = self.positions.members()
        turned, bowed = (members[name][1] for name in ("rotation", "bow"))
        worst = int(np.argmax(np.maximum(turned, bowed)))
        if not self.scene.analysis.allow_large and max(turned[worst], bowed[worst]) > VALIDITY.farthest:
            raise SolverError(
                f"elastic deflection turns member {self.positions.mesh.members[worst]!r} by {turned[worst]:.3g} rad "
                f"and moves it by {bowed[worst]:.3g} of its length. The theory of small deflections does not hold near "
                f"{VALIDITY.farthest:g}. Lower loads or speed, keep away from resonances and dead centres, or take "
                "stiffer members or more damping; analysis.allow_large lets it pass"
            )

    def result(self, errors: Errors | None, names: Collection[str] | None = None) -> Result:
        """Label what was found."""
        decided = decisions(len(self.found.by.mechanism.P.kept), len(self.positions.mesh.cell), choices_of(self.scene))
        attributes: dict[str, object] = {"solver": "sub-intervals"} | decided
        if self.change is None:
            beside = self._beside_cycle().assign_attrs(condition=self.found.by.condition)
            found = collected(self, errors, beside, names)  # type: ignore[arg-type]
        else:
            attributes |= {"cycle_change": self.change, "time_steps": len(self.found.q)}
            data = read_off(self.positions).drop_vars(self.untold, errors="ignore")
            found = labelled_in_time(self.scene, data, [self._power_in_time(errors)], errors)
        found.data.attrs.update(attributes)
        return found

    def _beside_cycle(self) -> xr.Dataset:
        """Give natural frequencies, and strains and stresses without vibration."""
        by, found, s = self.found.by, self.positions, self.positions.stations
        still = found.P.to_nodes(by.mechanism.stiffness.solve(by.load))
        axial, _, moment = section_forces(found.P, still, found.P.acceleration, s)
        modes = of_modes(by.modes.omega, frequency_error(by.mechanism, by.modes), by.modes.assurance)
        return modes.assign(without_vibration(self.scene.rigidities(s), axial, moment))

    def _power_in_time(self, errors: Errors | None) -> xr.Dataset:
        """Give the mean power of every cause, and what the machine stores."""
        found, P = self.positions, self.found.by.mechanism.P
        powers, duration = found.powers(), float(np.ptp(P.t))
        mean = mean_in_time(P.t, powers)
        ends, q = [0, -1], P.to_machine(P.to_nodes(self.found.q))
        motion = Motion(self.made.machine, P.t[ends], q[ends], found.rates[ends], 0 * q[ends])
        weight, stored = energy_of_weight(motion), kinetic_energy(motion) + energy_of_terms(motion)
        if any(self.scene.gravity):
            mean[Cause.WEIGHT] = given_by(weight, duration)
        mean[Cause.STORED] = given_by(stored, duration)
        bound = np.nan if errors is None else errors.of_power(found.drive_rates())
        return balance_of(mean, powers, bound, MEASURE.small_power)

    # ---- errors ----
    def errors(self) -> Errors:
        """Estimate the errors by half as many sub-intervals, more modes, a finer mesh, and the answer by poses."""
        here, remarks = self.positions.quantities, between_points(self.scene, self.scene.analysis.sub_intervals)
        if self.change is not None:
            parts = dict(self._errors_in_time(here))
            return replace(judged_errors(self.scene, here, parts, orders=ORDERS), remarks=IN_TIME)
        if len(self.found.by.mechanism.P.kept) > MOST_DAMPED and np.any(self.scene.damping.ratio):
            remarks.append(f"what the damping of modes left out changes, as more than {MOST_DAMPED} are too many")
        if self.scene.analysis.join == "modal":
            remarks.append(
                "what join = 'modal' loses where the modes' shapes change, whatever the number of sub_intervals"
            )
        by, found = self.found.by, self.found
        half = by.halved(found)
        every = slice(0, 2 * len(half.q), 2)
        modes = self._with_more_modes()
        parts = {
            "time": _times(SAFETY, _apart(here, half, every)),
            "modes": _sum(_times(OF_MODES, _apart(here, modes)), _times(OF_MODES, self._of_damping(here))),
            "mesh": self._of_mesh(here),
        }
        judged_errors(self.scene, here, dict(parts), orders=ORDERS)  # before the theory, which takes longest
        missed = None
        if len(found.q) >= FEWEST:
            missed = missed_peaks(self.made, lambda share: self.positions, bent=False, shares=1, still=self._still)
            parts[BETWEEN] = dict(missed.errors)
        parts["theory"] = self._of_theory(here)
        return replace(judged_errors(self.scene, here, parts, missed, orders=ORDERS), remarks=tuple(remarks))

    def _still(self, t: Array) -> OfModes:
        """Read off the static answer at some instants (s)."""
        P = Transformation.of(self.made, t, self.found.by.mechanism.P)
        mechanism, none = Mechanism.of(P), np.zeros((len(t), 0))
        modes = Modes(none, np.zeros((len(t), 0, len(P.kept))), np.zeros((len(t), 0, len(P.kept))))
        by = SubIntervals(self.scene, mechanism, modes, np.ones((len(t), 1)), P.load, np.zeros_like(P.load))
        return read(by.answer(np.zeros((len(t), 0, 2))))

    def _errors_in_time(self, here: Quantities) -> Iterator[tuple[str, dict[str, Array]]]:
        """Errors of a motion in time: by half as many sub-intervals, or twice as many of an odd number; by modes."""
        count, by = self.scene.analysis.sub_intervals, self.found.by
        other = count // 2 if count % 2 == 0 else 2 * count
        free = {"analysis.sub_intervals": other, "analysis.settled": 0.0, "analysis.allow_ringing": True}
        found = ByModes.of(self.scene.changed(free)).found
        mine, theirs = (slice(None, None, step) for step in ((2, 1) if other < count else (1, 2)))
        found = found.part(theirs)
        length = min(len(here.axial[mine]), len(found.q))
        of_mine = slice(0, (2 if other < count else 1) * length, mine.step)
        yield "time", _times(SAFETY, _apart(here, found.part(slice(0, length)), of_mine))
        kept, size = by.modes.omega.shape[1], len(by.mechanism.P.kept)
        if kept < size:
            more = slowest(by.mechanism, min(2 * kept, size), self.scene.petsc)
            ringing = self.scene.changed({"analysis.allow_ringing": True})
            yield "modes", _times(SAFETY, _apart(here, replace(by, scene=ringing, modes=more).march()))

    def _with_more_modes(self) -> Response:
        """Give the response with the inertia of the modes left out; those that a load may meet vibrate, too."""
        by, kept = self.found.by, self.found.by.modes.omega.shape[1]
        reach, modes = by.reach(self.found), by.modes
        size = len(by.mechanism.P.kept)
        if kept < size and modes.omega.min(axis=0).max() < reach:
            wanted = min(slower_than(by.mechanism, reach) + 1, size)
            if JOINED * len(by.load) * wanted**2 < MOST_JOINED:
                modes = slowest(by.mechanism, wanted, self.scene.petsc)
        slow = modes.omega.max(axis=0) * by.duration.max() < np.pi  # faster ones would ring at the joins
        slow[:kept] = True
        if modes is by.modes or slow.sum() == kept:
            return by.with_modes_left_out(self.found)
        static = self.scene.changed({"analysis.static_correction": True})
        more = replace(by, scene=static, modes=modes.part(slice(None), np.flatnonzero(slow)))
        return more.with_modes_left_out(more.answer(more.periodic(*more.loads)))

    def _of_damping(self, here: Quantities) -> dict[str, Array]:
        """Errors of strains and deflections by the damping of the modes left out, at some of the positions."""
        by, kept, size = self.found.by, self.found.by.modes.omega.shape[1], len(self.found.by.mechanism.P.kept)
        if kept == size or not np.any(self.scene.damping.ratio) or size > MOST_DAMPED:
            return {}
        some = slice(0, None, max(1, len(by.load) // DAMPED_AT))
        found, mechanism = self.found.part(some), by.mechanism.part(some)
        modes = slowest(mechanism, size, self.scene.petsc)
        rate = modes.coordinates(rates(self.found.q, by.duration)[some])
        rate += mechanism.strain_by_turning(modes.shapes / modes.omega[..., None] ** 2, found.q[:, None])[..., 0]
        left_out = modes.omega.argsort(axis=1).argsort(axis=1) >= kept
        lost = 2 * ratios_of(self.scene, modes.omega) / modes.omega * rate * left_out
        elastic = found.elastic + modes.superposed(modes.omega**2 * lost)
        change = _apart(here, replace(found, q=found.q - modes.superposed(lost), elastic=elastic), some)
        return {name: change[name] for name in ("strain", "deflection")}

    def _of_mesh(self, here: Quantities) -> dict[str, Array]:
        """Errors by the mesh: what halved elements change, again where they may still miss a resonance."""
        by, kept, scene = self.found.by, self.found.by.modes.omega.shape[1], self.scene
        by_mesh, left_out_of = missed_vibrations(by)
        left_out = _vibrating(here, self.found, left_out_of)
        every, known = self._thinned, self.found
        if every > 1:
            coarse = by.thinned(every)
            known = coarse.answer(coarse.periodic(*coarse.loads))
        base = read(known).quantities
        times = by.mechanism.P.t[::every]
        edges = np.append(times, times[-1] + times[1] - times[0]) - (times[1] - times[0]) / 2
        for _ in range(MOST_HALVED):
            scene = with_halves(scene)
            finer = SubIntervals.of(scene, _machine(scene, self.made), times, edges, kept)
            found = finer.answer(finer.periodic(*finer.loads))
            change = _apart(base, found)
            if not by_mesh.any():
                return _sum(change, left_out)
            by_mesh, _ = missed_vibrations(finer)
        return _sum(_sum(change, left_out), _vibrating(read(found).quantities, found, by_mesh))

    @property
    def _thinned(self) -> int:
        """Odd number of sub-intervals that one may stand for, where only a difference is sought, as modes follow it."""
        count, fastest = len(self.found.q), float(self.found.by.modes.omega.max()) / (2 * np.pi)
        enough = max(2 * fastest * self.scene.period, COARSE)
        return max(every for every in (1, 3, 5, 7, 9) if every == 1 or (count % every == 0 and count >= every * enough))

    def _of_theory(self, here: Quantities) -> dict[str, Array]:
        """Errors by the theory: how far the equation of poses is, with exact strains, at some of the positions."""
        count = len(self.found.q)
        enough = STEPS_OF_LOADS if self.scene.loads else STEPS
        every = max(k for k in range(1, count // FEWEST + 1) if k == 1 or (count % k == 0 and count >= k * enough))
        effects = (*(name for name in self.scene.named_effects if name != VIBRATION), COUPLING, EXACT_STRAINS)
        asked = {"effects": effects, "analysis.sub_intervals": count // every, "analysis.solver": "poses"}
        try:
            positions = Solved.of(self.scene.changed(asked)).positions
        except MechanismError as error:
            logger.info("there is no motion by poses: %s", error)
            return {name: np.full_like(size, np.inf) for name, size in here.largest.items()}
        return positions.quantities.minus(_some(here, slice(0, None, every))).largest


def _some(all_of: Quantities, which: slice) -> Quantities:
    """Give quantities at some of the positions."""
    return Quantities(*(part[which] for part in all_of))


def _apart(here: Quantities, other: Response, which: slice = slice(None)) -> dict[str, Array]:
    """Give by how much another response differs at its positions, which are some of these, by quantity."""
    return read(other).quantities.minus(_some(here, which)).largest


def _times(factor: float, errors: dict[str, Array]) -> dict[str, Array]:
    return {name: factor * error for name, error in errors.items()}


def _sum(one: dict[str, Array], other: dict[str, Array]) -> dict[str, Array]:
    return {name: error + other.get(name, 0.0) for name, error in one.items()}


def _vibrating(here: Quantities, found: Response, missed: Vibration) -> dict[str, Array]:
    """Give what a vibration beside a response changes of each quantity."""
    if not missed.any():
        return {}
    modes, y = missed.modes, missed.y
    moved = replace(
        found, q=found.q + modes.superposed(y), elastic=found.elastic - modes.superposed(modes.omega**2 * y)
    )
    return _apart(here, moved)


def _settled(scene: Scene, q: Array) -> tuple[int, float]:
    """Number of positions up to which the motion settles, and the difference of the last two cycles."""
    samples, change = scene.analysis.sub_intervals, math.inf
    lead = len(q) - 1 - scene.analysis.cycles * samples
    for index in range(lead + 2 * samples, len(q), samples):
        now, then = q[index - samples : index], q[index - 2 * samples : index - samples]
        change = float(np.abs(now - then).max() / max(np.abs(now).max(), 1e-300))
        if change < scene.analysis.settled:
            return index + 1, change
    return len(q), change
