"""What is read off a motion that is linear beside another: the derivative of what is read off exact motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.geometry import End
from fenics_mech.machine.along_members import along_members, cubic_places
from fenics_mech.machine.evaluation import Evaluation, linear_forces
from fenics_mech.machine.from_scene import SceneMachine
from fenics_mech.machine.measured import Measured
from fenics_mech.machine.motion import LinearMotion
from fenics_mech.machine.section_forces import Sections
from fenics_mech.recovery.of_poses import OfPoses, Variables
from fenics_mech.scene.joints import Joint


@dataclass(frozen=True)
class OfLinear(OfPoses):
    """A motion of a scene's machine that is linear beside another, at some instants."""

    # What is no linear function of the motion, such as a power or a largest value, is made of such that are.

    linear: LinearMotion

    @classmethod
    def by(cls, made: SceneMachine, linear: LinearMotion) -> OfLinear:
        """Read off a linear motion of a scene's machine."""
        return cls(made, linear.beside(1.0), linear)

    @cached_property
    def _beside(self) -> tuple[OfPoses, OfPoses, OfPoses]:
        """The base, and the exact motions ahead and behind."""
        bent, made, places = self.linear.stiffening is not None, self.made, self.places
        shares = 0.0, self.linear.step, -self.linear.step
        return tuple(OfPoses(made, self.linear.beside(x), bent=bent, places=places) for x in shares)  # type: ignore[return-value]

    def _linear(self, read: Callable[[OfPoses], Array]) -> Array:
        base, ahead, behind = (read(x) for x in self._beside)
        return np.asarray(base + (ahead - behind) / (2 * self.linear.step))

    @cached_property
    def _exerting(self) -> OfPoses | None:
        """What the change exerts at the places of the base, where nothing else of it acts: without differences."""
        motion = self.linear.acting
        return None if motion is None else OfPoses(self.made, motion, bent=False, places=self.places)

    @cached_property
    def sections(self) -> Sections:
        """Forces in sections at the stations."""
        return self._sections(lambda x: x.sections, lambda x: x.motion.found)

    @cached_property
    def bare(self) -> Sections:
        """Forces in sections without what damps modes, which is no strain."""
        if self.made.machine.beams.modal is None:
            return self.sections
        return self._sections(lambda x: x.bare, lambda x: x.elastic)

    def _sections(self, read: Callable[[OfPoses], Sections], found: Callable[[OfPoses], Evaluation]) -> Sections:
        """Give forces in sections as a reading does, or where no stresses turn with the links, in their rigid axes."""
        # In these axes the forces of the base and those of the change add up to equilibrium. Neither are in it alone.
        if self.linear.stiffening is not None:
            parts = ([getattr(read(x), part.name) for x in self._beside] for part in fields(Sections))
            return Sections(*(base + (ahead - behind) / (2 * self.linear.step) for base, ahead, behind in parts))
        if self._exerting is not None:
            exact = read(self._exerting)
        else:
            base, ahead, behind = map(found, self._beside)
            at_base = linear_forces(base, ahead, behind, 1 / (2 * self.linear.step))
            exact = along_members(self.made, at_base, self.motion.a, self.stations, bent=False)
        return replace(exact, place=self._cubic + exact.bow)

    @cached_property
    def _cubic(self) -> Array:
        """Places on the polynomials between the nodes ``(instants, members, stations, 2)`` (m)."""
        return self._linear(lambda x: cubic_places(self.made, x.motion.found, self.stations))

    def held(self, name: str, joint: Joint, body: str) -> Array:
        """Give force and moment, about its point, of a joint on one of its bodies ``(instants, 3)`` (N, N m)."""
        if self._exerting is not None:
            return self._exerting.held(name, joint, body)
        return self._linear(lambda x: x.held(name, joint, body))

    def frame(self) -> Variables:
        """Give forces and couples on the ground at every support, and their sums about its origin."""
        if self._exerting is not None:
            return self._exerting.frame()
        found = [x.frame() for x in self._beside]
        return {
            name: (dims, base + (found[1][name][1] - found[2][name][1]) / (2 * self.linear.step))
            for name, (dims, base) in found[0].items()
        }

    def moved(self, end: End) -> tuple[Array, ...]:
        """Give place (m), velocity and acceleration of an end, ``(instants, 2)`` each."""
        return tuple(self._linear(lambda x: np.stack(x.moved(end))))

    def drive_rates(self) -> Array:
        """Give the rates of angles (rad/s) and strokes (m/s) of the drives ``(instants, drives)``."""
        return self._linear(lambda x: x.drive_rates())

    @cached_property
    def measured(self) -> Sequence[Measured]:
        """Measures and stresses of every term."""
        return [
            replace(
                here,
                x=self._linear(lambda of, k=k: of.measured[k].x),  # type: ignore[misc]
                rate=self._linear(lambda of, k=k: of.measured[k].rate),  # type: ignore[misc]
                response=replace(
                    here.response,
                    stress=self._linear(lambda of, k=k: of.measured[k].response.stress),  # type: ignore[misc]
                ),
            )
            for k, here in enumerate(self._beside[0].measured)
        ]
