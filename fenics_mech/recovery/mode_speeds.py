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
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import xarray as xr
from scipy.sparse.csgraph import connected_components

from fenics_mech._arrays import Array, Index, summed
from fenics_mech.effects import NOTHING
from fenics_mech.effects.vibration import EFFECT as VIBRATION
from fenics_mech.eigenmodes import Modes, solve_modes
from fenics_mech.errors import SolverError
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.forces.element_loads import pin_loads
from fenics_mech.forces.section_forces import section_forces
from fenics_mech.forces.strains import stress_over_modulus
from fenics_mech.mechanism import System
from fenics_mech.mechanism.equation import Equation
from fenics_mech.response.modal_damping import damping_ratios
from fenics_mech.response.running_frequencies import running_frequencies
from fenics_mech.response.setup import CommonParts, mechanism, moved, static_response, without_stiffening
from fenics_mech.scene import Scene

logger = logging.getLogger(__name__)
ORDERS = 12  # harmonics of the drive that are looked at: above them loads of linkages are small
POSITIONS = 72  # of the cycle: six in a period of the fastest of these harmonics
VEERS = np.pi / 4  # turn of two modes into each other, from which each is as much the other as itself


def mode_speeds(scene: Scene, common: CommonParts | None = None) -> xr.Dataset:
    """Give the critical speeds of a driven machine, and what decides how strong they are.

    Parameters
    ----------
    scene
        The scene, with its effects chosen.
    common
        What it may have in common with other analyses of a study.

    Returns
    -------
    xarray.Dataset
        Nothing where the drive does not lead the whole machine, or no link bends. Else by mode and order, the number
        of the harmonic, `critical_speed` (rad/s), `critical_order` and `critical_share`. By mode `mode_damping` and
        `mode_group`; `mode_share` by mode and link. `mode_frequency` (Hz) by mode and limit: "lowest", "mean" and
        "highest" over the cycle, held at each position, and "running", the mean about the motion.
    """
    wanted = scene.analysis.critical_speeds and scene.drives and scene.analysis.method != "static"
    if not wanted or scene.freedoms or scene.open_joints:
        return xr.Dataset()
    options = {"sub_intervals": POSITIONS, "method": "quasi-static", "allow_coarse": True}
    listed = tuple(name for name in scene.named_effects if name != VIBRATION.name)  # which the method states
    few = scene.model_copy(update={"effects": listed, "analysis": scene.analysis.model_copy(update=options)})
    try:
        system = mechanism(few, common=common)
        modes = solve_modes(system.without_axial_forces, few.analysis.modes, few.petsc)
        elastic = modes.elastic
        if not (count := elastic.omega.shape[1]):
            return xr.Dataset()
        every = modes.omega.shape[1]
        found = _labelled(ModesOfCycle(few, system, elastic), np.arange(every - count, every) + 1)
        return found.reindex(mode=np.arange(1, every + 1))
    except SolverError as error:
        logger.info("critical speeds are not known: %s", error)
        return xr.Dataset(attrs={"critical_speeds_unknown": str(error)})


def _labelled(cycle: ModesOfCycle, numbers: Index) -> xr.Dataset:
    """Label what is known of elastic modes with these numbers, ``(modes,)``; those of rigid bodies come before."""
    frequency = cycle.modes.frequency
    held, run = frequency.mean(axis=0), cycle.running
    limits = [frequency.min(axis=0), held, frequency.max(axis=0), held if run is None else run]
    by = ("mode", "order")
    return xr.Dataset(
        {
            "mode_frequency": (("mode", "limit"), np.stack(limits, axis=1)),
            "mode_damping": ("mode", cycle.damping),
            "mode_group": ("mode", numbers[cycle.groups]),
            "mode_share": (("mode", "link"), cycle.shares),
            "critical_speed": (by, cycle.speeds),
            "critical_order": (by, cycle.orders),
            "critical_share": (by, cycle.load_shares()),
        },
        {
            "mode": numbers,
            "order": np.arange(1, cycle.orders.shape[1] + 1),
            "limit": ["lowest", "mean", "highest", "running"],
            "link": list(cycle.system.motion.links),
        },
    )


