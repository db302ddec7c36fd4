"""What the sub-intervals of chapter 5 get wrong: by their number, by the modes left out, and by a load left out.

Half as many sub-intervals are those about every second position: their modes are known, and their loads. The modes left
out answer statically, which lacks their inertia: it bends them as one more load would. Where harmonics of that load may
meet their frequencies, they are taken in, as far as the sub-intervals can follow them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fenics_mech.accuracy.feedback import under_neglected
from fenics_mech.accuracy.hidden_resonances import Resonances, enough_modes, frequency_error, highest_felt
from fenics_mech.effects import Terms
from fenics_mech.forces.history import Better, History
from fenics_mech.mechanism import System
from fenics_mech.modes import Modes, solve_modes
from fenics_mech.response.modal_damping import damping_ratios
from fenics_mech.response.periodic.sub_intervals import JOINED, SubIntervals, solve_periodic, superposed
from fenics_mech.response.static.quasi_static import displacement_under
from fenics_mech.scene import Scene

Array = NDArray[np.float64]
Index = NDArray[np.int64]
ORDERS = {"time": 1, "modes": 2}  # measured
SAFETY = 2  # of both
STATIC = 0.5  # of the last frequency kept, up to which the modes left out answer statically
LEAST_MET = 1e-4  # of the largest elastic energy's square root, below which no harmonic is looked for
LARGEST = 5e8  # numbers in the joins of the modes that are sought
LEAST_RATIO = 1e-6  # of damping, for which resonance is looked for


@dataclass(frozen=True)
class Neighbours:
    """Motions beside one by sub-intervals.

    Parameters
    ----------
    scene, system, modes, joined, history
        As of `solve_periodic`, and its answer.
    boundary_load
        As of `solve_periodic`.
    """

    scene: Scene
    system: System
    modes: Modes
    joined: SubIntervals
    history: History
    boundary_load: Array | None = None

    def better(
        self, lack_of: Callable[[System, History], Terms], of_mesh: Callable[[System, History, Terms, bool], Better]
    ) -> Mapping[str, Better]:
        """Give the motion without the errors by steps, modes and the mesh.

        `lack_of` gives the loads that a mesh neglects of a motion, and `of_mesh` judges the motion without them.
        """
        lack, inertia = self._left_out()
        static = displacement_under(self.system, lack, self.scene.petsc)
        return {
            "time": Better(self._moved(*self._halved()), ORDERS["time"], SAFETY),
            "modes": Better(self._with_modes(lack, static, inertia), ORDERS["modes"], SAFETY),
            "mesh": replace(of_mesh(self.system, *self._without_mesh(lack_of)), hidden=self._hidden()),
        }

    def _hidden(self) -> tuple[History, float] | None:
        """Give the motion with the vibration that the mesh may hide."""
        rate = 2 * np.pi / self.scene.period
        modes = enough_modes(self.system, self.modes, self.system.load, rate, self.loss, self.scene.petsc)
        losses, off = 2 * damping_ratios(self.scene, modes.omega).mean(axis=0), frequency_error(self.system, modes)
        resonances = Resonances(modes, rate, self.system.load, losses, off)
        left_out = np.arange(len(off)) >= self.modes.omega.shape[1]  # `_with_modes` has them at the mesh's frequencies
        hidden = resonances.by_mesh | (resonances.met & left_out & resonances.shifted)
        if not hidden.any():
            return None
        y, _ = resonances.vibration(hidden)
        inertia = self.system.to_links(superposed(modes, -(modes.omega**2) * y))
        return self._moved(superposed(modes, y), inertia), 1.0

    def _without_mesh(self, lack_of: Callable[[System, History], Terms]) -> tuple[History, Terms, bool]:
        """Give the motion under what the mesh neglects of it; see `under_neglected`."""
        omega, system = self.modes.omega, self.system
        count = omega.shape[1]

        def moved(change: Array, beside: Terms) -> History:
            swing, q = change[:, :count], change[:, count:]
            accelerations = self._modal(self._load_of(beside)) - omega * swing
            return self._moved(q, system.to_links(superposed(self.modes, accelerations)))

        def change_by(lack: Terms) -> Array:
            return np.concatenate(self._under(self._load_of(lack)), axis=1)

        lack, unit = lack_of(system, self.history.elastic), np.pad(np.ones(count), (0, system.size))
        return under_neglected(system, lack, lack_of, change_by, moved, unit, self.loss)

    def _load_of(self, lack: Terms) -> Array:
        return self.system.on_coordinates(self.system.applied_by(lack))

    @property
    def step(self) -> float:
        """Duration of the sub-intervals (s)."""
        return self.scene.period / len(self.modes.theta)

    @property
    def loss(self) -> float:
        """Least loss factor of the modes kept, twice a damping ratio."""
        return 2 * float(damping_ratios(self.scene, self.modes.omega).min())

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

    def _moved(self, displacement: Array, inertia: Array) -> History:
        """Give the elastic motion with a change of q and of the nodal inertia."""
        elastic = self.history.elastic
        return replace(elastic, displacement=elastic.displacement + displacement, inertia=elastic.inertia + inertia)

    def _left_out(self) -> tuple[Array, Array]:
        """Load on the modes left out that the static answer lacks, and inertia of the nodal dofs with it."""
        q = self.history.displacement
        acceleration = (np.roll(q, -1, axis=0) - 2 * q + np.roll(q, 1, axis=0)) / self.step**2
        kept = np.einsum("kmi,ki->km", self.momenta, acceleration)
        acceleration -= superposed(self.modes, kept)
        lack = -self.system.mass_times(acceleration[:, None])[:, 0]
        inertia = self.system.to_links(acceleration)
        if not self.scene.analysis.static_correction:
            lack += self.system.load - np.einsum("kmi,km->ki", self.momenta, self.load)
            inertia += self.system.rigid_acceleration + self.system.to_links(superposed(self.modes, self.load))
        return lack, inertia

    def _with_modes(self, lack: Array, static: Array, inertia: Array) -> History:
        """Give the motion with the modes left out, by the load that they lack and its static answer."""
        modes, reach = self.modes, self._reach(lack, static)
        while modes.omega.shape[1] < self.system.size and modes.frequency.min(axis=0).max() < reach:
            if JOINED * len(modes.theta) * (2 * modes.omega.shape[1]) ** 2 > LARGEST:
                break
            modes = solve_modes(self.system, 2 * modes.omega.shape[1], self.scene.petsc)
        kept = np.arange(modes.omega.shape[1]) < self.modes.omega.shape[1]
        slow = 2 * modes.frequency.max(axis=0) * self.step < 1  # faster ones would ring at the joins
        if not (slow & ~kept).any():
            return self._moved(static, inertia)
        scene = self.scene.changed(analysis__static_correction=True, analysis__allow_ringing=True)
        modes = modes.only(slow | kept)
        joined = SubIntervals.of(scene, modes)
        history = solve_periodic(scene, self.system, modes, joined, self.boundary_load)
        more = Neighbours(scene, self.system, modes, joined, history)
        lack, inertia = more._left_out()
        return more._moved(displacement_under(self.system, lack, self.scene.petsc), inertia)

    def _reach(self, lack: Array, static: Array) -> float:
        """Frequency (Hz) of the highest harmonic of the load on the modes left out that would matter on one of theirs.

        Beside the rest, that is, measured by the square root of the elastic energy. It is 0 where it is well below all
        of theirs: they are not slower than those kept.
        """
        energy = np.sum(self.modes.omega**2 * np.einsum("kmi,ki->km", self.momenta, self.history.displacement) ** 2, 1)
        left_out = np.abs(np.einsum("ki,ki->k", lack, static)).max()
        enough = float(max(np.sqrt(left_out), LEAST_MET * np.sqrt(energy.max())))
        highest = highest_felt(lack, static, max(self.loss, 2 * LEAST_RATIO), enough) / self.scene.period
        return highest if highest > STATIC * self.modes.frequency.min(axis=0).max() else 0.0

    def _under(self, load: Array) -> tuple[Array, Array]:
        """Change of the modes' ``omega y``, and of q, under a load."""
        modal, omega = self._modal(load), self.modes.omega
        slope = (np.roll(modal, -1, axis=0) - np.roll(modal, 1, axis=0)) / (2 * self.step)
        y = self.joined.answer(modal, slope)[..., 0]
        static = displacement_under(self.system, load, self.scene.petsc)
        return omega * y, superposed(self.modes, y - modal / omega**2) + static

    def _halved(self) -> tuple[Array, Array]:
        """Change of q and of the nodal inertia by half as many sub-intervals.

        Of an odd number one sub-interval is left; at its position nothing is compared. Modes that half as many are too
        few for may ring there: they answer statically where that changes less.
        """
        count, square = len(self.modes.theta), self.modes.omega**2
        middles = np.arange(0, count - 1, 2)
        every = middles if count % 2 == 0 else np.append(middles, count - 1)
        y = np.einsum("kmi,ki->km", self.momenta, self.history.displacement)
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

    def _at(self, every: Index, followed: Array) -> Array:
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
        load, duration = self.system.load, np.full(len(every), 2 * self.step)
        middle, rise = load[every], load[(every + 1) % count] - load[every - 1]
        if count % 2:  # the last begins and ends at a position, and is not about one
            duration[-1] = self.step
            middle[-1], rise[-1] = (load[-2] + load[-1]) / 2, load[-1] - load[-2]
        if self.scene.analysis.load == "constant":
            rise[:] = 0
        modal, slope = (np.einsum("kmi,ki->km", shapes, part) for part in (middle, rise / duration[:, None]))
        return SubIntervals.of(self.scene, thinned, duration).answer(modal, slope)[..., 0]
