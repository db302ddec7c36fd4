"""Where a scene's machine with freedoms is at rest, by the equation of poses: links that bend, and such that do not."""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, Index
from fenics_mech.answers.buckled_links import refuse_folded
from fenics_mech.answers.held_by_friction import holds
from fenics_mech.answers.solved_by_poses import AtRest
from fenics_mech.errors import SceneError, SolverError
from fenics_mech.geometry import Given
from fenics_mech.joints.law_terms import LawTerm
from fenics_mech.machine.assembly import COARSELY_MET, closed, left_open
from fenics_mech.machine.drawn_from_scene import Law
from fenics_mech.machine.from_scene import SceneMachine, lead, machine_of
from fenics_mech.machine.machine import Machine
from fenics_mech.machine.motion import Motion
from fenics_mech.machine.rigid_from_scene import coordinates_of_bodies, driven, leading, poses_of_links
from fenics_mech.recovery.dataset import joined
from fenics_mech.recovery.freedoms_and_laws import law_efforts, of_freedoms
from fenics_mech.recovery.of_poses import OfPoses, OfRigid
from fenics_mech.scene import Friction, Scene
from fenics_mech.scene.meshing import with_halves
from fenics_mech.solve import damp_modes
from fenics_mech.solve.rest import Condensed, RestSearch, SmallMotions, small_motions

LED = 0.2  # rad, by which drives lead links to where they are held


def without_friction(scene: Scene) -> Scene:
    """Give a scene in which no dry friction holds a joint at rest."""
    none = {"coefficient": 0.0, "static": None, "stribeck": None}
    laws = {name: law.model_copy(update=none) if holds(law) else law for name, law in scene.joint_laws.items()}
    return scene.model_copy(update={"joint_laws": laws})


def refuse_friction(scene: Scene, why: str) -> None:
    """Raise `SceneError` where a joint has dry friction."""
    for name, law in scene.joint_laws.items():
        if isinstance(law, Friction) and (law.belt_speed or holds(law)):
            raise SceneError(
                f"dry friction holds a linkage in a range of equilibria, which is found of one freedom of links that "
                f"are rigid. This scene has {why}",
                place=f"joint_laws.{name}",
                hint="Write method = 'transient' with a duration, which shows where it comes to rest",
            )


