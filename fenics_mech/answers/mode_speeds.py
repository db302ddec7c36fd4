"""Which harmonics of the drive meet which mode at what speed, and how much of the strain they would make there.

The motion by itself is looked at: its inertia and the applied loads, at few positions of the cycle. So every driven
result has the same answer, a quasi-static one too. A mode ``y'' + 2 zeta omega y' + omega^2 y = f`` whose frequency
changes slowly over the cycle vibrates as ``y = Re a exp(i phi)/sqrt(omega)`` with ``phi' = omega`` (WKB). It repeats in
itself where its mean frequency is a whole multiple of the drive's. Averaged over the cycle it has there

    ``a = 2 <f exp(-i phi)/sqrt(omega)> / (2 zeta <omega>)``,

which is 1/(2 zeta) times its answer without vibration.

Spin and stiffening go with the square of the rate of the drive: ``omega^2 = omega_0^2 + c Omega^2`` (Southwell), so
that ``k Omega = omega`` is at ``Omega = omega_0/sqrt(k^2 - c)``.

Sources: Nayfeh, Perturbation Methods, section 7.1; Genta, Dynamics of Rotating Systems, section 2.5.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import xarray as xr
from scipy.optimize import linear_sum_assignment
from scipy.sparse.csgraph import connected_components

from fenics_mech._arrays import Array, Index, summed
from fenics_mech.answers.modes_by_poses import HeldMachine, over_cycle, undamped
from fenics_mech.classical.response import ratios_of
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.machine.along_members import along_members
from fenics_mech.machine.from_scene import SceneMachine, machine_of
from fenics_mech.machine.motion import LinearMotion, Motion
from fenics_mech.recovery.strains import stress_over_modulus
from fenics_mech.scene import Scene
from fenics_mech.solve import FollowedModes, quasi_static

logger = logging.getLogger(__name__)
ORDERS = 12  # harmonics of the drive that are looked at: above them loads of linkages are small
POSITIONS = 72  # of the cycle: six in a period of the fastest of these harmonics
VEERS = np.pi / 4  # turn of two modes into each other, from which each is as much the other as itself


def mode_speeds(scene: Scene, like: SceneMachine | None = None) -> xr.Dataset:
    """Give the critical speeds of a driven machine, and what decides how strong they are."""
    # Gives nothing where the drive does not lead the whole machine, or no link bends. Else by mode and order, the
    # number of the harmonic, `critical_speed` (rad/s), `critical_order` and `critical_share`. By mode `mode_damping`
    # and `mode_group`; `mode_share` by mode and link. `mode_frequency` (Hz) by mode and limit: "lowest", "mean" and
    # "highest" over the cycle, held at each position, and "running", the mean about the motion.
    wanted = scene.analysis.critical_speeds and scene.drives and scene.analysis.method != "static"
    if not wanted or scene.freedoms or scene.open_joints:
        return xr.Dataset()
    try:
        known = None if like is None else HeldMachine(like, np.zeros(1))
        return _labelled(ModesOfCycle(HeldMachine.of(over_cycle(scene, POSITIONS), known), scene))
    except (SceneError, SolverError) as error:
        logger.info("critical speeds are not known: %s", error)
        return xr.Dataset(attrs={"critical_speeds_unknown": str(error)})


def _labelled(cycle: ModesOfCycle) -> xr.Dataset:
    """Label what is known of the modes."""
    frequency = cycle.held.frequency
    mean, run = frequency.mean(axis=0), cycle.running
    limits = [frequency.min(axis=0), mean, frequency.max(axis=0), mean if run is None else run]
    by = ("mode", "order")
    return xr.Dataset(
        {
            "mode_frequency": (("mode", "limit"), np.stack(limits, axis=1)),
            "mode_damping": ("mode", cycle.damping),
            "mode_group": ("mode", 1 + cycle.groups),
            "mode_share": (("mode", "link"), cycle.shares),
            "critical_speed": (by, cycle.speeds),
            "critical_order": (by, cycle.orders),
            "critical_share": (by, cycle.load_shares()),
        },
        {
            "mode": np.arange(1, frequency.shape[1] + 1),
            "order": np.arange(1, cycle.orders.shape[1] + 1),
            "limit": ["lowest", "mean", "highest", "running"],
            "link": list(cycle.scene.links),
        },
    )


@dataclass(frozen=True)
class ModesOfCycle:
    """The modes of a machine over the cycle of its drive."""

    held: HeldMachine  # the machine at equal steps of the cycle, without damping
    scene: Scene  # its scene, with damping

    @property
    def modes(self) -> FollowedModes:
        """Its modes."""
        return self.held.modes

    @property
    def rate(self) -> float:
        """Rate of the cycle (rad/s)."""
        return abs(self.scene.cycle_rate)

    @cached_property
    def damping(self) -> Array:
        """Damping ratio of each mode, its mean over the cycle, ``(modes,)``."""
        parts = {"damping": self.scene.damping.model_copy(update={"ratio": 0.0}), "dampers": self.scene.dampers}
        machine = machine_of(undamped(self.held.made.scene).model_copy(update=parts)).machine
        machine.chart, shapes = self.held.made.machine.chart, self.modes.shapes
        zero = np.zeros((len(self.held.t), machine.size))
        found = machine.residual(self.held.t, zero, zero, zero, moving=False, heavy=False)
        whole = np.pad(shapes, ((0, 0), (0, machine.size - machine.n), (0, 0)))
        forces = np.stack([found.pattern.times(found.C, whole[..., m]) for m in range(shapes.shape[2])], axis=-1)
        by_forces = np.sum(whole * forces, axis=1) / (2 * self.modes.omega)
        return np.asarray((by_forces + ratios_of(self.scene, self.modes.omega)).mean(axis=0))

    @cached_property
    def carried(self) -> tuple[Array, Array]:
        """The modes and their momenta in the links' axes, ``(positions, modes, nodal dofs)``."""
        v = self.held.of_nodes(self.modes.shapes)
        v = v.reshape(*v.shape[:2], -1)
        assert self.held.made.links is not None
        return v, np.asarray((self.held.made.links.mass @ v.reshape(-1, v.shape[-1]).T).T).reshape(v.shape)

    @cached_property
    def shares(self) -> Array:
        """Share of each link in each mode, by mass, ``(modes, links)``."""
        v, momenta = self.carried
        assert self.held.made.links is not None
        of_links = np.repeat(self.held.made.links.mesh.node_link, 3)
        parts = summed((v * momenta).mean(axis=0), of_links, len(self.scene.links))
        return np.asarray(parts / parts.sum(axis=1, keepdims=True))

    @cached_property
    def groups(self) -> Index:
        """The first mode of those that each turns into over the cycle, ``(modes,)``, as assurance falls."""
        # The rate at which two modes turn into each other does not depend on the steps: a crossing that a step passes
        # over is none.
        v, momenta = self.carried
        overlap = np.roll(v, -1, axis=0)[:-1] @ momenta[:-1].transpose(0, 2, 1)
        turned = np.ptp(np.cumsum((overlap - overlap.transpose(0, 2, 1)) / 2, axis=0), axis=0)
        labels = connected_components(turned > VEERS, directed=False)[1]
        return np.array([int(np.flatnonzero(labels == label)[0]) for label in labels])

    @cached_property
    def closing(self) -> Array:
        """Signed permutation by which the modes come back after a cycle, ``(modes, modes)``."""
        v, momenta = self.carried
        last = momenta[0] @ v[-1].T
        found = np.zeros_like(last)
        for mode, place in enumerate(linear_sum_assignment(last.T**2, maximize=True)[1]):
            found[place, mode] = np.copysign(1.0, last[place, mode])
        return found

    @cached_property
    def courses(self) -> list[list[tuple[int, float]]]:
        """What each mode goes through until it comes back: the mode in each cycle, and its sign there."""
        # Mostly it is itself after one cycle. The last entry is where it has come back, with the sign of that.
        found = []
        for mode in range(self.modes.omega.shape[1]):
            course = [(mode, 1.0)]
            while len(course) == 1 or course[-1][0] != mode:
                column = self.closing[:, course[-1][0]]
                there = int(np.abs(column).argmax())
                course.append((there, course[-1][1] * float(column[there])))
            found.append(course)
        return found

    @cached_property
    def orders(self) -> Array:
        """Multiples of the drive, ``(modes, orders)``, NaN beyond the last: of most modes whole ones."""
        # A mode that comes back from n cycles meets every n-th part of the drive's rate; where its sign is then the
        # other one, those in their middle.
        cycles = np.array([len(course) - 1 for course in self.courses])[:, None]
        middle = np.array([0.5 * (course[-1][1] < 0) for course in self.courses])[:, None]
        orders = (np.arange(1, ORDERS * cycles.max() + 1) - middle) / cycles
        return np.where(orders <= ORDERS, orders, np.nan)

    def _mean(self, curves: Array) -> Array:
        """Means of curves of the modes over their courses, ``(modes,)``, from ``(angles, modes)``."""
        means = curves.mean(axis=0)
        return np.array([means[[mode for mode, _ in course[:-1]]].mean() for course in self.courses])

    @cached_property
    def running(self) -> Array | None:
        """Mean frequency of each mode about the motion (Hz), ``(modes,)``; None where nothing runs or loads."""
        found = self.held.running()
        return None if found is None else self._mean(found)

    @cached_property
    def speeds(self) -> Array:
        """Rates of the cycle at which an order meets a mode (rad/s), ``(modes, orders)``; NaN where none does."""
        mean = self._mean(self.modes.omega)
        if self.running is None:
            return mean[:, None] / self.orders
        loaded = self.held.running(moving=False)
        at_rest = mean if loaded is None else 2 * np.pi * self._mean(loaded)
        gain = ((2 * np.pi * self.running) ** 2 - at_rest**2) / self.rate**2  # (2.44) of Genta: Southwell
        left = np.nan_to_num(self.orders**2 - gain[:, None]) * (at_rest[:, None] > 0)  # none of a mode that buckles
        return np.where(left > 0, at_rest[:, None] / np.sqrt(np.where(left > 0, left, 1.0)), np.nan)

    def load_shares(self) -> Array:
        """Amplitude of strain that a harmonic makes without vibration, over the peak of all, ``(modes, orders)``."""
        # Both are those at the critical speed, where the inertia of the rigid motion is that of another rate.
        whole, applied = (self._strains(self._static(moving)) for moving in (True, False))
        machine, omegas = self.held.made.machine, self.modes.omega
        t, zero = self.held.t, np.zeros((len(self.held.t), machine.size))
        push, push_applied = (
            -np.einsum("kim,ki->km", self.modes.shapes, force[:, : machine.n])
            for force in (machine.residual(t, zero, zero, zero, moving=m, tangents=False).force for m in (True, False))
        )
        by_mode = self._of_modes()
        found = np.full_like(self.speeds, np.nan)
        for m, course in enumerate(self.courses):
            of_course, signs = [mode for mode, _ in course[:-1]], np.array([sign for _, sign in course[:-1]])
            omega = omegas[:, of_course].T.ravel()
            push_0, push_1 = ((signs[:, None] * part[:, of_course].T).ravel() for part in (push_applied, push))
            strained = np.concatenate([by_mode[mode] for mode in of_course]) / np.sqrt(omega)
            phase = 2 * np.pi / len(t) / omega.mean() * (np.cumsum(omega) - omega / 2)  # by trapezia
            for n in np.flatnonzero(np.isfinite(self.speeds[m])):
                square = (self.speeds[m, n] / self.rate) ** 2
                load = push_0 + square * (push_1 - push_0)
                waves = load * np.exp(-1j * self.orders[m, n] * phase) / np.sqrt(omega)
                peak = np.abs(applied + square * (whole - applied)).max()
                running = self.orders[m, n] * self.speeds[m, n]  # whose square is the stiffness about the motion
                size = 2 * abs(waves.mean()) * omega.mean() / running**2 * strained.max()
                found[m, n] = size / peak if peak else np.nan
        return found

    def _static(self, moving: bool) -> Motion:
        """Give the static answer to loads, and to the inertia of the rigid motion."""
        machine, t = self.held.made.machine, self.held.t
        zero, still = np.zeros((len(t), machine.size)), quasi_static(machine, t, moving)
        base = Motion(machine, t, zero, zero, zero, moving)
        acting = LinearMotion(base, still.change, moving=False, stresses=still.stresses).acting
        assert acting is not None
        return acting

    def _of_modes(self) -> Array:
        """Give the largest strain at the positions by each mode of the size 1 ``(modes, positions)``."""
        machine, shapes = self.held.made.machine, np.moveaxis(self.modes.shapes, 2, 0)
        count, positions, n = shapes.shape
        t = np.tile(self.held.t, 1 + count)  # the last without a mode: what acts there is no part of one
        change = np.zeros((len(t), machine.size))
        change[:-positions, :n] = shapes.reshape(-1, n)
        square = np.append(np.square(self.modes.omega).T.ravel(), np.zeros(positions))
        none = np.zeros_like(change)
        base, accelerated = Motion(machine, t, none, none, none, False), -square[:, None] * change
        found = base.with_tangents
        if machine.rides:  # whose pins push members between their nodes
            pulls = np.linalg.pinv(machine.pattern.dense(found.M)[:, :n, n:])
            left = found.pattern.times(found.K, change) + found.pattern.times(found.M, accelerated)
            accelerated[:, n:] = -(pulls @ left[:, :n, None])[..., 0]
        stresses = machine.predicted(found, change, none, accelerated)
        acting = LinearMotion(base, (change, none, accelerated), moving=False, stresses=stresses).acting
        assert acting is not None
        strains = self._strains(acting).reshape(1 + count, positions, -1)
        return np.asarray(np.abs(strains[:-1] - strains[-1]).max(axis=2))

    def _strains(self, acting: Motion) -> Array:
        """Strains of the outer fibres, ``(positions, members, stations, 2)``; eq. (6.38)."""
        s = np.linspace(0, 1, self.scene.analysis.stations)
        forces = along_members(self.held.made, acting.found, acting.a, s, bent=False)
        by_force, by_moment = stress_over_modulus(self.scene.rigidities(s), forces.axial, forces.moment)
        return np.asarray(by_force[..., None] + by_moment)
