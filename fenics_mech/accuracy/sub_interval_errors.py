"""Errors of a periodic response by the sub-intervals of chapter 5: their number, the modes left out, and the mesh.

Half as many sub-intervals are those about every second position: their modes are known, and their loads. The modes left
out answer statically, without their inertia: it bends them as one more load would. Where harmonics of that load may
meet their frequencies, they are taken in, as far as the sub-intervals can follow them. What the modes left out move has
inertia and drag on those kept too, as shapes turn: most where a mode kept exchanges its shape with one left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index
from fenics_mech.accuracy.corrected_response import ESTIMATES, CorrectedResponse
from fenics_mech.accuracy.feedback import Answer, without_mesh
from fenics_mech.accuracy.frequency_errors import highest_felt
from fenics_mech.effects import Loads
from fenics_mech.eigenmodes import Modes, solve_modes
from fenics_mech.forces.elastic_response import ElasticResponse
from fenics_mech.mechanism import System
from fenics_mech.response.modal_damping import damping_ratios
from fenics_mech.response.periodic.steady_state import by_sub_intervals
from fenics_mech.response.periodic.sub_intervals import SUB_INTERVALS, SubIntervals, straining_by, superposed
from fenics_mech.response.solution import SubIntervalSolution
from fenics_mech.response.static.quasi_static import displacement_under
from fenics_mech.scene import Scene

ORDERS = {"time": 1, "modes": 2}  # measured


@dataclass(frozen=True)
class ModeSearch:
    """Limits of the search for modes that were left out and may resonate."""

    static: float = 0.5  # share of the last frequency kept, up to which the modes left out answer statically
    least_energy: float = 1e-4  # share of the largest elastic energy's square root, below which no harmonic is sought
    largest_joins: float = 5e8  # numbers in the joins of the modes that are sought: memory
    least_ratio: float = 1e-6  # of damping, for which resonance is looked for


MODE_SEARCH = ModeSearch()


def sub_interval_errors(solution: SubIntervalSolution) -> dict[str, CorrectedResponse]:
    """Give a response by sub-intervals without the errors of their number ("time"), of modes left out, of the mesh.

    Parameters
    ----------
    solution
        The solution.

    Returns
    -------
    dict
        Responses by source.
    """
    motion = _ModalMotion(solution)
    return {
        "time": CorrectedResponse(solution.response.changed(*motion.halved()), ORDERS["time"], ESTIMATES.safety),
        "modes": CorrectedResponse(motion.with_modes(), ORDERS["modes"], ESTIMATES.of_modes),
        "mesh": without_mesh(motion.answer(), solution.response.undamped),
    }


def modal_answer(solution: SubIntervalSolution) -> Answer:
    """Give how a motion by sub-intervals answers to small loads.

    Parameters
    ----------
    solution
        The solution.
    """
    return _ModalMotion(solution).answer()


@dataclass(frozen=True)
class _ModalMotion:
    """A periodic motion by sub-intervals, and how it answers to small loads, to more modes and to other sub-intervals.

    The mechanism is at the middles of the sub-intervals, and has the modes kept.
    """

    solution: SubIntervalSolution

    @property
    def scene(self) -> Scene:
        return self.solution.scene

    @property
    def system(self) -> System:
        return self.solution.system

    @property
    def modes(self) -> Modes:
        return self.solution.modes

    def answer(self) -> Answer:
        """Give the linear answer to loads: the modes' ``omega y``, whose sizes are compared, and q."""
        unit = np.pad(np.ones(self.modes.omega.shape[1]), (0, self.system.size))
        return Answer(self.system, self.step, unit, np.inf, self._to, self._changed)

    def _to(self, loads: Loads) -> Array:
        """Give the change of the modes' ``omega y``, and of q, under loads, ``(angles, modes + coordinates)``."""
        load, omega = self.system.on_coordinates_by(loads), self.modes.omega
        modal = self._modal(load)
        slope = self._rate(modal)
        y = self.solution.joined.answer(modal, slope)[..., 0]
        static = displacement_under(self.system, load)
        return np.concatenate([omega * y, superposed(self.modes, y - modal / omega**2) + static], axis=1)

    def _changed(self, change: Array, loads: Loads) -> ElasticResponse:
        """Give the response with a change as `_to` gives it, under the loads of this change."""
        swing, q = np.split(change, [self.modes.omega.shape[1]], axis=1)
        accelerations = self._modal(self.system.on_coordinates_by(loads)) - self.modes.omega * swing
        return self.solution.response.changed(q, self.system.to_links(superposed(self.modes, accelerations)))

    @property
    def step(self) -> float:
        """Duration of the sub-intervals (s)."""
        return self.scene.period / len(self.modes.theta)

    @property
    def loss(self) -> float:
        """Least loss factor of the modes kept, twice a damping ratio."""
        return 2 * float(damping_ratios(self.scene.damping.ratio, self.modes.omega).min())

    @cached_property
    def momenta(self) -> Array:
        """``M Phi``, ``(angles, modes, coordinates)``."""
        return self.system.mass_times(self.modes.shapes)

    @cached_property
    def load(self) -> Array:
        """Modal load at the middles, ``(angles, modes)``."""
        return self._modal(self.system.load)

    def _modal(self, load: Array) -> Array:
        return np.einsum("kmi,ki->km", self.modes.shapes, load)

    def _left_out(self) -> tuple[Array, Array]:
        """Load on the modes left out that is missing in the static answer, and inertia of the nodal dofs with it."""
        acceleration = self._second_rate(self.solution.response.displacement)
        kept = np.einsum("kmi,ki->km", self.momenta, acceleration)
        acceleration -= superposed(self.modes, kept)
        missing = -self.system.mass_times(acceleration[:, None])[:, 0]
        inertia = self.system.to_links(acceleration)
        if not self.scene.analysis.static_correction:
            missing += self.system.load - np.einsum("kmi,km->ki", self.momenta, self.load)
            inertia += self.system.rigid_acceleration + self.system.to_links(superposed(self.modes, self.load))
        return missing, inertia

    def _rate(self, values: Array) -> Array:
        return np.asarray((np.roll(values, -1, axis=0) - np.roll(values, 1, axis=0)) / (2 * self.step))

    def _second_rate(self, values: Array) -> Array:
        return np.asarray((np.roll(values, -1, axis=0) - 2 * values + np.roll(values, 1, axis=0)) / self.step**2)

    def _completed(self, static: Array, inertia: Array) -> ElasticResponse:
        """Give the response with the modes left out, and with what they do to those kept; see `_left_out`."""
        q, joined = self.solution.response.displacement + static, self.solution.joined
        left = q - superposed(self.modes, np.einsum("kmi,ki->km", self.momenta, q))
        rate, second = (
            np.einsum("kmi,ki->km", self.momenta, part) for part in (self._rate(left), self._second_rate(left))
        )
        strained = rate + straining_by(self.system, self.modes, left[:, None])[..., 0]
        load = -second - 2 * joined.oscillators.zeta * joined.oscillators.omega * strained
        y = joined.answer(load, self._rate(load))[..., 0]
        moved = self.system.to_links(superposed(self.modes, -(self.modes.omega**2) * y))
        return self.solution.response.changed(static + superposed(self.modes, y), inertia + moved)

    def with_modes(self) -> ElasticResponse:
        """Give the response with the modes left out, by the load that is missing on them and its static answer."""
        missing, inertia = self._left_out()
        static = displacement_under(self.system, missing)
        modes, reach = self.modes, self._reach(missing, static)
        while modes.omega.shape[1] < self.system.size and modes.frequency.min(axis=0).max() < reach:
            if SUB_INTERVALS.joined * len(modes.theta) * (2 * modes.omega.shape[1]) ** 2 > MODE_SEARCH.largest_joins:
                break
            modes = solve_modes(self.system, 2 * modes.omega.shape[1], self.scene.petsc)
        kept = np.arange(modes.omega.shape[1]) < self.modes.omega.shape[1]
        slow = 2 * modes.frequency.max(axis=0) * self.step < 1  # faster ones would ring at the joins
        if not (slow & ~kept).any():
            return self._completed(static, inertia)
        more = _ModalMotion(self._solved_with(modes.only(slow | kept)))
        missing, inertia = more._left_out()
        return more._completed(displacement_under(self.system, missing), inertia)

    def _solved_with(self, modes: Modes) -> SubIntervalSolution:
        """Solve again with other modes."""
        scene = self.scene.changed(analysis__static_correction=True, analysis__allow_ringing=True)
        return by_sub_intervals(scene, self.system, modes)

    def _reach(self, missing: Array, static: Array) -> float:
        """Frequency (Hz) of the highest harmonic of the load on the modes left out that would matter on one of theirs.

        Beside the rest, that is, measured by the square root of the elastic energy. It is 0 where it is well below all
        of theirs: they are not slower than those kept.
        """
        energy = np.sum(
            self.modes.omega**2 * np.einsum("kmi,ki->km", self.momenta, self.solution.response.displacement) ** 2, 1
        )
        left_out = np.abs(np.einsum("ki,ki->k", missing, static)).max()
        enough = float(max(np.sqrt(left_out), MODE_SEARCH.least_energy * np.sqrt(energy.max())))
        highest = highest_felt(missing, static, max(self.loss, 2 * MODE_SEARCH.least_ratio), enough) / self.scene.period
        return highest if highest > MODE_SEARCH.static * self.modes.frequency.min(axis=0).max() else 0.0

    def halved(self) -> tuple[Array, Array]:
        """Change of q and of the nodal inertia by half as many sub-intervals.

        Of an odd number one sub-interval is left; at its position nothing is compared. Modes that half as many are too
        few for may ring there: they answer statically where that changes less.
        """
        count, square = len(self.modes.theta), self.modes.omega**2
        middles = np.arange(0, count - 1, 2)
        every = middles if count % 2 == 0 else np.append(middles, count - 1)
        y = np.einsum("kmi,ki->km", self.momenta, self.solution.response.displacement)
        slow = 2 * self.modes.frequency.max(axis=0) * self.scene.period <= len(every)
        changes = []
        for followed in [np.ones_like(slow)] if slow.all() else [np.ones_like(slow), slow]:
            change = np.zeros_like(y)
            change[middles] = (self.load / square - y)[middles]
            if followed.any():
                change[np.ix_(middles, followed)] = (self._at(every, followed) - y[every][:, followed])[: len(middles)]
            changes.append(change)
        change = min(changes, key=lambda found: (square * found**2).sum(axis=1).max())
        return superposed(self.modes, change), self.system.to_links(superposed(self.modes, -square * change))

    def _at(self, every: Index, followed: NDArray[np.bool_]) -> Array:
        """Coordinates y of modes at every second position, by sub-intervals about these, ``(positions, modes)``."""
        modes, count = self.modes, len(self.modes.theta)
        shapes, momenta = modes.shapes[every][:, followed], self.momenta[every][:, followed]
        thinned = Modes(
            theta=modes.theta[every],
            omega=modes.omega[every][:, followed],
            shapes=shapes,
            transfer=np.roll(momenta, -1, axis=0) @ shapes.transpose(0, 2, 1),
            back=momenta @ np.roll(shapes, -1, axis=0).transpose(0, 2, 1),
            size=modes.size[every][:, followed],
        )
        straining = self.solution.joined.straining[every][:, followed][:, :, followed]
        load, duration = self.system.load, np.full(len(every), 2 * self.step)
        middle, rise = load[every], load[(every + 1) % count] - load[every - 1]
        if count % 2:  # the last begins and ends at a position, and is not about one
            duration[-1] = self.step
            middle[-1], rise[-1] = (load[-2] + load[-1]) / 2, load[-1] - load[-2]
        if self.scene.analysis.load == "constant":
            rise[:] = 0
        modal, slope = (np.einsum("kmi,ki->km", shapes, part) for part in (middle, rise / duration[:, None]))
        return SubIntervals.of(self.scene, thinned, straining, duration).answer(modal, slope)[..., 0]