@dataclass
class Resting:
    """A scene's machine whose freedoms rows lead, with drives held at their position and all contacts closed."""

    made: SceneMachine  # the machine, whose freedoms nothing leads
    held: Machine  # the same with the rows
    rows: Index  # their numbers
    t: Array  # when the drives are at their position ``(1,)`` (s)
    start: Array  # where the freedoms start ``(freedoms,)``
    value: Array  # where the rows hold them
    bodies: Array  # coordinates of links that do not bend, where they were last ``(size,)``
    side: float = 0.0  # sign of their rows' determinant, which tells one assembly from another

    @classmethod
    def of(cls, scene: Scene) -> Resting:
        """Build it, and lead the drives from the start to their position, with the freedoms held."""
        made = machine_of(scene)
        start = np.array([part.start or 0.0 for part in scene.freedoms.values()])
        value = start.copy()
        t = np.array([scene.analysis.position / scene.cycle_rate if scene.drives else 0.0])
        holding = replace(made, machine=copy(made.machine))
        holding.machine.rows = list(made.machine.rows)
        rows = [lead(holding, name, _read(value, k)) for k, name in enumerate(scene.freedoms)]
        for term in made.machine.terms:
            if isinstance(term, LawTerm) and term.contacts:
                term.shut()
        found = cls(made, holding.machine, np.array(rows), t, start, value, made.bodies.q)
        steps = 1 + math.ceil(abs(scene.analysis.position) / LED) if scene.drives else 1
        for share in np.arange(1, steps + 1) / steps:
            found._lead(share * t, start)
        return found

    def _lead(self, t: Array, place: Array) -> None:
        """Lead rigid links to an instant of the drives ``(1,)`` (s) and places of the freedoms ``(freedoms,)``."""
        machine = leading(self.made, self.t, np.concatenate([driven(self.made, t)[0][0], place])[None])
        (q,), gaps = closed(machine, self.t, self.bodies[None])
        J = left_open(machine, self.t, q[None])[1]
        side = float(np.linalg.slogdet(J)[0][0]) if J.shape[1] == J.shape[2] else 1.0
        if gaps[0] > COARSELY_MET or side * self.side < 0:  # there is no way on, or only in another assembly
            raise SolverError(f"the links do not follow the freedoms at joint {', '.join(self.made.scene.freedoms)}")
        self.bodies, self.side = q, side

    def _led(self, place: Array) -> Array:
        """Lead the freedoms to places ``(freedoms,)``, and give the coordinates of links that do not bend ``(n,)``."""
        self.value[:] = place
        self._lead(self.t, place)
        return coordinates_of_bodies(self.made, self.bodies[None])[0]

    @cached_property
    def search(self) -> RestSearch:
        """The search for the equilibrium."""
        names = tuple(self.made.scene.freedoms)
        return RestSearch(self.held, self.rows, names, self.t, self._led, self.held.angles_as_drawn())

    def _beside(self, place: Array, here: Condensed) -> tuple[Given, Array, Array]:
        """Give links that do not bend as a chart, coordinates beside it, and multipliers among accelerations."""
        shape, n = here.shape, self.held.n
        q = shape.q - np.pad(self._led(place), (0, self.held.size - n))
        bodies = self.bodies[None]
        return Given(self.t, poses_of_links(self.made, bodies, 0 * bodies, 0 * bodies)), q, shape.a

    def read(self, place: Array, here: Condensed) -> OfRigid:
        """Give what is read off where freedoms are at places ``(freedoms,)``, beside links that do not bend."""
        made, machine, (chart, q, a) = self.made, copy(self.made.machine), self._beside(place, here)
        machine.chart = chart
        q, a = (np.delete(x, machine.n + self.rows, axis=1) for x in (q, a))  # nothing holds the freedoms
        motion = Motion(machine, self.t, q, 0 * q, a, False, angles=here.shape.angles)
        turned = made.bodies.angles + self.bodies[None, 2 : 3 * len(made.scene.links) : 3]
        return OfRigid(replace(made, machine=machine), motion, turned, made.scene.cycle_rate * self.t)

    def small_motions(self, place: Array, here: Condensed, count: int) -> SmallMotions:
        """Give small motions about where the freedoms are at places ``(freedoms,)``."""
        scene, machine, (chart, q, a) = self.made.scene, copy(self.held), self._beside(place, here)
        if np.any(scene.damping.ratio) and self.made.links is not None:
            machine = Resting.of(scene).held  # whose beams are others, and damped
            machine.chart = chart
            damp_modes(machine, scene.period, scene.damping.ratio, times=self.t)
        machine.chart = chart
        q, a = (np.pad(x[0], (0, machine.size - x.shape[1])) for x in (q, a))
        found = small_motions(machine, float(self.t[0]), q, a, self.rows, count, here.shape.angles)
        if not scene.analysis.allow_unstable:
            self.search.refuse_unstable(found)
        return found


def _read(value: Array, k: int) -> Law:
    """Give the law of a row that reads a value where it is now."""
    return lambda t: np.full(len(t), value[k])


@dataclass(frozen=True)
class FreelyAtRest(AtRest):
    """An equilibrium of a scene's machine with freedoms, with exact strains."""

    place: Array = field(kw_only=True)  # where the freedoms are ``(freedoms,)``
    motions: SmallMotions = field(kw_only=True)  # small motions about it

    @classmethod
    def of(cls, scene: Scene) -> FreelyAtRest:
        """Find it."""
        refuse_friction(scene, "links that bend")
        resting = Resting.of(scene)
        place, here = resting.search.found_from(resting.start)
        count = resting.held.n if scene.analysis.modes == "all" else scene.analysis.modes
        motions, found = resting.small_motions(place, here, count), resting.read(place, here)
        refuse_folded(found.made, found.motion.found, resting.t)
        return cls(scene, found.made, found, None, place=place, motions=motions)

    def better(self) -> Iterator[tuple[str, OfPoses | None]]:
        """Give the same without the error of the mesh."""
        resting = Resting.of(with_halves(self.scene))
        yield "mesh", resting.read(*resting.search.found_from(self.place))

    @property
    def told(self) -> xr.Dataset:
        """What it has beside other answers: places of the freedoms, small motions, and what laws of joints exert."""
        freedoms = of_freedoms(self.scene, self.place[None], 0 * self.place[None])
        return joined(freedoms, of_small_motions(self.motions), law_efforts(self.positions))


def of_small_motions(motions: SmallMotions) -> xr.Dataset:
    """Label the small motions about an equilibrium."""
    along = ("small_motion",)
    variables = {"rest_frequency": (along, motions.frequency), "rest_decay": (along, motions.decay)}
    return xr.Dataset(variables, {"small_motion": np.arange(1, len(motions.decay) + 1)})