@dataclass(frozen=True)
class ModesOfCycle:
    """The modes of a machine over the cycle of its drive.

    Parameters
    ----------
    scene
        The scene.
    system
        Its mechanism at equal steps of the cycle.
    modes
        Its elastic modes there, without axial forces.
    """

    scene: Scene
    system: System
    modes: Modes

    @property
    def rate(self) -> float:
        """Rate of the cycle (rad/s)."""
        return abs(self.scene.cycle_rate)

    @cached_property
    def held(self) -> System:
        """The mechanism at rest at the positions: the applied loads are on it, and no inertia."""
        return moved(self.scene, self.system, self.system.motion.held())

    @cached_property
    def damping(self) -> Array:
        """Damping ratio of each mode, its mean over the cycle, ``(modes,)``."""
        bare = replace(self.system, terms=replace(self.system.without_axial_forces.terms, law=None, coupled=False))
        forces = Equation(bare).linear.damped(self.modes.shapes)
        by_forces = np.sum(self.modes.shapes * forces, axis=-1) / (2 * self.modes.omega)
        return np.asarray((by_forces + damping_ratios(self.scene.damping.ratio, self.modes.omega)).mean(axis=0))

    @cached_property
    def carried(self) -> tuple[Array, Array]:
        """The modes and their momenta in the links' axes, ``(angles, modes, links' coordinates)``."""
        v = self.system.transformation.forward(self.system.values[:, None], self.modes.shapes)
        return v, np.asarray((self.system.link_mass @ v.reshape(-1, v.shape[-1]).T).T).reshape(v.shape)

    @cached_property
    def shares(self) -> Array:
        """Share of each link in each mode, by mass, ``(modes, links)``."""
        v, momenta = self.carried
        parts = summed((v * momenta).mean(axis=0), self.system.link_of_coordinate, len(self.system.motion.links))
        return np.asarray(parts / parts.sum(axis=1, keepdims=True))

    @cached_property
    def groups(self) -> Index:
        """The first mode of those that each turns into over the cycle, ``(modes,)``: assurance between positions falls.

        The rate at which two modes turn into each other does not depend on the steps: a crossing that a step passes
        over is none.
        """
        v, momenta = self.carried
        overlap = np.roll(v, -1, axis=0)[:-1] @ momenta[:-1].transpose(0, 2, 1)
        turned = np.ptp(np.cumsum((overlap - overlap.transpose(0, 2, 1)) / 2, axis=0), axis=0)
        labels = connected_components(turned > VEERS, directed=False)[1]
        return np.array([int(np.flatnonzero(labels == label)[0]) for label in labels])

    @cached_property
    def courses(self) -> list[list[tuple[int, float]]]:
        """What each mode goes through until it comes back: the mode in each cycle, and its sign there.

        Mostly it is itself after one cycle. The last entry is where it has come back, with the sign of that.
        """
        found = []
        for mode in range(self.modes.omega.shape[1]):
            course = [(mode, 1.0)]
            while len(course) == 1 or course[-1][0] != mode:
                column = self.modes.closing[:, course[-1][0]]
                there = int(np.abs(column).argmax())
                course.append((there, course[-1][1] * float(column[there])))
            found.append(course)
        return found

    @cached_property
    def orders(self) -> Array:
        """Multiples of the drive, ``(modes, orders)``, NaN beyond the last: of most modes whole ones.

        A mode that comes back from n cycles meets every n-th part of the drive's rate; where its sign is then the other
        one, those in their middle.
        """
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
        found = running_frequencies(self.scene, self.system, self.modes)
        return None if found is None else self._mean(found)

    @cached_property
    def speeds(self) -> Array:
        """Rates of the cycle at which an order meets a mode (rad/s), ``(modes, orders)``; NaN where none does."""
        mean = self._mean(self.modes.omega)
        if self.running is None:
            return mean[:, None] / self.orders
        loaded = running_frequencies(self.scene, self.held, self.modes)
        at_rest = mean if loaded is None else 2 * np.pi * self._mean(loaded)
        gain = ((2 * np.pi * self.running) ** 2 - at_rest**2) / self.rate**2  # (2.44) of Genta: Southwell
        left = np.nan_to_num(self.orders**2 - gain[:, None]) * (at_rest[:, None] > 0)  # none of a mode that buckles
        return np.where(left > 0, at_rest[:, None] / np.sqrt(np.where(left > 0, left, 1.0)), np.nan)

    def load_shares(self) -> Array:
        """Amplitude of strain that a harmonic makes without vibration, over the peak of all, ``(modes, orders)``.

        Both are those at the critical speed, where the inertia of the rigid motion is that of another rate.
        """
        straight = without_stiffening(self.scene, replace(self.system, terms=NOTHING))
        still = without_stiffening(self.scene, replace(self.held, terms=NOTHING))
        response = static_response(self.scene, straight)
        whole, applied = self._strains(straight, response), self._strains(still, static_response(self.scene, still))
        push = np.einsum("kmi,ki->km", self.modes.shapes, straight.load)
        push_applied = np.einsum("kmi,ki->km", self.modes.shapes, still.load)
        by_mode = [
            np.abs(self._of_mode(m, straight, response) - whole).max(axis=(1, 2, 3)) for m in range(push.shape[1])
        ]
        found = np.full_like(self.speeds, np.nan)
        for m, course in enumerate(self.courses):
            of_course, signs = [mode for mode, _ in course[:-1]], np.array([sign for _, sign in course[:-1]])
            omega = self.modes.omega[:, of_course].T.ravel()
            push_0, push_1 = ((signs[:, None] * part[:, of_course].T).ravel() for part in (push_applied, push))
            strained = np.concatenate([by_mode[mode] for mode in of_course]) / np.sqrt(omega)
            phase = 2 * np.pi / len(self.modes.theta) / omega.mean() * (np.cumsum(omega) - omega / 2)  # by trapezia
            for n in np.flatnonzero(np.isfinite(self.speeds[m])):
                square = (self.speeds[m, n] / self.rate) ** 2
                load = push_0 + square * (push_1 - push_0)
                waves = load * np.exp(-1j * self.orders[m, n] * phase) / np.sqrt(omega)
                peak = np.abs(applied + square * (whole - applied)).max()
                running = self.orders[m, n] * self.speeds[m, n]  # whose square is the stiffness about the motion
                size = 2 * abs(waves.mean()) * omega.mean() / running**2 * strained.max()
                found[m, n] = size / peak if peak else np.nan
        return found

    def _of_mode(self, mode: int, straight: System, response: ElasticResponse) -> Array:
        """Strains of a motion with a mode of the size 1 beside it, ``(angles, members, stations, 2)``."""
        shape, square = self.modes.shapes[:, mode], np.square(self.modes.omega[:, mode])[:, None]
        return self._strains(straight, response.changed(shape, straight.to_links(-square * shape)))

    def _strains(self, system: System, response: ElasticResponse) -> Array:
        """Strains of the outer fibres, ``(angles, members, stations, 2)``; eq. (6.38)."""
        s = np.linspace(0, 1, self.scene.analysis.stations)
        forces = section_forces(system, response, s, pin_loads(system, response))
        axial, _, moment = (force.reshape(len(force), -1, len(s)) for force in forces)
        by_force, by_moment = stress_over_modulus(self.scene.rigidities(s), axial, moment)
        return by_force[..., None] + by_moment
